"""The atlas as a picture: models by row, clips by column, potentials over time, spikes as ticks."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import matplotlib as mpl
import numpy as np
import numpy.typing as npt
import pyarrow as pa
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from dsnn.looming.grouping import REST
from experiments.bench.clips.experiment import Showing
from experiments.bench.clips.plan import OfflinePlan
from experiments.bench.engine.models import ConfiguredModel
from experiments.bench.figures.palette import colours
from experiments.bench.figures.plotting import LETTER_INCHES, LINE, PAGE, STYLE, WIDTH, key_below, plain, wrapped

INCHES, LEAST_HIGH = (1.02, 0.62), 0.3
"""Size of a panel, across and down, and its least height."""
LEAST_LABEL, MOST_LABEL, KEY_INCHES = 0.8, 1.5, 0.75
"""Width of the models' names, at least and at most; height of the key."""
WRAP, LEAST_HEADING = 14, 0.8
"""Characters of a column's heading in a line, and the width of a column below which it is turned."""
HEADING, TURNED_HEADING = 0.5, 1.2
"""Heights of a heading with what is below its columns, and of one that is turned; inches."""
BELOW, ABOVE = -1.45, 1.15
TICKS = {"hs": -1.15, "vs": -1.35, "looming": -1.25}
"""Height of the spikes of each channel."""
UPWARD = {"looming": -0.22}
"""Limits of the axis where nothing goes below 0."""


@dataclass(frozen=True, slots=True)
class _Column:
    """Clip of a column: a frame of it, and by frame whether something moves, (T,)."""

    name: str
    picture: npt.NDArray[np.uint8]
    moves: npt.NDArray[np.bool_]
    fps: float


