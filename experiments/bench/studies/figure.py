"""A study as a figure: heat maps of counts and numbers."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.image import AxesImage
from matplotlib.patches import Rectangle

from experiments.bench.engine.settings import PRESET
from experiments.bench.figures.plotting import STYLE, headline, plain, wrapped
from experiments.bench.store.parameters import in_title
from experiments.bench.studies.counts import TOGETHER, ClaimCell, Counts, Number, by_claim, by_measure
from experiments.bench.studies.grid import Point
from experiments.bench.studies.plan import StudyPlan
from experiments.bench.studies.study import Axis, value_text

SHADES, SCALE = "Blues", "YlGnBu"
"""Of counts, and of numbers."""
UNJUDGED = "#e3dccb"
DEFAULT = "#c0392b"
"""Of what marks the default's place."""
SHORT = {"at the end of the range": "at end"}
"""Marks that are too long for a cell."""
MOST_ROWS = 16
"""Points with names, of two axes and more: above so many, they make a map for each claim and not the rows of one."""
MOST_COLUMNS = 3
WIDTH, HEIGHT = 0.55, 0.5
"""Of a cell, inches."""
LETTER_INCHES = 0.075
"""Width of a letter of a row's label."""


@dataclass(frozen=True, slots=True)
class Panel:
    """A heat map: cells by row and column.

    Parameters
    ----------
    title
        What its cells are about.
    columns, rows
        Labels, in the order in which they are drawn; rows from below.
    cells
        (Row, column) -> its cell, by their places.
    """

    title: str
    columns: tuple[str, ...]
    rows: tuple[str, ...]
    cells: Mapping[tuple[int, int], ClaimCell | Number]


def draw(counts: Counts) -> Figure:
    """Draw counts and numbers.

    Parameters
    ----------
    counts
        What a study comes to.

    Returns
    -------
    matplotlib.figure.Figure
        A grid of parameters has a panel for each claim and measure. Cells of a claim say "held/all replicates", and
        are hatched where a replicate could not be judged. Cells of a measure have its value, its lowest and highest in
        a replicate where they differ, and what is to be known of it; they are hatched where there is no value. The
        scale of each measure goes from its lowest to its highest value. Triangles at the axes mark the defaults; a
        frame marks the cell where both are. Of points with names, one panel has them down and the claims across; of
        more than `MOST_ROWS` of several axes, each claim has a panel with the last axis down and the others across.
    """
    plan = counts.plan
    across, up = (*plan.axes, None, None)[:2]
    gridded = bool(plan.axes) and all(axis.of_keys for axis in plan.axes)
    mapped = not gridded and len(plan.axes) > 1 and len(plan.points) > MOST_ROWS
    panels = _grids(counts) if gridded and across else _maps(counts) if mapped else [_matrix(counts)]
    wide = max(len(panel.columns) for panel in panels)
    high = max(len(panel.rows) for panel in panels)
    number = len(panels)
    columns = min(number, MOST_COLUMNS)
    lines = math.ceil(number / columns)
    left = 0.0 if gridded else LETTER_INCHES * max(len(row) for row in panels[0].rows)
    size = (
        columns * (max(wide * WIDTH, 2.2) + 0.5) + 1.8 + left,
        lines * (max(high * HEIGHT, 0.5) + (0.9 if number > 1 else 0.7)) + 1.0,
    )
    with mpl.rc_context(STYLE):
        drawn = Figure(figsize=size, layout="constrained")
        places = drawn.subplots(lines, columns, squeeze=False, sharex=True, sharey=True)
        shares: list[tuple[Axes, AxesImage]] = []
        for axes, panel in zip(places.flat, panels, strict=False):
            draw_panel = _numbers if isinstance(next(iter(panel.cells.values())), Number) else _claims
            image = draw_panel(axes, panel)
            if draw_panel is _numbers:
                drawn.colorbar(image, ax=axes, pad=0.02, aspect=25).outline.set_visible(False)
            else:
                shares.append((axes, image))
            title_inches = max(wide * WIDTH, 2.2) if number > 1 else size[0] - left - 1.0
            axes.set_title(plain(wrapped(panel.title, title_inches, 8)), fontsize=8, loc="left")
            if gridded and across:
                _mark_default(axes, across, up)
            if mapped:
                _frame_default(axes, plan, panel)
        for axes in places.flat[number:]:
            axes.set_axis_off()
        if shares:
            bar = drawn.colorbar(shares[0][1], ax=[axes for axes, _ in shares], pad=0.02, aspect=25, shrink=1 / lines)
            bar.ax.set_ylim(0.0, 1.0)
            bar.outline.set_visible(False)
            bar.set_label("share of replicates\nin which it holds")
        if gridded and across:
            drawn.supxlabel(plain(" ".join(across.words())), fontsize=8)
            if up:
                drawn.supylabel(plain("\n".join(up.words())), fontsize=8)
        if not gridded and not mapped and len(plan.axes) > 1:  # a row is called by a level of each of them
            drawn.supylabel(plain(", ".join(axis.name for axis in plan.axes)), fontsize=8)
        if mapped:
            drawn.supxlabel(plain(", ".join(axis.name for axis in plan.axes[:-1])), fontsize=8)
            drawn.supylabel(plain(plan.axes[-1].name), fontsize=8)
        title = f"{plan.models[0].label if len(plan.models) == 1 else plan.study.name}: {_counted(counts)}"
        headline(drawn, f"{title}, from seed {plan.seed}{in_title(_set(plan))}")
    return drawn


