"""The laws of every stimulus: the truth beside a frame is held against what is painted there."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np

from dsnn.stimuli import Box, StimulusEntry, StimulusFrame, Truth
from experiments.bench.check.laws import LawBroken

SEED = 3
MOST_FRAMES = 150
"""Frames that are looked at, from the first; a clip may be longer."""
EDGE_PX = 1.0
"""Greatest reach of an object's antialiased edge beyond its outline, px."""
SLOPPY = 1.0
"""Largest difference between an object's displacement in a frame and what its velocity says, px."""
STILL_GREY = 1
"""Largest change of a pixel that is called still, grey levels: what rounding does."""


def _frames(entry: StimulusEntry) -> list[StimulusFrame]:
    clip = entry.clip(SEED)
    return [clip.frame(index) for index in range(min(len(clip), MOST_FRAMES))]


def frames(entry: StimulusEntry) -> None:
    """Every frame is uint8, of the shape of its parameters, and there are 2 or more."""
    clip = entry.clip(SEED)
    if len(clip) < 2:
        raise LawBroken(f"len(clip) must be 2 or more, got {len(clip)}")
    for index, frame in enumerate(_frames(entry)):
        luma = np.asarray(getattr(frame, "luma", None))
        if not isinstance(frame, StimulusFrame) or luma.dtype != np.uint8 or luma.shape != clip.shape:
            problem = f"frame {index} is a {type(frame).__name__} of {luma.dtype} {luma.shape}"
            raise LawBroken(f"{problem}: expected a dsnn.stimuli.StimulusFrame of uint8 {clip.shape}")


def order(entry: StimulusEntry) -> None:
    """A frame is the same whenever and in whatever order it is asked for."""
    clip = entry.clip(SEED)
    places = (0, len(clip) // 2, len(clip) - 1)
    forward = [clip.frame(index).luma.copy() for index in places]
    clip.frame(places[1]).luma[:] = 7  # what a caller does with its frame is no business of the next
    for index, before in zip(reversed(places), reversed(forward), strict=True):
        if not np.array_equal(clip.frame(index).luma, before):
            raise LawBroken(
                f"frame {index} is another when asked for again: paint it from index, params and seed alone"
            )


def seeds(entry: StimulusEntry) -> None:
    """Equal seeds give equal bytes and equal truth."""
    for index, (one, other) in enumerate(zip(_frames(entry), _frames(entry), strict=True)):
        if not np.array_equal(one.luma, other.luma) or one.truth != other.truth:
            raise LawBroken(f"frame {index} is another in a clip built alike: draw by dsnn.stimuli.streams.stream")


def shape(entry: StimulusEntry) -> None:
    """Rows and columns of the parameters are those of the frames."""
    clip = entry.clip(SEED, rows=48, columns=80)
    luma = clip.frame(len(clip) // 2).luma
    if luma.shape != (48, 80):
        raise LawBroken(f"with rows=48, columns=80 a frame is {luma.shape}")


def truth(entry: StimulusEntry) -> None:
    """The truth has a word for the motion, and finite numbers."""
    for index, frame in enumerate(_frames(entry)):
        said = frame.truth
        if not isinstance(said, Truth) or not isinstance(said.motion, str) or not said.motion:
            raise LawBroken(f"in frame {index} the truth is {said!r}: expected a dsnn.stimuli.Truth, its motion a word")
        box = said.box and (said.box.left, said.box.top, said.box.width, said.box.height)
        if not all(map(math.isfinite, (*(said.velocity or ()), *said.background_velocity, *(box or ())))):
            raise LawBroken(f"in frame {index} the truth has a number that is not finite")


def place(entry: StimulusEntry) -> None:
    """Before a background at rest nothing changes outside of the truth's box.

    A clip that has a word for motion without an object moves by itself, as leaves do: it is not asked.
    """
    shown = _frames(entry)
    if any(frame.truth.box is None and frame.truth.motion != "still" for frame in shown):
        return
    for index, pair in enumerate(pairwise(shown)):
        if any(frame.truth.background_velocity != (0.0, 0.0) for frame in pair):
            continue
        changed = np.abs(pair[1].luma.astype(int) - pair[0].luma) > STILL_GREY
        for box in (frame.truth.box for frame in pair if frame.truth.box is not None):
            changed[_covered(box)] = False
        if changed.any():
            row, column = np.argwhere(changed)[0]
            problem = f"pixel ({row}, {column}) changes from frame {index} to {index + 1}"
            raise LawBroken(f"{problem} outside of the truth's box, or where it says that nothing moves")


def _covered(box: Box) -> tuple[slice, slice]:
    """Return the rows and columns that an object may paint."""
    ends = ((box.top, box.top + box.height), (box.left, box.left + box.width))
    rows, columns = (slice(max(math.floor(a - EDGE_PX), 0), max(math.ceil(b + EDGE_PX), 0)) for a, b in ends)
    return rows, columns


def velocity(entry: StimulusEntry) -> None:
    """The box moves as the truth's velocity says, between two frames that have the same one."""
    fps = entry.clip(SEED).fps
    for index, (before, after) in enumerate(pairwise(frame.truth for frame in _frames(entry))):
        if before.box is None or after.box is None or not before.velocity or before.velocity != after.velocity:
            continue
        for axis, start, size, speed in (("x", "left", "width", 0), ("y", "top", "height", 1)):
            middles = [getattr(box, start) + getattr(box, size) / 2 for box in (before.box, after.box)]
            moved, expected = middles[1] - middles[0], before.velocity[speed] / fps
            if abs(moved - expected) > SLOPPY:
                problem = f"from frame {index} to {index + 1} the box moves {moved:.3g} px along {axis}"
                raise LawBroken(f"{problem}, and by its velocity {expected:.3g} px")


LAWS = (frames, order, seeds, shape, truth, place, velocity)
