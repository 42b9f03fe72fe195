"""Scores of models with their intervals, as a figure and on the terminal: a row for each model, the best on top."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import polars as pl
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from experiments.bench.report import style, terminal
from experiments.bench.stats.tests import Score

ACROSS, ROW, AROUND = 4, 0.26, 1.1
"""Panels side by side, and the heights of a row and of what is around a panel's rows, inches."""
PRINTED = 3
"""Measures in one table on the terminal."""
Panels = Mapping[str, Sequence[str]]
"""Quantity -> its measures, by the names of their columns; those of times in us are on a logarithmic axis."""


def draw(table: pl.DataFrame, panels: Panels, chance: Mapping[str, float], title: str, caption: str) -> Figure:
    """Draw scores as dots with intervals, a panel for each quantity.

    Parameters
    ----------
    table
        A row for each model; for each measure the columns ``NAME``, ``NAME_low`` and ``NAME_high``.
    panels
        The measures of each panel.
    chance
        Beginning of a measure -> what guessing gets.
    title, caption
        The finding, and what the symbols mean.
    """
    down = math.ceil(len(panels) / ACROSS)
    height = min(ROW * table.height + AROUND, (style.PAGE - 1.0) / down)
    with style.look():
        figure = Figure((style.WIDTH, height * down + 0.8), layout="constrained")
        panel = style.grid(figure, len(panels), ACROSS, sharey=True)
        for axes, (quantity, measures) in zip(panel, panels.items(), strict=True):
            _panel(axes, table, measures)
            axes.set_title(style.wrapped(quantity, style.WIDTH / ACROSS - 0.4))
            for level in {guess for start, guess in chance.items() if measures[0].startswith(start)}:
                axes.axvline(level, color=style.GREY, ls=":", lw=0.8, zorder=1)
        panel[0].set_yticks(range(table.height), table["model"])
        panel[0].set_ylim(table.height - 0.5, -0.5)
        style.headline(figure, title)
        style.caption(figure, f"{caption} Dotted: chance.")
    return figure


def _panel(axes: Axes, table: pl.DataFrame, measures: Sequence[str]) -> None:
    """Draw the measures of one quantity, each a little below the last."""
    for place, name in enumerate(measures):
        known = table.with_row_index("row").drop_nulls(name)
        rows = known["row"].to_numpy() + 0.25 * (place - (len(measures) - 1) / 2)
        style.intervals(axes, known, rows, (name, f"{name}_low", f"{name}_high"), ms=3.5, color=style.HUES[place],
                        elinewidth=1.2, label=name)  # fmt: skip
    if measures[0].startswith("us_"):
        axes.set_xscale("log")
        axes.xaxis.set_major_formatter("{x:g}")
    else:
        axes.set_xlim(left=0.0)
        axes.xaxis.set_major_locator(MaxNLocator(4, steps=[1, 2, 5, 10]))
    axes.grid(axis="y", lw=0.3)
    axes.legend(fontsize=style.SMALL, frameon=False, loc="upper center", bbox_to_anchor=(0.5, -0.1), handletextpad=0.1)


def show(table: pl.DataFrame, panels: Panels, title: str) -> None:
    """Print scores with their intervals: ``table`` and ``panels`` as of `draw`."""
    names = [name for measures in panels.values() for name in measures]
    for first in range(0, len(names), PRINTED):
        part = names[first : first + PRINTED]
        rows = [{"model": row["model"], **{name: _score(row, name) for name in part}} for row in table.to_dicts()]
        terminal.show(pl.DataFrame(rows), title if not first else "")


def _score(row: Mapping[str, Any], name: str) -> str:
    value, low, high = (math.nan if row[key] is None else row[key] for key in (name, f"{name}_low", f"{name}_high"))
    return "" if math.isnan(value) else str(Score(value, low, high, 0))
