"""A study as a figure: heat maps of counts and numbers."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
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

from experiments.bench.figures.plotting import LETTER_INCHES, LINE, STYLE, headline, leftmost, lowest, plain, wrapped
from experiments.bench.run.settings import PRESET
from experiments.bench.stats.count import REASONS
from experiments.bench.store.parameters import in_title
from experiments.bench.studies.counts import SIGNS, TOGETHER, ClaimCell, Counts, Number, by_claim, by_measure
from experiments.bench.studies.grid import Point
from experiments.bench.studies.measures import BELOW_THRESHOLD
from experiments.bench.studies.plan import StudyPlan
from experiments.bench.studies.sheet import NUMBER_HIGH, SHORT, Panel, Sheet, broken, cell_lines, lay_out, notes
from experiments.bench.studies.study import Axis, value_text

SHADES, SCALE = "Blues", "YlGnBu"
"""Colour maps of counts, and of numbers."""
LEAST_SPAN = 0.1
"""Least span of a scale of numbers, as a share of the largest: half a spike of 240 is not light against dark."""
UNJUDGED, HATCH = "#e3dccb", "#9a9078"
DEFAULT = "#c0392b"
"""Colour of the marks at the default's place."""
MOST_KEYED = 6
"""Claims in the columns of one panel, of which the words stand below it; of more they would take a third of a page."""
MOST_ROWS = 16
"""Points with names, of two axes and more: above so many, they make a map for each claim and not the rows of one."""


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
        Where the panels of several models would be taller than a page, those of one axis are the rows of one panel,
        and the others have a scale of each measure in common.
    """
    plan = counts.plan
    panels = _grids(counts) if _gridded(plan) else _maps(counts) if _mapped(plan) else [_matrix(counts)]
    framed = _gridded(plan) or _mapped(plan)
    keys = _keys(panels, counts, framed=framed)
    if not framed and len(panels[0].columns) <= MOST_KEYED:
        keys = [*_subject_keys(counts), *keys]
    sheet = lay_out([panels], [*map(_key_inches, keys)])
    if sheet.tight and len({panel.subject for panel in panels}) < len(panels):  # of several models
        if all(len(panel.rows) == 1 for panel in panels):
            sheet = lay_out([_stacked(panels)], [*map(_key_inches, keys)])
        else:
            keys = [*_subject_keys(counts), *keys]
            sheet = lay_out(_by_subject(panels), [*map(_key_inches, keys)], shared=True)
    panels = sheet.panels
    with mpl.rc_context(STYLE):
        drawn = Figure(figsize=sheet.size, layout="constrained")
        places = drawn.subplots(sum(sheet.lines), sheet.columns, squeeze=False, sharey=True)
        firsts = [sum(sheet.lines[:place]) for place in range(len(sheet.groups))]
        shown = [axes for first, group in zip(firsts, sheet.groups, strict=True)
                 for axes in list(places[first:].flat)[: len(group)]]  # fmt: skip
        for axes in places.flat:
            if axes not in shown:
                axes.set_axis_off()
        _heat(drawn, shown, sheet)
        for axes, panel in zip(shown, panels, strict=True):
            axes.set_title(plain(wrapped(panel.title, sheet.title_inches, 8)), fontsize=8, loc="left")
            axes.tick_params(axis="x", labelrotation=90 if sheet.turned else 0, labelbottom=not sheet.once)
            if _gridded(plan):
                _mark_default(axes, plan.axes, len(panel.rows))
            if _mapped(plan):
                _frame_default(axes, plan, panel)
        _name_axes(drawn, shown, plan, sheet)
        if keys:
            drawn.legend(handles=keys, loc="outside lower left", frameon=False, fontsize=8, handlelength=3.0,
                         handler_map={Text: SignHandler()})  # fmt: skip
        headline(drawn, f"{_title(plan)}{_counted(counts)}, from seed {plan.seed}{in_title(_set(plan))}")
    return drawn


def _title(plan: StudyPlan) -> str:
    """Say which study it is: of a map, whose name says nothing, the model; of any other, what it is about."""
    if not _gridded(plan):
        return f"{plan.study.name}: {plan.study.summary}\n"
    return f"{plan.study.name}{f', {plan.models[0].label}' if len(plan.models) == 1 else ''}: "


def _gridded(plan: StudyPlan) -> bool:
    """Tell whether the points are a grid of parameters."""
    return bool(plan.axes) and all(axis.of_keys for axis in plan.axes)


def _mapped(plan: StudyPlan) -> bool:
    """Tell whether the points have names and are so many that they make a map for each claim."""
    return not _gridded(plan) and len(plan.axes) > 1 and len(plan.points) > MOST_ROWS


def _ticks(panels: Sequence[Panel]) -> MaxNLocator | list[float]:
    """Return the ticks of the scale of panels of numbers: one value has no scale."""
    values = {number.value for panel in panels for number in panel.cells.values() if isinstance(number, Number)} - {
        None
    }
    return MaxNLocator(4) if len(values) != 1 else [value for value in values if value is not None]


def _heat(drawn: Figure, shown: Sequence[Axes], sheet: Sheet) -> None:
    """Draw the cells of all panels, and their scales: one of all claims, and one of each measure."""
    short = min(1.0, 2.5 / drawn.get_size_inches()[0])
    pad = 0.1 / sheet.size[1] if sheet.tight or all(panel.of_claims for panel in sheet.panels) else 0.04
    shares: list[tuple[Axes, AxesImage]] = []
    places = iter(shown)
    for group in sheet.groups:
        numbers: list[tuple[Axes, AxesImage, Panel]] = []
        for panel, axes in zip(group, places, strict=False):
            if panel.of_claims:
                shares.append((axes, _claims(axes, panel, sheet.label)))
            else:
                image = _numbers(axes, panel, sheet, _limits(group if sheet.shared else [panel]))
                numbers.append((axes, image, panel))
        if sheet.shared and numbers:
            bar = drawn.colorbar(numbers[0][1], ax=[axes for axes, _, _ in numbers], location="bottom", aspect=30,
                                 pad=pad, shrink=short, ticks=_ticks(group))  # fmt: skip
            bar.outline.set_visible(False)
            bar.set_label(plain(group[0].subject))
        for axes, image, panel in numbers if not sheet.shared else ():
            bar = drawn.colorbar(image, ax=axes, location="bottom", aspect=30, pad=pad, ticks=_ticks([panel]))
            bar.outline.set_visible(False)
    if shares:
        bar = drawn.colorbar(shares[0][1], ax=[axes for axes, _ in shares], location="bottom", aspect=30, pad=pad,
                             shrink=short)  # fmt: skip
        bar.ax.set_xlim(0.0, 1.0)
        bar.outline.set_visible(False)
        bar.set_label("share of replicates in which it holds")


def _limits(panels: Sequence[Panel]) -> tuple[float, float]:
    """Return the ends of the scale of a measure: its smallest and largest value, or what leaves small spans pale."""
    numbers = [cell for panel in panels for cell in panel.cells.values() if isinstance(cell, Number)]
    known = [number.value for number in numbers if number.value is not None and math.isfinite(number.value)]
    if not known:
        return 0.0, 1.0
    return min(min(known), max(known) - LEAST_SPAN * abs(max(known))), max(known)


def _stacked(panels: Sequence[Panel]) -> list[Panel]:
    """Return for panels of one row a panel for each subject, with a row for each model, the first on top."""
    models = list(dict.fromkeys(panel.first.model for panel in reversed(panels)))
    return [
        Panel(subject, group[0].columns, tuple(models),
              {(models.index(panel.first.model), column): cell
               for panel in group for (_, column), cell in panel.cells.items()})
        for subject, group in _groups(panels).items()
    ]  # fmt: skip


def _by_subject(panels: Sequence[Panel]) -> list[list[Panel]]:
    """Return the panels of each subject, called by their model alone, and by the subject's name if there are more."""
    groups = list(_groups(panels).values())
    if len(groups) == 1:
        return [[replace(panel, title=panel.first.model) for panel in groups[0]]]
    return [[replace(panel, title=f"{_name(panel.first)}, {panel.first.model}") for panel in group] for group in groups]


