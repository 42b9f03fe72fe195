"""A fit as a figure: where in the box claims are kept, what each turns on, and which exclude each other."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure, SubFigure
from matplotlib.patches import Rectangle

from experiments.bench.figures.plotting import STYLE, WIDTH, headline, plain
from experiments.bench.studies.counts import TOGETHER
from experiments.bench.studies.figure import DEFAULT, SCALE, SHADES
from experiments.bench.studies.fitting.box import Range
from experiments.bench.studies.fitting.fitted import Fitted
from experiments.bench.studies.fitting.scores import Score

MOST_PARAMETERS = 5
"""Parameters of which pairs are drawn: those that matter most."""
KEY = "dots: searched; squares: even; darker: keeps more claims; black edge: keeps all; star: the winner"
"""What the marks of the upper panels are."""
LEAST_SHADE = 0.12
"""Shade of a setting that keeps no claim, so that it is seen."""


def draw(fitted: Fitted) -> Figure:
    """Draw a fit.

    Parameters
    ----------
    fitted
        What it comes to.

    Returns
    -------
    matplotlib.figure.Figure
        Above, a panel for each pair of parameters, or one of the least slack over a single one: dots are settings that
        were searched, squares those of the even sample, darker the more claims they keep, with a black edge where they
        keep all; the star is the winner. Below, how much each claim turns on each parameter; and in how many settings
        two claims are kept together, framed where they exclude each other.
    """
    ranges = _drawn(fitted)
    pairs = list(itertools.combinations(ranges, 2))
    across = min(max(len(pairs), 1), 3)
    down = -(-max(len(pairs), 1) // across)
    tables = 0.7 + 0.3 * (len(fitted.claims) + 1)
    with mpl.rc_context(STYLE):
        drawn = Figure(figsize=(WIDTH, 2.4 * down + tables + 1.3), layout="constrained")
        above, below = drawn.subfigures(2, 1, squeeze=False, height_ratios=(2.4 * down, tables + 0.3))[:, 0]
        panels = above.subplots(down, across, squeeze=False)
        for axes, pair in zip(panels.flat, pairs, strict=False):
            _pair(axes, fitted, *pair)
        if not pairs:
            _single(panels[0, 0], fitted, ranges[0])
        for axes in list(panels.flat)[max(len(pairs), 1) :]:
            axes.set_axis_off()
        _tables(below, fitted)
        low, high = fitted.share.interval or (0.0, 1.0)
        share = f"{low:.0%} to {high:.0%} of the box"
        kept = f"all kept in {fitted.share.holds} of {len(fitted.sample)} even settings ({share})"
        count = fitted.anew[0].count()
        winner = f"the winner anew: {count} replicates, {fitted.word}"
        title = f"{fitted.fit.study.name}: {len(fitted.searched)} settings searched; {winner}\n{kept}\n{KEY}"
        headline(drawn, title)
    return drawn


def _drawn(fitted: Fitted) -> list[Range]:
    """Return the parameters that matter most, in the order of the box."""
    shares = fitted.importance[""]
    most = sorted(fitted.box.ranges, key=lambda part: -shares[part.key])[:MOST_PARAMETERS]
    return [part for part in fitted.box.ranges if part in most]


def _places(part: Range, scores: Sequence[Score]) -> list[float]:
    texts = [score.setting[part.key] for score in scores]
    return [float(part.choices.index(text)) if part.choices else float(text) for text in texts]


def _shades(fitted: Fitted, scores: Sequence[Score]) -> tuple[list[str], list[float]]:
    """Return the colour of each setting, and the width of its edge."""
    shares = [sum(map(score.holds_claim, fitted.claims)) / len(fitted.claims) for score in scores]
    colours = mpl.colormaps[SHADES]([LEAST_SHADE + (0.85 - LEAST_SHADE) * share for share in shares])
    return [mpl.colors.to_hex(colour) for colour in colours], [0.9 if score.holds else 0.0 for score in scores]


def _pair(axes: Axes, fitted: Fitted, one: Range, other: Range) -> None:
    for scores, marker, size in ((fitted.searched, "o", 13), (fitted.sample, "s", 20)):
        colours, edges = _shades(fitted, scores)
        axes.scatter(_places(one, scores), _places(other, scores), s=size, c=colours, marker=marker, linewidths=edges,
                     edgecolors="black", zorder=2)  # fmt: skip
    axes.plot(
        *(_places(part, [fitted.winner]) for part in (one, other)), "*", color=DEFAULT, ms=11, mec="white", zorder=4
    )
    _axis(axes, one, "x")
    _axis(axes, other, "y")


def _single(axes: Axes, fitted: Fitted, part: Range) -> None:
    for scores, marker, size in ((fitted.searched, "o", 13), (fitted.sample, "s", 20)):
        colours, edges = _shades(fitted, scores)
        axes.scatter(_places(part, scores), [score.value for score in scores], s=size, c=colours, marker=marker,
                     linewidths=edges, edgecolors="black", zorder=2)  # fmt: skip
    axes.plot(_places(part, [fitted.winner]), [fitted.winner.value], "*", color=DEFAULT, ms=11, mec="white", zorder=4)
    axes.axhline(0.0, color="#777777", lw=0.8, zorder=1)
    axes.set_ylabel("least slack, smallest differences", fontsize=8)
    _axis(axes, part, "x")


def _axis(axes: Axes, part: Range, which: str) -> None:
    label = plain(f"{part.key} ({part.unit or 'no unit'})")
    axes.set(**{f"{which}label": label})
    (axes.xaxis if which == "x" else axes.yaxis).label.set_fontsize(8)
    if part.choices:
        ticks = list(map(plain, part.choices))
        (axes.set_xticks if which == "x" else axes.set_yticks)(range(len(ticks)), ticks)
    else:
        margin = 0.0 if part.log else 0.04 * (part.high - part.low)
        axes.set(**{f"{which}lim": (part.low - margin, part.high + margin)})
        if part.log:
            axes.set(**{f"{which}scale": "log"})


def _tables(place: SubFigure, fitted: Fitted) -> None:
    claims, keys = fitted.claims, [part.key for part in fitted.box.ranges]
    turns, together = place.subplots(1, 2, squeeze=False)[0]
    names = (TOGETHER, *claims) if len(claims) > 1 else claims
    shares = np.array([[fitted.importance["" if name == TOGETHER else name][key] for key in keys] for name in names])
    turns.imshow(shares, cmap=SCALE, vmin=0.0, vmax=1.15, aspect="auto")
    _cells(turns, shares, [[f"{share:.2f}" for share in row] for row in shares], 0.6)
    turns.set_xticks(range(len(keys)), [plain(key.partition(".")[2]) for key in keys], rotation=20, ha="right")
    turns.set_yticks(range(len(names)), [plain(name) for name in names])
    turns.set_title("what each claim turns on", fontsize=8, loc="left")
    _matrix(together, fitted)


def _matrix(axes: Axes, fitted: Fitted) -> None:
    claims, every = fitted.claims, len(fitted.searched) + len(fitted.sample)
    kept = np.zeros((len(claims), len(claims)))
    for n, claim in enumerate(claims):
        kept[n, n] = sum(score.holds_claim(claim) for score in (*fitted.searched, *fitted.sample))
    for pair in fitted.pairs():
        one, other = claims.index(pair["claim"]), claims.index(pair["other"])
        kept[one, other] = kept[other, one] = pair["both"]
        if pair in fitted.exclusions():
            for x, y in ((one, other), (other, one)):
                axes.add_patch(Rectangle((x - 0.45, y - 0.45), 0.9, 0.9, fill=False, ec=DEFAULT, lw=1.6, zorder=4))
    axes.imshow(kept / every, cmap=SHADES, vmin=0.0, vmax=1.15, aspect="auto")
    _cells(axes, kept / every, [[f"{number:.0f}" for number in row] for row in kept], 0.6)
    axes.set_xticks(range(len(claims)), [plain(claim) for claim in claims])
    axes.set_yticks(range(len(claims)), [plain(claim) for claim in claims])
    axes.set_title(f"kept together, of {every} settings", fontsize=8, loc="left")


def _cells(axes: Axes, values: np.ndarray, texts: Sequence[Sequence[str]], dark: float) -> None:
    for (row, column), value in np.ndenumerate(values):
        axes.text(column, row, texts[row][column], ha="center", va="center", fontsize=8,
                  color="white" if value > dark else "black", zorder=3)  # fmt: skip
    axes.tick_params(length=0)
