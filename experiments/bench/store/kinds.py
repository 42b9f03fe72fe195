"""The kinds of run: what a folder of each holds. ``experiment.json`` says the kind since the run began."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from experiments.bench.engine.errors import UsageError, short
from experiments.bench.store.description import KIND

TRAINED = "learning.csv"
"""What a training leaves in its folder, and one at several seeds in the folder of each."""


@dataclass(frozen=True, slots=True)
class Kind:
    """Kind of a run: what its folder holds.

    Parameters
    ----------
    name
        As ``experiment.json`` has it.
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
CLIPS = Kind("clips", "clips that models are shown", "clips")
TUNING = Kind("tuning", "tuning curves", "clips", "preferences.csv")
EPISODES = Kind("episodes", "episodes of behaviours", "episodes", "scores.csv")
TRAINING = Kind("training", "the episodes that trained policies are judged by", "episodes", "scores.csv")
MAP = Kind("map", "a map", summary="counts.csv")
STUDY = Kind("study", "a study", summary="counts.csv")
SWEEP = Kind("sweep", "a sweep", summary="sweep.csv", parts=True)
LEADERBOARD = Kind("leaderboard", "a leaderboard", summary="leaderboard.csv", parts=True)
FIT = Kind("fit", "a fit", summary="fit.csv", parts=True)
REPRODUCTION = Kind("reproduction", "a reproduction", parts=True)
WHOLE = Kind("whole", "several runs", parts=True)
"""Of a folder that says nothing of itself, where folders in it are runs."""
FOOTAGE = Kind("footage", "footage that was watched", "frames")

KINDS: Mapping[str, Kind] = {
    kind.name: kind
    for kind in (
        TRIALS, MEASURED, CLIPS, TUNING, EPISODES, TRAINING, MAP, STUDY, SWEEP, LEADERBOARD, FIT, REPRODUCTION,
        WHOLE, FOOTAGE,
    )
}  # fmt: skip
MARKS = {
    "sweep.csv": SWEEP, "leaderboard.csv": LEADERBOARD, "looming.csv": LEADERBOARD, "atlas.html": LEADERBOARD,
    "design.json": REPRODUCTION, "report.html": REPRODUCTION,
}  # fmt: skip
"""Of a whole whose parts are runs, and which says nothing of itself: what tells its kind by being there."""
NAMED = {"tuning": TUNING, "behave": EPISODES, "map": MAP}
"""The kinds of runs of no declared experiment, by what their ``experiment`` is called."""


def kind_of(folder: Path, description: Mapping[str, Any]) -> Kind:
    """Return the kind of a run: as its description says, or of a folder of an older version as the rest tells.

    Parameters
    ----------
    folder
        The run's folder.
    description
        Its ``experiment.json``; empty where it has none.

    Raises
    ------
    UsageError
        A version of another day wrote it: the kind is not known here.
    """
    written = description.get(KIND)
    if written is None:
        return _inferred(folder, description)
    if not isinstance(written, str) or written not in KINDS:
        known = ", ".join(KINDS)
        raise UsageError(f"{folder}: experiment.json: {KIND} {short(written)} is not known here; known are {known}")
    return KINDS[written]


def _inferred(folder: Path, description: Mapping[str, Any]) -> Kind:
    """Return the kind of a run whose description has no `KIND`: it is of a version before 0.3, or a whole of parts."""
    if not description:
        return next((kind for name, kind in MARKS.items() if (folder / name).exists()), WHOLE)
    if "measured" in description:
        return MEASURED
    experiment = description.get("experiment")
    if isinstance(experiment, Mapping):
        return CLIPS if "clips" in experiment else TRIALS
    if experiment == "behave" and any(path.is_file() for path in (folder / TRAINED, folder / "training.json")):
        return TRAINING
    return NAMED.get(str(experiment), STUDY)