def _groups(panels: Sequence[Panel]) -> dict[str, list[Panel]]:
    groups: dict[str, list[Panel]] = {}
    for panel in panels:
        groups.setdefault(panel.subject, []).append(panel)
    return groups


def _name(cell: ClaimCell | Number) -> str:
    """Return what a cell is of, in a word."""
    return cell.measure.name if isinstance(cell, Number) else cell.claim


def _subject_keys(counts: Counts) -> list[Artist]:
    """Return the words of the claims, of panels that are called by a claim's id or not at all."""
    words = {claim.id: claim.title for claim, _ in counts.plan.claims} | {TOGETHER: "all claims together"}
    return [_sign(claim, words.get(claim, claim)) for claim in dict.fromkeys(cell.claim for cell in counts.cells)]


def _name_axes(drawn: Figure, shown: Sequence[Axes], plan: StudyPlan, sheet: Sheet) -> None:
    """Write what is along the axes: at each outer panel of a grid; once where a row is called by levels."""
    for axes in lowest([shown]):
        axes.tick_params(axis="x", labelbottom=True)
        if _gridded(plan):
            axes.set_xlabel(plain(wrapped(" ".join(plan.axes[0].words()), sheet.panel, 8)), fontsize=8)
        if _mapped(plan):
            axes.set_xlabel(plain(", ".join(axis.name for axis in plan.axes[:-1])), fontsize=8)
    if _gridded(plan) and len(plan.axes) > 1:
        if sheet.tight:
            drawn.supylabel(plain(" ".join(plan.axes[1].words())), fontsize=8)
        for axes in leftmost([shown]) if not sheet.tight else ():
            axes.set_ylabel(plain("\n".join(plan.axes[1].words())), fontsize=8)
    elif _mapped(plan):
        drawn.supylabel(plain(plan.axes[-1].name), fontsize=8)
    elif plan.axes:  # a row is called by a level of each of them
        drawn.supylabel(plain(", ".join(axis.name for axis in plan.axes)), fontsize=8)


