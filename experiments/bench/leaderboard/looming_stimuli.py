"""Stimuli that the leaderboard shows to looming models: approaches, and what is none, through the robot's lens.

All clips have 99x72 px and 30 frames/s.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from experiments.bench.leaderboard.stimuli import JITTER_PX, PHOTOGRAPH, REPEATS, SHIFT_PX_S
from experiments.bench.sources.clips import Clip, OfflineExperiment

Changes = tuple[tuple[str, Any], ...]

L_OVER_V_S = (0.04, 0.08, 0.16, 0.32)
OFF_CENTRE_DEG, OFF_CENTRE_S = (-20.0, 20.0), 0.16
MOTIONS = ("looming", "receding")
WAYS = ("rightward", "leftward", "downward", "upward")
SPEEDS_PX_S, SPEED_PX_S = (30.0, 60.0, 120.0), 60.0
GRATING_HZ, GRATING_DEG = (2.0, 4.0), (0.0, 90.0, 180.0, 270.0)
BACKGROUND_S = 5.0
FRAME: Changes = (("rows", 72), ("columns", 99))
SQUARE: Changes = (("width", 25.0), ("height", 25.0))
SHADES: dict[str, Changes] = {
    "dark": (("grey", 40.0), ("background_grey", 200.0)), "light": (("grey", 200.0), ("background_grey", 40.0)),
}  # fmt: skip
EXTREME: dict[str, Changes] = {"dark": (("grey", 0.0),), "light": (("grey", 255.0),)}
BEHIND: Changes = (
    ("grey", 40.0), ("background_grey", 127.5), ("background", "grating"), ("contrast", 0.4), ("temporal_hz", 2.0),
)  # fmt: skip


def looming_experiments(models: Sequence[str]) -> tuple[OfflineExperiment, ...]:
    """List the clips for ``models``: on even ground, where nothing is random and one is enough; and before others."""
    labels = tuple(models)
    return (
        OfflineExperiment("looming-plain", "looming, and what is none, on an even ground", plain_clips(), labels),
        OfflineExperiment("looming-moving", "the same before what moves", moving_clips(), labels, (), REPEATS),
    )


def plain_clips() -> tuple[Clip, ...]:
    """Dark and light squares: looming and receding at the centre and off it, crossing four ways; 48 clips."""
    clips = []
    for shade, greys in SHADES.items():
        for motion in MOTIONS:
            changes = (("motion", motion), *greys)
            clips += [Clip(f"{shade} {motion} {s:g} s", "looming", (("l_over_v_s", s), *changes)) for s in L_OVER_V_S]
            clips += [
                Clip(f"{shade} {motion} {deg:+g} deg", "looming",
                     (("l_over_v_s", OFF_CENTRE_S), ("azimuth_deg", deg), *changes))
                for deg in OFF_CENTRE_DEG
            ]  # fmt: skip
        clips += [
            Clip(f"{shade} {way} {speed:g} px/s", "plain",
                 (*FRAME, *SQUARE, ("motion", way), ("speed", speed), *greys))
            for way in WAYS
            for speed in SPEEDS_PX_S
        ]  # fmt: skip
    return tuple(clips)


def moving_clips() -> tuple[Clip, ...]:
    """Squares before a drifting grating and before a shifting photograph, gratings and backgrounds alone; 32 clips."""
    before = [
        Clip(f"{motion} {s:g} s before a grating", "looming", (("l_over_v_s", s), ("motion", motion), *BEHIND))
        for motion in MOTIONS
        for s in L_OVER_V_S
    ]
    ground = (*FRAME, PHOTOGRAPH, ("background_speed", -SHIFT_PX_S))
    clutter = [
        Clip(f"{shade} {motion} before clutter", "cluttered",
             (*ground, *SQUARE, ("motion", motion), ("speed", SPEED_PX_S), *grey))
        for shade, grey in EXTREME.items()
        for motion in (*MOTIONS, *WAYS)
    ]  # fmt: skip
    return (*before, *clutter, *_gratings(), *_backgrounds())


def _gratings() -> tuple[Clip, ...]:
    changes = (*FRAME, ("period_px", 16.0))
    return tuple(
        Clip(f"grating {hz:g} Hz {deg:g} deg", "grating", (*changes, ("temporal_hz", hz), ("direction_deg", deg)))
        for hz in GRATING_HZ
        for deg in GRATING_DEG
    )


def _backgrounds() -> tuple[Clip, ...]:
    """Return a panning camera, a trembling one, and leaves in the wind, `BACKGROUND_S` each."""
    alone = (*FRAME, ("object", "absent"), ("motion", "looming"), ("duration_s", BACKGROUND_S), ("rest_s", 0.0))
    return (
        Clip("shift left", "cluttered", (*alone, PHOTOGRAPH, ("background_speed", -SHIFT_PX_S))),
        Clip("shift right", "cluttered", (*alone, PHOTOGRAPH, ("background_speed", SHIFT_PX_S))),
        Clip("jitter", "cluttered", (*alone, PHOTOGRAPH, ("background_speed", 0.0)), JITTER_PX),
        Clip("foliage", "foliage", (*FRAME, ("duration_s", BACKGROUND_S), ("rest_s", 0.0))),
    )
