"""Where the heat maps of a study's figure stand, and how large their cells are."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from experiments.bench.figures.plotting import LETTER_INCHES, LINE, PAGE, WIDTH, wrapped
from experiments.bench.studies.counts import ClaimCell, Number, in_digits

SHORT = {"at the end of the range": "at end"}
"""Marks that are too long for a cell."""
CELL, CLAIM_HIGH, NUMBER_HIGH = 0.55, 0.27, 0.5
"""Size of a cell, inches: its width where there is room for it, the height of one line and of three."""
MARGIN = 0.45
"""Width of what stands left and right of all panels, inches."""
LEAST_WIDTH = 4.2
"""Least width of a figure, inches: that of its title."""
TITLE_HIGH, BAR_HIGH = 0.45, 0.45
"""Heights of a panel's title, and of a colour bar with its numbers, inches."""
AROUND, CLAIMS_BAR, KEY_HIGH = 0.9, 0.65, 0.2
"""Heights of the figure's title, of the colour bar of claims, and of a line of the key, inches."""
TIGHT_TITLE = 0.16
"""Height of what is around the lines of a panel's title where panels are tight, inches."""


@dataclass(frozen=True, slots=True)
class Spacing:
    """How close all stands.

    Parameters
    ----------
    columns
        Most panels side by side.
    pad, gap
        Widths beside the text of a cell, and between panels, inches.
    panel
        Least width of a panel, inches.
    label
        Greatest width of the label of a row where there is room for it, inches; longer ones are broken.
    """

    columns: int
    pad: float
    gap: float
    panel: float
    label: float


USUAL, TIGHT = Spacing(3, 0.05, 0.15, 1.5, 2.6), Spacing(6, 0.03, 0.08, 1.2, 3.4)


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
    subject
        The title without the model, of which there are several.
    """

    title: str
    columns: tuple[str, ...]
    rows: tuple[str, ...]
    cells: Mapping[tuple[int, int], ClaimCell | Number]
    subject: str = ""

    @property
    def first(self) -> ClaimCell | Number:
        """One of its cells."""
        return next(iter(self.cells.values()))

    @property
    def of_claims(self) -> bool:
        """True if the cells are counts of a claim, not values of a measure."""
        return not isinstance(self.first, Number)


Group = Sequence[Panel]
"""Panels that begin a line."""


@dataclass(frozen=True, slots=True)
class Sheet:
    """How panels stand.

    Parameters
    ----------
    groups
        The panels, of which each group begins a line.
    columns
        Panels side by side.
    left, label, panel
        Widths, inches: of the rows' labels, of the longest that one may be, and of a panel.
    row
        Height of a row of cells, inches.
    turned, once
        Whether the labels of columns are turned, and whether they stand at the lowest panels alone.
    size
        Width and height of the figure, inches.
    tight
        Whether all stands as close as type allows.
    shared
        Whether the panels of a group have one scale of colours, and one bar of it.
    """

    groups: tuple[Group, ...]
    columns: int
    left: float
    label: float
    panel: float
    row: float
    turned: bool
    once: bool
    size: tuple[float, float]
    tight: bool = False
    shared: bool = False

    @property
    def panels(self) -> list[Panel]:
        """All panels, in their order."""
        return [panel for group in self.groups for panel in group]

    @property
    def lines(self) -> list[int]:
        """How many lines of panels each group has."""
        return [math.ceil(len(group) / self.columns) for group in self.groups]

    @property
    def title_inches(self) -> float:
        """Width of a panel's title."""
        return self.panel if self.columns > 1 else self.size[0] - self.left - MARGIN


def lay_out(groups: Sequence[Group], keys: Sequence[float], *, shared: bool = False) -> Sheet:
    """Return how panels stand; ``keys`` are the widths of the lines of the key.

    Where they would be taller than a page, and where a scale of colours is ``shared``, they are tight: rows are as low
    as their text allows, and as many panels stand side by side as it takes and as there is room for.
    """
    sheet = _usual(_widths(groups, keys, USUAL), len(keys))
    for columns in range(sheet.columns, TIGHT.columns + 1):
        if sheet.size[1] <= PAGE + 1e-9 and sheet.shared == shared:
            break
        close = _widths(groups, keys, replace(TIGHT, columns=columns))
        sheet = _tight(replace(close, tight=True, shared=shared), len(keys))
    return sheet


