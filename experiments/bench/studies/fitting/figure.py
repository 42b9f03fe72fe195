"""A fit as a figure: where in the box claims are kept or measures are large, what each turns on, what excludes what."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from experiments.bench.figures.plotting import STYLE, WIDTH, headline, plain
from experiments.bench.report.sweep import DEFAULT, SHADES
from experiments.bench.studies.fitting.box import Range
from experiments.bench.studies.fitting.fitted import Fitted
from experiments.bench.studies.fitting.optimum import Optimum, front
from experiments.bench.studies.fitting.scores import Reading, Score
from experiments.bench.sweep import TOGETHER

MOST_PARAMETERS = 5
"""Parameters of which pairs are drawn: those that matter most."""
KEY = "dots: searched; squares: even; darker: keeps more claims; black edge: keeps all; star: the winner"
KEY_OF_MEASURES = "dots: searched; squares: even; darker: better in {goal}, by rank; star: the winner"
"""What the marks of the upper panels are, of claims and of measures."""
LEAST_SHADE = 0.12
"""Shade of a setting that keeps no claim, so that it is seen."""


def draw(fitted: Fitted | Optimum) -> Figure:
    """Draw a fit.

    Parameters
    ----------
    fitted
        The fit's result.

    Returns
    -------
    matplotlib.figure.Figure
        Above, a panel for each pair of parameters, or one of the first goal over a single one: dots are settings that
        were searched, squares those of the even sample, darker the more claims they keep, with a black edge where they
        keep all, or the better they are by rank; the star is the winner. Below, how much each claim or measure turns on
        each parameter. Then, of claims, in how many settings two are kept together, framed where they exclude each
        other; of one measure its values in the search and anew; of several the front.
    """
    ranges = _drawn(fitted)
    pairs = list(itertools.combinations(ranges, 2))
    across = min(max(len(pairs), 1), 3)
    down = -(-max(len(pairs), 1) // across)
    names = len(fitted.importance) - 1
    tables = max(0.7 + 0.3 * (names + 1), 2.0 if isinstance(fitted, Optimum) else 0.0)
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
        turns, other = below.subplots(1, 2, squeeze=False)[0]
        _turns(turns, fitted)
        if isinstance(fitted, Optimum):
            _measured(other, fitted)
        else:
            _matrix(other, fitted)
        headline(drawn, _title(fitted))
    return drawn


def _title(fitted: Fitted | Optimum) -> str:
    head = f"{fitted.fit.study.name}: {len(fitted.searched)} settings searched"
    if isinstance(fitted, Optimum):
        goal = fitted.goals[0]
        gain, luck = fitted.gain(goal), fitted.luck(goal)
        told = "" if gain is None else f"; the winner anew: better in {goal.name} by {gain:+.3g}"
        lucky = "" if luck is None or luck <= 0 else f", {luck:.3g} less than in the search"
        return f"{head}{told}{lucky}\n{KEY_OF_MEASURES.format(goal=goal.name)}"
    low, high = fitted.share.interval or (0.0, 1.0)
    share = f"{low:.0%} to {high:.0%} of the box"
    kept = f"all kept in {fitted.share.holds} of {len(fitted.sample)} even settings ({share})"
    count = fitted.anew[0].count()
    return f"{head}; the winner anew: {count} replicates, {fitted.word}\n{kept}\n{KEY}"


def _drawn(fitted: Fitted | Optimum) -> list[Range]:
    """Return the parameters that matter most, in the order of the box."""
    shares = fitted.importance[""]
    most = sorted(fitted.box.ranges, key=lambda part: -shares[part.key])[:MOST_PARAMETERS]
    return [part for part in fitted.box.ranges if part in most]


def _places(part: Range, scores: Sequence[Score] | Sequence[Reading]) -> list[float]:
    texts = [score.setting[part.key] for score in scores]
    return [float(part.choices.index(text)) if part.choices else float(text) for text in texts]


def _shades(fitted: Fitted | Optimum, scores: Sequence[Any]) -> tuple[list[str], list[float]]:
    """Return the colour of each setting, and the width of its edge."""
    if isinstance(fitted, Optimum):
        shares = _ranks(fitted, scores)
        edges = [0.0] * len(scores)
    else:
        shares = [score.kept / len(fitted.claims) for score in scores]
        edges = [0.9 if score.holds else 0.0 for score in scores]
    colours = mpl.colormaps[SHADES]([LEAST_SHADE + (0.85 - LEAST_SHADE) * share for share in shares])
    return [mpl.colors.to_hex(colour) for colour in colours], edges


def _ranks(fitted: Optimum, readings: Sequence[Reading]) -> list[float]:
    """Return the share of all settings that each is at least as good as in the first goal; 0 of one without a value."""
    goals = fitted.goals[:1]
    every = np.array([reading.searched(goals)[0] for reading in (*fitted.searched, *fitted.sample)])
    values = np.array([reading.searched(goals)[0] for reading in readings])
    return [0.0 if np.isnan(value) else float(np.mean(every <= value)) for value in values]


def _height(fitted: Fitted | Optimum, score: Any) -> float:
    """Return what a panel of a single parameter shows of a setting."""
    return float(score.value if isinstance(fitted, Fitted) else score.numbers[fitted.goals[0].name])


def _marks(axes: Axes, fitted: Fitted | Optimum, x: Range, y: Range | None) -> None:
    """Draw search, sample and winner over one parameter or two."""

    def heights(scores: Any) -> list[float]:
        return [_height(fitted, score) for score in scores] if y is None else _places(y, scores)

    for scores, marker, size in ((fitted.searched, "o", 13), (fitted.sample, "s", 20)):
        colours, edges = _shades(fitted, scores)
        axes.scatter(_places(x, scores), heights(scores), s=size, c=colours, marker=marker, linewidths=edges,
                     edgecolors="black", zorder=2)  # fmt: skip
    winner: Any = [fitted.winner]
    axes.plot(_places(x, winner), heights(winner), "*", color=DEFAULT, ms=11, mec="white", zorder=4)
    _axis(axes, x, "x")


def _pair(axes: Axes, fitted: Fitted | Optimum, one: Range, other: Range) -> None:
    _marks(axes, fitted, one, other)
    _axis(axes, other, "y")


def _single(axes: Axes, fitted: Fitted | Optimum, part: Range) -> None:
    _marks(axes, fitted, part, None)
    if isinstance(fitted, Fitted):
        axes.axhline(0.0, color="#777777", lw=0.8, zorder=1)
        axes.set_ylabel("least slack, smallest differences", fontsize=8)
    else:
        axes.set_ylabel(plain(fitted.goals[0].name), fontsize=8)


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


def _turns(turns: Axes, fitted: Fitted | Optimum) -> None:
    keys = [part.key for part in fitted.box.ranges]
    rows = {name: shares for name, shares in fitted.importance.items() if name}
    if isinstance(fitted, Fitted) and len(rows) > 1:
        rows = {TOGETHER: fitted.importance[""], **rows}
    shares = np.array([[row[key] for key in keys] for row in rows.values()])
    turns.imshow(shares, cmap="YlGnBu", vmin=0.0, vmax=1.15, aspect="auto")
    _cells(turns, shares, [[f"{share:.2f}" for share in row] for row in shares], 0.6)
    names = ["+".join(dict.fromkeys(key.partition(".")[2] for key in part.keys)) for part in fitted.box.ranges]
    turns.set_xticks(range(len(names)), list(map(plain, names)), rotation=20, ha="right")
    turns.set_yticks(range(len(rows)), [plain(name) for name in rows])
    turns.set_title("what each turns on, as a share", fontsize=8, loc="left")


def _measured(axes: Axes, fitted: Optimum) -> None:
    """Draw the front of two goals; of one goal what was judged anew, beside the search's promise."""
    goals = fitted.goals
    if len(goals) > 1:
        for readings, marker in ((fitted.searched, "o"), (fitted.sample, "s")):
            colours, _ = _shades(fitted, readings)
            x, y = ([reading.numbers[goal.name] for reading in readings] for goal in goals[:2])
            axes.scatter(x, y, s=10, c=colours, marker=marker, linewidths=0, zorder=2)
        places = front(fitted.searched, goals)
        ends = sorted([fitted.searched[place].numbers[goal.name] for goal in goals[:2]] for place in places)
        if len(goals) == 2:
            axes.plot(*zip(*ends, strict=True), color=DEFAULT, lw=1.0, zorder=3)
        axes.set(xlabel=plain(goals[0].name), ylabel=plain(goals[1].name))
        axes.set_title("settings, and the front", fontsize=8, loc="left")
        return
    rows = [row for row in fitted.anew_rows() if row["anew"] is not None]
    for place, row in enumerate(rows):
        height = len(rows) - place
        if row["low"] is not None:
            axes.plot((row["low"], row["high"]), (height, height), color="#444444", lw=1.2, zorder=2)
        axes.plot(row["anew"], height, "o", color="#222222", ms=4, zorder=3)
        if row["in the search"] is not None:
            axes.plot(row["in the search"], height, "|", color=DEFAULT, ms=9, mew=1.6, zorder=3)
    names = ["as it is" if row["number"] is None else f"no. {row['number']}" for row in rows]
    axes.set_yticks(range(len(rows), 0, -1), names, fontsize=8)
    axes.set_xlabel(plain(goals[0].name))
    axes.set_title("anew: mean, 95 % interval; bar: in the search", fontsize=8, loc="left")


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
