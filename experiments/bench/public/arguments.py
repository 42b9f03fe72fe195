"""Arguments of Python calls as the texts that the command line takes, so that both check them alike."""

from __future__ import annotations

import operator
import os
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
    for model in (listed := list(models)):
        if not is_path(model):
            raise UsageError(f"models must be names and paths of .py files, got {short(model)}")
    return [str(os.fspath(model)) for model in listed]


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
