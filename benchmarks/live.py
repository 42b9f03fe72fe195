"""A frame of ``colias live``: the trial alone, and with the page that shows it, without a browser.

``python -m benchmarks.live`` runs these alone. It needs the extra ``[live]``.
"""

from __future__ import annotations

import importlib.util
import resource

from rich.console import Console
from rich.table import Table

from benchmarks.timing import interleaved

ALONE, SHOWN = "the trial alone", "with its page"
FRAMES = 90
PORT = 8469
LONG = 3000
"""Frames over which the memory is watched."""


def table() -> Table:
    """Milliseconds a frame, frames a second, and how much the memory grows."""
    result = Table("a frame of colias live", "ms, best", "frames/s", "ratio")
    if importlib.util.find_spec("viser") is None:
        result.add_row("viser is not installed", "", "", "")
        return result
    from experiments.bench.live.arena import ArenaSession as Session
    from experiments.bench.live.page import Page

    session = Session(["dsnn"])
    page = Page(session, "127.0.0.1", PORT)

    def alone() -> int:
        for _ in range(FRAMES):
            session.step()
        return FRAMES

    def shown() -> int:
        for _ in range(FRAMES):
            page.inputs.heed()
            page.show(session.step(), 1.0)
        return FRAMES

    try:
        times = interleaved({ALONE: alone, SHOWN: shown}, 7)
        for name in (ALONE, SHOWN):
            best, ratio = times.us(name), times.ratio(name, ALONE)
            result.add_row(name, f"{best / 1000:.2f}", f"{1e6 / best:.0f}", f"{ratio:.2f}")
        before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        for _ in range(LONG):
            page.show(session.step(), 1.0)
        grown = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before
        result.add_row(f"memory after {LONG} more frames", f"+{grown / 1024:.1f} MB", "", "")
    finally:
        page.close()
    return result


if __name__ == "__main__":
    Console().print(table())
