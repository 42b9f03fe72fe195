"""How much of a reproduction is run, and the names of its parts."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from experiments.declare.claim import EACH_TRIAL
from experiments.declare.study import WHOLE
from experiments.judge.count import LEAST_JUDGED
from experiments.kinds.tables import OFFLINE
from experiments.paper.studies.onboard import STUDY as ONBOARD

SHORT = (
    "clean", "blocked", "clutter-depth", "clutter-translation", "edges", "apparent", "background-alone",
)  # fmt: skip
"""The off-line experiments without grids of long clips."""


READ_OFF = ("background", "constants-2017", "constants-emd")
"""The studies whose points are clips of an off-line experiment of the same name."""


REPLICATES, SENSITIVITY, SENSITIVITY_CLIPS = "replicates", "sensitivity", "sensitivity-clips"
"""Folders of the trials other than replicate 0's."""


COUNTED = (*READ_OFF, SENSITIVITY, SENSITIVITY_CLIPS, ONBOARD.name)
"""The studies whose counts the report has, each in ``NAME.json``, as far as they are run."""


@dataclass(frozen=True, slots=True)
class Scale:
    """The scale of a reproduction: how much of each part is run.

    Parameters
    ----------
    replicates
        Replicates of the experiments with the robot, 1 or more. Replicate r has the seed of the run plus r.
    repeats
        Trials of each condition in a replicate. Fewer than a claim's ``least`` leave it unjudged.
    moves
        Whether to run one replicate with each thing moved that the studies of sensitivity name, and clips so too.
    offline_replicates
        Replicates of the off-line experiments in which anything is random; the others have one.
    episodes
        Episodes of each behaviour.
    steps
        Frames of an episode at most; otherwise the env's own number.
    offline
        The off-line experiments to run.
    onboard
        Whether the network in the robot's own arithmetic watches the other replicates too.
    """

    replicates: int
    repeats: int
    moves: bool
    offline_replicates: int
    episodes: int
    steps: int | None = None
    offline: tuple[str, ...] = OFFLINE
    onboard: bool = False


QUICK = Scale(2, EACH_TRIAL, moves=False, offline_replicates=1, episodes=1, steps=150, offline=SHORT)


USUAL = Scale(5, WHOLE, moves=True, offline_replicates=5, episodes=20, steps=900)


FULL = Scale(40, WHOLE, moves=True, offline_replicates=LEAST_JUDGED, episodes=60, onboard=True)


SCALES: Mapping[str, Scale] = {"quick": QUICK, "usual": USUAL, "full": FULL}
