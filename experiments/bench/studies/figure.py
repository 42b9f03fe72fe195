"""A study as a figure: heat maps of counts and numbers."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.image import AxesImage
from matplotlib.legend_handler import HandlerBase
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, Rectangle
from matplotlib.text import Text
from matplotlib.ticker import MaxNLocator

from experiments.bench.engine.settings import PRESET
from experiments.bench.figures.plotting import (
    LETTER_INCHES,
    LINE,
    STYLE,
    WIDTH,
    headline,
    leftmost,
    lowest,
    plain,
    wrapped,
)
from experiments.bench.store.parameters import in_title
from experiments.bench.studies.counts import SIGNS, TOGETHER, ClaimCell, Counts, Number, by_claim, by_measure
from experiments.bench.studies.grid import Point
from experiments.bench.studies.measures import BELOW_THRESHOLD
from experiments.bench.studies.plan import StudyPlan
from experiments.bench.studies.study import Axis, value_text

SHADES, SCALE = "Blues", "YlGnBu"
"""Colour maps of counts, and of numbers."""
UNJUDGED, HATCH = "#e3dccb", "#9a9078"
DEFAULT = "#c0392b"
"""Colour of the marks at the default's place."""
SHORT = {"at the end of the range": "at end"}
"""Marks that are too long for a cell."""
MOST_ROWS = 16
"""Points with names, of two axes and more: above so many, they make a map for each claim and not the rows of one."""
MOST_COLUMNS = 3
CELL, CLAIM_HIGH, NUMBER_HIGH = 0.55, 0.27, 0.5
"""Size of a cell, inches: its width where there is room for it, the height of one line and of three."""
LEAST_PANEL = 1.5
"""Least width of a panel, inches: that of a short title."""
GAP, MARGIN = 0.15, 0.45
"""Width between panels, and of what stands left and right of all, inches."""
MOST_LABEL = 2.6
"""Greatest width of a row's label, inches; longer ones are broken."""
LEAST_WIDTH = 4.2
"""Least width of a figure, inches: that of its title."""
BAR_HIGH = 0.45
"""Height of a colour bar with its numbers, inches."""


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

    @property
    def of_claims(self) -> bool:
        """True if the cells are counts of a claim, not values of a measure."""
        return not isinstance(next(iter(self.cells.values())), Number)


