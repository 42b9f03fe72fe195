"""A frame of ``colias live``: the trial alone, with the page that shows it, and with a client that looks at the page.

``python -m benchmarks.live`` runs these alone. It needs the extra ``[live]``. The client takes all that a browser
takes, in a process of its own, and draws nothing.
"""

from __future__ import annotations

import importlib.util
import os
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from rich.console import Console
from rich.table import Table

from benchmarks.timing import interleaved

if TYPE_CHECKING:
    from experiments.bench.live.page import Page

ALONE, SHOWN, SEEN = "the trial alone", "with its page", "with its page, and a client that looks at it"
FRAMES, ROUNDS = 90, 7
PORT = 8469
LONG = 3000
"""Frames over which the memory is watched."""
CLIENT = """
import sys, msgspec, viser
from viser._messages import ViewerCameraMessage
from websockets.sync.client import connect
up = 0.0, 0.0, 1.0
camera = ViewerCameraMessage((1.0, 0.0, 0.0, 0.0), up, 1.0, 0.1, 9.0, 600, 800, (0.0, 0.0, 0.0), up)
with connect(sys.argv[1], subprotocols=[f"viser-v{viser.__version__}"], max_size=None) as socket:
    socket.send(msgspec.msgpack.encode(camera.as_serializable_dict()))
    while True:
        socket.recv()
"""


@contextmanager
def looking(page: Page) -> Iterator[None]:
    """Let a client take everything that the page sends."""
    client = subprocess.Popen(
        [sys.executable, "-c", CLIENT, page.address.replace("http", "ws")], stderr=subprocess.DEVNULL
    )
    try:
        while not page.server.get_clients():
            time.sleep(0.01)
        yield
    finally:
        client.kill()
        client.wait()
        while page.server.get_clients():
            time.sleep(0.01)


def table() -> Table:
    """Milliseconds a frame, frames a second, and how much the memory grows."""
    result = Table("a frame of colias live, with all panels", "ms, best", "frames/s", "ratio")
    if importlib.util.find_spec("viser") is None:
        result.add_row("viser is not installed", "", "", "")
        return result
    from experiments.bench.live.arena import ArenaSession
    from experiments.bench.live.page import Page

    session = ArenaSession(["dsnn"])
    pages = [Page(session, "127.0.0.1", PORT + offset) for offset in (0, 1)]

    def alone() -> int:
        for _ in range(FRAMES):
            session.step()
        return FRAMES

    def show_frames(page: Page, frames: int = FRAMES) -> int:
        for _ in range(frames):
            page.inputs.heed()
            page.show(session.step(), 1.0)
        return frames

    try:
        with looking(pages[1]):
            work = {ALONE: alone, SHOWN: partial(show_frames, pages[0]), SEEN: partial(show_frames, pages[1])}
            times = interleaved(work, ROUNDS)
            for name in work:
                best, ratio = times.us(name), times.ratio(name, ALONE)
                result.add_row(name, f"{best / 1000:.2f}", f"{1e6 / best:.0f}", f"{ratio:.2f}")
            before = _resident_mb()
            show_frames(pages[1], LONG)
            result.add_row(f"memory after {LONG} more frames", f"{_resident_mb() - before:+.1f} MB", "", "")
    finally:
        for page in pages:
            page.close()
    return result


def _resident_mb() -> float:
    return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 1e6


if __name__ == "__main__":
    Console().print(table())
