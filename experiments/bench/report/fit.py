"""Fits as figures and on the terminal: where in the box the goal is reached, what it turns on, the best judged anew."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
import polars as pl
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from experiments.bench.report import style
from experiments.bench.report.sweep import DEFAULT, SCALE, SHADES, show_rows
from experiments.bench.report.terminal import show_line, show_places

PAIRS = 3
"""Pairs of parameters that are drawn: of those on which the goal turns most."""
SHOWN = 5
"""Settings judged anew that are printed; ``anew.csv`` has all."""


def draw(fitted: Any) -> Figure:
    """Draw a fit.

    Parameters
    ----------
    fitted
        The result, an `experiments.Fitted`.

    Returns
    -------
    matplotlib.figure.Figure
        Above, the settings by pairs of parameters, or the goal over a single one; the better, the darker. Below, how
        much each claim or measure turns on each parameter, and the goal of the best settings in the search and anew.
    """
    shares = fitted.importance[""]
    ranges = sorted(fitted.box, key=lambda part: -shares[part.key])[:PAIRS]
    pairs: list[tuple[Any, Any]] = [*itertools.combinations(ranges, 2)] or [(ranges[0], None)]
    with style.look():
        figure = Figure((style.WIDTH, 5.2 + 0.2 * len(fitted.names)), layout="constrained")
        above, below = figure.subfigures(2, 1, squeeze=False, height_ratios=(2.6, 2.2 + 0.2 * len(fitted.names)))[:, 0]
        for panel, pair in zip(above.subplots(1, len(pairs), squeeze=False)[0], pairs, strict=True):
            _settings(panel, fitted, *pair)
        turns, anew = below.subplots(1, 2)
        _turns(turns, fitted)
        _anew(anew, fitted)
        style.headline(figure, fitted.sentences()[1 if fitted.fit.of_claims else 0])
        style.caption(
            figure,
            f"{fitted.fit.study.name}: {len(fitted.settings)} settings searched (dots), {len(fitted.even)} that fill"
            f" the box evenly (squares), the winner (star); anew: {fitted.fit.held_out} replicates that the search"
            " never saw, with the 95 % interval where there is one",
        )
    return figure


def _places(part: Any, settings: Sequence[Any]) -> list[float]:
    texts = [setting[part.key] for setting in settings]
    return [float(part.choices.index(text)) if part.choices else float(text) for text in texts]


def _settings(panel: Axes, fitted: Any, one: Any, other: Any) -> None:
    """Draw search, sample and winner over two parameters, or the goal over one."""
    sign = next(iter(fitted.fit.goals.values()))
    searched, even = fitted.goal(fitted.searched), fitted.goal(fitted.sample)
    ranks = np.argsort(np.argsort(sign * np.nan_to_num([*searched, *even], nan=-np.inf * sign)))
    colours = mpl.colormaps[SHADES](0.15 + 0.8 * ranks / max(len(ranks) - 1, 1))
    start = len(searched)
    for settings, values, shade, marker in (
        (fitted.settings, searched, colours[:start], "o"), (fitted.even, even, colours[start:], "s"),
    ):  # fmt: skip
        heights = values if other is None else _places(other, settings)
        panel.scatter(_places(one, settings), heights, s=12, c=shade, marker=marker, linewidths=0)
    winner = [fitted.winner]
    height = [searched[fitted.best[0]]] if other is None else _places(other, winner)
    panel.plot(_places(one, winner), height, "*", color=DEFAULT, ms=10, mec="white", zorder=4)
    panel.set_xlabel(_label(one))
    panel.set_ylabel(next(iter(fitted.fit.goals)) if other is None else _label(other))
    for part, axis, scale in ((one, panel.xaxis, panel.set_xscale), (other, panel.yaxis, panel.set_yscale)):
        if part is not None and part.choices:
            axis.set_ticks(range(len(part.choices)), part.choices)
        elif part is not None and part.log:
            scale("log")
            style.plain_numbers(panel, "x" if part is one else "y")


def _label(part: Any) -> str:
    name = "+".join(dict.fromkeys(key.partition(".")[2] for key in part.key.split("+")))
    return f"{name}{f' ({part.unit})' if part.unit else ''}"


def _turns(panel: Axes, fitted: Any) -> None:
    rows = {name or "all": shares for name, shares in fitted.importance.items() if name or len(fitted.names) > 1}
    shares = np.array([[row[part.key] for part in fitted.box] for row in rows.values()])
    panel.imshow(shares, cmap=SCALE, vmin=0.0, vmax=1.15, aspect="auto")
    for (down, across), share in np.ndenumerate(shares):
        panel.text(across, down, f"{share:.2f}", ha="center", va="center", fontsize=style.SMALL,
                   path_effects=style.HALO)  # fmt: skip
    panel.set_xticks(range(len(fitted.box)), list(map(_label, fitted.box)), rotation=20, ha="right")
    panel.set_yticks(range(len(rows)), list(rows))
    panel.set_title("what each turns on, as a share")


def _anew(panel: Axes, fitted: Any) -> None:
    """Draw the first goal of the best settings in the search and anew, or the replicates in which all is kept."""
    table = fitted.judged_anew()
    name = "claim" if fitted.fit.of_claims else "goal"
    rows = table.filter(pl.col(name) == table[name][0]).to_dicts()
    for place, row in enumerate(reversed(rows)):
        value = row["kept"] / max(row["replicates"], 1) if fitted.fit.of_claims else row["anew"]
        if row["low"] is not None:
            panel.plot((row["low"], row["high"]), (place, place), color=style.INK, lw=1.2)
        if value is not None and not (fitted.fit.of_claims and row["low"] is None):  # judged in no replicate
            panel.plot(value, place, "o", color=style.INK, ms=4)
        if not fitted.fit.of_claims and row["in the search"] is not None:
            panel.plot(row["in the search"], place, "|", color=DEFAULT, ms=9, mew=1.6)
    names = ["as it is" if row["number"] is None else f"no. {row['number']}" for row in reversed(rows)]
    panel.set_yticks(range(len(rows)), names)
    if fitted.fit.of_claims:
        panel.set(xlim=(-0.02, 1.02), xlabel="share of replicates", title="anew: all claims kept")
    else:
        panel.set(xlabel=rows[0]["goal"], title="anew; bar: in the search")


def show(fitted: Any, folder: Path) -> None:
    """Print the answer, the settings judged anew, and where everything is."""
    for line in fitted.sentences():
        show_line(line, 4)
    table = fitted.judged_anew()
    numbers = table["number"].unique(maintain_order=True).to_list()
    best = pl.col("number").is_in(numbers[:SHOWN]) | pl.col("number").is_null()
    title = f"judged anew in {fitted.fit.held_out} replicates, the first {SHOWN} (anew.csv has all)"
    show_rows(title, table.filter(best).to_dicts())
    show_places({"figure": folder / "fit.png", "settings": folder / "fit.csv", "anew": folder / "anew.csv"})
