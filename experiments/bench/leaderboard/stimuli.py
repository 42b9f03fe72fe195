"""Stimuli that the leaderboard shows to every model: the robot's trials, and the off-line clips.

All of it is 320x180 px or the robot's 99x72, so that a model is met at the two sizes it is timed at.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from experiments.bench.sources.clips import Clip, OfflineExperiment
from experiments.bench.sources.conditions import Condition
from experiments.bench.sources.designs import Translation, angular
from experiments.bench.sources.experiment import Experiment
from experiments.clean import GREYS as EVEN
from experiments.clean import LONG_EDGE_AHEAD
from experiments.clutter_depth import GREYS as EXTREME

REPEATS = 5
SPEEDS_CM_S = (4.0, 6.0, 10.0)
DISTANCES_CM = (6.0, 10.0)
NEAR_CM, FAR_CM, ACCELERATION_CM_S2 = 5.0, 20.0, 17.0
"""Distances and acceleration of approach and recession: those of the experiment ``general``."""

SPEEDS_PX_S = (120.0, 240.0)
DEPTH_S = (1.0, 2.0)
"""Duration of looming and receding, s."""
SHIFT_PX_S = 8.0
"""Speed of the background, px/s, to either side: within the paper's -2 .. -10."""
JITTER_PX = 0.3
PHOTOGRAPH = ("background", "photograph")
"""The boards' ground, in all repeats: windows of one photograph. The boards that are published were run so."""
DEPTH = ("looming", "receding")


@dataclass(frozen=True)
class BoardDesign:
    """Crossings both ways, and straight approach and recession at the same speeds."""

    pose_sd_mm: float = 1.0
    heading_sd_deg: float = 1.0

    def conditions(self) -> tuple[Condition, ...]:
        """Twelve crossings, three approaches, three recessions."""
        depth = (
            angular(motion, 0.0, speed, NEAR_CM, FAR_CM, ACCELERATION_CM_S2)
            for motion in ("approach", "recession")
            for speed in SPEEDS_CM_S
        )
        return (*Translation(SPEEDS_CM_S, DISTANCES_CM, "both").conditions(), *depth)


ROBOT = Experiment(
    name="robot",
    summary="crossings at 4, 6, 10 cm/s, at 6 and 10 cm; straight approach and recession at the same speeds",
    design=BoardDesign(),
    varies="speed_cm_s",
    repeats=REPEATS,
)


def clip_experiments(models: Sequence[str]) -> tuple[OfflineExperiment, ...]:
    """List the clips for ``models``: on an even ground, where nothing is random and one is enough, and in clutter."""
    labels = tuple(models)
    return (
        OfflineExperiment("clips-plain", "on an even ground", plain_clips(), labels),
        OfflineExperiment("clips-clutter", "before clutter, and clutter alone", clutter_clips(), labels, (), REPEATS),
    )


def plain_clips() -> tuple[Clip, ...]:
    """Dark and light rectangles: four directions at two speeds, looming and receding in two times; 24 clips."""
    crossings = tuple(
        _clip(f"{shade} {motion} {speed:g} px/s", "plain", motion, grey=grey, background_grey=ground, speed=speed)
        for shade, (grey, ground) in EVEN.items()
        for motion in LONG_EDGE_AHEAD
        for speed in SPEEDS_PX_S
    )
    depth = tuple(
        _clip(f"{shade} {motion} in {s:g} s", "plain", motion, grey=grey, background_grey=ground, duration_s=s)
        for shade, (grey, ground) in EVEN.items()
        for motion in DEPTH
        for s in DEPTH_S
    )
    return (*crossings, *depth)


def clutter_clips() -> tuple[Clip, ...]:
    """Make the clips before a natural image shifting left: 12 clips of objects as on the even ground; then 4 of
    backgrounds alone.
    """
    before = {"columns": 320, "background_speed": -SHIFT_PX_S, "background": "photograph"}
    objects = tuple(
        _clip(f"{shade} {motion}", "cluttered", motion, grey=grey, **before)
        for shade, grey in EXTREME.items()
        for motion in (*LONG_EDGE_AHEAD, *DEPTH)
    )
    return (*objects, *_backgrounds())


def _backgrounds() -> tuple[Clip, ...]:
    """Make clips of backgrounds alone. Nothing in these crosses, looms or recedes: what a model answers to them is a
    false alarm.
    """
    alone = (("columns", 320), ("object", "absent"), PHOTOGRAPH)
    return (
        Clip("shift left", "cluttered", (*alone, ("background_speed", -SHIFT_PX_S))),
        Clip("shift right", "cluttered", (*alone, ("background_speed", SHIFT_PX_S))),
        Clip("foliage", "foliage"),
        Clip("jitter", "cluttered", (*alone, ("background_speed", 0.0)), JITTER_PX),
    )


def _clip(name: str, stimulus: str, motion: str, **changes: Any) -> Clip:
    width, height = LONG_EDGE_AHEAD.get(motion, (50.0, 90.0))
    return Clip(name, stimulus, (("motion", motion), ("width", width), ("height", height), *changes.items()))
