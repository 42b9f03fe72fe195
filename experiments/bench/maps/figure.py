"""A map as a figure: a heat map for each claim, one of all claims together, and one for each measure."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from experiments.bench.engine.settings import PRESET
from experiments.bench.figures.plotting import STYLE, headline, plain
from experiments.bench.maps.axes import Axis, said
from experiments.bench.maps.judging import TOGETHER, Cell, Number, by_claim, by_measure
from experiments.bench.maps.plan import MapPlan
from experiments.bench.store.parameters import in_title

SHADES, SCALE = "Blues", "YlGnBu"
"""Of counts, and of numbers."""
UNTESTED = "#e3dccb"
DEFAULT = "#c0392b"
"""Of what marks the default's place."""
SHORT = {"at the end of the range": "at end"}
"""Marks that are too long for a cell."""
MOST_COLUMNS = 3
WIDTH, HEIGHT = 0.55, 0.42
"""Of a cell, inches."""


def draw(made: MapPlan, found: Sequence[Cell], measured: Sequence[Number] = ()) -> Figure:
    """Draw counts and numbers.

    Parameters
    ----------
    made
        The map's plan: its axes, the model, the numbers of repeats and replicates.
    found
        The counts of every claim at every point.
    measured
        Every measure at every point.

    Returns
    -------
    matplotlib.figure.Figure
        Cells of a claim say "held/all replicates", and are hatched where a replicate could not be judged. Cells of a
        measure have its value, its lowest and highest in a replicate where they differ, and what is to be known of it;
        they are hatched where there is no value. The scale of each measure goes from its lowest to its highest value.
        Triangles at the axes mark the defaults; a frame marks the cell where both are.
    """
    panels, others = by_claim(found), by_measure(measured)
    number = len(panels) + len(others)
    columns = min(number, MOST_COLUMNS)
    lines = math.ceil(number / columns)
    across, up = len(made.axes[0].levels), len(made.axes[1].levels) if len(made.axes) > 1 else 1
    size = (columns * (max(across * WIDTH, 2.2) + 0.5) + 1.2, lines * (max(up * HEIGHT, 0.5) + 0.7) + 1.0)
    with mpl.rc_context(STYLE):
        drawn = Figure(figsize=size, layout="constrained")
        places = drawn.subplots(lines, columns, squeeze=False, sharex=True, sharey=True)
        for place, (claim, chosen) in zip(places.flat, panels.items(), strict=False):
            _panel(place, made, chosen)
            title = "all together" if claim == TOGETHER else f"{claim}  ({chosen[0].experiment})"
            place.set_title(plain(title), fontsize=9, loc="left")
        for place, (name, own) in zip(places.flat[len(panels) :], others.items(), strict=False):
            _numbers(place, made, own)
            unit = f", {own[0].measure.unit}" if own[0].measure.unit else ""
            place.set_title(plain(f"{name}{unit}  ({own[0].experiment})"), fontsize=9, loc="left")
        for place in places.flat[number:]:
            place.set_axis_off()
        drawn.supxlabel(plain(" ".join(made.axes[0].words())), fontsize=8)
        if len(made.axes) > 1:
            drawn.supylabel(plain("\n".join(made.axes[1].words())), fontsize=8)
        counted = f"{_counted(made, bool(found))}, from seed {made.seed}"
        headline(drawn, f"{made.model.label}: {counted}{in_title(_set(made))}", 9)
    return drawn


def _set(made: MapPlan) -> dict[str, Any]:
    """Return the parameters that are not at their defaults at any point, without those that the axes move."""
    moved = [key for axis in made.axes for key in axis.keys] + [key for point in made.points for key, _ in point.values]
    ends = tuple(key.removesuffix(PRESET) for key in moved if key.endswith(f".{PRESET}"))
    return {
        key: values
        for key, values in made.description.get("changed", {}).items()
        if not key.startswith(ends) and not any(each == key or each.startswith(f"{key}.") for each in moved)
    }


def _counted(made: MapPlan, claims: bool) -> str:
    """What the cells have, and what a replicate has."""
    number = f"{made.replicates} replicate{'s' if made.replicates > 1 else ''}"
    counted = f"held in n/{made.replicates} replicates" if claims else number
    repeats = "/".join(str(each) for each in dict.fromkeys(made.repeats))
    return f"{counted}\n{'each clip once' if made.things == 'clips' else f'{repeats} repeats each'}"


