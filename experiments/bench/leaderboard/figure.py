"""A ranking as a picture: a row for each model, a panel for each kind of measure, dots with 95 % intervals."""

from __future__ import annotations

import matplotlib as mpl
from matplotlib.figure import Figure

from experiments.bench.engine.terminal import count
from experiments.bench.figures.palette import colours
from experiments.bench.figures.plotting import PAGE, STYLE, TYPE, WIDTH, headline, rows_inches, scoreboard
from experiments.bench.leaderboard.kinds import Ranking

ACROSS = 3
"""Panels side by side, of more than `MOST_IN_A_ROW`: where they fit on a page so."""
MOST_IN_A_ROW = 4
AROUND, LEAST_AROUND = 1.75, 1.2
"""Height of what stands above and below the rows of a panel, inches; and of a figure of a page's height."""


def draw(ranking: Ranking, repeats: int) -> Figure:
    """Draw the standings, the first on top; ``repeats`` is the number of trials of each condition."""
    standings, panels = ranking.standings, ranking.kind.panels
    high, around = rows_inches(len(standings)), AROUND
    across = len(panels) if len(panels) <= MOST_IN_A_ROW else ACROSS
    if -(-len(panels) // across) * (around + high) > PAGE:
        across, around = MOST_IN_A_ROW, LEAST_AROUND
    bands = [panels[first : first + across] for first in range(0, len(panels), across)]
    high = rows_inches(len(standings), PAGE / len(bands) - around)
    with mpl.rc_context(STYLE):
        drawn = Figure(figsize=(WIDTH, (around + high) * len(bands)), layout="constrained")
        parts = drawn.subfigures(len(bands), 1, squeeze=False)[:, 0] if len(bands) > 1 else [drawn]
        for part, band in zip(parts, bands, strict=True):
            axes = part.subplots(1, across, sharey=True)
            for empty in axes[len(band) :]:
                empty.set_visible(False)
            scoreboard(axes[: len(band)], band, standings, colours(standing.name for standing in standings), high)
        title = "leaderboard" if ranking.kind.name == "direction" else f"leaderboard, {ranking.kind.name}"
        what = f"{count(repeats, 'trial')} of each condition; {ranking.kind.drawn}; dotted: chance"
        headline(drawn, f"{title}, the best on top; {what}", TYPE)
    return drawn
