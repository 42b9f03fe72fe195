"""Rerun's viewer, its web server, or a picture of it, by a process that ends with the command that opened it."""

from __future__ import annotations

import re
import signal
import subprocess
import tempfile
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any

from experiments.bench.engine.terminal import program
from experiments.bench.run import interrupts
from experiments.bench.run.errors import UsageError
from experiments.bench.viewer import HOST, SETTLES_S, free_port, listens, url

if TYPE_CHECKING:
    from rerun.experimental import ViewerClient

PATIENCE_S = 5.0
"""How long a viewer may take to end before it is killed."""
TIMELINE, WINDOW, PAINTS_S = "time", "1400x840", 60.0
"""Timeline and size of a picture, and how long it may take."""
ENDING = ("SIGTERM", "SIGHUP")


def show(files: Sequence[Path], *, web: bool = False, instead: str) -> int:
    """Open recordings in Rerun, listening on 127.0.0.1 only, and wait until it is closed; returns its exit status.

    When this process ends, the viewer ends too, unless this is killed. Raises `UsageError`, which tells ``instead``,
    where its window does not open.
    """
    paths = [str(file.absolute()) for file in files]  # a name such as --save=a.rrd is no option
    command = [*program(), "--bind", "127.0.0.1", *(["--web-viewer"] if web else []), *paths]
    if web:  # what it says has the address in it
        return _attend(command, None)
    with tempfile.TemporaryFile("w+", encoding="utf-8", errors="replace") as output:
        status = _attend(command, output)
        output.seek(0)
        # Without the place in its source.
        why = [re.sub(r"^Error: (.*\.rs:\d+: )?", "", line.strip()) for line in output if line.startswith("Error: ")]
    if status > 0:
        reason = why[-1] if why else f"exit status {status}"
        raise UsageError(f"Rerun's viewer did not open, or broke off ({reason}): {instead}")
    return status


def _attend(command: Sequence[str], output: IO[str] | None) -> int:
    """Run a command until it ends, and no longer than this process; ``output`` takes what it writes."""
    with _ended_in_order(), interrupts.held():
        # In a session of its own a terminal's Ctrl-C comes to this process alone, which then ends the viewer.
        child = subprocess.Popen(command, stdout=output, stderr=output, start_new_session=True)
        try:
            with interrupts.window():
                status = child.wait()
        finally:
            _end(child)
    return status if status >= 0 else 128 - status


def _end(child: subprocess.Popen[Any]) -> None:
    child.terminate()
    try:
        child.wait(PATIENCE_S)
    except subprocess.TimeoutExpired:
        child.kill()
        child.wait()


@contextmanager
def _ended_in_order() -> Iterator[None]:
    """While this lasts, a signal that asks this process to end lets it end what it has started first."""

    def leave(number: int, _: Any) -> None:
        raise SystemExit(128 + number)

    numbers = [getattr(signal, name) for name in ENDING if hasattr(signal, name)]
    heeded = [number for number in numbers if signal.getsignal(number) is not signal.SIG_IGN]  # nohup's stays ignored
    before = {number: signal.signal(number, leave) for number in heeded}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


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
    options = ["--headless", "--hide-welcome-screen", "--window-size", WINDOW, "--bind", HOST, "--port", f"{port}"]
    quiet = subprocess.DEVNULL
    with _ended_in_order():
        child = subprocess.Popen([*program(), *options, str(file.absolute())], stdout=quiet, stderr=quiet)
        try:
            deadline = time.monotonic() + PAINTS_S
            while not listens(f"{HOST}:{port}"):
                if child.poll() is not None or time.monotonic() > deadline:
                    raise UsageError("Rerun's viewer cannot draw: on Debian run 'apt-get install mesa-vulkan-drivers'")
                time.sleep(0.1)
            place.write_bytes(_painted(ViewerClient.connect(url(f"{HOST}:{port}")), deadline))
        except ConnectionError:
            raise UsageError(f"Rerun's viewer broke off while it opened {file}") from None
        finally:
            _end(child)


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
