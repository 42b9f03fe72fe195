"""Pickling between the processes of a vector env: a user's objects, and exceptions."""

from __future__ import annotations

import contextlib
import pickle
import sys
import traceback
from collections.abc import Mapping
from typing import Any

import cloudpickle

PackedError = tuple[bytes | None, str, str]
"""An exception for a pipe: its pickle (``None`` if it has none), its one line, its traceback."""

SPAWNED_MAIN = "__mp_main__"
"""The name under which the processes of `multiprocessing` run the user's script.

This name is not in the documentation of the standard library.
`tests.colias_sim.test_private_names` fails when it changes.
"""


def cloudpickled(value: Any) -> bytes:
    """Pickle a value by content: functions and classes of the user's script included, as no process imports that.

    Parameters
    ----------
    value
        Any object.

    Returns
    -------
    bytes
        For `pickle.loads`.

    Raises
    ------
    Exception
        Whatever the value's own pickling raises.
    """
    script = sys.modules.get(SPAWNED_MAIN)
    if script is None:
        return bytes(cloudpickle.dumps(value))
    cloudpickle.register_pickle_by_value(script)
    try:
        return bytes(cloudpickle.dumps(value))
    finally:
        cloudpickle.unregister_pickle_by_value(script)


def check_pickles(values: Mapping[str, Any]) -> None:
    """Check that keyword arguments can be sent to another process.

    Raises
    ------
    ValueError
        In one line, naming the first of ``values`` that does not pickle.
    """
    for name, value in values.items():
        try:
            cloudpickled(value)
        except Exception as error:
            raise ValueError(
                f"{name}={value!r} does not pickle, which another process needs ({error}): "
                "give something that does, or workers=0"
            ) from None


def pack_error(error: Exception | SystemExit) -> PackedError:
    """Convert an exception to what a pipe can carry, whether or not it pickles."""
    content = None
    if isinstance(error, Exception):  # a SystemExit that arrived whole would end whoever asked
        with contextlib.suppress(Exception):
            pickled = cloudpickled(error)
            pickle.loads(pickled)
            content = pickled
    try:
        message = str(error)
    except Exception:  # an exception of a user's own may have no words
        message = ""
    return content, f"{type(error).__name__}: {message}", "".join(traceback.format_exception(error))


def unpack_error(packed: PackedError, who: str) -> Exception:
    """Restore an exception from another process.

    Parameters
    ----------
    packed
        What `pack_error` gave.
    who
        The envs of that process, for the note.

    Returns
    -------
    Exception
        The exception itself, or a ``RuntimeError`` with the same words if it does not pickle. Its note has the
        traceback in the other process.
    """
    content, line, trace = packed
    error: Exception
    try:
        error = RuntimeError(line) if content is None else pickle.loads(content)
    except Exception:
        error = RuntimeError(line)
    error.add_note(f"in the process of {who}, where it came of:\n{trace}")
    return error
