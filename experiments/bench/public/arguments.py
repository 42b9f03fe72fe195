"""Arguments of Python calls as the texts that the command line takes, so that both check them alike."""

from __future__ import annotations

import operator
import os
from collections.abc import Mapping, Set
from pathlib import Path
from typing import Any, TypeGuard

import numpy as np

from experiments.bench.run.errors import UsageError, short


def model_texts(models: Any) -> list[str]:
    """Return models as ``--model`` takes them.

    Parameters
    ----------
    models
        One or several: names, or paths of .py files, as texts or path objects; with settings as ``dsnn:w_i=1``.
    """
    if isinstance(models, str | os.PathLike):
        models = [models]
    listed = _listed(models)
    if listed is None:
        raise UsageError(f"models must be names and paths of .py files, got {short(models)}")
    for model in listed:
        if not is_path(model):
            raise UsageError(f"models must be names and paths of .py files, got {short(model)}")
    return [str(os.fspath(model)) for model in listed]


def assignments(settings: Mapping[str, Any] | None) -> list[str]:
    """Return settings as ``--set`` takes them: ``{"dsnn.n_con": 6}`` is ``dsnn.n_con=6``."""
    if settings is None:
        return []
    if not isinstance(settings, Mapping):
        raise UsageError(f'settings must be a mapping such as {{"dsnn.n_con": 6}}, got {short(settings)}')
    return [f"{key}={_text(str(key), value)}" for key, value in settings.items()]


def _text(key: str, value: Any) -> str:
    if isinstance(value, np.ndarray) and value.ndim == 0:
        value = value[()]
    if isinstance(value, bool | np.bool_):
        return str(value).lower()
    if isinstance(value, str):
        return value
    neither = isinstance(value, Mapping | Set | bytes | bytearray)
    if not neither and (listed := _listed(value)) is not None:
        return ",".join(_text(key, item) for item in listed)
    try:
        number = float("" if neither else value)
    except (TypeError, ValueError, OverflowError):
        raise UsageError(f"settings: {key} must be a number, a text, or several of them, got {short(value)}") from None
    text = str(value)  # the shortest text that is the same number again, but of a fraction or a tensor
    return text if _is_number(text) else str(number)


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _listed(values: Any) -> list[Any] | None:
    """Return the items of an iterable; ``None`` of what is none, such as an array without dimensions."""
    try:
        return list(values)
    except TypeError:
        return None


def is_path(value: object) -> TypeGuard[str | os.PathLike[str]]:
    """Say whether a value is a name or a path, as a text."""
    return isinstance(value, str) or (isinstance(value, os.PathLike) and isinstance(os.fspath(value), str))


def folder(name: str, value: Any) -> Path:
    """Return the folder that the argument ``name`` gives; `UsageError` for what is no path."""
    if not is_path(value):
        raise UsageError(f"{name} must be the path of a folder, got {short(value)}")
    return Path(value)


def flag(name: str, value: Any) -> bool:
    """Return true or false, also one of NumPy's; `UsageError` for anything else."""
    if not isinstance(value, bool | np.bool_):
        raise UsageError(f"{name} must be True or False, got {short(value)}")
    return bool(value)


def whole(name: str, value: Any) -> int:
    """Return a whole number, also one of numpy's; `UsageError` for anything else."""
    try:
        if isinstance(value, bool | np.bool_):
            raise TypeError
        return operator.index(value)
    except TypeError:
        raise UsageError(f"{name} must be a whole number, got {short(value)}") from None