def _panel(axes: Axes, made: MapPlan, chosen: Sequence[Cell]) -> None:
    across, up = made.axes[0], made.axes[1] if len(made.axes) > 1 else None
    held = np.zeros((len(up.levels) if up else 1, len(across.levels)))
    for cell in chosen:
        values = dict(cell.point.values)
        column, row = across.levels.index(values[across.name]), up.levels.index(values[up.name]) if up else 0
        held[row, column] = cell.held / cell.of
        if cell.untested:
            axes.add_patch(Rectangle((column - 0.5, row - 0.5), 1, 1, fc=UNTESTED, ec="#9a9078", hatch="///", lw=0))
        dark = held[row, column] > 0.6 and not cell.untested
        axes.text(column, row, cell.shown(), ha="center", va="center", fontsize=8,
                  color="white" if dark else "black", zorder=3)  # fmt: skip
    axes.imshow(held, cmap=SHADES, vmin=0.0, vmax=1.15, origin="lower", aspect="auto", zorder=0)
    _frame(axes, across, up)


def _numbers(axes: Axes, made: MapPlan, chosen: Sequence[Number]) -> None:
    """The cells of one measure; a second line has its spread over replicates, or its mark."""
    across, up = made.axes[0], made.axes[1] if len(made.axes) > 1 else None
    values = np.full((len(up.levels) if up else 1, len(across.levels)), np.nan)
    for each in chosen:
        at = dict(each.point.values)
        column, row = across.levels.index(at[across.name]), up.levels.index(at[up.name]) if up else 0
        if each.value is None:
            axes.add_patch(Rectangle((column - 0.5, row - 0.5), 1, 1, fc=UNTESTED, ec="#9a9078", hatch="///", lw=0))
        else:
            values[row, column] = each.value
    known = values[np.isfinite(values)]
    low, high = (float(known.min()), float(known.max())) if known.size else (0.0, 1.0)
    for each in chosen:
        at = dict(each.point.values)
        column, row = across.levels.index(at[across.name]), up.levels.index(at[up.name]) if up else 0
        dark = each.value is not None and high > low and (each.value - low) / (high - low) > 0.6
        style: dict[str, Any] = {"ha": "center", "va": "center", "color": "white" if dark else "black", "zorder": 3}
        notes = _notes(each)
        axes.text(column, row + (0.16 if notes else 0.0), each.shown(), fontsize=8, **style)
        axes.text(column, row - 0.22, notes, fontsize=5.5, **style)
    axes.imshow(values, cmap=SCALE, vmin=low, vmax=high + 0.15 * (high - low), origin="lower", aspect="auto", zorder=0)
    _frame(axes, across, up)


def _notes(each: Number) -> str:
    """The second line of a cell: the replicates' lowest and highest value where they differ, and the mark's words."""
    spread = ""
    if each.lowest is not None and each.highest is not None and each.lowest != each.highest:
        spread = f"{each.lowest:.3g}-{each.highest:.3g}"
    return ", ".join(filter(None, (spread, SHORT.get(each.mark, each.mark))))


def _frame(axes: Axes, across: Axis, up: Axis | None) -> None:
    """Ticks, lines between the cells, the defaults."""
    axes.set_xticks(range(len(across.levels)), [plain(said(value)) for value in across.values()])
    axes.set_yticks(range(len(up.levels)) if up else [], [plain(said(value)) for value in up.values()] if up else [])
    axes.tick_params(length=0, labelbottom=True)
    axes.set_xticks(np.arange(len(across.levels) - 1) + 0.5, minor=True)
    axes.set_yticks(np.arange((len(up.levels) if up else 1) - 1) + 0.5, minor=True)
    axes.grid(which="minor", color="white", lw=1.2)
    axes.tick_params(which="minor", length=0)
    _mark_default(axes, across, up)


def _mark_default(axes: Axes, across: Axis, up: Axis | None) -> None:
    """Triangles where the defaults lie along the axes, and a frame around a cell that is the default in all."""
    x, y = place(across), place(up) if up else 0.0
    style: dict[str, Any] = {"color": DEFAULT, "ms": 5, "clip_on": False, "zorder": 4, "ls": ""}
    if x is not None:
        axes.plot(x, 1.0, marker="v", transform=axes.get_xaxis_transform(), **style)
    if y is not None and up:
        axes.plot(1.0, y, marker="<", transform=axes.get_yaxis_transform(), **style)
    if x is not None and y is not None and x == round(x) and y == round(y):
        axes.add_patch(Rectangle((x - 0.5, y - 0.5), 1, 1, fill=False, ec=DEFAULT, lw=1.6, zorder=4, clip_on=False))


def place(axis: Axis) -> float | None:
    """Where the default lies among an axis's levels: 0 at the first, between two levels a fraction.

    ``None`` where there is no default, or it is outside of the levels, or they are texts and it is none of them.
    """
    if axis.default in axis.values():
        return float(axis.values().index(axis.default))
    numbers = [value for value in (axis.default, *axis.values()) if isinstance(value, float)]
    if len(numbers) <= len(axis.levels) or not numbers[1] <= numbers[0] <= numbers[-1]:
        return None
    return float(np.interp(numbers[0], numbers[1:], range(len(axis.levels))))
