"""A sweep as a table and a figure: mean spikes at every point of the grid."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from experiments.bench.core.figures.palette import LINES
from experiments.bench.core.figures.plotting import STYLE, plain
from experiments.bench.core.statistics import summarise
from experiments.bench.core.store.rows import group, known
from experiments.bench.robot.experiment import CONDITION_COLUMNS
from experiments.bench.robot.figure import AXIS_LABELS, UNITS
from experiments.bench.robot.rows import varying

Row = Mapping[str, Any]
MARKERS = ("o", "s", "^", "D", "v", "P", "X", "*")


def table(rows: Sequence[Row], keys: Sequence[str]) -> list[dict[str, Any]]:
    """A row per model, point and condition of `Part.tagged` rows: n, mean, and its 95 % interval.

    ``keys`` are those of the grid; a key that is not of the model is empty.
    """
    columns = ("model", *keys, *CONDITION_COLUMNS)
    made = []
    for values, chosen in group(rows, *columns).items():
        summary = summarise([row["spikes"] for row in chosen])
        made.append(
            {
                **dict(zip(columns, values, strict=True)), "n": summary.n,
                "spikes_mean": summary.mean, "ci_low": known(summary.ci_low), "ci_high": known(summary.ci_high),
            }
        )  # fmt: skip
    return made


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

    A colour for each model at each point, a marker for each model, a style for each of the other conditions.
    """
    apart = telling(rows, keys, varies)
    others = [name for name in apart if name not in ("model", *keys)]
    levels = sorted({row[varies] for row in rows})
    points = list(group(rows, "model", *keys))
    shades = dict(zip(points, mpl.colormaps["viridis"](np.linspace(0, 0.92, max(len(points), 2))), strict=False))
    markers = {m: MARKERS[i % len(MARKERS)] for i, m in enumerate(dict.fromkeys(row["model"] for row in rows))}
    styles = {key: LINES[i % len(LINES)] for i, key in enumerate(group(rows, *others))}
    lines = group(rows, "model", *keys, *others)
    with mpl.rc_context(STYLE):
        drawn = Figure(figsize=(8.4, 4.2), layout="constrained")
        axes = drawn.subplots()
        for place, (line, chosen) in enumerate(lines.items()):
            shift = 0.3 * (place / max(len(lines) - 1, 1) - 0.5)
            _line(axes, chosen, varies, levels, shift, color=shades[line[: 1 + len(keys)]],
                  ls=styles[line[1 + len(keys) :]], fmt=markers[line[0]],
                  label=_said(chosen[0], apart, keys))  # fmt: skip
        axes.set_xticks(range(len(levels)), [v if isinstance(v, str) else f"{v:g}" for v in levels])
        axes.set(xlabel=AXIS_LABELS[varies], ylabel="spikes per trial", title=plain(title))
        if len(lines) <= 24:
            drawn.legend(loc="outside right upper", frameon=False, fontsize=7)
    return drawn


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


def _line(axes: Axes, rows: Sequence[Row], varies: str, levels: Sequence[Any], shift: float, **style: Any) -> None:
    """Means with intervals at the levels that these rows have."""
    spikes = {tick: [row["spikes"] for row in rows if row[varies] == level] for tick, level in enumerate(levels)}
    summaries = {tick + shift: summarise(values) for tick, values in spikes.items() if values}
    # NaN of a single trial: then no bar is drawn.
    spread = np.array([[s.mean - s.ci_low, s.ci_high - s.mean] for s in summaries.values()]).T
    means = [summary.mean for summary in summaries.values()]
    axes.errorbar(list(summaries), means, yerr=spread, ms=3, lw=1, capsize=2, **style)
