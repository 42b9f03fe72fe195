"""Pictures of models: what each answers to one clip of its kind, frame by frame."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import matplotlib as mpl
import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from dsnn import ModelEntry, ResponseSeries
from dsnn.model import SPIKING, run_model
from dsnn.stimuli import StimulusFrame
from experiments.bench.figures.palette import marks
from experiments.bench.figures.plotting import STYLE
from experiments.bench.leaderboard import FRAME, SQUARE
from experiments.bench.sources.clips import Clip
from tools.pages import drawing
from tools.pages.drawing import INCHES, SIZE

DARK = {"grey": 40.0, "background_grey": 200.0}
RIGHTWARD = {**FRAME, **SQUARE, "motion": "rightward", "speed": 60.0}
STANDARD: Mapping[str, Clip] = {
    "direction": Clip("dark square rightward", "plain", tuple((RIGHTWARD | DARK).items())),
    "looming": Clip("dark looming", "looming", tuple({"l_over_v_s": 0.16, **DARK}.items())),
}
"""Kind -> the clip that stands for it."""
LABELS: Mapping[str, str] = {"flow": "mean flow (px/frame)"}
"""Model -> what its HS and VS are, where they are no membrane potentials."""
NAMES = {"hs": "HS", "vs": "VS", "looming": "looming", "azimuth": "azimuth"}
LOOKS = {"vs": ":"}
"""Channel -> its line; the others are solid."""
SECOND, THIRD = "#383838", "#dd3d74"
"""The colours of VS, and of the looming of a model that has direction too."""
LEFT, RIGHT = 0.64, 0.08
"""Inches beside the panels."""
HEIGHTS = {"potential": 1.45, "spikes": 0.75, "azimuth": 0.75}
"""Heights of the panels, inches."""


@dataclass(frozen=True, slots=True)
class Shown:
    """A model's answers to a clip.

    Attributes
    ----------
    kind
        ``direction`` or ``looming``.
    clip
        What was shown.
    """

    entry: ModelEntry
    kind: str
    clip: Clip
    frames: tuple[StimulusFrame, ...]
    series: ResponseSeries
    fps: float


def kinds(entry: ModelEntry) -> tuple[str, ...]:
    """Return what a model answers: ``direction``, ``looming`` or both."""
    return tuple(kind for kind, channel in (("direction", "hs"), ("looming", "looming")) if channel in entry.channels)


def show_standard_clip(entry: ModelEntry, kind: str) -> Shown:
    """Show the standard clip of a kind to a model with its parameters on the robot."""
    clip = STANDARD[kind]
    built = clip.build(0)
    frames = tuple(built)
    series = run_model(entry.build(built.shape, entry.robot), (frame.luma for frame in frames))
    return Shown(entry, kind, clip, frames, series, built.fps)


def draw(answers: Shown, path: Path) -> None:
    """Draw frames, potentials with thresholds and spikes, one above the other against time."""
    panels = _panels(answers)
    rows, columns = answers.frames[0].luma.shape
    wide = (INCHES - LEFT - RIGHT - 0.05 * (drawing.SHOWN - 1)) / drawing.SHOWN
    high = wide * rows / columns
    whole = 0.28 + high + sum(HEIGHTS[name] + 0.16 for name in panels) + 0.42
    with mpl.rc_context(STYLE):
        drawn = Figure(figsize=(INCHES, whole))
        indices = drawing.shown_frames(answers.frames)
        for number, index in enumerate(indices):
            axes = drawing.place(drawn, LEFT + number * (wide + 0.05), 0.22, wide, high)
            drawing.show_frame(axes, answers.frames[index].luma, f"{index / answers.fps:.2f} s")
        top = 0.22 + high + 0.16
        for name in panels:
            axes = drawing.place(drawn, LEFT, top, INCHES - LEFT - RIGHT, HEIGHTS[name])
            {"potential": _potential, "spikes": _spikes, "azimuth": _azimuth}[name](axes, answers)
            _common(axes, answers, indices, last=name == panels[-1])
            top += HEIGHTS[name] + 0.16
        drawing.save(drawn, path)


def _panels(answers: Shown) -> list[str]:
    channels, entry = answers.entry.channels, answers.entry
    spiking = any(entry.threshold(channel, entry.robot) is not None for channel in channels)
    return ["potential", *(["spikes"] if spiking else []), *(["azimuth"] if "azimuth" in channels else [])]


def _spiking(answers: Shown) -> list[str]:
    return [channel for channel in SPIKING if channel in answers.entry.channels]


def _colour(answers: Shown, channel: str) -> str:
    if channel == "vs":
        return SECOND
    name = answers.entry.name
    return THIRD if channel == "looming" and "hs" in answers.entry.channels else marks([name])[name].colour


def _times(answers: Shown) -> npt.NDArray[np.float64]:
    return np.arange(len(answers.frames)) / answers.fps


def _potential(axes: Axes, answers: Shown) -> None:
    times = _times(answers)
    levels: dict[str, float | None] = {}
    for channel in _spiking(answers):
        curve = getattr(answers.series, channel)
        axes.plot(times, curve, LOOKS.get(channel, "-"), color=_colour(answers, channel), lw=1.5, label=NAMES[channel])
        levels[channel] = answers.entry.threshold(channel, answers.entry.robot)
    for level in sorted({level for level in levels.values() if level is not None}):
        for sign in (1, -1) if level == levels.get("hs") else (1,):
            axes.axhline(sign * level, color="black", ls="--", lw=0.7)
        axes.annotate(f"T = {level:.3g}", (0.0, level), (2, 2), xycoords=("axes fraction", "data"),
                      textcoords="offset points", fontsize=SIZE - 1)  # fmt: skip
    axes.set_ylabel(LABELS.get(answers.entry.name, "potential"), fontsize=SIZE)
    if len(levels) > 1:
        axes.legend(fontsize=SIZE - 1, frameon=False, loc="upper right", ncols=len(levels), borderaxespad=0.0,
                    handlelength=1.6, columnspacing=1.0)  # fmt: skip
        low, high = axes.get_ylim()
        axes.set_ylim(low, high + 0.16 * (high - low))


def _spikes(axes: Axes, answers: Shown) -> None:
    times = _times(answers)
    most = 1
    for channel in _spiking(answers):
        counts = getattr(answers.series, f"{channel}_spikes")
        fired = counts != 0
        beside = 0.35 / answers.fps if channel == "vs" else 0.0
        axes.vlines(times[fired] + beside, 0, counts[fired], color=_colour(answers, channel), lw=1.2)
        most = max(most, int(np.abs(counts).max()))
    lowest = min(int(getattr(answers.series, f"{channel}_spikes").min()) for channel in _spiking(answers))
    axes.axhline(0, color="black", lw=0.6)
    axes.set_ylim(1.15 * min(lowest, 0) - 0.05, 1.2 * most)
    axes.set_yticks(sorted({lowest, 0, most}))
    axes.set_ylabel("spikes/frame", fontsize=SIZE)


def _azimuth(axes: Axes, answers: Shown) -> None:
    axes.plot(_times(answers), answers.series.azimuth, color=_colour(answers, "hs"), lw=1.5)
    axes.set_ylim(-1.1, 1.1)
    axes.set_yticks([-1, 0, 1], ["left", "0", "right"])
    axes.set_ylabel("azimuth", fontsize=SIZE)


def _common(axes: Axes, answers: Shown, indices: Sequence[int], *, last: bool) -> None:
    """Draw the axis of time, and where the frames above are on it."""
    for index in indices:
        axes.axvline(index / answers.fps, color="#bbbbbb", lw=0.6, zorder=0)
    axes.set_xlim(0, len(answers.frames) / answers.fps)
    axes.tick_params(labelsize=SIZE, labelbottom=last)
    axes.yaxis.set_label_coords(-0.46 / (INCHES - LEFT - RIGHT), 0.5)
    if last:
        axes.set_xlabel("time (s)", fontsize=SIZE)