def _keys(panels: Sequence[Panel], counts: Counts, *, framed: bool) -> list[Artist]:
    """Return what the cells' signs mean, in words: of those that there are."""
    cells = [cell for panel in panels for cell in panel.cells.values()]
    judged = [cell for cell in cells if isinstance(cell, ClaimCell)]
    numbers = [cell for cell in cells if isinstance(cell, Number)]
    signs = {note for number in numbers for note in notes(number).split("\n")}
    keys: list[Artist] = []
    if judged:
        total = counts.plan.replicates
        keys.append(_sign(f"n/{total}", f"in n of {total} replicate{'s' * (total > 1)} the claim holds"))
    keys += [_sign(sign, words) for sign, words in SIGNS.items() if any(sign in cell.signs for cell in judged)]
    hatched = [
        f"some replicate could not be judged: {why}" for reason, why in REASONS.items()
        if any(reason in cell.unjudged for cell in judged)
    ]  # fmt: skip
    if not hatched and any(number.value is None for number in numbers):
        hatched = ["no value"]
    keys += [Patch(fc=UNJUDGED, ec=HATCH, hatch="///", lw=0, label=words) for words in hatched]
    if any(number.lowest is not None and number.lowest != number.highest for number in numbers):
        keys.append(_sign("a-b", "lowest and highest value of a replicate"))
    keys += [_sign(short, f"the value is {words}") for words, short in SHORT.items() if short in signs]
    if BELOW_THRESHOLD in signs:
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
        claim, model = cells[0].claim, title.removeprefix(cells[0].claim)  # ", MODEL" of several models
        about = f"all together{model}" if claim == TOGETHER else f"{title}{words.get(claim, '')}"
        subject = "all together" if claim == TOGETHER else f"{claim}{words.get(claim, '')}"
        panels.append(Panel(about, columns, rows, {place(cell): cell for cell in cells}, subject))
    for title, numbers in by_measure(counts.numbers).items():
        unit = f", {numbers[0].measure.unit}" if numbers[0].measure.unit else ""
        more = f"{unit} ({numbers[0].experiment})"
        cells_of = {place(number): number for number in numbers}
        panels.append(Panel(f"{title}{more}", columns, rows, cells_of, f"{numbers[0].measure.name}{more}"))
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

    panels = []
    for title, cells in by_claim(counts.cells).items():
        claim, model = cells[0].claim, title.removeprefix(cells[0].claim)
        about = f"all together{model}" if claim == TOGETHER else title + words.get(claim, "")
        subject = "all together" if claim == TOGETHER else claim + words.get(claim, "")
        panels.append(Panel(about, columns, rows, {place(cell.point): cell for cell in cells}, subject))
    return panels


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
    return Panel("claims", claims, labels, cells)


