"""Fits as figures and on the terminal: where in the box the goal is reached, what it turns on, the best judged anew."""

from __future__ import annotations

import itertools
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from experiments.bench.report import style, terminal
from experiments.bench.report.sweep import DEFAULT

PAIRS = 3
"""Pairs of parameters that are drawn: of those on which the goal turns most."""
SHOWN = 5
"""Settings judged anew that are printed; ``anew.csv`` has all."""


def draw(fitted: Any) -> Figure:
    """Draw a fit, an `experiments.Fitted`.

    Above, the settings by pairs of parameters, or the goal over a single one; the better, the darker. Below, how much
    each claim or measure turns on each parameter, and the goal of the best settings in the search and anew.
    """
    plan, anew = fitted.plan, fitted.anew
    first = next(iter(fitted.importance.values()))
    ranges = sorted(plan.box, key=lambda part: -first[part.key])[:PAIRS]
    pairs: list[tuple[Any, Any]] = [*itertools.combinations(ranges, 2)] or [(ranges[0], None)]
    claims = plan.fit.of_claims
    goal = ("kept" if "kept" in plan.fit.goals else "least slack") if claims else next(iter(plan.fit.goals))
    rows = anew.filter(pl.col("claim" if claims else "goal") == anew["claim" if claims else "goal"][0])
    row = rows.row(0, named=True)
    if claims:
        what = "All claims are" if "all" in anew["claim"] else f"{row['claim']} is"
        title = f"{what} kept in {row['kept']} of {row['replicates']} fresh replicates at the best setting"
    else:
        value = "no value" if row["anew"] is None else f"{row['anew']:.3g}"
        title = f"{goal} is {value} at the best setting in {row['replicates']} fresh replicates"
    with style.look():
        height = 2.2 + 0.2 * len(fitted.importance)
        figure = Figure((style.WIDTH, 3.0 + height), layout="constrained")
        above, below = figure.subfigures(2, 1, squeeze=False, height_ratios=(2.6, height))[:, 0]
        for panel, pair in zip(above.subplots(1, len(pairs), squeeze=False)[0], pairs, strict=True):
            _settings(panel, fitted.settings, goal, plan.fit.goals.get(goal, 1), row["number"], *pair)
        turns, again = below.subplots(1, 2)
        _turns(turns, fitted)
        _anew(again, rows, claims)
        style.headline(figure, title)
        symbols = f"Dots: settings searched; squares: {plan.fit.sample} that fill the box evenly; the darker the better"
        shares = f"Shares: how much of {goal} a parameter decides (PED-ANOVA)"
        notes = f"{symbols}; star: the winner, of the search. {shares}. Whiskers: 95 % interval."
        if fitted.share is not None:
            low, high = fitted.share.interval or (0.0, 1.0)
            notes += (
                f" {fitted.share} squares keep every claim: {low:.0%} to {high:.0%} of the box; slack 0: just kept."
            )
        style.caption(figure, notes)
    return figure


def _settings(panel: Axes, settings: pl.DataFrame, goal: str, sign: int, winner: int, one: Any, other: Any) -> None:
    """Draw search, sample and winner over two parameters, or the goal over one."""

    def places(part: Any) -> Any:
        if part is None:
            return settings[goal]
        texts = settings[part.key]
        return texts.replace_strict(part.choices, range(len(part.choices))) if part.choices else texts.cast(float)

    ranks = (settings[goal].fill_nan(None) * sign).rank("ordinal").fill_null(0)
    x, y, searched = places(one), places(other), settings["of"] == "search"
    for own, marker in ((searched, "o"), (~searched, "s")):
        panel.scatter(x.filter(own), y.filter(own), s=12, c=ranks.filter(own), marker=marker, linewidths=0,
                      cmap="Blues", vmin=-0.2 * len(ranks), vmax=len(ranks))  # fmt: skip
    panel.plot(x[winner], y[winner], "*", color=DEFAULT, ms=10, mec="white", zorder=4)
    if other is None and goal == "least slack":
        panel.axhline(0.0, color=style.GREY, ls="--", lw=0.8, zorder=1)
    panel.set_xlabel(style.wrapped(one.title, 2.0))
    panel.set_ylabel(goal if other is None else style.wrapped(other.title, 1.8))
    for part, axis, scale in ((one, panel.xaxis, panel.set_xscale), (other, panel.yaxis, panel.set_yscale)):
        if part is not None and part.choices:
            axis.set_ticks(range(len(part.choices)), part.choices)
        elif part is not None and part.whole and not part.log:
            axis.set_major_locator(MaxNLocator(integer=True))
        elif part is not None and part.log:
            scale("log")
            style.plain_numbers(panel, "x" if part is one else "y")


def _turns(panel: Axes, fitted: Any) -> None:
    shares = np.array([[row[part.key] for part in fitted.plan.box] for row in fitted.importance.values()])
    panel.imshow(shares, cmap="Greys", vmin=0.0, vmax=1.6, aspect="auto")
    for (down, across), share in np.ndenumerate(shares):
        panel.text(across, down, f"{share:.2f}", ha="center", va="center", fontsize=style.SMALL)
    panel.set_xticks(
        range(len(fitted.plan.box)),
        [style.wrapped(part.title, 1.0) for part in fitted.plan.box],
        rotation=20,
        ha="right",
    )
    panel.set_yticks(range(len(shares)), list(fitted.importance))
    panel.set_title("share that a parameter decides")


def _anew(panel: Axes, rows: pl.DataFrame, claims: bool) -> None:
    """Draw the goal of the best settings in the search and anew, or the replicates in which all is kept."""
    rows = rows.reverse().with_row_index("place")
    value = pl.col("kept") / pl.col("replicates") if claims else pl.col("anew")
    known = rows.with_columns(value.alias("value")).drop_nulls(["value", *(["low"] if claims else [])])
    style.intervals(panel, known, known["place"], ("value", "low", "high"), ms=4, color=style.INK, elinewidth=1.2)
    names = ["as it is" if number is None else f"no. {number}" for number in rows["number"]]
    panel.set_yticks(range(len(names)), names)
    if claims:
        panel.set(xlim=(-0.02, 1.02), xlabel="share of replicates", title="judged anew: every claim kept")
    else:
        panel.plot(rows["in the search"], rows["place"], "|", color=DEFAULT, ms=9, mew=1.6)
        panel.set(xlabel=rows["goal"][0], title="judged anew; bar: in the search")


def show(fitted: Any, folder: Path) -> None:
    """Print the answer, the settings judged anew, and where everything is."""
    for line in fitted.sentences:
        terminal.show_line(line, 4)
    best = fitted.anew["number"].unique(maintain_order=True)[:SHOWN]
    shown = fitted.anew.filter(pl.col("number").is_in(best.implode()) | pl.col("number").is_null())
    terminal.show(shown, f"judged anew, the first {SHOWN} (anew.csv has all)")
    terminal.show_places({"figure": folder / "fit.png", "settings": folder / "fit.csv", "anew": folder / "anew.csv"})
