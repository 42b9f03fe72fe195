"""How a vector env's processes start: a new interpreter, which inherits a pipe and memory and no other file.

A process forked with an OpenGL context hangs. One started by `multiprocessing` imports the user's script again, which
a script without ``if __name__ == "__main__":`` does not survive.
"""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

if sys.platform != "win32":  # where there are no workers, see `POSSIBLE`
    import fcntl

POSSIBLE = os.name == "posix"
"""Whether there can be workers: they inherit file descriptors."""

WORKER = Path(__file__).with_name("worker.py")

_FLAGS = {
    "debug": "-d", "optimize": "-O", "dont_write_bytecode": "-B", "no_user_site": "-s", "no_site": "-S",
    "ignore_environment": "-E", "isolated": "-I", "verbose": "-v", "bytes_warning": "-b",
    "dev_mode": "-Xdev", "utf8_mode": "-Xutf8", "warn_default_encoding": "-Xwarn_default_encoding",
}  # fmt: skip
"""The interpreter's option for each entry of ``sys.flags`` that another process should have too."""


def launched(pipe: int, board: int) -> subprocess.Popen[bytes]:
    """A worker, deaf to Ctrl-C from its first moment, with these two file descriptors and nothing to read as stdin.

    Working directory, environment and the interpreter's flags are this process's.
    """
    if not sys.executable:
        raise RuntimeError("sys.executable is empty, so no other process can be started: give workers=0")
    # -P: sys.path is sent; until then, modules beside worker.py must not be taken for the standard library's.
    command = [sys.executable, "-P", *_interpreter_flags(), str(WORKER)]
    # Ctrl-C goes to all of a terminal's processes: it is this one's to handle.
    with _above_standard(pipe) as one, _above_standard(board) as two, _no_interrupt():
        return subprocess.Popen([*command, str(one), str(two)], stdin=subprocess.DEVNULL, pass_fds=(one, two))


def shared_memory(size: int) -> int:
    """A file descriptor of so many bytes of zeros, which have no name that could be left behind."""
    try:
        descriptor = os.memfd_create("colias-board")
    except (AttributeError, OSError):  # not Linux, or an old one
        with tempfile.TemporaryFile() as file:
            descriptor = os.dup(file.fileno())
    os.ftruncate(descriptor, size)
    return descriptor


def _interpreter_flags() -> list[str]:
    given = [option for name, option in _FLAGS.items() for _ in range(int(getattr(sys.flags, name)))]
    return [*given, *(f"-W{option}" for option in sys.warnoptions)]


@contextlib.contextmanager
def _above_standard(descriptor: int) -> Iterator[int]:
    """A copy of a file descriptor that is not 0, 1 or 2, which it may be where this process was started without."""
    copy = fcntl.fcntl(descriptor, fcntl.F_DUPFD_CLOEXEC, 3)
    try:
        yield copy
    finally:
        os.close(copy)


@contextlib.contextmanager
def _no_interrupt() -> Iterator[None]:
    """Block SIGINT: a process started in here inherits that."""
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