def _grids(counts: Counts) -> list[Panel]:
    """Return a panel for each claim and measure over the axes, the first across and the second up."""
    across, up = (*counts.plan.axes, None)[:2]
    assert across is not None
    columns = tuple(value_text(value) for value in across.values())
    rows = tuple(value_text(value) for value in up.values()) if up else ("",)

    def place(cell: ClaimCell | Number) -> tuple[int, int]:
        labels = dict(cell.point.values)
        return up.labels.index(labels[up.name]) if up else 0, across.labels.index(labels[across.name])

    words = _words(counts)
    panels = []
    for title, cells in by_claim(counts.cells).items():
        about = "all together" if cells[0].claim == TOGETHER else f"{title}{words.get(cells[0].claim, '')}"
        panels.append(Panel(about, columns, rows, {place(cell): cell for cell in cells}))
    for title, numbers in by_measure(counts.numbers).items():
        unit = f", {numbers[0].measure.unit}" if numbers[0].measure.unit else ""
        about = f"{title}{unit}  ({numbers[0].experiment})"
        panels.append(Panel(about, columns, rows, {place(number): number for number in numbers}))
    return panels


def _words(counts: Counts) -> dict[str, str]:
    """Return the title of each claim, to be put behind its id."""
    return {claim.id: f": {claim.title}" for claim, _ in counts.plan.claims}


def _maps(counts: Counts) -> list[Panel]:
    """A panel for each claim over points with names: the last axis down from its first level, the others across."""
    plan = counts.plan
    columns = tuple(dict.fromkeys(_across(point) for point in plan.points))
    rows = tuple(reversed(plan.axes[-1].labels))

    words = _words(counts)

    def place(point: Point) -> tuple[int, int]:
        return rows.index(point.values[-1][1]), columns.index(_across(point))

    return [
        Panel("all together" if cells[0].claim == TOGETHER else title + words.get(cells[0].claim, ""), columns, rows,
              {place(cell.point): cell for cell in cells})
        for title, cells in by_claim(counts.cells).items()
    ]  # fmt: skip


def _across(point: Point) -> str:
    """Return what a column of a map of points with names is called: by all levels but the last axis's."""
    return ", ".join(label for _, label in point.values[:-1])


def _matrix(counts: Counts) -> Panel:
    """Return one panel of points with names: points and models down from the first, claims across."""
    plan = counts.plan
    claims = tuple(dict.fromkeys(cell.claim for cell in counts.cells))
    several = len({model for _, model in plan.judged}) > 1
    rows = tuple(reversed(plan.judged))
    labels = tuple(row_label(point, model if several else "") or plan.study.name for point, model in rows)
    cells = {(rows.index((cell.point, cell.model)), claims.index(cell.claim)): cell for cell in counts.cells}
    return Panel(plan.study.name, claims, labels, cells)


def row_label(point: Point, model: str = "") -> str:
    """Return what a row of the matrix is called: the point's levels, then the model where there are several."""
    return ", ".join(filter(None, (*(label for _, label in point.values), model)))


def _set(plan: StudyPlan) -> dict[str, Any]:
    """Return the parameters that are not at their defaults at any point, without those that the axes move."""
    moved = [key for axis in plan.axes for key in axis.keys] + [key for point in plan.points for key, _ in point.values]
    ends = tuple(key.removesuffix(PRESET) for key in moved if key.endswith(f".{PRESET}"))
    return {
        key: values
        for key, values in plan.description.get("changed", {}).items()
        if not key.startswith(ends)
        and not any(moved_key == key or moved_key.startswith(f"{key}.") for moved_key in moved)
    }


def _counted(counts: Counts) -> str:
    """Say what the cells have, and what a replicate has."""
    plan = counts.plan
    number = f"{plan.replicates} replicate{'s' if plan.replicates > 1 else ''}"
    counted = f"held in n/{plan.replicates} replicates" if counts.cells else number
    repeats = "/".join(str(count) for count in dict.fromkeys(plan.repeats))
    return f"{counted}\n{'each clip once' if plan.things == 'clips' else f'{repeats} repeats each'}"


