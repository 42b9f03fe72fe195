"""What goes from process to process of a vector env: things of the user's, and exceptions."""

from __future__ import annotations

import pickle
import sys
import traceback
from collections.abc import Mapping
from typing import Any

import cloudpickle

Told = tuple[bytes | None, str, str]
"""An exception: itself if it survives pickling, its one line, its traceback."""


def cloudpickled(value: Any) -> bytes:
    """``value`` for `pickle.loads`, with the functions and classes of a script or notebook, as nobody can import it."""
    script = sys.modules.get("__mp_main__")  # what multiprocessing calls the script, in the processes that it starts
    if script is None:
        return bytes(cloudpickle.dumps(value))
    cloudpickle.register_pickle_by_value(script)
    try:
        return bytes(cloudpickle.dumps(value))
    finally:
        cloudpickle.unregister_pickle_by_value(script)


def check_pickles(values: Mapping[str, Any]) -> None:
    """Raise ``ValueError`` in one line naming the first of ``values`` that does not pickle."""
    for name, value in values.items():
        try:
            cloudpickled(value)
        except Exception as error:
            raise ValueError(
                f"{name}={value!r} does not pickle, which another process needs ({error}): "
                "give something that does, or workers=0"
            ) from None


def told(error: Exception) -> Told:
    """An exception for a pipe."""
    content: bytes | None
    try:
        content = cloudpickled(error)
        pickle.loads(content)
    except Exception:
        content = None
    return content, f"{type(error).__name__}: {error}", "".join(traceback.format_exception(error))


def restored(told: Told, who: str) -> Exception:
    """The exception that was `told`, or a ``RuntimeError`` that says the same; with a note of where it came of."""
    content, line, trace = told
    error: Exception
    try:
        error = RuntimeError(line) if content is None else pickle.loads(content)
    except Exception:
        error = RuntimeError(line)
    error.add_note(f"in the process of {who}, where it came of:\n{trace}")
    return error
