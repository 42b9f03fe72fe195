"""The first lines of a vector env's worker. `launching.launched` runs this file by its path, with two numbers.

They are the file descriptors of the worker's end of a pipe, and of the board's memory. Nothing of this package is
imported at the top: where modules are found is the first thing that the starting process sends. Its script is not
imported at all.
"""

from __future__ import annotations

import signal
import sys
import traceback
from multiprocessing.connection import Connection


def main(pipe_fd: int, board_fd: int) -> None:
    """Learn where modules are found, and what to host; then serve until nobody is there to ask."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # blocked until here, by the process that started this one
    signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
    pipe = Connection(pipe_fd)
    try:
        sys.path[:], content = pipe.recv()
    except (EOFError, ConnectionError):
        return
    try:
        from colias_sim.envs.serving import serve
    except Exception as error:  # no OpenGL library, for one; sent as `telling.told` would
        pipe.send((False, (None, f"{type(error).__name__}: {error}", traceback.format_exc())))
        return
    serve(pipe, board_fd, content)


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