def _claims(axes: Axes, panel: Panel) -> AxesImage:
    held = np.zeros((len(panel.rows), len(panel.columns)))
    for (row, column), cell in panel.cells.items():
        assert isinstance(cell, ClaimCell)
        held[row, column] = cell.drawn.holds / len(cell.outcomes)
        if cell.unjudged:
            axes.add_patch(Rectangle((column - 0.5, row - 0.5), 1, 1, fc=UNJUDGED, ec="#9a9078", hatch="///", lw=0))
        dark = held[row, column] > 0.6 and not cell.unjudged
        axes.text(column, row, cell.text(), ha="center", va="center", fontsize=8,
                  color="white" if dark else "black", zorder=3)  # fmt: skip
    image = axes.imshow(held, cmap=SHADES, vmin=0.0, vmax=1.15, origin="lower", aspect="auto", zorder=0)
    _frame(axes, panel)
    return image


def _numbers(axes: Axes, panel: Panel) -> AxesImage:
    """Draw the cells of one measure; a second line has its spread over replicates, or its mark."""
    values = np.full((len(panel.rows), len(panel.columns)), np.nan)
    for (row, column), number in panel.cells.items():
        assert isinstance(number, Number)
        if number.value is None:
            axes.add_patch(Rectangle((column - 0.5, row - 0.5), 1, 1, fc=UNJUDGED, ec="#9a9078", hatch="///", lw=0))
        else:
            values[row, column] = number.value
    known = values[np.isfinite(values)]
    low, high = (float(known.min()), float(known.max())) if known.size else (0.0, 1.0)
    for (row, column), number in panel.cells.items():
        assert isinstance(number, Number)
        dark = number.value is not None and high > low and (number.value - low) / (high - low) > 0.6
        style: dict[str, Any] = {"ha": "center", "va": "center", "color": "white" if dark else "black", "zorder": 3}
        notes = _notes(number)
        lines = notes.count("\n") + 1 if notes else 0
        axes.text(column, row + (0.0, 0.16, 0.28)[lines], number.text(), fontsize=8, **style)
        axes.text(column, row - (0.0, 0.22, 0.14)[lines], notes, fontsize=8, **style)
    most = high + 0.15 * (high - low)
    image = axes.imshow(values, cmap=SCALE, vmin=low, vmax=most, origin="lower", aspect="auto", zorder=0)
    _frame(axes, panel)
    return image


def _notes(number: Number) -> str:
    """Say, as a cell's further lines, the replicates' lowest and highest value if they differ, and the mark's words."""
    spread = ""
    if number.lowest is not None and number.highest is not None and number.lowest != number.highest:
        spread = f"{number.lowest:.3g}-{number.highest:.3g}"
    return "\n".join(filter(None, (spread, SHORT.get(number.mark, number.mark))))


def _frame(axes: Axes, panel: Panel) -> None:
    """Ticks, and lines between the cells."""
    axes.set_xticks(range(len(panel.columns)), [plain(label) for label in panel.columns])
    rows = [plain(label) for label in panel.rows] if any(panel.rows) else []
    axes.set_yticks(range(len(rows)), rows)
    axes.tick_params(length=0, labelbottom=True)
    axes.set_xticks(np.arange(len(panel.columns) - 1) + 0.5, minor=True)
    axes.set_yticks(np.arange(len(panel.rows) - 1) + 0.5, minor=True)
    axes.grid(which="minor", color="white", lw=1.2)
    axes.tick_params(which="minor", length=0)


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


def _frame_default(axes: Axes, plan: StudyPlan, panel: Panel) -> None:
    """Frame the cell of a map of points with names at which every axis has its default, where there is one."""
    default = tuple((axis.name, axis.default) for axis in plan.axes)
    for point in (candidate for candidate in plan.points if candidate.values == default):
        x, y = panel.columns.index(_across(point)), panel.rows.index(point.values[-1][1])
        axes.add_patch(Rectangle((x - 0.5, y - 0.5), 1, 1, fill=False, ec=DEFAULT, lw=1.6, zorder=4, clip_on=False))


def place(axis: Axis) -> float | None:
    """Find where the default lies among an axis's levels: 0 at the first, between two levels a fraction.

    ``None`` where there is no default, or it is outside of the levels, or they are texts and it is none of them.
    """
    if axis.default in axis.values():
        return float(axis.values().index(axis.default))
    numbers = [value for value in (axis.default, *axis.values()) if isinstance(value, float)]
    if len(numbers) <= len(axis.labels) or not numbers[1] <= numbers[0] <= numbers[-1]:
        return None
    return float(np.interp(numbers[0], numbers[1:], range(len(axis.labels))))
