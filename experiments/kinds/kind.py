"""What a kind of run is, and how any run is done: by its kind."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from experiments.kinds.result import Run, load
from experiments.kinds.tables import kind_of
from experiments.store.asked import Asked
from experiments.store.folder import RunFolder
from experiments.store.plan import Plan, filled
from experiments.store.workers import Workers

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class Kind:
    """A kind of run: to run it, ``plan`` and ``work``; to read what is in a folder, ``draw`` and ``show``.

    Parameters
    ----------
    plan
        Makes the plan of what was asked. Raises `UsageError` for what cannot be run.
    work
        Does what a folder lacks of a plan, and writes verdicts, tables and figures there.
    draw
        Draws the figure of a run from its folder alone: no file of a model is run. A text says why there is none.
    show
        Prints what a run comes to, from its folder alone.
    renders
        Whether its trials are drawn by OpenGL, on workers; ``None``: its work starts these itself, or needs none.
    summary
        The table that sums up such a run.
    chapter
        Heading of such runs on a page; empty of those that no page has.
    words
        Says what a run shows, from its folder alone.
    whole
        Whether its folder holds runs, and no trials of its own.
    """

    plan: Callable[[Asked], Plan[Any]]
    work: Callable[[Plan[Any], Path, Workers], None]
    draw: Callable[[Run], Figure] | str
    show: Callable[[Run], None]
    renders: bool | None = True
    summary: str = "summary.csv"
    chapter: str = ""
    words: Callable[[Run], str] = str
    whole: bool = False


def concluding(conclude: Callable[[Plan[Any], RunFolder], None]) -> Callable[[Plan[Any], Path, Workers], None]:
    """Return the work of a kind whose trials all go into one folder: do them, then conclude."""

    def work(plan: Plan[Any], out: Path, pool: Workers) -> None:
        with filled(plan, out, pool) as folder:
            conclude(plan, folder)

    return work


def planned(asked: Asked) -> Plan[Any]:
    """Return the plan of what was asked, by its kind; `UsageError` for what cannot be run. Nothing is written."""
    kind: Kind = kind_of(asked.kind)
    return kind.plan(asked)


def perform(plan: Plan[Any], out: Path, pool: Workers) -> Run:
    """Do what a folder lacks of a run, and judge and draw it.

    Parameters
    ----------
    plan
        From `planned`.
    out
        The run's folder: a new one, or one that holds a part of this run.
    pool
        Where the trials are done.

    Returns
    -------
    Run
        The run as its files have it.

    Raises
    ------
    UsageError
        The folder holds another run.
    """
    kind: Kind = kind_of(plan.asked.kind)
    if kind.renders is None:
        kind.work(plan, out, pool)
    else:
        with pool.running(rendering=kind.renders):
            kind.work(plan, out, pool)
    return load(out)
