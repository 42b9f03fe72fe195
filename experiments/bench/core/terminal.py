"""What commands print: the two consoles, progress with the time left, verdicts, and where results are.

The time left is estimated from a run's own first jobs, on this machine.
"""

from __future__ import annotations

import importlib.util
import os
import sys
import time
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Protocol

from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, MofNCompleteColumn, Progress, ProgressColumn, Task, TextColumn
from rich.text import Text

from experiments.bench.core.verdict import Verdict

LINE_EVERY_S = 60.0
"""How often to tell where there is no terminal to draw a bar on."""
MINUTES_FROM_S = 150.0

out_console = Console(highlight=False, emoji=False, width=None if sys.stdout.isatty() else 100)
error_console = Console(stderr=True, highlight=False, emoji=False)

VERDICT_COLOURS: Mapping[str, str] = {
    "holds": "green", "fails": "red", "vacuous": "yellow", "untestable": "yellow", "untested": "yellow",
    "fragile": "yellow", "mixed": "yellow",
}  # fmt: skip


def count(number: int, thing: str) -> str:
    """Return ``1 trial``, ``2 trials``."""
    return f"{number} {thing}{'s' * (number != 1)}"


def coloured(verdict: str) -> str:
    """Return a verdict's word in its colour, as markup."""
    return f"[{VERDICT_COLOURS[verdict]}]{verdict}[/{VERDICT_COLOURS[verdict]}]"


def show_verdict(verdict: Verdict, *, model: bool) -> None:
    """Print a verdict: the claim, the number that decided, everything measured, the effect.

    ``model`` says whether to name the model that it is about.
    """
    who = f" ({escape(verdict.model)})" if model and verdict.model else ""
    found = coloured(verdict.verdict) + (f" [{verdict.provenance}]".replace("[", r"\[") if verdict.provenance else "")
    if (verdict.replicates or 0) > 1:
        found = f"{verdict.held} (replicate 0: {found})"
    out_console.print(f"\n[b]{verdict.id}[/b]{who} {found}: {verdict.says}")
    decided = f"decided by: {verdict.decided}" if verdict.decided else ""
    for line in filter(None, (decided, verdict.measured, verdict.effect)):
        out_console.print(f"    {line}", markup=False)


def tell_troubles(judged: Iterable[tuple[str, str]]) -> bool:
    """Print a line for each claim whose judge, a user's own, went wrong.

    Parameters
    ----------
    judged
        The claims' ids, and what went wrong; empty where nothing did.

    Returns
    -------
    bool
        Whether one did.
    """
    lines = dict.fromkeys(f"claim {claim}: {trouble}" for claim, trouble in judged if trouble)
    for line in lines:
        error_console.print(line, soft_wrap=True, markup=False)
    return bool(lines)


def show_places(places: Mapping[str, object]) -> None:
    """Print where results are: a line for each name and path."""
    for name, place in places.items():
        out_console.print(f"{name:<12}{place}", soft_wrap=True, markup=False)


class Advance(Protocol):
    """Called as each job is done or has failed, with its ``size`` in whatever unit the whole is told in.

    ``left`` is what the other jobs will take, where that is not the whole less the sizes so far.
    """

    def __call__(self, size: float = 1.0, left: float | None = None) -> None:
        """Count one more."""


class Pace:
    """How fast jobs come back, ``width`` at a time, the first of each worker aside: it has the worker's start in it.

    ``whole`` is the sum of the jobs' sizes. Nothing is said before ``least`` jobs are back.
    """

    def __init__(self, whole: float, width: int, least: int = 0) -> None:
        self._left, self._width, self._least = whole, max(width, 1), least
        self._since_s: float | None = None
        self._size = self._before = 0.0
        self.count = 0

    def add(self, size: float, now_s: float, left: float | None = None) -> None:
        """A job of that size is back, and so much work is ``left``; without it, the whole less all sizes so far."""
        self.count += 1
        self._size += size
        self._left = self._left - size if left is None else left
        if self.count == self._width:
            self._since_s, self._before = now_s, self._size
        self._now_s = now_s

    @property
    def known(self) -> bool:
        """Whether as many jobs again are back as there are workers, and no fewer than the least."""
        return self.count >= max(2 * self._width, self._least)

    def left_s(self) -> float | None:
        """Seconds that the rest will take, as of the last job; ``None`` before that is known."""
        if not self.known or self._since_s is None or self._size <= self._before:
            return None
        return max(self._left, 0.0) * (self._now_s - self._since_s) / (self._size - self._before)

    def said(self) -> str:
        """``about 40 s left``; empty before that is known."""
        left = self.left_s()
        if left is None:
            return ""
        return f"about {left:.0f} s left" if left < MINUTES_FROM_S else f"about {left / 60:.0f} min left"


class _Left(ProgressColumn):
    """The rate, and the time left."""

    def __init__(self, pace: Pace) -> None:
        super().__init__()
        self._pace = pace

    def render(self, task: Task) -> Text:
        rate = f"{task.speed:.1f}/s  " if task.speed else ""
        return Text(rate + self._pace.said())


@contextmanager
def progress(
    name: str, total: int, quiet: bool, things: str = "trials", *, width: int = 1, whole: float | None = None,
    least: int = 0,
) -> Iterator[Advance]:  # fmt: skip
    """Show how far ``total`` jobs have got, ``width`` under way at a time; yields what to call for each.

    On a terminal that is a bar with the time left. Elsewhere it is a line as soon as the time left is known, and one a
    minute. ``whole`` is the sum of the sizes that the calls will give; without it all jobs count alike.
    The time left is told once ``least`` jobs are back.
    """
    pace = Pace(float(total) if whole is None else whole, width, least)
    if quiet or not error_console.is_terminal:
        yield _lines(pace, total, quiet, things)
        return
    columns = (TextColumn("{task.description}", markup=False), BarColumn(), MofNCompleteColumn(), _Left(pace))
    with Progress(*columns, console=error_console, transient=True) as bar:
        task = bar.add_task(f"{name}: {things}", total=total)

        def advance(size: float = 1.0, left: float | None = None) -> None:
            pace.add(size, time.monotonic(), left)
            bar.advance(task)

        yield advance


def _lines(pace: Pace, total: int, quiet: bool, things: str) -> Advance:
    began_s = time.monotonic()
    told_s: float | None = None

    def advance(size: float = 1.0, left: float | None = None) -> None:
        nonlocal told_s
        now_s = time.monotonic()
        pace.add(size, now_s, left)
        if quiet or pace.count >= total or not pace.known:
            return
        if told_s is None:
            told_s = now_s
            error_console.print(f"{pace.said()}, by the first {pace.count} {things}", markup=False)
        elif now_s - told_s > LINE_EVERY_S:
            told_s = now_s
            rate = pace.count / (now_s - began_s)
            error_console.print(f"{pace.count} of {total} {things}, {rate:.1f}/s, {pace.said()}", markup=False)

    return advance


def program() -> list[str]:
    """Rerun's viewer as a command: the program itself, which its Python package would leave running when ended."""
    found = importlib.util.find_spec("rerun_cli")
    own = os.environ.get("RERUN_CLI_PATH")
    binary = Path(own) if own else Path(found.origin).parent / "rerun" if found and found.origin else None
    return [str(binary)] if binary is not None and binary.is_file() else [sys.executable, "-P", "-m", "rerun_cli"]
