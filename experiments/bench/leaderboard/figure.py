"""A ranking as a picture: a row for each model, a panel for each kind of measure, dots with 95 % intervals."""

from __future__ import annotations

import matplotlib as mpl
from matplotlib.figure import Figure

from experiments.bench.figures.palette import colours
from experiments.bench.figures.plotting import INCHES_A_ROW, STYLE, scoreboard
from experiments.bench.leaderboard.kinds import Ranking

ACROSS = 4
"""Panels side by side."""


def draw(ranking: Ranking, repeats: int) -> Figure:
    """Draw the standings, the first on top; ``repeats`` is the number of trials of each condition."""
    standings, panels = ranking.standings, ranking.kind.panels
    bands = [panels[first : first + ACROSS] for first in range(0, len(panels), ACROSS)]
    with mpl.rc_context(STYLE):
        height = 1.75 + INCHES_A_ROW * len(standings)
        drawn = Figure(figsize=(9.6, height * len(bands)), layout="constrained")
        parts = drawn.subfigures(len(bands), 1, squeeze=False)[:, 0] if len(bands) > 1 else [drawn]
        for part, band in zip(parts, bands, strict=True):
            axes = part.subplots(1, ACROSS, sharey=True)
            scoreboard(axes, band, standings, colours(standing.name for standing in standings))
        title = "leaderboard" if ranking.kind.name == "direction" else f"leaderboard, {ranking.kind.name}"
        what = f"n = {repeats} of each trial; {ranking.kind.drawn}; dotted: chance"
        drawn.suptitle(f"{title}, {what}", fontsize=8, x=0.01, ha="left")
    return drawn
