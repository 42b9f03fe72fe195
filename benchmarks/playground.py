"""Benchmark of the playground in Chromium, from disk: ``python -m benchmarks.playground``, after ``make docs``.

Times are in milliseconds, so they are not among the ratios of ``make bench``: from the start of the page to the first
trial drawn, and from the event of a slider to the trial redrawn, the median and the slowest of 20 moves.
"""

from __future__ import annotations

import statistics
import sys
import tempfile
from pathlib import Path

from rich.console import Console
from rich.table import Table

from tests.helpers.browser import CHROMIUM, browser
from tests.helpers.site import SITE
from tools.pages.playground import PAGE

TRIALS = ("speed-6", "speed-4", "speed-2", "clutter")
WINDOWS = {"desktop": dict(width=1280, height=900), "phone": dict(width=390, height=844, phone=True)}
MOVES = """(async () => {
  const input = document.getElementById("input-w_i"), taken = [];
  const marks = (name) => performance.getEntriesByName(name);
  for (let i = 0; i < 20; i++) {
    const drawn = marks("drawn").length;
    input.value = 0.05 * i;
    input.dispatchEvent(new Event("input"));
    while (marks("drawn").length === drawn) await new Promise(requestAnimationFrame);
    taken.push(marks("drawn").at(-1).startTime - marks("moved").at(-1).startTime);
  }
  return taken;
})()"""


def table() -> Table:
    """Return the times of `TRIALS` in both windows."""
    times = Table("window", "trial", "frames", "first drawn, ms", "redrawn, ms", "slowest", title="playground")
    with tempfile.TemporaryDirectory() as profile, browser(Path(profile)) as tab:
        for window, size in WINDOWS.items():
            for trial in TRIALS:
                tab.show(f"{(SITE / PAGE).as_uri()}#trial={trial}", **size)
                tab.until("performance.getEntriesByName('counted').length")
                first = tab.ask("performance.getEntriesByName('drawn')[0].startTime")
                frames = 1 + int(tab.ask("document.getElementById('scrubber').max"))
                taken = tab.ask(MOVES)
                middle, slowest = statistics.median(taken), max(taken)
                times.add_row(window, trial, str(frames), f"{first:.0f}", f"{middle:.0f}", f"{slowest:.0f}")
    return times


if __name__ == "__main__":
    if CHROMIUM is None or not (SITE / PAGE).exists():
        sys.exit(f"needs chromium, and {SITE / PAGE}: make docs builds it")
    Console().print(table())
