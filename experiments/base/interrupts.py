"""Effects of Ctrl-C on a command. Imports next to nothing: whatever is imported before `begin` is not guarded.

Python raises ``KeyboardInterrupt`` wherever the program happens to be. Inside the import of a compiled library that is
lost, or ends as an unrelated error. So Ctrl-C ends a command of ours at once, with one line and status 130. Nothing is
lost by that, as every file of ours is written under another name and then renamed. A command that has to clean up
first does so in a block of `once`; a second Ctrl-C ends it at once even there.

Without `begin`, which only a command line of ours calls, Python's own behaviour stays, and the blocks do nothing.
"""

import os
import signal
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

STATUS = 130
MESSAGE = "colias: interrupted"
IMPATIENT_S = 1.0
"""Two signals nearer than this are one wish: a terminal and a parent may both send it."""


def open_streams() -> None:
    """Write to nowhere what a process that was started with a closed stream would write there: libraries flush it."""
    while (number := os.open(os.devnull, os.O_RDWR)) <= 2:  # the lowest that is free, or a pipe would be taken for it
        os.set_inheritable(number, True)
    os.close(number)
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:
            setattr(sys, name, Path(os.devnull).open("w", encoding="utf-8"))  # noqa: SIM115 - until the process ends


def begin() -> None:
    """Take over Ctrl-C for this process, unless whoever started it wanted it ignored."""
    if signal.getsignal(signal.SIGINT) in (signal.default_int_handler, signal.SIG_DFL):
        signal.signal(signal.SIGINT, leave)


def end() -> None:
    """Ignore Ctrl-C from here on: of a process that has done everything it is the interpreter's own end."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def leave(*_: object) -> None:
    """End this process at once, without a word from any library."""
    try:
        os.write(2, f"{MESSAGE}\n".encode())
    finally:
        os._exit(STATUS)


def _raise() -> None:
    raise KeyboardInterrupt


@contextmanager
def once(action: Callable[[], None] = _raise) -> Iterator[None]:
    """At the first Ctrl-C in this block do something else than `leave`: raise ``KeyboardInterrupt`` by default."""
    if signal.getsignal(signal.SIGINT) is not leave:
        yield
        return

    def interrupt(*_: object) -> None:
        first_s = time.monotonic()
        signal.signal(signal.SIGINT, lambda *_: leave() if time.monotonic() - first_s > IMPATIENT_S else None)
        action()

    signal.signal(signal.SIGINT, interrupt)
    try:
        yield
    finally:
        if signal.getsignal(signal.SIGINT) is interrupt:  # otherwise it was done, and the command is about to end
            signal.signal(signal.SIGINT, leave)