def draw(counts: Counts) -> Figure:
    """Draw counts and numbers.

    Parameters
    ----------
    counts
        The study's result.

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
    panels = _grids(counts) if _gridded(plan) else _maps(counts) if _mapped(plan) else [_matrix(counts)]
    layout = _layout(panels)
    panels = [part for panel in panels for part in _parts(panel, layout.most)]
    keys = _keys(panels, counts, framed=_gridded(plan) or _mapped(plan))
    wide, high = max(len(panel.columns) for panel in panels), max(len(panel.rows) for panel in panels)
    columns = layout.columns(len(panels), wide)
    lines = math.ceil(len(panels) / columns)
    panel_inches = min(max(wide * CELL, 2.2), (WIDTH - layout.left - MARGIN) / columns - GAP)
    longest = LETTER_INCHES * max(len(label) for panel in panels for label in panel.columns)
    turned = longest > panel_inches / wide - 0.1
    once = turned and len({panel.columns for panel in panels}) == 1
    of_claims = [panel.of_claims for panel in panels]
    below = 0.0 if once else longest if turned else LINE
    line_high = high * layout.high + 0.45 + below + (0.0 if all(of_claims) else BAR_HIGH)
    size = (
        min(WIDTH, max(layout.left + MARGIN + columns * (panel_inches + GAP), *map(_key_inches, keys), LEAST_WIDTH)),
        lines * line_high + 0.75 + (0.65 if any(of_claims) else 0.0) + 0.2 * len(keys),
    )
    title_inches = panel_inches if columns > 1 else size[0] - layout.left - MARGIN
    with mpl.rc_context(STYLE):
        drawn = Figure(figsize=size, layout="constrained")
        places = drawn.subplots(lines, columns, squeeze=False, sharey=True)
        shown = list(places.flat[: len(panels)])
        for axes in places.flat[len(panels) :]:
            axes.set_axis_off()
        _heat(drawn, shown, panels, pad=0.1 / size[1] if all(of_claims) else 0.04)
        for axes, panel in zip(shown, panels, strict=True):
            axes.set_title(plain(wrapped(panel.title, title_inches, 8)), fontsize=8, loc="left")
            axes.tick_params(axis="x", labelrotation=90 if turned else 0, labelbottom=not once)
            if _gridded(plan):
                _mark_default(axes, plan.axes)
            if _mapped(plan):
                _frame_default(axes, plan, panel)
        _name_axes(drawn, shown, plan, panel_inches)
        if keys:
            drawn.legend(handles=keys, loc="outside lower left", frameon=False, fontsize=8, handlelength=3.0,
                         handler_map={Text: SignHandler()})  # fmt: skip
        title = f"{plan.models[0].label if len(plan.models) == 1 else plan.study.name}: {_counted(counts)}"
        headline(drawn, f"{title}, from seed {plan.seed}{in_title(_set(plan))}")
    return drawn


def _gridded(plan: StudyPlan) -> bool:
    """Tell whether the points are a grid of parameters."""
    return bool(plan.axes) and all(axis.of_keys for axis in plan.axes)


def _mapped(plan: StudyPlan) -> bool:
    """Tell whether the points have names and are so many that they make a map for each claim."""
    return not _gridded(plan) and len(plan.axes) > 1 and len(plan.points) > MOST_ROWS


def _heat(drawn: Figure, shown: Sequence[Axes], panels: Sequence[Panel], pad: float) -> None:
    """Draw the cells of all panels, and their scales: one of all claims, and one of each measure."""
    shares: list[tuple[Axes, AxesImage]] = []
    for axes, panel in zip(shown, panels, strict=True):
        if panel.of_claims:
            shares.append((axes, _claims(axes, panel)))
        else:
            image = _numbers(axes, panel)
            values = {number.value for number in panel.cells.values() if isinstance(number, Number)} - {None}
            ticks = MaxNLocator(4) if len(values) != 1 else list(values)  # one value has no scale
            bar = drawn.colorbar(image, ax=axes, location="bottom", aspect=30, pad=pad, ticks=ticks)
            bar.outline.set_visible(False)
    if shares:
        bar = drawn.colorbar(shares[0][1], ax=[axes for axes, _ in shares], location="bottom", aspect=30, pad=pad,
                             shrink=min(1.0, 2.5 / drawn.get_size_inches()[0]))  # fmt: skip
        bar.ax.set_xlim(0.0, 1.0)
        bar.outline.set_visible(False)
        bar.set_label("share of replicates in which it holds")


def _name_axes(drawn: Figure, shown: Sequence[Axes], plan: StudyPlan, panel_inches: float) -> None:
    """Write what is along the axes: at each outer panel of a grid; once where a row is called by levels."""
    for axes in lowest([shown]):
        axes.tick_params(axis="x", labelbottom=True)
        if _gridded(plan):
            axes.set_xlabel(plain(wrapped(" ".join(plan.axes[0].words()), panel_inches, 8)), fontsize=8)
        if _mapped(plan):
            axes.set_xlabel(plain(", ".join(axis.name for axis in plan.axes[:-1])), fontsize=8)
    if _gridded(plan) and len(plan.axes) > 1:
        for axes in leftmost([shown]):
            axes.set_ylabel(plain("\n".join(plan.axes[1].words())), fontsize=8)
    elif _mapped(plan):
        drawn.supylabel(plain(plan.axes[-1].name), fontsize=8)
    elif len(plan.axes) > 1:  # a row is called by a level of each of them
        drawn.supylabel(plain(", ".join(axis.name for axis in plan.axes)), fontsize=8)


@dataclass(frozen=True, slots=True)
class Layout:
    """Sizes that panels need, inches.

    Parameters
    ----------
    left
        Width of the labels of rows.
    least, high
        Least width of a cell, and its height.
    """

    left: float
    least: float
    high: float

    @property
    def most(self) -> int:
        """The most cells beside each other on a page."""
        return max(int((WIDTH - self.left - MARGIN - GAP) / self.least), 1)

    def columns(self, panels: int, wide: int) -> int:
        """Return how many panels of ``wide`` cells stand beside each other, of so many ``panels``."""
        fitting = int((WIDTH - self.left - MARGIN) / (max(wide * self.least, LEAST_PANEL) + GAP))
        return max(min(panels, fitting, MOST_COLUMNS), 1)


def _layout(panels: Sequence[Panel]) -> Layout:
    cells = [cell for panel in panels for cell in panel.cells.values()]
    lines = [
        line
        for cell in cells
        for line in (cell.text(), *(_notes(cell).split("\n") if isinstance(cell, Number) else ()))
    ]
    labels = [line for panel in panels for row in panel.rows for line in _row_label(row).split("\n")]
    of_rows = max(_row_label(row).count("\n") + 1 for panel in panels for row in panel.rows)
    numbers = any(isinstance(cell, Number) for cell in cells)
    return Layout(
        LETTER_INCHES * max(map(len, labels)),
        LETTER_INCHES * max(map(len, lines), default=1) + 0.05,
        max(NUMBER_HIGH if numbers else CLAIM_HIGH, LINE * of_rows + 0.06),
    )


def _row_label(row: str) -> str:
    """Break the label of a row into lines that leave room for the cells."""
    return wrapped(row, MOST_LABEL, 8)


def _parts(panel: Panel, most: int) -> list[Panel]:
    """Break a panel of more than ``most`` columns into panels of about equally many, below each other."""
    number = math.ceil(len(panel.columns) / most)
    if number <= 1:
        return [panel]
    share = math.ceil(len(panel.columns) / number)
    starts = range(0, len(panel.columns), share)
    return [
        Panel(f"{panel.title} ({place} of {len(starts)})", panel.columns[start : start + share], panel.rows,
              {(row, column - start): cell for (row, column), cell in panel.cells.items()
               if start <= column < start + share})
        for place, start in enumerate(starts, 1)
    ]  # fmt: skip


def _keys(panels: Sequence[Panel], counts: Counts, *, framed: bool) -> list[Artist]:
    """Return what the cells' signs mean, in words: of those that there are."""
    cells = [cell for panel in panels for cell in panel.cells.values()]
    judged = [cell for cell in cells if isinstance(cell, ClaimCell)]
    numbers = [cell for cell in cells if isinstance(cell, Number)]
    notes = {note for number in numbers for note in _notes(number).split("\n")}
    keys: list[Artist] = []
    if judged:
        total = counts.plan.replicates
        keys.append(_sign(f"n/{total}", f"in n of {total} replicate{'s' * (total > 1)} the claim holds"))
    keys += [_sign(sign, words) for sign, words in SIGNS.items() if any(sign in cell.signs for cell in judged)]
    unjudged = any(cell.unjudged for cell in judged)
    if unjudged or any(number.value is None for number in numbers):
        words = "some replicate could not be judged, as trials or clips are missing" if unjudged else "no value"
        keys.append(Patch(fc=UNJUDGED, ec=HATCH, hatch="///", lw=0, label=words))
    if any(number.lowest is not None and number.lowest != number.highest for number in numbers):
        keys.append(_sign("a-b", "lowest and highest value of a replicate"))
    keys += [_sign(short, f"the value is {words}") for words, short in SHORT.items() if short in notes]
    if BELOW_THRESHOLD in notes:
        keys.append(_sign(BELOW_THRESHOLD, "the value does not pass the model's threshold"))
    return [*keys, *(_default_keys(counts.plan) if framed else [])]


