"""Pictures of stimuli: a few frames with their times, and a slice through space and time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from dsnn.stimuli import StimulusEntry, StimulusFrame
from experiments.bench.report.style import LOOK
from tools.pages import drawing
from tools.pages.drawing import INCHES, SHOWN, SIZE, Frames

BANDS: Mapping[str, int] = {"dots": 40}
"""Stimulus -> rows of its slice, the darkest of which counts; of the others it is one row."""
LEFT, GAP, ACROSS = 0.02, 0.06, 3
"""Inches beside the frames and between them; how many stand side by side."""
SLICE_LEFT, SLICE_HIGH = 0.5, 1.35
"""Inches left of the slice, and its height."""


def draw(entry: StimulusEntry, path: Path) -> int:
    """Draw a stimulus with its default parameters at seed 0; return the row that the slice is of."""
    clip = entry.build(entry.params, 0)
    frames = tuple(clip)
    rows, columns = clip.shape
    wide = (INCHES - 2 * LEFT - GAP * (ACROSS - 1)) / ACROSS
    high = wide * rows / columns
    down = -(-SHOWN // ACROSS)
    row = slice_row(frames)
    below = down * (high + 0.22) + 0.12
    with mpl.rc_context(LOOK):
        drawn = Figure(figsize=(INCHES, below + SLICE_HIGH + 0.42))
        indices = drawing.shown_frames(frames)
        for number, index in enumerate(indices):
            left, top = LEFT + number % ACROSS * (wide + GAP), 0.18 + number // ACROSS * (high + 0.22)
            axes = drawing.place(drawn, left, top, wide, high)
            drawing.show_frame(axes, frames[index].luma, f"{index / clip.fps:.2f} s")
        axes = drawing.place(drawn, SLICE_LEFT, below, INCHES - SLICE_LEFT - 0.08, SLICE_HIGH)
        _slice(axes, space_time(frames, row, BANDS.get(entry.name, 1)), clip.fps)
        _marks(axes, indices, clip.fps)
        drawing.save(drawn, path)
    return row


def slice_row(frames: Sequence[StimulusFrame]) -> int:
    """Return the row that the object's centre is in when it is seen first; without an object the middle one."""
    rows = frames[0].luma.shape[0]
    boxes = [frame.truth.box for frame in frames if frame.truth.box is not None]
    centre = boxes[0].top + boxes[0].height / 2 if boxes else rows / 2
    return int(min(max(centre, 0), rows - 1))


def space_time(frames: Sequence[StimulusFrame], row: int, band: int) -> Frames:
    """Grey over time and column, (T, C): the darkest of ``band`` rows about ``row``."""
    first = max(row - band // 2, 0)
    return np.stack([frame.luma[first : first + band].min(axis=0) for frame in frames])


def _slice(axes: Axes, grey: Frames, fps: float) -> None:
    times, columns = grey.shape
    axes.imshow(grey, cmap="gray", vmin=0, vmax=255, aspect="auto", extent=(0, columns, times / fps, 0),
                interpolation="antialiased")  # fmt: skip
    axes.set_xlabel("x (px)", fontsize=SIZE, labelpad=1)
    axes.set_ylabel("time (s)", fontsize=SIZE)
    axes.yaxis.set_label_coords(-0.4 / (INCHES - SLICE_LEFT), 0.5)
    axes.yaxis.set_major_locator(MaxNLocator(4, steps=[1, 2, 5, 10]))
    axes.tick_params(labelsize=SIZE)


def _marks(axes: Axes, indices: Sequence[int], fps: float) -> None:
    """Ticks at the right where the frames above are."""
    for index in indices:
        axes.annotate("", (1.0, index / fps), (1.02, index / fps), xycoords=("axes fraction", "data"),
                      arrowprops={"arrowstyle": "-", "lw": 1.2, "color": "#dd3d74"})  # fmt: skip
