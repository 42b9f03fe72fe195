"""The leaderboard as a picture: a row for each model, a panel for each kind of measure, dots with 95 % intervals."""

from __future__ import annotations

from collections.abc import Sequence

import matplotlib as mpl
from matplotlib.figure import Figure

from experiments.bench.core.figures.palette import colours
from experiments.bench.core.figures.plotting import INCHES_A_ROW, STYLE, Panel, scoreboard
from experiments.bench.core.scores import Standing

_SHOWN = ("robot", "clips")
PANELS = (
    Panel("direction accuracy", ("direction_robot", "direction_clips"), _SHOWN, 0.25, share=True),
    Panel("AUC, translation\nagainst depth", ("auc_robot", "auc_clips"), _SHOWN, 0.5, share=True),
    Panel("false alarms,\nbackground alone", ("false_alarms",), _SHOWN[1:], share=True, filled=False),
    Panel("µs per frame", ("us_99x72", "us_320x180"), ("99x72", "320x180"), log=True),
)


def draw(standings: Sequence[Standing], repeats: int) -> Figure:
    """Draw the standings, the first on top; ``repeats`` is the number of trials of each condition."""
    with mpl.rc_context(STYLE):
        drawn = Figure(figsize=(9.6, 1.75 + INCHES_A_ROW * len(standings)), layout="constrained")
        axes = drawn.subplots(1, len(PANELS), sharey=True)
        scoreboard(axes, PANELS, standings, colours(standing.name for standing in standings))
        said = f"leaderboard, n = {repeats} of each trial; 95 % intervals; dotted: chance"
        drawn.suptitle(said, fontsize=9, x=0.01, ha="left")
    return drawn
