"""Panels of peaks: blocks with a panel for each model, or, where they would be taller than a page, a row for each."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.figure import Figure, SubFigure
from matplotlib.layout_engine import LayoutEngine

from experiments.bench.figures.plotting import (
    LINE,
    PAGE,
    WIDTH,
    grid_of_panels,
    leftmost,
    lowest,
    plain,
    wrapped,
)

ACROSS, HIGH = 3, 2.2
"""Most panels of a block side by side, and the height of one with its title, inches."""
TITLE_INCHES = 2.0
"""Width of the title of one of `ACROSS` panels."""
ROW_ACROSS, TWO_ACROSS = 6, 4
"""Most panels side by side where each model has a row, and where two models are in one."""
NAME_INCHES, NUMBERS_INCHES = 1.3, 0.4
"""Widths of the names of models left of their rows, and of the numbers of an axis."""
GAP = 0.1
"""Room between panels side by side, inches."""
LEAST_ROW, MOST_ROW = 0.34, 1.1
"""Heights of a row, inches."""
AROUND_ROWS = 2.1
"""Height of what stands above and below the rows: title, headings, the numbers of the axes and the key; inches."""
PADS = {"h_pad": 0.015, "hspace": 0.0}
"""Room between rows, inches and as a share of a panel."""
SHARE_IN_ROWS = 0.45
"""Size of dots in rows, and of what a curve is drawn wider by, as shares of those in blocks."""
QUANTITY = "largest |potential|"
STEPS = (1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0)
"""First digits of the number at the axis of a row."""
HIGHEST_NUMBER = 0.85
"""Highest place of that number, as a share of the axis: it stays clear of the 0 of the row above."""


@dataclass(frozen=True, slots=True)
class ModelPanels:
    """The panels of a figure.

    Parameters
    ----------
    blocks
        A panel for each model, of each block.
    in_rows
        Whether each model has a row, with a panel of each block.
    """

    blocks: list[list[Axes]]
    in_rows: bool

    @property
    def dots(self) -> float:
        """Size of dots, as a share of their usual one."""
        return SHARE_IN_ROWS if self.in_rows else 1.0

    def from_zero(self, blocks: Sequence[Sequence[Axes]]) -> None:
        """Give ``blocks``, when all is drawn, scales from 0 up by which models are compared: in rows one for all."""
        for together in [[axes for block in blocks for axes in block]] if self.in_rows else blocks:
            top = max((axes.get_ylim()[1] for axes in together), default=1.0)
            for axes in together:
                axes.set_ylim(0.0, top)
                if self.in_rows:
                    axes.set_yticks([0.0, number := _number_below(HIGHEST_NUMBER * top)], ["0", f"{number:g}"])
        if self.in_rows:
            self._share_numbers(blocks)

    def _share_numbers(self, blocks: Sequence[Sequence[Axes]]) -> None:
        """Write the numbers of panels side by side, which have one scale, at the first alone."""
        first = {_column(axes) for axes in blocks[0]} if blocks else set()
        for axes in (axes for block in blocks for axes in block):
            axes.tick_params(labelleft=_column(axes) in first)


def in_rows(models: int, blocks: int, around: float) -> bool:
    """Tell whether ``blocks`` with a panel for each model, and what is ``around`` them, are taller than a page."""
    return blocks * HIGH * -(-models // ACROSS) + around > PAGE


def blocks_inches(models: int, blocks: int) -> float:
    """Return the height of ``blocks`` with a panel for each of so many models."""
    return blocks * HIGH * -(-models // ACROSS)


def rows_inches(models: Sequence[str], blocks: int, around: float) -> float:
    """Return the height of rows of ``models`` that fit on a page with what is ``around`` them, if they can."""
    lines = max(len(_name(model).split("\n")) for model in models)
    down = -(-len(models) // _sets(blocks)) * _bands(blocks)
    return down * max(LEAST_ROW, lines * LINE + 0.04, min(MOST_ROW, (PAGE - around) / down))


def in_blocks(
    part: Figure | SubFigure, models: Sequence[str], titles: Sequence[str], along: Sequence[str]
) -> ModelPanels:
    """Return panels that are called by their model, and by the title of their block where it has one.

    Parameters
    ----------
    part
        A figure, or a part of one.
    models
        The panels of a block.
    titles, along
        Of each block: what is in it, and the quantity along its axis.
    """
    panels = grid_of_panels(part, len(titles), len(models), ACROSS, sharex=True)
    for title, block in zip(titles, panels, strict=True):
        for axes, model in zip(block, models, strict=True):
            axes.set_title(plain(wrapped(f"{model}, {title}" if title else model, TITLE_INCHES, 8)), fontsize=8)
    for axes in lowest(panels):
        axes.set_xlabel(along[-1], fontsize=8)
    for axes in leftmost(panels):
        axes.set_ylabel(QUANTITY, fontsize=8)
    return ModelPanels(panels, in_rows=False)


def of_rows(
    part: Figure | SubFigure, models: Sequence[str], titles: Sequence[str], along: Sequence[str]
) -> ModelPanels:
    """Return panels in rows that are called by their model, in columns that are called by the title of their block.

    Models stand beside each other where there is room for two. Numbers are at the lowest panel of each column.
    ``part``, ``models``, ``titles`` and ``along`` are those of `in_blocks`.
    """
    _layout_engine(part).set(**PADS)
    sets, bands = _sets(len(titles)), _bands(len(titles))
    across, down = -(-len(titles) // bands), -(-len(models) // sets)
    places = part.subplots(bands * down, sets * across, squeeze=False, sharex="col")
    inches = (WIDTH - sets * (NAME_INCHES + NUMBERS_INCHES)) / (sets * across) - GAP
    blocks = [
        [places[block // across * down + row % down, row // down * across + block % across]
         for row in range(len(models))]
        for block in range(len(titles))
    ]  # fmt: skip
    for title, block in zip(titles, blocks, strict=True):
        for axes in block[::down]:
            axes.set_title(plain(wrapped(title, inches, 8)), fontsize=8)
    for block in blocks[::across]:
        for axes, model in zip(block, models, strict=True):
            axes.set_ylabel(_name(model), rotation=0, ha="right", va="center", fontsize=8)
    _clear(places, {axes for block in blocks for axes in block})
    for place, axes in enumerate(places[-1]):
        axes.set_xlabel(_quantity(along[place % across], inches), fontsize=8)
    part.supylabel(QUANTITY, fontsize=8)
    return ModelPanels(blocks, in_rows=True)


def _sets(blocks: int) -> int:
    """Return how many models stand beside each other, each with a panel of so many blocks."""
    return 2 if 2 * blocks <= TWO_ACROSS else 1


def _bands(blocks: int) -> int:
    """Return how many rows of panels a model has, one below the other models' rows."""
    return -(-blocks // ROW_ACROSS)


def _quantity(label: str, inches: float) -> str:
    """Break the label of an axis into lines; its unit, in parentheses, stays whole."""
    name, mark, unit = label.partition(" (")
    return label if wrapped(label, inches, 8) == label else f"{wrapped(name, inches, 8)}\n{mark.strip()}{unit}"


def _name(model: str) -> str:
    return plain(wrapped(model, NAME_INCHES, 8))


def _column(axes: Axes) -> int:
    spec = axes.get_subplotspec()
    assert spec is not None
    return int(spec.colspan.start)


def _layout_engine(part: Figure | SubFigure) -> LayoutEngine:
    whole = part.figure if isinstance(part, SubFigure) else part
    engine = whole.get_layout_engine()
    assert engine is not None
    return engine


def _clear(places: npt.NDArray[Any], drawn: set[Axes]) -> None:
    """Leave of the places without a panel nothing, and of those at the foot of a column its numbers."""
    for axes in places.flat:
        if axes not in drawn:
            axes.yaxis.set_visible(False)
            axes.spines[:].set_visible(False)
            axes.patch.set_visible(False)
            if axes not in places[-1]:
                axes.set_visible(False)


def _number_below(most: float) -> float:
    """Return the largest round number up to ``most``, above 0."""
    decade = 10.0 ** math.floor(math.log10(most))
    return decade * max(step for step in STEPS if step * decade <= most * (1.0 + 1e-9))