def _widths(groups: Sequence[Group], keys: Sequence[float], spacing: Spacing) -> Sheet:
    """Return how panels stand side by side; panels that are too wide are broken."""
    panels = [panel for group in groups for panel in group]
    cells = [line for panel in panels for cell in panel.cells.values() for line in cell_lines(cell)]
    least = LETTER_INCHES * max(map(len, cells), default=1) + spacing.pad
    wide = max(len(panel.columns) for panel in panels)
    label = max(USUAL.label, min(spacing.label, WIDTH - MARGIN - spacing.gap - wide * least))
    rows = [line for panel in panels for row in panel.rows for line in broken(row, label).split("\n")]
    left = LETTER_INCHES * max(map(len, rows))
    most = max(int((WIDTH - left - MARGIN - spacing.gap) / least), 1)
    folded = tuple([part for panel in group for part in _parts(panel, most)] for group in groups)
    names = {panel.columns for group in folded for panel in group}
    wide = max(map(len, names))
    fitting = int((WIDTH - left - MARGIN) / (max(wide * least, spacing.panel) + spacing.gap))
    columns = max(min(max(map(len, folded)), fitting, spacing.columns), 1)
    inches = min(max(wide * CELL, 2.2), (WIDTH - left - MARGIN) / columns - spacing.gap)
    turned = LETTER_INCHES * max(len(name) for row in names for name in row) > inches / wide - 2 * spacing.pad
    width = max(left + MARGIN + columns * (inches + spacing.gap), *keys, LEAST_WIDTH)
    return Sheet(folded, columns, left, label, inches, 0.0, turned, turned and len(names) == 1,
                 (min(WIDTH, width), 0.0))  # fmt: skip


def _usual(sheet: Sheet, keys: int) -> Sheet:
    """Return the sheet with the usual heights."""
    lines, row = sum(sheet.lines), _row_inches(sheet)
    bar = 0.0 if all(panel.of_claims for panel in sheet.panels) else BAR_HIGH
    below = 0.0 if sheet.once else _below(sheet)
    line = _rows(sheet) * row + TITLE_HIGH + below + bar
    return replace(sheet, row=row, size=(sheet.size[0], lines * line + _around(sheet, keys)))


def _tight(sheet: Sheet, keys: int) -> Sheet:
    """Return the sheet with rows as low as text allows, up to the usual, so that it is a page high if it can."""
    once = len({panel.columns for panel in sheet.panels}) == 1
    lines = sum(sheet.lines)
    bars = sum((1 if sheet.shared else down) * (not all(panel.of_claims for panel in group))
               for group, down in zip(sheet.groups, sheet.lines, strict=True))  # fmt: skip
    titles = max(wrapped(panel.title, sheet.title_inches, 8).count("\n") + 1 for panel in sheet.panels)
    around = lines * (TIGHT_TITLE + LINE * titles) + (1 if once else lines) * _below(sheet) + bars * BAR_HIGH
    around += _around(sheet, keys)
    text = max(len(cell_lines(cell)) for panel in sheet.panels for cell in panel.cells.values())
    least = LINE * max(text, _label_lines(sheet)) + 0.02
    rows = lines * _rows(sheet)
    row = max(least, min(_row_inches(sheet), (PAGE - around) / rows))
    return replace(sheet, row=row, once=once, size=(sheet.size[0], rows * row + around))


def _row_inches(sheet: Sheet) -> float:
    """Return the usual height of a row."""
    high = CLAIM_HIGH if all(panel.of_claims for panel in sheet.panels) else NUMBER_HIGH
    return max(high, LINE * _label_lines(sheet) + 0.06)


def _rows(sheet: Sheet) -> int:
    """Return the most rows of a panel."""
    return max(len(panel.rows) for panel in sheet.panels)


def _label_lines(sheet: Sheet) -> int:
    """Return the most lines of the label of a row."""
    return max(broken(row, sheet.label).count("\n") + 1 for panel in sheet.panels for row in panel.rows)


def _below(sheet: Sheet) -> float:
    """Return the height of the labels of columns."""
    longest = max(len(column) for panel in sheet.panels for column in panel.columns)
    return LETTER_INCHES * longest if sheet.turned else LINE


def _around(sheet: Sheet, keys: int) -> float:
    """Return the height of what stands above and below all panels."""
    return AROUND + (CLAIMS_BAR if any(panel.of_claims for panel in sheet.panels) else 0.0) + KEY_HIGH * keys


def broken(row: str, inches: float) -> str:
    """Break the label of a row into lines that leave room for the cells."""
    return wrapped(row, inches, 8)


def cell_lines(cell: ClaimCell | Number) -> list[str]:
    """Return the lines of a cell's text."""
    return [cell.text(), *(filter(None, notes(cell).split("\n")) if isinstance(cell, Number) else ())]


def notes(number: Number) -> str:
    """Say, as a cell's further lines, the replicates' lowest and highest value if they differ, and the mark's words."""
    spread = ""
    if number.lowest is not None and number.highest is not None and number.lowest != number.highest:
        spread = f"{in_digits(number.lowest)}-{in_digits(number.highest)}"
    return "\n".join(filter(None, (spread, SHORT.get(number.mark, number.mark))))


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
               if start <= column < start + share}, panel.subject)
        for place, start in enumerate(starts, 1)
    ]  # fmt: skip
