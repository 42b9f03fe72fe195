"""Drawing that the pictures of models and of stimuli share: frames with their times, and how a picture is saved.

A picture is as wide as a phone's screen, so that its letters are legible there; a wide screen shows it larger.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import matplotlib as mpl
import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from dsnn.stimuli import StimulusFrame
from experiments.bench.report.style import LOOK

INCHES = 4.4
"""Width of a picture: 420 px of a browser."""
DPI = 160
SIZE = 9
"""Size of letters, points."""
SHOWN = 5
"""Frames of a clip in its picture."""

Frames = npt.NDArray[np.uint8]


def shown_frames(frames: Sequence[StimulusFrame]) -> list[int]:
    """Return the indices of the frames to show: from the first that moves to the first after the motion."""
    moving = [index for index, frame in enumerate(frames) if frame.truth.motion != "still"]
    first, last = (moving[0], min(moving[-1] + 1, len(frames) - 1)) if moving else (0, len(frames) - 1)
    if last - first < SHOWN - 1:  # shorter than there are frames to show
        first = max(first - (SHOWN - 1) // 2, 0)
        last = first + SHOWN - 1
    return [round(index) for index in np.linspace(first, last, SHOWN).tolist()]


def show_frame(axes: Axes, luma: Frames, title: str) -> None:
    """Draw a frame as it is, black as 0 and white as 255, below its title."""
    axes.imshow(luma, cmap="gray", vmin=0, vmax=255, interpolation="antialiased")
    axes.set_xticks([])
    axes.set_yticks([])
    for spine in axes.spines.values():
        spine.set(visible=True, color="#999999", linewidth=0.6)
    axes.set_title(title, fontsize=SIZE, pad=2)


def place(drawn: Figure, left: float, top: float, width: float, height: float) -> Axes:
    """Axes at a place of a figure, in inches from its upper left corner."""
    whole_x, whole_y = drawn.get_size_inches()
    return drawn.add_axes((left / whole_x, 1 - (top + height) / whole_y, width / whole_x, height / whole_y))


def save(drawn: Figure, path: Path) -> None:
    """Write a picture as PNG. Equal figures give equal bytes."""
    with mpl.rc_context(LOOK):
        drawn.savefig(path, dpi=DPI, metadata={"Software": None})
