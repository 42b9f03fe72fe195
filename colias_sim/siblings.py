"""The packages that are installed beside this one, and strangers of the same names that hide them."""

from __future__ import annotations

import importlib.util
import os
import sys
import warnings
from pathlib import Path

SIBLINGS = ("experiments", "dsnn", "scenes")


def warn_of_strangers() -> None:
    """Warn, in one line, where ``import experiments`` and its like would take a stranger's module.

    A folder of that name with an ``__init__.py``, or a file ``experiments.py``, hides ours where it comes earlier on
    ``sys.path``: beside the script that is run, or in the current folder of a notebook. Nothing is imported for this.
    A folder without ``__init__.py`` hides nothing.
    """
    process = sys.modules.get("multiprocessing.process")
    if process is not None and process.parent_process() is not None:
        return  # a worker: the process that started it has warned
    for name in SIBLINGS:
        ours, imported = Path(__file__).parents[1] / name / "__init__.py", _origin(name)
        if imported is None or not ours.is_file() or _folder(imported) == _folder(ours):
            continue
        remedy = f"rename it, or start Python in another folder (colias-sim's is {ours.parent})"
        message = f"'import {name}' takes {imported}, which is not colias-sim's: {remedy}"
        warnings.warn(message, RuntimeWarning, stacklevel=3)


def _origin(name: str) -> str | None:
    """Return the file that an import takes; ``None`` where there is none, or it cannot be told."""
    try:
        spec = importlib.util.find_spec(name)
    except (ImportError, ValueError):
        return getattr(sys.modules.get(name), "__file__", None)
    return spec.origin if spec is not None and spec.has_location else None


def _folder(file: str | Path) -> str:
    return os.path.realpath(Path(file).parent)
