"""The first lines of a worker process. `launch.start_worker` runs this file by its path, with two numbers.

The numbers are file descriptors: the worker's end of a pipe, and the memory of the buffers. This file imports nothing
but the standard library at its top: the list of places where modules are found (``sys.path``) is the first message on
the pipe. The user's script is never imported.
"""

from __future__ import annotations

import signal
import sys
import traceback
from multiprocessing.connection import Connection


def main(pipe_fd: int, memory_fd: int) -> None:
    """Receive where modules are found and what to host; then serve until the pipe ends.

    Parameters
    ----------
    pipe_fd, memory_fd
        The two file descriptors.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # blocked until here by the process that started this one
    signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
    # The documentation of the standard library does not tell how a `Connection` is made from a file descriptor;
    # `tests.colias_sim.test_private_names` fails when that changes.
    pipe = Connection(pipe_fd)
    try:
        sys.path[:], content = pipe.recv()
    except (EOFError, ConnectionError):
        return
    try:
        from colias_sim.envs.vector.worker import serve
    except Exception as error:  # for example no OpenGL library; sent in the form of `pickling.pack_error`
        pipe.send((False, (None, f"{type(error).__name__}: {error}", traceback.format_exc())))
        return
    serve(pipe, memory_fd, content)


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
