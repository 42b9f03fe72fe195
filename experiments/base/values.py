"""Values of parameters by their keys, ``SECTION.NAME``: from Python as they are, from ``--set`` as texts."""

import json
from collections.abc import Iterable, Mapping
from typing import Any

from experiments.base.errors import UsageError


def by_key(settings: Mapping[str, Any] | None) -> dict[str, Any]:
    """Return settings as JSON has them, by key: ``{"dsnn": {"n_con": 6}}`` is ``{"dsnn.n_con": 6}``."""
    from pydantic_core import to_jsonable_python  # not before: it takes its time to load

    found: dict[str, Any] = {}
    for key, value in (settings or {}).items():
        if isinstance(value, Mapping):
            found |= by_key({f"{key}.{name}": part for name, part in value.items()})
        else:  # NumPy's values have ``tolist``
            found[key] = to_jsonable_python(value, fallback=lambda other: getattr(other, "tolist", other.__str__)())
    return found


def key_texts(settings: Mapping[str, Any]) -> list[str]:
    """Return settings as the ``KEY=VALUE`` texts that ``--set`` takes."""
    return [f"{key}={_text(value)}" for key, value in by_key(settings).items()]


def _text(value: Any) -> str:
    if isinstance(value, list):
        return ",".join(map(_text, value))
    return value if isinstance(value, str) else json.dumps(value)


def key_values(texts: Iterable[str] | None, option: str = "--set") -> dict[str, str]:
    """Return ``KEY=VALUE`` texts by key; of two for one key the last counts. Raises `UsageError` for another form."""
    found = {}
    for text in texts or ():
        key, equals, found[key] = text.partition("=")
        if not equals:
            raise UsageError(f"{option} {text}: expected SECTION.NAME=VALUE, for example dsnn.n_con=6")
    return found
