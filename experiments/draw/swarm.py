"""The figure of a scenario: a measure against the number of robots or their speed, a line a swarm."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import polars as pl
from matplotlib.figure import Figure

from experiments.base import palette
from experiments.draw import style

if TYPE_CHECKING:
    from matplotlib.axes import Axes

AXES = {"robots": "robots", "speed_cm_s": "speed (cm/s)"}


def draw(trials: pl.DataFrame, described: Mapping[str, Any]) -> Figure:
    """Draw means over repeats with their 95 % intervals, and the chance level as a dashed line.

    Parameters
    ----------
    trials
        Rows of ``trials.parquet``.
    described
        The contents of ``run.json``.
    """
    (column, heading), along = described["experiment"]["figure"], described["experiment"]["along"]
    with style.look():
        figure = Figure(figsize=(5.0, 3.4), layout="constrained")
        axes: Axes = figure.subplots()
        places = sorted(set(trials[along]))
        chance = sorted({(case[along == "speed_cm_s"], case[2]) for case in described["chance"] or ()})
        if chance:
            axes.plot(*zip(*chance, strict=True), color=palette.THRESHOLD, ls="--", lw=0.8, marker="_", label="chance")
        hues = palette.of_others(dict.fromkeys(trials["model"]))
        gap = 0.3 * min((b - a for a, b in pairwise(places)), default=1.0)
        for model, hue in hues.items():
            own = trials.filter(pl.col(column).is_not_null(), model=model)
            samples = [own.filter(pl.col(along) == place)[column].to_list() for place in places]
            style.means(axes, places, samples, hue, model, gap=gap)
        axes.set(xlabel=AXES[along], ylabel=heading, xticks=places)
        axes.set_ylim(bottom=0.0)
        style.headline(figure, described["experiment"]["name"])
        style.legend(figure, [axes])
        n = described["repeats"]
        style.caption(figure, f"{n} repeats, seed {described['seed']}; means with 95 % intervals"
                              f"{', dashed: chance' if chance else ''}.")  # fmt: skip
    return figure
