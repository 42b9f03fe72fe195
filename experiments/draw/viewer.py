"""Rerun's viewer as another process: whether there is a screen for it, where one listens, a new one, a picture."""

from __future__ import annotations

import importlib.util
import os
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING
from urllib.parse import quote

from colias_sim.gl import has_screen
from experiments.base.console import out_console
from experiments.base.errors import UsageError

if TYPE_CHECKING:
    from rerun.experimental import ViewerClient

HOST = "127.0.0.1"
START_S, SETTLES_S, ANSWERS_S = 20.0, 1.0, 2.0
"""How long a viewer may take to listen, to find that it has no window, and to answer."""
QUIET = {"RUST_LOG": "error", "CI": "true"}
"""Environment of a viewer: without its log, and without its reports of use, which it makes nowhere in a test run."""
MEMORY = "1GB"
"""A viewer then drops the oldest data: a camera may run for days."""


def program() -> list[str]:
    """Rerun's viewer as a command: the program itself, which its Python package would leave running when ended."""
    spec = importlib.util.find_spec("rerun_cli")
    binary = Path(spec.origin).parent / "rerun" if spec and spec.origin else None
    return [str(binary)] if binary and binary.is_file() else [sys.executable, "-P", "-m", "rerun_cli"]


def require_screen(what: str, instead: str) -> None:
    """Raise `UsageError` where there is no screen to open a window on; ``instead`` says what to do then."""
    if not has_screen():
        raise UsageError(f"{what}the viewer needs a screen (DISPLAY is not set): {instead}")


def url(port: int) -> str:
    """Return the URL of the viewer at a port of this machine."""
    return f"rerun+http://{HOST}:{port}/proxy"


def listens(port: int) -> bool:
    """Tell whether something listens at a port of this machine."""
    try:
        with socket.create_connection((HOST, port), ANSWERS_S):
            return True
    except OSError:
        return False


def opened(instead: str) -> str:
    """Open a viewer that stays open when this process is over; return its URL, or raise `UsageError` (``instead``)."""
    port = free_port()
    command = [*program(), "--bind", HOST, "--port", f"{port}"]
    command += ["--memory-limit", MEMORY, "--expect-data-soon", "--hide-welcome-screen"]
    # A session of its own: Ctrl-C is meant for the command, not for the viewer.
    quiet = subprocess.DEVNULL  # or a pipe that reads our output would wait for the viewer
    viewer = subprocess.Popen(command, env=QUIET | os.environ, stdout=quiet, stderr=quiet, start_new_session=True)
    deadline = time.monotonic() + START_S
    while viewer.poll() is None and time.monotonic() < deadline:
        listening = listens(port)
        time.sleep(SETTLES_S if listening else 0.05)  # it listens before it finds that it has no window
        if listening and viewer.poll() is None:
            return url(port)
    viewer.terminate()
    raise UsageError(instead)


def free_port() -> int:
    """Return a port of this machine that nothing listens at."""
    with socket.socket() as probe:
        probe.bind((HOST, 0))
        return int(probe.getsockname()[1])


TIMELINE, WINDOW, PAINTS_S = "time", "1400x840", 60.0
"""Timeline and size of a picture, and how long it may take."""


@contextmanager
def _running(*options: str, stderr: int | None = None) -> Iterator[subprocess.Popen[bytes]]:
    """Run a viewer that listens on this machine alone; it ends with the block, and when SIGTERM ends this process."""
    command = [*program(), "--bind", HOST, *options]
    with subprocess.Popen(command, env=QUIET | os.environ, stdout=subprocess.DEVNULL, stderr=stderr) as child:
        before = signal.signal(signal.SIGTERM, lambda *_: child.terminate())
        try:
            yield child
        finally:
            child.terminate()
            signal.signal(signal.SIGTERM, before)


def show(files: Sequence[Path], *, web: bool = False) -> int:
    """Open recordings in Rerun, in a browser its address is printed for, and wait until it is closed.

    Returns
    -------
    int
        Its exit status.
    """
    paths = [str(file.absolute()) for file in files]  # a name such as --save=a.rrd is no option
    port, page = free_port(), free_port()
    # With a screen it opens the browser too.
    served = ["--web-viewer" if has_screen() else "--serve-web", "--web-viewer-port", f"{page}"] if web else []
    with _running("--port", f"{port}", *served, *paths) as child:
        while web and child.poll() is None and not listens(page):
            time.sleep(0.05)
        if web and child.poll() is None:
            out_console.print(f"http://{HOST}:{page}?url={quote(url(port), safe='')} shows them; Ctrl-C ends it")
        status = child.wait()
    return status if status >= 0 else 128 - status


def screenshot(file: Path, place: Path) -> None:
    """Save a picture of a recording as the viewer opens it, at the middle of its time; no screen is needed.

    Parameters
    ----------
    file
        The recording.
    place
        The .png file.

    Raises
    ------
    UsageError
        The viewer cannot draw, or does not finish in `PAINTS_S`.
    """
    from rerun.experimental import ViewerClient

    port = free_port()
    options = ["--headless", "--hide-welcome-screen", "--window-size", WINDOW, "--port", f"{port}"]
    with _running(*options, str(file.absolute()), stderr=subprocess.DEVNULL) as child:
        try:
            deadline = time.monotonic() + PAINTS_S
            while not listens(port):
                if child.poll() is not None or time.monotonic() > deadline:
                    raise UsageError("Rerun's viewer cannot draw: on Debian run 'apt-get install mesa-vulkan-drivers'")
                time.sleep(0.1)
            place.write_bytes(_painted(ViewerClient.connect(url(port)), deadline))
        except (ConnectionError, TimeoutError):
            raise UsageError(f"Rerun's viewer broke off while it opened {file}") from None


def _painted(viewer: ViewerClient, deadline: float) -> bytes:
    """Return a picture of the window, PNG, once all is loaded and two pictures in a row are equal."""
    before, at_middle = b"", False
    while time.monotonic() < deadline:
        state = viewer.get_state()
        known = [line for one in state.recordings for line in one.timelines if line.name == TIMELINE]
        if known and not state.loading and state.views:
            if not at_middle:
                middle = ((known[0].start or 0) + (known[0].end or 0)) / 2e9
                viewer.set_time(TIMELINE, duration=middle, play_state="paused")
                at_middle, before = True, b""
            picture = viewer.take_screenshot()
            if picture == before:
                return picture
            before = picture
        time.sleep(SETTLES_S)
    raise UsageError("Rerun's viewer did not finish painting")
