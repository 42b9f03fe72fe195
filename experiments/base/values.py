"""Values as the texts that ``--set`` takes."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from typing import Any

from experiments.base.errors import UsageError, short


def assignments(settings: Mapping[str, Any] | None) -> list[str]:
    """Return settings as ``--set`` takes them: ``{"dsnn.n_con": 6}`` or ``{"dsnn": {"n_con": 6}}``: ``dsnn.n_con=6``.

    Raises `UsageError` for ``None``, and for several values of which one has a comma, or is several itself.
    """
    texts = []
    for key, value in (settings or {}).items():
        if isinstance(value, Mapping):
            texts += assignments({f"{key}.{name}": part for name, part in value.items()})
        else:
            texts.append(f"{key}={_text(value)}")
    return texts


def values(settings: Mapping[str, Any] | None) -> dict[str, str]:
    """Return settings by key, each as the text that ``--set`` takes."""
    return dict(text.split("=", 1) for text in assignments(settings))


def _text(value: Any) -> str:
    if isinstance(value, str | bytes | os.PathLike):
        return os.fsdecode(value)
    if isinstance(value, Iterable) and getattr(value, "ndim", True):
        parts = [_text(part) for part in value]
        if any("," in part for part in parts):
            raise UsageError(f"settings: each of several values must be one, without a comma, got {short(parts)}")
        return ",".join(parts)
    if value is None:
        raise UsageError("settings: None is no value; leave that parameter out")
    return {"True": "true", "False": "false"}.get(text := str(value), text)
