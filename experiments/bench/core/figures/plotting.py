"""How figures look: style, colours, and how they are saved."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import LogLocator, NullFormatter, StrMethodFormatter

from experiments.bench.core.scores import Score, Standing

STYLE: dict[Any, Any] = {
    "font.size": 9,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "svg.hashsalt": "colias-sim",  # equal runs, equal bytes
    "svg.fonttype": "none",
}


def plain(text: str) -> str:
    """Words as they are: a dollar sign in a label of the user's begins no formula."""
    return text.replace("$", r"\$")


def save(drawn: Figure, folder: Path, name: str = "figure") -> Path:
    """Write ``NAME.svg`` and ``NAME.png`` atomically; return the path of the latter."""
    with mpl.rc_context(STYLE):
        for kind in ("svg", "png"):
            partial = folder / f"{name}.{kind}.part"
            drawn.savefig(partial, format=kind, dpi=160, metadata={"Date": None} if kind == "svg" else None)
            partial.replace(folder / f"{name}.{kind}")
    return folder / f"{name}.png"


@dataclass(frozen=True, slots=True)
class Panel:
    """One panel of a scoreboard.

    Parameters
    ----------
    title
        Its heading.
    measures
        Measures drawn together: one, or two, the second open.
    keys
        What tells the measures apart, in words; none for a single measure without a legend.
    chance
        What guessing gets; a dotted line.
    log, share
        Whether the axis is logarithmic, or goes from 0 to 1.
    filled
        Whether the first measure's dots are filled.
    column
        The column of each row's value, drawn as a tick; empty where the measure is of all rows together.
    """

    title: str
    measures: tuple[str, ...]
    keys: tuple[str, ...] = ()
    chance: float | None = None
    log: bool = False
    share: bool = False
    filled: bool = True
    column: str = ""


APART = 0.17
"""Of the dots of one row, from its middle."""
INCHES_A_ROW = 0.34
"""Height of a row of a scoreboard."""
TICKS_INCHES = 0.22
"""Height of the numbers below an axis; the keys stand under them."""
SPACIOUS = 300.0
"""The ratio of the ends of a logarithmic axis from which on powers of ten alone are labelled."""
MISSING = "#777777"
NOT_APPLYING = "does not apply"


def scoreboard(
    axes: Sequence[Axes], panels: Sequence[Panel], standings: Sequence[Standing], tints: Mapping[str, str]
) -> None:
    """Draw a row for each standing, the first on top, and a panel for each kind of measure.

    Parameters
    ----------
    axes
        One for each panel, side by side, with a common y axis.
    panels, standings
        What is drawn: dots with 95 % intervals; words where a measure does not apply or is infinite.
    tints
        Standing -> its colour.
    """
    for place, panel in zip(axes, panels, strict=True):
        _panel(place, panel, standings, tints)
    axes[0].set_yticks(range(len(standings)), [plain(standing.name) for standing in standings])
    axes[0].set_ylim(len(standings) - 0.5, -0.5)


def _panel(axes: Axes, panel: Panel, standings: Sequence[Standing], tints: Mapping[str, str]) -> None:
    if panel.chance is not None:
        axes.axvline(panel.chance, color="black", ls=":", lw=0.8, zorder=1)
    for row in range(0, len(standings), 2):
        axes.axhspan(row - 0.5, row + 0.5, color="black", alpha=0.04, lw=0)
    for row, standing in enumerate(standings):
        _row(axes, panel, row, standing, tints[standing.name])
    if panel.log:
        axes.set_xscale("log")
        low, high = axes.get_xlim()
        axes.xaxis.set_major_locator(LogLocator(subs=(1.0, 3.0) if high < SPACIOUS * low else (1.0,)))
        axes.xaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
        axes.xaxis.set_minor_formatter(NullFormatter())
    elif panel.share:
        axes.set_xlim(-0.04, 1.04)
        axes.set_xticks([0, 0.25, 0.5, 0.75, 1], ["0", "¼", "½", "¾", "1"])
    axes.tick_params(axis="y", length=0)
    axes.set_title(panel.title, fontsize=9, loc="left")
    if panel.keys:
        _keys(axes, panel, TICKS_INCHES / (INCHES_A_ROW * len(standings)))


def _row(axes: Axes, panel: Panel, row: int, standing: Standing, tint: str) -> None:
    found = [standing.scores.get(measure) for measure in panel.measures]
    if not any(score is not None and math.isfinite(score.value) for score in found):
        said = "none" if any(score is not None and math.isinf(score.value) for score in found) else NOT_APPLYING
        axes.annotate(said, (0.02, row), xycoords=("axes fraction", "data"), ha="left", va="center", color=MISSING,
                      fontsize=7, fontstyle="italic")  # fmt: skip
    if panel.column:
        each = [value for one in standing.rows if (value := one[panel.column]) is not None]
        axes.plot(each, [row + 0.3] * len(each), "|", color=tint, alpha=0.45, ms=5)
    shifts = (-APART, APART) if len(found) > 1 else (0.0,)
    for place, (score, shift) in enumerate(zip(found, shifts, strict=True)):
        if score is not None and math.isfinite(score.value):
            _dot(axes, score, row + shift, tint, filled=panel.filled and place == 0)


def _dot(axes: Axes, score: Score, height: float, tint: str, *, filled: bool) -> None:
    """A score with its interval; an infinite end is left out."""
    ends = [end if math.isfinite(end) else score.value for end in (score.low, score.high)]
    axes.plot(ends, [height, height], color=tint, lw=1.4, solid_capstyle="butt", zorder=2)
    face = tint if filled else "white"
    axes.plot(score.value, height, "o", ms=5, mfc=face, mec=tint, mew=1.2, zorder=3, clip_on=False)


def _keys(axes: Axes, panel: Panel, below: float) -> None:
    """Which dots are which, ``below`` the axis as a share of its height."""
    grey = "#444444"
    keys = [
        Line2D(
            [], [], ls="", marker="o", ms=5, color=grey, mfc=grey if panel.filled and not place else "white", label=key
        )
        for place, key in enumerate(panel.keys)
    ]
    axes.legend(
        handles=keys, ncols=2, fontsize=8, frameon=False, loc="upper center", borderaxespad=0.0,
        bbox_to_anchor=(0.5, -below), handletextpad=0.1, columnspacing=1.0,
    )  # fmt: skip
