"""The laws that every stimulus keeps, tried on one: what ``colias check`` asks of a file with a ``STIMULUS``.

Clips, tuning curves and judges take them for granted. The truth beside a frame is held against what is painted there.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache
from itertools import pairwise
from types import MappingProxyType

import numpy as np

from dsnn.stimuli import Box, ClipParams, Stimulus, StimulusEntry, StimulusFrame, Truth
from experiments.bench.conformance.laws import Finding, tried

Clip = Stimulus[ClipParams]

SEED = 3
MOST_FRAMES = 150
"""Frames that are looked at, from the first; a clip may be longer."""
EDGE_PX = 1.0
"""Greatest reach of an object's antialiased edge beyond its outline, px."""
SLOPPY = 1.0
"""Largest difference between an object's displacement in a frame and what its velocity says, px."""
STILL_GREY = 1
"""Largest change of a pixel that is called still, grey levels: what rounding does."""


def check(entry: StimulusEntry) -> list[Finding]:
    """Try every law on a stimulus. Whatever goes wrong in it breaks the law that was tried."""
    _frames.cache_clear()  # a file may have been edited meanwhile
    return [Finding(law, asks, tried(question, entry)) for law, (asks, question) in LAWS.items()]


def _clip(entry: StimulusEntry, seed: int = SEED) -> Clip:
    return entry.clip(seed)


def _frame(clip: Clip, index: int) -> StimulusFrame:
    return clip.frame(index)


@lru_cache(maxsize=1)
def _frames(entry: StimulusEntry) -> tuple[StimulusFrame, ...]:
    clip = _clip(entry)
    return tuple(_frame(clip, index) for index in range(min(len(clip), MOST_FRAMES)))


def _bytes(entry: StimulusEntry) -> str:
    clip = _clip(entry)
    if len(clip) < 2:
        return f"len(clip) is {len(clip)}: legal is 2 frames or more"
    for index, frame in enumerate(_frames(entry)):
        if not isinstance(frame, StimulusFrame):
            return f"frame {index} is a {type(frame).__name__}: expected a dsnn.stimuli.StimulusFrame(luma, truth)"
        luma = frame.luma
        if not isinstance(luma, np.ndarray) or luma.dtype != np.uint8 or luma.shape != clip.shape:
            kind = f"{luma.dtype} {luma.shape}" if isinstance(luma, np.ndarray) else type(luma).__name__
            return f"frame {index} is {kind}: legal is uint8 {clip.shape}, (rows, columns) of its parameters"
    return ""


