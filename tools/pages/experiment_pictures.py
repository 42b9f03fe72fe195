"""Pictures of experiments: the paths of a robot's trials from above, or a frame of each clip."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Wedge

from colias_sim import CameraConfig
from experiments.bench.figures.palette import HUES
from experiments.bench.figures.plotting import STYLE, plain, wrapped
from experiments.bench.sources.clips import Clip
from experiments.bench.sources.course import ROBOT_RADIUS_CM, nominal
from experiments.bench.sources.experiment import Experiment
from experiments.bench.trials import configure
from tools.pages import drawing
from tools.pages.drawing import INCHES, SIZE

Place = tuple[float, float]
"""Centimetres ahead of the observer, and to its left: the plane of the view from above in videos."""
MOST = 12
"""Clips in a picture."""
ACROSS, GAP = 3, 0.06
"""Number of frames side by side, and inches between them."""
MOTIONS = {"translation": (HUES[0], 1.6), "approach": (HUES[1], 3.6), "recession": (HUES[3], 1.6)}
"""Motion -> the colour of its paths and their width, points: an approach may have a recession on it."""
OTHER = (HUES[2], 1.6)
"""Colour and width of a path of an experiment's own."""
PARTS = 100
"""Straight parts in which such a path is drawn."""
LEFT, WIDE, HIGH = 0.66, INCHES - 0.72, 2.9
"""Left edge and size of the view from above, inches."""
BEHIND = 5.0
"""Centimetres behind the observer that are drawn at least."""
LEGEND = 0.19
"""Inches of a line of the legend, which is below."""
TITLE = 0.15
"""Inches of a line of a frame's title."""


def draw_paths(experiment: Experiment, path: Path) -> None:
    """Draw the stimulus's nominal paths from above, as videos do: the observer looks to the right, its left is up."""
    settings = configure(experiment, experiment.models, ())[1]
    lines: list[tuple[str, tuple[Place, ...]]] = []
    for condition in experiment.conditions():
        route = nominal(condition, settings).stimulus.route
        parts = 1 if condition.path is None else PARTS
        poses = [route.point(route.length * part / parts) for part in range(parts + 1)]
        places = tuple((round(100 * p.x, 3), round(100 * p.y, 3)) for p in poses)
        if (condition.motion, places) not in lines:  # another speed has the same path
            lines.append((condition.motion, places))
    kinds = dict.fromkeys(motion for motion, _ in lines)
    with mpl.rc_context(STYLE):
        drawn = Figure(figsize=(INCHES, HIGH + 0.55 + LEGEND * len(kinds)))
        axes = drawing.place(drawn, LEFT, 0.1, WIDE, HIGH)
        _observer(axes, settings.camera)
        for motion, places in lines:
            colour, width = MOTIONS.get(motion, OTHER)
            axes.plot(*zip(*places[:-1], strict=True), color=colour, lw=width)
            axes.annotate("", places[-1], places[-2], arrowprops={"arrowstyle": "->", "lw": width, "color": colour,
                                                               "shrinkA": 0, "shrinkB": 0})  # fmt: skip
        for motion in kinds:
            colour, width = MOTIONS.get(motion, OTHER)
            axes.plot([], [], color=colour, lw=width, label=f"{motion} of the stimulus")
        ends = np.array([place for _, places in lines for place in places])
        behind = min(float(ends[:, 0].min()) - 1.5, -BEHIND)
        ahead, aside = float(ends[:, 0].max()) + 1.5, float(np.abs(ends[:, 1]).max()) + 1.5
        inch = max((ahead - behind) / WIDE, 2 * aside / HIGH)
        axes.set_xlim(behind, behind + inch * WIDE)
        axes.set_ylim(-inch * HIGH / 2, inch * HIGH / 2)
        drawn.legend(fontsize=SIZE, frameon=False, loc="lower left", borderaxespad=0.1)
        axes.set_xlabel("ahead of the observer (cm)", fontsize=SIZE)
        axes.set_ylabel("to its left (cm)", fontsize=SIZE)
        axes.tick_params(labelsize=SIZE)
        drawing.save(drawn, path)


def _observer(axes: Axes, camera: CameraConfig) -> None:
    half = camera.hfov_deg / 2
    view = Wedge((camera.forward_cm, 0.0), 100.0, -half, half, color="#278100", alpha=0.10, lw=0)
    axes.add_patch(view)
    axes.add_patch(Circle((0.0, 0.0), ROBOT_RADIUS_CM, color="#278100", lw=0))
    axes.text(0.015, 0.02, "green: the observer\nand its view", transform=axes.transAxes, fontsize=SIZE)


def shown_clips(clips: Sequence[Clip]) -> list[Clip]:
    """Return the clips that a picture has room for, taken evenly."""
    places = np.linspace(0, len(clips) - 1, min(MOST, len(clips)))
    return [clips[round(place)] for place in places.tolist()]


def draw_clips(clips: Sequence[Clip], path: Path) -> None:
    """Draw the frame in the middle of each clip, below its name."""
    built_clips = [(clip, clip.build(0)) for clip in clips]
    wide = (INCHES - 0.04 - GAP * (ACROSS - 1)) / ACROSS
    names = [plain(wrapped(clip.name, wide, SIZE - 1)) for clip, _ in built_clips]
    whole, tops = 0.0, []
    for start in range(0, len(built_clips), ACROSS):
        room = max(name.count("\n") + 1 for name in names[start : start + ACROSS]) * TITLE + 0.04
        tops.append(whole + room)
        whole += room + max(wide * b.shape[0] / b.shape[1] for _, b in built_clips[start : start + ACROSS]) + GAP
    with mpl.rc_context(STYLE):
        drawn = Figure(figsize=(INCHES, whole))
        for number, ((_, built), name) in enumerate(zip(built_clips, names, strict=True)):
            rows, columns = built.shape
            left = 0.02 + number % ACROSS * (wide + GAP)
            axes = drawing.place(drawn, left, tops[number // ACROSS], wide, wide * rows / columns)
            drawing.show_frame(axes, built[len(built) // 2].luma, name)
            axes.title.set_fontsize(SIZE - 1)
        drawing.save(drawn, path)