def _default_keys(plan: StudyPlan) -> list[Artist]:
    """Return what the marks of the defaults mean: of those that there are."""
    if not _gridded(plan):
        framed = any(axis.default is not None for axis in plan.axes)
        return [Patch(fill=False, ec=DEFAULT, lw=1.6, label="the default")] if framed else []
    places = [place(axis) for axis in plan.axes]
    keys: list[Artist] = []
    if any(where is not None for where in places):
        keys.append(Line2D([], [], ls="", marker="v", color=DEFAULT, ms=5, label="the default"))
    if all(where is not None and where == round(where) for where in places):
        keys.append(
            Patch(fill=False, ec=DEFAULT, lw=1.6, label="all at their defaults" if len(places) > 1 else "the default")
        )
    return keys[-1:] if len(places) == 1 else keys


def _key_inches(key: Artist) -> float:
    """Return the width of a key's words and of its sign."""
    return LETTER_INCHES * len(str(key.get_label())) + 0.7


def _sign(sign: str, words: str) -> Text:
    """Return the key of a sign that stands in cells; `SignHandler` draws it."""
    return Text(text=sign, label=words)


class SignHandler(HandlerBase):
    """Draws a sign in a key as it stands in cells."""

    def create_artists(
        self, legend: Any, orig_handle: Any, xdescent: float, ydescent: float, width: float, height: float,
        fontsize: float, trans: Any,
    ) -> list[Artist]:  # fmt: skip
        """Return the sign in the middle of the handle's place."""
        sign = Text(width / 2 - xdescent, height / 2 - ydescent, orig_handle.get_text(), fontsize=8, ha="center",
                    va="center_baseline")  # fmt: skip
        sign.set_transform(trans)
        return [sign]


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
        about = f"{title}{unit} ({numbers[0].experiment})"
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
    plural = "" if repeats == "1" else "s"
    return f"{counted}\n{'each clip once' if plan.things == 'clips' else f'{repeats} repeat{plural} each'}"