def _again(entry: StimulusEntry) -> str:
    clip, last = _clip(entry), len(_clip(entry)) - 1
    forward = [_frame(clip, index).luma.copy() for index in (0, last // 2, last)]
    _frame(clip, last // 2).luma[:] = 7  # what a caller does with its frame is no business of the next
    for index, before in zip((last, last // 2, 0), reversed(forward), strict=True):
        if not np.array_equal(_frame(clip, index).luma, before):
            return (
                f"frame {index} is another when it is asked for again: paint it from its index, params and seed alone"
            )
    return ""


def _seeds(entry: StimulusEntry) -> str:
    other = _clip(entry)
    for index, first in enumerate(_frames(entry)):
        second = _frame(other, index)
        if not np.array_equal(first.luma, second.luma) or first.truth != second.truth:
            return f"frame {index} is another in a clip built alike: draw from a generator made of the seed"
    return ""


def _shapes(entry: StimulusEntry) -> str:
    other = {"rows": 48, "columns": 80}
    try:
        clip = entry.clip(SEED, **other)
    except ValueError as error:
        return f"with rows=48, columns=80: {error}"
    luma = _frame(clip, len(clip) // 2).luma
    return "" if luma.shape == (48, 80) else f"with rows=48, columns=80 a frame is {luma.shape}"


def _kinds(entry: StimulusEntry) -> str:
    for index, frame in enumerate(_frames(entry)):
        truth = frame.truth
        if not isinstance(truth, Truth) or not isinstance(truth.motion, str) or not truth.motion:
            return f"in frame {index} the truth is {truth!r}: legal is a dsnn.stimuli.Truth, its motion a word"
        numbers: Sequence[float] = [
            *(truth.velocity or ()), *truth.background_velocity,
            *((truth.box.left, truth.box.top, truth.box.width, truth.box.height) if truth.box else ()),
        ]  # fmt: skip
        if not all(map(math.isfinite, numbers)):
            return f"in frame {index} the truth has a number that is not finite"
    return ""


def _outside(entry: StimulusEntry) -> str:
    """Check that what changes between frames, before a background at rest, lies in the object's outline.

    A clip that has a word for motion without an object moves by itself, as leaves do: it is not asked.
    """
    frames = _frames(entry)
    if any(frame.truth.box is None and frame.truth.motion != "still" for frame in frames):
        return ""
    for index, (before, after) in enumerate(pairwise(frames)):
        truths = before.truth, after.truth
        if any(truth.background_velocity != (0.0, 0.0) for truth in truths):
            continue
        boxes = [truth.box for truth in truths if truth.box is not None]
        changed = np.abs(after.luma.astype(int) - before.luma) > STILL_GREY
        for box in boxes:
            changed[_covered(box, changed.shape)] = False
        if changed.any():
            row, column = (int(places[0]) for places in np.nonzero(changed))
            where = "outside of the truth's box" if boxes else "where the truth says that nothing moves"
            return f"pixel ({row}, {column}) changes from frame {index} to {index + 1} {where}"
    return ""


def _covered(box: Box, shape: tuple[int, ...]) -> tuple[slice, slice]:
    rows, columns = shape
    top, bottom = math.floor(box.top - EDGE_PX), math.ceil(box.top + box.height + EDGE_PX)
    left, right = math.floor(box.left - EDGE_PX), math.ceil(box.left + box.width + EDGE_PX)
    return slice(max(top, 0), min(max(bottom, 0), rows)), slice(max(left, 0), min(max(right, 0), columns))


def _speed(entry: StimulusEntry) -> str:
    """Check that the middle of the outline moves by the velocity between two frames that have the same one."""
    fps = _clip(entry).fps
    for index, (before, after) in enumerate(pairwise(frame.truth for frame in _frames(entry))):
        if before.box is None or after.box is None or not before.velocity or before.velocity != after.velocity:
            continue
        ends = zip(_ends(before.box), _ends(after.box), strict=True)
        moved = [_middle(second) - _middle(first) for first, second in ends]
        for axis, displacement, speed in zip("xy", moved, before.velocity, strict=True):
            if abs(displacement - speed / fps) > SLOPPY:
                return (
                    f"from frame {index} to {index + 1} the box moves {displacement:.3g} px along {axis}, and its"
                    f" velocity of {speed:g} px/s is {speed / fps:.3g} px a frame"
                )
    return ""


def _ends(box: Box) -> tuple[tuple[float, float], tuple[float, float]]:
    return (box.left, box.width), (box.top, box.height)


def _middle(end: tuple[float, float]) -> float:
    return end[0] + end[1] / 2


LAWS: Mapping[str, tuple[str, Callable[[StimulusEntry], str]]] = MappingProxyType(
    {
        "bytes": ("every frame is uint8, of the shape of its parameters, and there are 2 or more", _bytes),
        "any frame": ("a frame is the same whenever and in whatever order it is asked for", _again),
        "seeds": ("equal seeds give equal bytes and equal truth", _seeds),
        "shape": ("rows and columns of the parameters are those of the frames", _shapes),
        "truth": ("the truth has a word for the motion, and finite numbers", _kinds),
        "what moves": ("before a background at rest nothing changes outside of the truth's box", _outside),
        "velocity": ("the box moves as the truth's velocity says", _speed),
    }
)
"""Name -> what it asks, and what says how a stimulus breaks it."""
