"""The start of a vector env's processes: a new interpreter each, which inherits a pipe and memory and no other file.

Two usual ways do not work here. A process that is forked with an OpenGL context hangs. A process that is started by
`multiprocessing` imports the user's script again, which fails without ``if __name__ == "__main__":`` in the script.
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

POSSIBLE = os.name == "posix"
"""Whether there can be worker processes. They inherit file descriptors, which needs POSIX."""

BOOTSTRAP = Path(__file__).with_name("bootstrap.py")
"""The file that a worker process runs."""

_FLAGS = {
    "debug": "-d", "optimize": "-O", "dont_write_bytecode": "-B", "no_user_site": "-s", "no_site": "-S",
    "ignore_environment": "-E", "isolated": "-I", "verbose": "-v", "bytes_warning": "-b",
    "dev_mode": "-Xdev", "utf8_mode": "-Xutf8", "warn_default_encoding": "-Xwarn_default_encoding",
}  # fmt: skip
"""Entry of ``sys.flags`` -> the interpreter's option that sets it, for all that a worker process is to share."""


def start_worker(pipe: int, memory: int) -> subprocess.Popen[bytes]:
    """Start a worker process, which ignores Ctrl-C from its first moment.

    Working directory, environment and the interpreter's flags are those of this process; standard input is empty.

    Parameters
    ----------
    pipe
        File descriptor of the worker's end of a pipe.
    memory
        File descriptor of the memory of the buffers.

    Returns
    -------
    subprocess.Popen
        The process.

    Raises
    ------
    RuntimeError
        Where ``sys.executable`` is empty, as in an embedded interpreter.
    """
    if not sys.executable:
        raise RuntimeError("sys.executable is empty, so no other process can be started: give workers=0")
    # -P: until sys.path is sent, modules beside bootstrap.py must not be taken for those of the standard library.
    command = [sys.executable, "-P", *_interpreter_flags(), str(BOOTSTRAP)]
    # Ctrl-C goes to all processes of a terminal; this one handles it.
    with _above_standard(pipe) as one, _above_standard(memory) as two, _no_interrupt():
        return subprocess.Popen([*command, str(one), str(two)], stdin=subprocess.DEVNULL, pass_fds=(one, two))


def shared_memory(size: int) -> int:
    """Make memory for several processes. It has no name in any file system, so nothing can be left behind.

    Parameters
    ----------
    size
        Bytes, all zero.

    Returns
    -------
    int
        A file descriptor, to be closed by the caller.
    """
    try:
        descriptor = os.memfd_create("colias-buffers")
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
    """Yield a copy, above 2, of a file descriptor: the original may be 0, 1 or 2 without standard streams."""
    import fcntl  # Windows has none, and no workers: see `POSSIBLE`

    copy = fcntl.fcntl(descriptor, fcntl.F_DUPFD_CLOEXEC, 3)
    try:
        yield copy
    finally:
        os.close(copy)


@contextlib.contextmanager
def _no_interrupt() -> Iterator[None]:
    """Block SIGINT; a process that is started inside inherits the block."""
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