def _claims(axes: Axes, panel: Panel) -> AxesImage:
    held = np.zeros((len(panel.rows), len(panel.columns)))
    for (row, column), cell in panel.cells.items():
        assert isinstance(cell, ClaimCell)
        held[row, column] = cell.drawn.holds / len(cell.outcomes)
        if cell.unjudged:
            axes.add_patch(Rectangle((column - 0.5, row - 0.5), 1, 1, fc=UNJUDGED, ec=HATCH, hatch="///", lw=0))
        dark = held[row, column] > 0.6 and not cell.unjudged
        clear = {"fc": UNJUDGED, "lw": 0, "pad": 0.8} if cell.unjudged else None  # no hatching behind the count
        axes.text(column, row, cell.text(), ha="center", va="center", fontsize=8, bbox=clear,
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
            axes.add_patch(Rectangle((column - 0.5, row - 0.5), 1, 1, fc=UNJUDGED, ec=HATCH, hatch="///", lw=0))
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
    most = high + (0.15 * (high - low) or 1.0)  # of equal values the scale begins at theirs
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
    rows = [plain(_row_label(label)) for label in panel.rows] if any(panel.rows) else []
    axes.set_yticks(range(len(rows)), rows)
    axes.tick_params(length=0, labelbottom=True)
    axes.set_xticks(np.arange(len(panel.columns) - 1) + 0.5, minor=True)
    axes.set_yticks(np.arange(len(panel.rows) - 1) + 0.5, minor=True)
    axes.grid(which="minor", color="white", lw=1.2)
    axes.tick_params(which="minor", length=0)


def _mark_default(axes: Axes, moved: Sequence[Axis]) -> None:
    """Triangles where the defaults lie along the axes, and a frame around a cell that is the default in all."""
    across, up = (*moved, None)[:2]
    assert across is not None
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