def row_label(point: Point, model: str = "") -> str:
    """Return what a row of the matrix is called: the point's levels, then the model where there are several."""
    return ", ".join(filter(None, (*(label for _, label in point.values), model)))


def _set(plan: StudyPlan) -> dict[str, Any]:
    """Return the parameters that are not at their defaults, without those that the axes move."""
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
    counted = f"held in n of {number}" if counts.cells else number
    repeats = "/".join(str(count) for count in dict.fromkeys(plan.repeats))
    plural = "" if repeats == "1" else "s"
    return f"{counted}\n{'each clip once' if plan.things == 'clips' else f'{repeats} repeat{plural} each'}"


def _claims(axes: Axes, panel: Panel, label: float) -> AxesImage:
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
    _frame(axes, panel, label)
    return image


def _numbers(axes: Axes, panel: Panel, sheet: Sheet, limits: tuple[float, float]) -> AxesImage:
    """Draw the cells of one measure; a second line has its spread over replicates, or its mark."""
    values = np.full((len(panel.rows), len(panel.columns)), np.nan)
    for (row, column), number in panel.cells.items():
        assert isinstance(number, Number)
        if number.value is None:
            axes.add_patch(Rectangle((column - 0.5, row - 0.5), 1, 1, fc=UNJUDGED, ec=HATCH, hatch="///", lw=0))
        else:
            values[row, column] = number.value
    (low, high), line = limits, LINE / sheet.row
    values_up, notes_down = ((0.0, 0.16, 0.28), (0.0, 0.22, 0.14)) if sheet.row >= NUMBER_HIGH else (
        (0.0, 0.5 * line, line), (0.0, 0.5 * line, 0.5 * line)
    )  # fmt: skip
    for (row, column), number in panel.cells.items():
        assert isinstance(number, Number)
        dark = number.value is not None and high > low and (number.value - low) / (high - low) > 0.6
        style: dict[str, Any] = {"ha": "center", "va": "center", "color": "white" if dark else "black", "zorder": 3}
        more = cell_lines(number)[1:]
        axes.text(column, row + values_up[len(more)], number.text(), fontsize=8, **style)
        axes.text(column, row - notes_down[len(more)], "\n".join(more), fontsize=8, **style)
    most = high + (0.15 * (high - low) or 1.0)  # of equal values the scale begins at theirs
    image = axes.imshow(values, cmap=SCALE, vmin=low, vmax=most, origin="lower", aspect="auto", zorder=0)
    _frame(axes, panel, sheet.label)
    return image


def _frame(axes: Axes, panel: Panel, label: float) -> None:
    """Ticks, and lines between the cells."""
    axes.set_xticks(range(len(panel.columns)), [plain(column) for column in panel.columns])
    rows = [plain(broken(row, label)) for row in panel.rows] if any(panel.rows) else []
    axes.set_yticks(range(len(rows)), rows)
    axes.tick_params(length=0, labelbottom=True)
    axes.set_xticks(np.arange(len(panel.columns) - 1) + 0.5, minor=True)
    axes.set_yticks(np.arange(len(panel.rows) - 1) + 0.5, minor=True)
    axes.grid(which="minor", color="white", lw=1.2)
    axes.tick_params(which="minor", length=0)


def _mark_default(axes: Axes, moved: Sequence[Axis], rows: int) -> None:
    """Triangles where the defaults lie along the axes, and a frame around a cell that is the default in all.

    Where there is one axis, the frame is around all ``rows``.
    """
    across, up = (*moved, None)[:2]
    assert across is not None
    x, y = place(across), place(up) if up else 0.0
    style: dict[str, Any] = {"color": DEFAULT, "ms": 5, "clip_on": False, "zorder": 4, "ls": ""}
    if x is not None:
        axes.plot(x, 1.0, marker="v", transform=axes.get_xaxis_transform(), **style)
    if y is not None and up:
        axes.plot(1.0, y, marker="<", transform=axes.get_yaxis_transform(), **style)
    if x is not None and y is not None and x == round(x) and y == round(y):
        high = 1 if up else rows
        axes.add_patch(Rectangle((x - 0.5, y - 0.5), 1, high, fill=False, ec=DEFAULT, lw=1.6, zorder=4, clip_on=False))


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