def draw(plan: OfflinePlan, frames: pa.Table) -> Figure:
    """Draw the answers in ``frames`` to the clips of a plan, one repeat of each: as many clips side by side as fit."""
    models = plan.showings[0].models
    tints = colours(model.label for model in models)
    columns = [_column(showing) for showing in plan.showings]
    series = _series(frames)
    down = len(models) + 1
    labels = {model.label: wrapped(model.label, MOST_LABEL, 8) for model in models}
    left = LETTER_INCHES * max(len(line) for label in labels.values() for line in label.split("\n")) + 0.2
    lines = max(label.count("\n") + 2 for label in labels.values())  # one for the scale of its axis
    note = _spikeless(models)
    around = KEY_INCHES + LINE * (note.count("\n") + 2) * bool(note)
    least = max(LEAST_HIGH, lines * LINE + 0.02)
    layout = _layout(len(columns), len(models), WIDTH - max(left, LEAST_LABEL), least, around)
    blocks, across = layout.blocks, layout.across
    with mpl.rc_context(STYLE):
        drawn = Figure(figsize=(WIDTH, (layout.heading + layout.high * (down + 1)) * blocks + around))
        drawn.set_layout_engine("constrained", w_pad=0.02, h_pad=0.02, wspace=0.02, hspace=0.02)
        grid = drawn.add_gridspec(down * blocks, across, height_ratios=[1.3, *[1.0] * len(models)] * blocks)
        panels = {
            (row, place): drawn.add_subplot(grid[place // across * down + row, place % across])
            for row in range(down) for place in range(len(columns))
        }  # fmt: skip
        for place, column in enumerate(columns):
            _head(panels[0, place], column, turned=layout.heading == TURNED_HEADING)
        for row, model in enumerate(models, 1):
            model_series = {place: series.get((place, model.label)) for place in range(len(columns))}
            scale = _scale(model, model_series)
            for place, column in enumerate(columns):
                _cell(panels[row, place], model, model_series[place], column, scale, tints[model.label])
            unit = f"\nup to ±{scale:.2g}" if _signed(model) else "\n0.5 to 1"
            for place in range(0, len(columns), across):
                words = plain(f"{labels[model.label]}{unit}")
                label = panels[row, place].set_ylabel(words, rotation=0, ha="right", va="center", fontsize=8)
                label.set_color(tints[model.label])
        for place, column in enumerate(columns):
            panels[len(models), place].set_xlabel(f"{len(column.moves) / column.fps:.1f} s long", fontsize=8)
        key_below(drawn, _keys(models))
        if note:
            drawn.suptitle(note, fontsize=8, x=0.01, ha="left")
    return drawn


@dataclass(frozen=True, slots=True)
class _Layout:
    """How clips stand: in ``blocks`` below each other, ``across`` in each; heights of a panel and of headings."""

    blocks: int
    across: int
    high: float
    heading: float


def _layout(clips: int, models: int, inches: float, least: float, around: float) -> _Layout:
    """Return the layout of most blocks that fits on a page, with panels at least as high as ``least``.

    ``inches`` is the width of a block, and ``around`` the height of what is above and below all blocks. Where there are
    so many models that none fits, all clips stand in one block.
    """
    for blocks in range(math.ceil(clips / max(int(inches / INCHES[0]), 1)), 0, -1):
        across = math.ceil(clips / blocks)
        heading = HEADING if inches / across >= LEAST_HEADING else TURNED_HEADING
        high = ((PAGE - around) / blocks - heading) / (models + 2)
        if high >= least:
            break
    return _Layout(blocks, across, min(max(high, least), INCHES[1]), heading)


def _column(showing: Showing) -> _Column:
    clip = showing.condition.build(showing.seed)
    truths = [frame.truth for frame in clip]
    moves = np.array([t.motion != "still" or any(t.background_velocity or (0.0, 0.0)) for t in truths])
    frames = np.flatnonzero(moves) if moves.any() else np.arange(len(clip))
    # Two thirds of the way: what looms is large by then, and what crosses is still in view.
    return _Column(showing.condition.name, clip[int(frames[2 * len(frames) // 3])].luma, moves, clip.fps)


def _series(frames: pa.Table) -> dict[tuple[int, str], Mapping[str, Any]]:
    """(Trial, model) -> its columns by frame, (T,) each."""
    trial, name = frames["trial"].to_numpy(), np.asarray(frames["model"])
    wanted = ("hs", "vs", "looming", "hs_spikes", "vs_spikes", "looming_spikes")
    columns = {column: frames[column].to_numpy() for column in wanted}
    by_clip: dict[tuple[int, str], Mapping[str, Any]] = {}
    for index in np.unique(trial):
        for model in np.unique(name[trial == index]):
            here = (trial == index) & (name == model)
            by_clip[int(index), str(model)] = {column: values[here] for column, values in columns.items()}
    return by_clip


def _scale(model: ConfiguredModel, model_series: Mapping[int, Mapping[str, Any] | None]) -> float:
    """Return the largest |HS| or |VS| of a row; 1 where there is none."""
    sizes = [
        float(np.abs(series[channel]).max()) for series in model_series.values() if series is not None
        for channel in ("hs", "vs") if channel in model.channels
    ]  # fmt: skip
    return max(sizes, default=0.0) or 1.0


def _head(axes: Axes, column: _Column, *, turned: bool) -> None:
    axes.imshow(column.picture, cmap="gray", vmin=0, vmax=255, interpolation="nearest")
    axes.set_xticks([])
    axes.set_yticks([])
    axes.spines[:].set_visible(False)
    axes.set_title("\n".join(textwrap.wrap(column.name, WRAP)), fontsize=8, rotation=90 if turned else 0)


def _cell(
    axes: Axes, model: ConfiguredModel, series: Mapping[str, Any] | None, column: _Column, scale: float, tint: str
) -> None:
    """Draw one model's answer to one clip."""
    signed = _signed(model)
    steps = np.arange(len(column.moves))
    axes.set(xlim=(0, max(len(steps) - 1, 1)), ylim=(BELOW, ABOVE) if signed else (-0.4, ABOVE), xticks=[], yticks=[])
    axes.fill_between(steps, BELOW, ABOVE, where=column.moves.tolist(), color="black", alpha=0.05, lw=0)
    for side in axes.spines.values():
        side.set_linewidth(0.3)
    if series is None:
        axes.annotate("failed", (0.5, 0.5), xycoords="axes fraction", ha="center", va="center", fontsize=8, color="0.4")
        return
    axes.axhline(0.0, color="black", lw=0.4)
    styles = {"hs": "-", "vs": ":", "looming": "--" if signed else "-"}
    heights = TICKS if signed else UPWARD
    for channel in (style for style in styles if style in model.channels):
        values = (series[channel] - REST) / REST if channel == "looming" else series[channel] / scale
        axes.plot(steps, values, ls=styles[channel], lw=1.0, color=tint)
        fired = np.flatnonzero(series[f"{channel}_spikes"])
        axes.plot(fired, np.full(fired.size, heights[channel]), "|", ms=3, mew=0.6, color="black")


def _signed(model: ConfiguredModel) -> bool:
    """Tell whether a model has potentials of both signs."""
    return "hs" in model.channels or "vs" in model.channels


def _spikeless(models: Sequence[ConfiguredModel]) -> str:
    """Name the models without a threshold, in lines; empty if there is none."""
    names = ", ".join(model.label for model in models if not model.spiking)
    return plain(wrapped(f"without a threshold, so without spikes: {names}", WIDTH - 0.2, 8)) if names else ""


def _keys(models: Sequence[ConfiguredModel]) -> list[Line2D]:
    """Return what the lines of these models are."""
    grey = "#444444"
    signed = [model for model in models if _signed(model)]
    detectors = len(signed) < len(models)
    beside = any("looming" in model.channels for model in signed)
    solid = " or ".join(["HS potential"] * bool(signed) + ["looming potential, from 0.5"] * detectors)
    spikes = "spikes: HS, below them VS" if signed else "spikes"
    return [
        Line2D([], [], color=grey, lw=1.0, label=solid),
        *[Line2D([], [], color=grey, lw=1.0, ls=":", label="VS potential")] * bool(signed),
        *[Line2D([], [], color=grey, lw=1.0, ls="--", label="looming potential beside HS, from 0.5 to 1")] * beside,
        Line2D([], [], color="black", ls="", marker="|", ms=5, label=spikes),
        Line2D([], [], color="0.9", lw=6, label="something moves"),
    ]
