"""A sweep as a table and a figure: mean spikes at every point of the grid."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from experiments.bench.figures.palette import LINES, MARKERS, Mark, level_colours, marks
from experiments.bench.figures.plotting import LETTER, STYLE, headline, plain
from experiments.bench.judging.statistics import summarise
from experiments.bench.robot.experiment import CONDITION_COLUMNS
from experiments.bench.robot.figure import AXIS_LABELS, UNITS, said
from experiments.bench.robot.rows import varying
from experiments.bench.store.rows import group, known

Row = Mapping[str, Any]
PANEL_INCHES = 6.0
"""Width of the panel; the key stands beside it."""
MOST_IN_A_COLUMN = 24
"""Lines of the key below each other."""
SPREAD = 0.3
"""Width of all lines at one level, as a share of the smallest gap between levels."""


def table(rows: Sequence[Row], keys: Sequence[str]) -> list[dict[str, Any]]:
    """A row per model, point and condition of `Part.tagged` rows: n, mean, and its 95 % interval.

    ``keys`` are those of the grid; a key that is not of the model is empty, and so are the mean and its interval of a
    model that does not spike.
    """
    columns = ("model", *keys, *CONDITION_COLUMNS)
    made = []
    for values, chosen in group(rows, *columns).items():
        summary = summarise(spikes) if (spikes := _spikes(chosen)) else None
        mean, low, high = (summary.mean, summary.ci_low, summary.ci_high) if summary else (math.nan,) * 3
        made.append(
            {
                **dict(zip(columns, values, strict=True)), "n": len(chosen),
                "spikes_mean": known(mean), "ci_low": known(low), "ci_high": known(high),
            }
        )  # fmt: skip
    return made


def _spikes(rows: Iterable[Row]) -> list[int]:
    """The counts of trials; none of a model that does not spike."""
    return [row["spikes"] for row in rows if row["spikes"] is not None]


def telling(rows: Sequence[Row], keys: Sequence[str], varies: str) -> list[str]:
    """The columns that tell lines apart: the model if there are several, the grid's keys, other conditions."""
    by_point = group(rows, "model", *keys).values()
    others = [
        name
        for name in varying(rows, varies)
        if name not in ("model", varies) and any(len({row[name] for row in own}) > 1 for own in by_point)
    ]
    several = len({row["model"] for row in rows}) > 1
    return [*(["model"] if several else []), *keys, *others]


def draw(rows: Sequence[Row], keys: Sequence[str], varies: str, title: str) -> Figure:
    """Mean spikes against the condition, with 95 % intervals: a line per model, point and other condition that differs.

    One model has a colour for each point of the grid. Several have each its own, and each point a marker. Other
    conditions have line styles. An axis of numbers has their scale; words have no line between them. Models that do not
    spike are named, and have no line.
    """
    silent = dict.fromkeys(row["model"] for row in rows if row["spikes"] is None)
    apart = telling(rows, keys, varies)
    others = [name for name in apart if name not in ("model", *keys)]
    levels = list(dict.fromkeys(row[varies] for row in rows))
    ordinal = isinstance(levels[0], str)
    ticks = {level: float(i) for i, level in enumerate(levels)} if ordinal else {v: float(v) for v in sorted(levels)}
    gaps = [b - a for a, b in zip(list(ticks.values()), list(ticks.values())[1:], strict=False)]
    styles = {key: LINES[i % len(LINES)] for i, key in enumerate(group(rows, *others))}
    lines = group([row for row in rows if row["spikes"] is not None], "model", *keys, *others)
    looks = _looks(rows, keys)
    labels = [_said(chosen[0], apart, keys) for chosen in lines.values()]
    across = -(-len(lines) // MOST_IN_A_COLUMN)
    key_inches = across * (0.6 + LETTER * 7 / 72 * max(map(len, labels), default=0))
    with mpl.rc_context(STYLE):
        drawn = Figure(figsize=(PANEL_INCHES + key_inches, 4.4), layout="constrained")
        axes = drawn.subplots()
        for place, (label, (line, chosen)) in enumerate(zip(labels, lines.items(), strict=True)):
            shift = SPREAD * (min(gaps) if gaps else 1.0) * (place / max(len(lines) - 1, 1) - 0.5)
            point, style = looks[line[: 1 + len(keys)]], styles[line[1 + len(keys) :]]
            _line(axes, chosen, varies, ticks, shift, color=point.colour, ls="none" if ordinal else style,
                  marker=point.marker, label=label)  # fmt: skip
        axes.set_xticks(list(ticks.values()), [said(level) for level in ticks])
        axes.set(xlabel=AXIS_LABELS[varies], ylabel="spikes per trial")
        headline(drawn, title)
        if silent:
            axes.set_title(plain(f"not drawn, as without spikes: {', '.join(silent)}"), fontsize=7, loc="left")
        if lines:
            drawn.legend(loc="outside right upper", frameon=False, fontsize=7, ncols=across)
    return drawn


def _looks(rows: Sequence[Row], keys: Sequence[str]) -> dict[tuple[Any, ...], Mark]:
    """A mark for each model at each point: of one model a colour a point, of several each model's colour."""
    points = list(group(rows, "model", *keys))
    own = marks(point[0] for point in points)
    if len(own) == 1:
        shades = level_colours(list(range(len(points))))
        return {each: Mark(shades[i], MARKERS[i % len(MARKERS)], "-") for i, each in enumerate(points)}
    places = {model: [each for each in points if each[0] == model] for model in own}
    return {
        each: Mark(own[each[0]].colour, MARKERS[places[each[0]].index(each) % len(MARKERS)], "-") for each in points
    }


def _said(row: Row, apart: Sequence[str], keys: Sequence[str]) -> str:
    """A line in words: its model, the grid's values it has, its other conditions."""
    model = [row["model"]] if "model" in apart else []
    grid = " ".join(f"{key}={row[key]}" for key in keys if row[key] is not None)
    others = [
        f"{row[c]:g} {UNITS[c]}" if c in UNITS and row[c] is not None else str(row[c])
        for c in apart
        if c not in ("model", *keys)
    ]
    return plain(", ".join([*model, *([grid] if grid else []), *others]) or row["model"])


def _line(axes: Axes, rows: Sequence[Row], varies: str, ticks: Mapping[Any, float], shift: float, **style: Any) -> None:
    """Means with intervals at the levels that these rows have."""
    spikes = {place: _spikes(row for row in rows if row[varies] == level) for level, place in ticks.items()}
    summaries = {place + shift: summarise(values) for place, values in spikes.items() if values}
    # NaN of a single trial: then no bar is drawn.
    spread = np.array([[s.mean - s.ci_low, s.ci_high - s.mean] for s in summaries.values()]).T
    means = [summary.mean for summary in summaries.values()]
    axes.errorbar(list(summaries), means, yerr=spread, ms=4, lw=1, capsize=2, **style)
