"""Effects of Ctrl-C, moment by moment. Imports next to nothing: whatever is imported before `begin` is not guarded.

Python raises ``KeyboardInterrupt`` wherever the program happens to be. Inside the import of a compiled library that
is lost, or ends as an unrelated error; while worker processes start it leaves them half made. So a command of ours
takes Ctrl-C in one of three ways:

- usually, and from the first line on: the process ends at once, with one line and status 130. Nothing is lost by
  that, as every file of ours is written beside its place and then renamed;
- inside `held`: it waits, until the next `window` or `check`, or the end of that block;
- inside `window`, where a command only waits for something: ``KeyboardInterrupt`` is raised there.

A second Ctrl-C, a second or more after one that still waits, ends the process at once.

Without `begin`, which only a command line of ours calls, Python's own behaviour stays, and the blocks do nothing.
"""

from __future__ import annotations

import os
import signal
import time

TYPE_CHECKING = False  # that of typing, which takes as long
if TYPE_CHECKING:
    from typing import Any

STATUS = 130
SAID = "colias: interrupted"
IMPATIENT_S = 1.0
"""Two signals nearer than this are one wish: a terminal and a parent may both send it."""

_NOW, _HELD, _OPEN = "now", "held", "open"


class _State:
    """State of interrupts: how the next Ctrl-C is taken, when the last was noted, whether it has been passed on."""

    mode = _NOW
    noted_s: float | None = None
    raised = False


def begin() -> None:
    """Take over Ctrl-C for this process, unless whoever started it wanted it ignored."""
    if signal.getsignal(signal.SIGINT) in (signal.default_int_handler, signal.SIG_DFL):
        signal.signal(signal.SIGINT, _heed)


def end() -> None:
    """Ignore Ctrl-C from here on: of a process that has done everything it is the interpreter's own end."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def leave() -> None:
    """End this process at once, without a word from any library."""
    try:
        os.write(2, f"{SAID}\n".encode())
    finally:
        os._exit(STATUS)


def _heed(*_: Any) -> None:
    if _State.mode == _NOW:
        leave()
    now = time.monotonic()
    if _State.noted_s is None:
        _State.noted_s = now
        if _State.mode == _OPEN:
            check()
    elif now - _State.noted_s >= IMPATIENT_S:
        leave()


def check() -> None:
    """Raise ``KeyboardInterrupt`` if a Ctrl-C was noted, once."""
    if _State.noted_s is not None and not _State.raised:
        _State.raised = True
        raise KeyboardInterrupt


class _Block:
    """A block of code in which Ctrl-C is taken one way."""

    def __init__(self, mode: str) -> None:
        self._mode = mode

    def __enter__(self) -> None:
        self._before, _State.mode = _State.mode, self._mode
        if self._mode == _OPEN:
            try:
                check()
            except KeyboardInterrupt:
                _State.mode = self._before
                raise

    def __exit__(self, kind: object, *_: object) -> None:
        _State.mode = self._before
        if kind is None and self._before != _HELD:
            check()


def held() -> _Block:
    """Let Ctrl-C wait while this block runs; at its end ``KeyboardInterrupt`` is raised if one came."""
    return _Block(_HELD)


def window() -> _Block:
    """Inside `held`: ``KeyboardInterrupt`` may be raised anywhere in this block, and is if a Ctrl-C waits."""
    return _Block(_OPEN)
