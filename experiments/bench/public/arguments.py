"""Arguments of Python calls as the texts that the command line takes, so that both check them alike."""

from __future__ import annotations

import operator
import os
from collections.abc import Iterable, Mapping
from typing import Any

from experiments.bench.core.errors import UsageError, short


def model_texts(models: Any) -> list[str]:
    """Return models as ``--model`` takes them.

    Parameters
    ----------
    models
        One or several: names, or paths of .py files, as texts or path objects; with settings as ``dsnn:w_i=1``.
    """
    if isinstance(models, str | os.PathLike):
        models = [models]
    if not isinstance(models, Iterable):
        raise UsageError(f"models={short(models)}: legal are names and paths of .py files")
    listed = list(models)
    for model in listed:
        if not isinstance(model, str | os.PathLike):
            raise UsageError(f"models={short(listed)}: legal are names and paths of .py files, not {short(model)}")
    return [str(os.fspath(model)) for model in listed]


def assignments(settings: Mapping[str, Any] | None) -> list[str]:
    """Return settings as ``--set`` takes them: ``{"dsnn.n_con": 6}`` is ``dsnn.n_con=6``."""
    if settings is None:
        return []
    if not isinstance(settings, Mapping):
        raise UsageError(f'settings={short(settings)}: legal is a mapping, for example {{"dsnn.n_con": 6}}')
    return [f"{key}={_text(str(key), value)}" for key, value in settings.items()]


def _text(key: str, value: Any) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return value
    if isinstance(value, Iterable) and not isinstance(value, Mapping):
        return ",".join(_text(key, each) for each in value)
    try:
        float(value)
    except (TypeError, ValueError):
        raise UsageError(f"settings: {key}={short(value)}: legal is a number, a text, or several of them") from None
    return str(value)  # the shortest text that is the same number again


def whole(name: str, value: Any) -> int:
    """Return a whole number, also one of numpy's; `UsageError` for anything else."""
    try:
        return operator.index(value)
    except TypeError:
        raise UsageError(f"{name}={short(value)}: legal is a whole number") from None
