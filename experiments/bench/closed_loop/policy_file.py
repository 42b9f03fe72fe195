"""Policies in files: an .npz of float32 arrays and a JSON text. Reading one never runs what it holds."""

from __future__ import annotations

import errno
import json
import os
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from pydantic import TypeAdapter, ValidationError

from experiments.bench.closed_loop.policy import About, Policy
from experiments.bench.run.errors import UsageError, explain
from experiments.bench.store.places import replacing

ENDING = ".npz"


def save(policy: Policy, path: Path) -> None:
    """Write a policy. Raises ``FileExistsError`` rather than overwrite, ``OSError`` where it cannot be written."""
    arrays = {"about": np.array(TypeAdapter(About).dump_json(policy.about).decode())}
    for index, (weights, biases) in enumerate(policy.layers):
        arrays |= {f"weights{index}": weights, f"biases{index}": biases}
    if path.exists():
        raise FileExistsError(errno.EEXIST, os.strerror(errno.EEXIST), str(path))
    with replacing(path) as partial, partial.open("wb") as file:
        np.savez(file, allow_pickle=False, **arrays)


def load(path: Path) -> Policy:
    """Read a policy from a file that anybody may have made.

    Raises `UsageError` in one line on what is no policy file, ``OSError`` on a file that cannot be read.
    """
    if not path.is_file():
        raise UsageError(f"{path}: no such file")
    try:
        with np.load(path, allow_pickle=False) as file:
            arrays = dict(file)
        about = _about(arrays.pop("about", None))
        names = [(f"weights{i}", f"biases{i}") for i in range(len(about.shapes()))]
        if set(arrays) != {name for pair in names for name in pair}:
            raise ValueError(f"holds {', '.join(sorted(arrays)) or 'no layers'}, expected {len(names)} layers")
        if any(array.dtype != np.float32 for array in arrays.values()):
            raise ValueError("its layers are not float32")
        return Policy(about, [(arrays[weights], arrays[biases]) for weights, biases in names])
    except ValidationError as error:
        raise UsageError(f"{path}: {_short(explain(error))}") from None
    except ValueError as error:
        raise UsageError(f"{path}: not a policy file ({_short(str(error))})") from None


def _about(text: npt.NDArray[Any] | None) -> About:
    if text is None or text.shape != () or text.dtype.kind != "U":
        raise ValueError("no text 'about' in it")
    values = json.loads(str(text))
    if not isinstance(values, dict) or values.get("format") != About.format:
        raise ValueError(f"'about' says no format, or one other than {About.format!r}")
    return TypeAdapter(About).validate_python(values)


def _short(text: str) -> str:
    return " ".join(text.split())[:200]
