"""Scores of models with their intervals, as a figure and on the terminal: a row for each model, the best on top."""

import math
from collections.abc import Mapping, Sequence
from string import ascii_lowercase
from typing import Any

import polars as pl
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, MaxNLocator

from experiments.base import console, palette
from experiments.draw import style
from experiments.judge.tests import Score

ENDS = {"": float, "_low": float, "_high": float, "_n": int}
"""What is added to a measure's name -> type of the column."""
PRINTED = 3
"""Measures in one table."""
ACROSS, ROW, AROUND = 4, 0.17, 0.75
"""Panels side by side, and the heights of a row and of what is around a panel's rows, inches."""


def tabulate(scores: Mapping[str, Mapping[str, Sequence[float | None] | None]]) -> pl.DataFrame:
    """Return scores with a row for each model, and the columns ``NAME``, ``NAME_low``, ``NAME_high`` and ``NAME_n``.

    ``scores`` has of each model each measure's value, ends of its interval and n; ``None`` where it does not apply.
    """
    kinds = {f"{name}{end}": kind for found in scores.values() for name in found for end, kind in ENDS.items()}
    rows = [(model, *(value for of in found.values() for value in of or [None] * len(ENDS)))
            for model, found in scores.items()]  # fmt: skip
    return pl.DataFrame(rows, {"model": str, **kinds}, orient="row")


def draw(table: pl.DataFrame, labels: Mapping[str, str], chance: Mapping[str, float], title: str, note: str) -> Figure:
    """Draw scores as dots with intervals, a panel for each measure that any model has.

    Parameters
    ----------
    table
        As of `show`, with the columns ``NAME_n`` too.
    labels
        Measure -> its words; the axes of those that say so are logarithmic, and of those without a unit end at 1.
    chance
        Beginning of a measure -> what guessing gets.
    title, note
        The finding, and what the intervals are.
    """
    measured = [name for name in labels if name in table.columns]
    known = [name for name in measured if table[name].count()] or measured[:1]
    across = min(ACROSS, len(known))
    down = math.ceil(len(known) / across)
    height = min(ROW * table.height + AROUND, (style.PAGE - 1.0) / down)
    numbers = []
    with style.look():
        figure = Figure((style.WIDTH, height * down + 0.8), layout="constrained")
        panels = style.grid(figure, len(known), across, sharey=True)
        for axes, name, letter in zip(panels, known, ascii_lowercase, strict=False):
            rows = table.with_row_index("row").drop_nulls(name)
            style.intervals(axes, rows, rows["row"].to_numpy(), (name, f"{name}_low", f"{name}_high"), ms=3.5,
                            color=palette.INK, elinewidth=1.2, zorder=2, clip_on=False)  # fmt: skip
            axes.set_title(style.wrapped(f"{letter}  {labels[name]}", style.WIDTH / across - 0.4))
            if "logarithmic" in labels[name]:
                axes.set_xscale("log")
                low, high = axes.dataLim.intervalx
                ticks = [at for at in LogLocator(subs=(1.0, 2.0, 5.0)).tick_values(low, high) if low <= at <= high]
                style.plain_numbers(axes, ticks[:: math.ceil(len(ticks) / 4)] if len(ticks) > 1 else (low, high))
            else:
                axes.set_xlim(min(axes.dataLim.x0, 0.0), None if "(" in labels[name] else 1.0)
                axes.xaxis.set_major_locator(MaxNLocator(4, steps=[1, 2, 5, 10]))
            for level in (guess for start, guess in chance.items() if name.startswith(start)):
                axes.axvline(level, color=palette.GREY, ls=":", lw=0.8, zorder=1)
            axes.grid(axis="y", lw=0.3)
            ends = dict.fromkeys((rows[f"{name}_n"].min(), rows[f"{name}_n"].max()))
            numbers.append(f"{letter}={' to '.join(map(str, ends))}")
        panels[0].set_yticks(range(table.height), table["model"])
        panels[0].set_ylim(table.height - 0.5, -0.5)
        style.headline(figure, title)
        style.caption(figure, note, "Blank: does not apply, or silent. Dotted: chance.", f"n: {', '.join(numbers)}.")
    return figure


def show(table: pl.DataFrame, measures: Sequence[str], title: str) -> None:
    """Print scores with their intervals.

    Parameters
    ----------
    table
        A row for each model; for each measure the columns ``NAME``, ``NAME_low`` and ``NAME_high``.
    measures
        Their names.
    title
        Of the first table.
    """
    for first in range(0, len(measures), PRINTED):
        part = measures[first : first + PRINTED]
        rows = [{"model": row["model"], **{name: _score(row, name) for name in part}} for row in table.to_dicts()]
        console.show(pl.DataFrame(rows), title if not first else "")


def _score(row: Mapping[str, Any], name: str) -> str:
    value, low, high = (math.nan if row[key] is None else row[key] for key in (name, f"{name}_low", f"{name}_high"))
    return "" if math.isnan(value) else str(Score(value, low, high, 0))
