"""The leaderboard as a picture: a row for each model, a panel for each kind of measure, dots with 95 % intervals."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import LogLocator, NullFormatter, StrMethodFormatter

from experiments.bench.figures import STYLE, plain
from experiments.bench.leaderboard_scores import Score, Standing
from experiments.bench.offline_figures import colours


@dataclass(frozen=True, slots=True)
class Panel:
    """Measures drawn together: the first filled, the second open; ``chance`` is what guessing gets."""

    title: str
    measures: tuple[str, ...]
    keys: tuple[str, ...]
    chance: float | None = None
    log: bool = False


PANELS = (
    Panel("direction accuracy", ("direction_robot", "direction_clips"), ("robot", "clips"), 0.25),
    Panel("AUC, translation\nagainst depth", ("auc_robot", "auc_clips"), ("robot", "clips"), 0.5),
    Panel("false alarms,\nbackground alone", ("false_alarms",), ("clips",)),
    Panel("µs per frame", ("us_99x72", "us_320x180"), ("99x72", "320x180"), log=True),
)
APART = 0.17
"""Of the dots of one row, from its middle."""
INCHES_A_ROW = 0.34
TICKS_INCHES = 0.22
"""Height of the numbers below an axis; the keys stand under them."""


def draw(standings: Sequence[Standing], repeats: int) -> Figure:
    """The standings, the first on top."""
    with mpl.rc_context(STYLE):
        drawn = Figure(figsize=(9.6, 1.75 + INCHES_A_ROW * len(standings)), layout="constrained")
        axes = drawn.subplots(1, len(PANELS), sharey=True)
        for place, panel in zip(axes, PANELS, strict=True):
            _panel(place, panel, standings)
        axes[0].set_yticks(range(len(standings)), [plain(standing.model) for standing in standings])
        axes[0].set_ylim(len(standings) - 0.5, -0.5)
        said = f"leaderboard, n = {repeats} of each trial; 95 % intervals; dotted: chance; -: does not apply"
        drawn.suptitle(said, fontsize=9, x=0.01, ha="left")
    return drawn


def _panel(axes: Axes, panel: Panel, standings: Sequence[Standing]) -> None:
    if panel.chance is not None:
        axes.axvline(panel.chance, color="black", ls=":", lw=0.8, zorder=1)
    for row in range(0, len(standings), 2):
        axes.axhspan(row - 0.5, row + 0.5, color="black", alpha=0.04, lw=0)
    tints = colours(standing.model for standing in standings)
    for row, standing in enumerate(standings):
        _row(axes, panel, row, standing, tints[standing.model])
    if panel.log:
        axes.set_xscale("log")
        axes.xaxis.set_major_locator(LogLocator(subs=(1.0, 3.0)))
        axes.xaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
        axes.xaxis.set_minor_formatter(NullFormatter())
    else:
        axes.set_xlim(-0.04, 1.04)
        axes.set_xticks([0, 0.25, 0.5, 0.75, 1], ["0", "¼", "½", "¾", "1"])
    axes.tick_params(axis="y", length=0)
    axes.set_title(panel.title, fontsize=9, loc="left")
    _legend(axes, panel, TICKS_INCHES / (INCHES_A_ROW * len(standings)))


def _row(axes: Axes, panel: Panel, row: int, standing: Standing, tint: str) -> None:
    found = [standing.scores[measure] for measure in panel.measures]
    if not any(found):
        axes.annotate("-", (0.5, row), xycoords=("axes fraction", "data"), ha="center", va="center", color="#777777",
                      fontsize=14)  # fmt: skip
    shifts = (-APART, APART) if len(found) > 1 else (0.0,)
    for place, (score, shift) in enumerate(zip(found, shifts, strict=True)):
        if score is not None:
            _dot(axes, score, row + shift, tint, filled=_filled(panel, place))


def _filled(panel: Panel, place: int) -> bool:
    """Robot trials and small frames are; clips are open in every panel."""
    return place == 0 and panel.keys[0] != "clips"


def _dot(axes: Axes, score: Score, height: float, shade: str, filled: bool) -> None:
    if np.isfinite([score.low, score.high]).all():
        axes.plot([score.low, score.high], [height, height], color=shade, lw=1.4, solid_capstyle="butt", zorder=2)
    face = shade if filled else "white"
    axes.plot(score.value, height, "o", ms=5, mfc=face, mec=shade, mew=1.2, zorder=3, clip_on=False)


def _legend(axes: Axes, panel: Panel, below: float) -> None:
    """Which dots are which, ``below`` the axis as a share of its height."""
    keys = [
        Line2D(
            [], [], ls="", marker="o", ms=5, color="#444444", mfc="#444444" if _filled(panel, i) else "white", label=k
        )
        for i, k in enumerate(panel.keys)
    ]
    axes.legend(
        handles=keys, ncols=2, fontsize=8, frameon=False, loc="upper center", borderaxespad=0.0,
        bbox_to_anchor=(0.5, -below), handletextpad=0.1, columnspacing=1.0,
    )  # fmt: skip
