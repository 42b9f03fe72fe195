"""Rerun's viewer as another process: whether there is a screen for it, where one listens, and a new one."""

from __future__ import annotations

import re
import socket
import subprocess
import time

from colias_sim.gl import has_screen
from experiments.bench.engine.terminal import program
from experiments.bench.run.errors import UsageError, short

HOST, PORT = "127.0.0.1", 9876
"""Where Rerun's viewer listens unless it is told otherwise."""
START_S, SETTLES_S, ANSWERS_S = 20.0, 1.0, 2.0
"""How long a viewer may take to listen, to find that it has no window, and to answer."""
MEMORY = "1GB"
"""A viewer then drops the oldest data: a camera may run for days."""
GREETING = b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n" + bytes([0, 0, 0, 4, 0, 0, 0, 0, 0])
"""What a client of gRPC sends first: HTTP/2's preface and empty settings."""
SETTINGS = 4
"""The type of the frame that a server of HTTP/2 answers with."""


def require_screen(what: str, instead: str) -> None:
    """Raise `UsageError` where there is no screen to open a window on; ``instead`` says what to do then."""
    if not has_screen():
        raise UsageError(f"{what}Rerun's viewer needs a screen (DISPLAY is not set): {instead}")


def url(address: str) -> str:
    """Return the URL of the viewer at an address, HOST:PORT."""
    return f"rerun+http://{address}/proxy"


def parsed(text: str) -> str:
    """Check the address of a viewer, HOST:PORT or the URL that it prints; return HOST:PORT."""
    match = re.fullmatch(r"(?:rerun\+http://)?([A-Za-z0-9.\-]+):(\d{1,5})(?:/proxy)?", text)
    if match is None or not 0 < int(match[2]) < 2**16:
        raise UsageError(f"--viewer {short(text)}: legal is HOST:PORT, as {HOST}:{PORT}")
    return f"{match[1]}:{match[2]}"


def listens(address: str) -> bool:
    """Tell whether something that speaks HTTP/2, as a viewer does, listens at an address, HOST:PORT."""
    host, _, port = address.rpartition(":")
    try:
        with socket.create_connection((host, int(port)), ANSWERS_S) as connection:
            connection.settimeout(ANSWERS_S)
            connection.sendall(GREETING)
            head = connection.recv(9)
    except OSError:
        return False
    return len(head) == 9 and head[3] == SETTINGS


def opened(instead: str) -> tuple[subprocess.Popen[bytes], str]:
    """Open a viewer of its own that listens on this machine alone, and stays open when this process is over.

    Parameters
    ----------
    instead
        What to do where none can open.

    Returns
    -------
    subprocess.Popen
        The viewer.
    str
        Its address, HOST:PORT.

    Raises
    ------
    UsageError
        It does not open.
    """
    port = free_port()
    command = [*program(), "--bind", HOST, "--port", f"{port}"]
    command += ["--memory-limit", MEMORY, "--expect-data-soon", "--hide-welcome-screen"]
    # A session of its own: Ctrl-C is meant for the command, not for the viewer.
    quiet = subprocess.DEVNULL  # or a pipe that reads our output would wait for the viewer
    viewer = subprocess.Popen(command, stdout=quiet, stderr=quiet, start_new_session=True)
    _await(viewer, port, instead)
    return viewer, f"{HOST}:{port}"


def _await(viewer: subprocess.Popen[bytes], port: int, instead: str) -> None:
    """Wait until the viewer listens, and a moment longer: it listens before it finds that it has no window."""
    deadline = time.monotonic() + START_S
    while viewer.poll() is None and time.monotonic() < deadline:
        with socket.socket() as probe:
            listening = probe.connect_ex((HOST, port)) == 0
        time.sleep(SETTLES_S if listening else 0.05)
        if listening and viewer.poll() is None:
            return
    viewer.terminate()
    raise UsageError(instead)


def free_port() -> int:
    """Return a port of this machine that nothing listens at."""
    with socket.socket() as probe:
        probe.bind((HOST, 0))
        return int(probe.getsockname()[1])
