"""The kinds of run: what a folder of each holds. ``run.json`` says the kind since the run began."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from experiments.bench.run.errors import UsageError
from experiments.bench.store import provenance
from experiments.bench.store.description import KIND


@dataclass(frozen=True, slots=True)
class Kind:
    """Kind of a run: what its folder holds.

    Parameters
    ----------
    name
        As ``run.json`` has it.
    what
        What it is a run of, for people.
    things
        What its jobs are called.
    summary
        The table that sums it up, beside ``trials.parquet``; empty where there is none.
    parts
        Whether its folders are runs of their own, and it has no tables itself.
    robot
        Whether its rows are of trials with the robot, each in one of the conditions of its design.
    """

    name: str
    what: str
    things: str = "trials"
    summary: str = ""
    parts: bool = False
    robot: bool = False


TRIALS = Kind("trials", "trials with the robot", summary="summary.csv", robot=True)
MEASURED = Kind("measured", "an imported log", summary="summary.csv", robot=True)
CLIPS = Kind("clips", "clips that models are shown", "clips", "summary.csv")
TUNING = Kind("tuning", "tuning curves", "clips", "preferences.csv")
EPISODES = Kind("episodes", "episodes of behaviours", "episodes", "summary.csv")
SWEEP = Kind("sweep", "a sweep", summary="counts.csv")
LEADERBOARD = Kind("leaderboard", "a leaderboard", summary="leaderboard.csv", parts=True)
FIT = Kind("fit", "a fit", summary="fit.csv", parts=True)
REPRODUCTION = Kind("reproduction", "a reproduction", parts=True)
WHOLE = Kind("whole", "several runs", parts=True)
"""Of a folder that says nothing of itself, where folders in it are runs."""
FOOTAGE = Kind("footage", "footage that was watched", "frames")

KINDS: Mapping[str, Kind] = {
    kind.name: kind
    for kind in (
        TRIALS, MEASURED, CLIPS, TUNING, EPISODES, SWEEP, LEADERBOARD, FIT, REPRODUCTION,
        WHOLE, FOOTAGE,
    )
}  # fmt: skip


def kind_of(folder: Path, description: Mapping[str, Any]) -> Kind:
    """Return the kind of a run, as its description says.

    Parameters
    ----------
    folder
        The run's folder.
    description
        Its ``run.json``; empty of a folder that only holds runs.

    Raises
    ------
    UsageError
        Another version made the run; the line says which version reads it.
    """
    if not description:
        return WHOLE
    made_by, here = description["versions"]["colias-sim"], provenance.versions()["colias-sim"]
    if made_by.split(".")[:2] != here.split(".")[:2]:
        raise UsageError(f"{folder}: colias-sim {made_by} made this run and reads it; this is colias-sim {here}")
    return KINDS[description[KIND]]
