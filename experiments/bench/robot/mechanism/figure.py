"""The figure of why counts go with speed or distance as they do: count, time in view, firing rate, potential."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure, SubFigure
from matplotlib.lines import Line2D

from experiments.bench.figures.palette import HUES, LINES, lanes, marks
from experiments.bench.figures.plotting import LETTER_INCHES, STYLE, WIDTH, extra_widths, headline, plain, wrapped
from experiments.bench.robot.figure import AXIS_LABELS
from experiments.bench.sources.windows import NEAR_AXIS_CM
from experiments.bench.stats.tests import LEAST_FOR_BOOTSTRAP, Summary, summarise
from experiments.bench.store.rows import looming_alone

Rows = Sequence[Mapping[str, Any]]

PANELS: tuple[tuple[str, tuple[tuple[str, str], ...]], ...] = (
    ("spikes per trial", (("spikes", "whole crossing"), ("spikes_in_window", "one window for all"))),
    ("time in view (s)", (("seconds_in_view", ""),)),
    ("firing rate in view (Hz)", (("rate_in_view_hz", ""),)),
    (
        "HS potential",
        (("peak_hs", "peak"), ("mean_hs_near_axis", f"mean within {NEAR_AXIS_CM:g} cm of the axis")),
    ),
)
"""Title of a panel of the first model, and what it shows: column, and its name where there are several."""

COMPARED = (
    ("mean_hs_near_axis", f"mean HS within {NEAR_AXIS_CM:g} cm of the axis"), ("peak_hs", "peak HS"),
    ("spikes", "spikes per trial"),
)  # fmt: skip
"""Columns that all models are compared by: column, title of the panel."""

HIGH = 3.1
"""Height of the first model's row, inches."""
LANE = 2.3
"""Least height of a row of other models, inches."""
KEY_INCHES = 0.17
"""Height of a model's line in the key."""
PANEL_INCHES = 1.5
"""Width of a panel."""
THRESHOLD: dict[str, Any] = {"color": "black", "ls": "--", "lw": 0.8}
"""Look of the line at the threshold."""
LOGARITHMIC_FROM = 5.0
"""Ratio of the largest to the smallest level from which the axis is logarithmic."""


def figure(rows: Rows, varies: str, heading: str, threshold: float | None) -> Figure:
    """Draw the mechanism of a run of crossings.

    Parameters
    ----------
    rows
        Of ``trials.parquet``. Every point is a mean over trials, from `LEAST_FOR_BOOTSTRAP` on with its 95 % interval.
    varies
        The column along the axes, a number.
    heading
        Title of the figure.
    threshold
        Of the first model's potential; ``None``: it does not spike.

    Returns
    -------
    matplotlib.figure.Figure
        Above, the first model: spikes, time in view, firing rate in view, potential. Below, where there are several
        models: potential and spikes of each, a row for as many as have colours of their own.
    """
    models = list(dict.fromkeys(row["model"] for row in rows))
    with mpl.rc_context(STYLE):
        groups = lanes(models) if len(models) > 1 else []
        lower = [max(LANE, 0.3 + KEY_INCHES * len(group)) for group in groups]
        drawn = Figure(figsize=(WIDTH, HIGH + sum(lower)), layout="constrained")
        ratios = [HIGH, *lower]
        parts = drawn.subfigures(len(ratios), 1, squeeze=False, height_ratios=ratios)[:, 0] if lower else [drawn]
        _first_model([row for row in rows if row["model"] == models[0]], varies, parts[0], threshold)
        if groups:
            parts[0].suptitle(plain(f"{models[0]} alone"), fontsize=8, x=0.01, ha="left")
            parts[1].suptitle("beside the others", fontsize=8, x=0.01, ha="left")
        for part, group in zip(parts[1:], groups, strict=True):
            _models(rows, models, group, varies, part.subplots(1, 4), threshold)
        headline(drawn, heading)
    return drawn


def _first_model(rows: Rows, varies: str, place: Figure | SubFigure, threshold: float | None) -> None:
    """Draw the first model's panels, and below them which line is what where a panel has two."""
    places = place.subplots(1, len(PANELS))
    names: dict[Any, list[str]] = {}
    for axes, (heading, columns) in zip(places, PANELS, strict=True):
        columns_shown = [column for column in columns if column[0] != "spikes_in_window" or varies == "speed_cm_s"]
        for style, (column, name) in zip(LINES, columns_shown, strict=False):
            _curve(axes, rows, varies, column, HUES[0], style, name)
        if heading.startswith("HS"):
            _threshold(axes, threshold)
        _frame(axes, rows, varies, heading)
        if len(columns_shown) > 1:
            for style, (_, name) in zip(LINES, columns_shown, strict=False):
                names.setdefault(style, []).append(f"{heading.partition(' ')[0]}: {name}")
    keys = [Line2D([], [], color=HUES[0], ls=style, label="; ".join(parts)) for style, parts in names.items()]
    keys += _threshold_keys(threshold, " of HS")
    place.legend(handles=keys, fontsize=8, frameon=False, loc="outside lower center", ncols=2)


def _models(
    rows: Rows,
    models: Sequence[str],
    group: Sequence[str],
    varies: str,
    places: Sequence[Axes],
    threshold: float | None,
) -> None:
    """Draw a panel for each measure of a ``group`` of the models; the last place has the legend."""
    given, looming = marks(models), looming_alone(rows)
    for axes, (column, heading) in zip(places, COMPARED, strict=False):
        shown = [model for model in group if column == "spikes" or model not in looming]  # those have no HS
        owned = [[row for row in rows if row["model"] == model] for model in shown]
        curves = [[summary.mean for summary in _summaries(model_rows, varies, column).values()] for model_rows in owned]
        largest = max((abs(value) for curve in curves for value in curve), default=1.0)
        for model_rows, mark, extra in zip(
            owned, map(given.__getitem__, shown), extra_widths(curves, 0.01 * largest), strict=True
        ):
            _curve(
                axes,
                model_rows,
                varies,
                column,
                mark.colour,
                "-",
                plain(model_rows[0]["model"]),
                1.1 + extra,
                mark.marker,
            )
        if column != "spikes":
            _threshold(axes, threshold)
        _frame(axes, rows, varies, heading)
    keys = [Line2D([], [], color=given[model].colour, marker=given[model].marker, lw=1.1, ms=3.0, label=plain(model))
            for model in group]  # fmt: skip
    keys += _threshold_keys(threshold, f" of {models[0]}")
    places[-1].set_axis_off()
    places[-1].legend(handles=keys, loc="center left", fontsize=8, frameon=False, handlelength=2.6)


def _curve(
    axes: Axes, rows: Rows, varies: str, column: str, tint: Any, style: Any, name: str, width: float = 1.4,
    marker: str = "o",
) -> None:  # fmt: skip
    """Means against the level, with their 95 % intervals; of few trials these themselves.

    An interval of what is never negative ends at 0.
    """
    summaries = _summaries(rows, varies, column)
    if not summaries:
        return
    levels, means = list(summaries), [summary.mean for summary in summaries.values()]
    axes.plot(levels, means, color=tint, ls=style, lw=width, marker=marker, ms=1.9 + width, label=name)
    if all(one.n < LEAST_FOR_BOOTSTRAP for one in summaries.values()):
        values = [(row[varies], row[column]) for row in rows if row[column] is not None]
        axes.plot(*zip(*values, strict=True), ".", color=tint, ms=3.0, alpha=0.5)
        return
    lowest = 0.0 if min(row[column] for row in rows if row[column] is not None) >= 0 else -math.inf
    ranges = {level: one for level, one in summaries.items() if one.n >= LEAST_FOR_BOOTSTRAP}
    axes.vlines(list(ranges), [max(one.ci_low, lowest) for one in ranges.values()],
                [one.ci_high for one in ranges.values()], color=tint, lw=1.0)  # fmt: skip


def _summaries(rows: Rows, varies: str, column: str) -> dict[float, Summary]:
    """The means of a column at each level where it has any value."""
    levels = sorted({row[varies] for row in rows if row[column] is not None})
    return {
        level: summarise([row[column] for row in rows if row[varies] == level and row[column] is not None])
        for level in levels
    }


def _labels(axes: Axes, levels: Sequence[float]) -> list[str]:
    """Return the numbers at the ``levels`` of an axis, without those that would touch another."""
    places = np.log(levels) if axes.get_xscale() == "log" else np.asarray(levels, float)
    inches = places / max(float(np.ptp(places)), 1e-9) * (PANEL_INCHES - 0.3)
    words = [f"{level:g}" for level in levels]
    kept = [len(levels) - 1]  # the last says how far the axis goes
    for place, word in enumerate(words[:-1]):
        if all(abs(inches[place] - inches[other]) > LETTER_INCHES * (len(word) + len(words[other]) + 1) / 2
               for other in kept):  # fmt: skip
            kept.append(place)
    return [word if place in kept else "" for place, word in enumerate(words)]


def _threshold(axes: Axes, threshold: float | None) -> None:
    if threshold is not None:
        axes.axhline(threshold, **THRESHOLD)


def _threshold_keys(threshold: float | None, whose: str) -> list[Line2D]:
    """Return the key of the dashed line, where there is one: panels are too narrow for its words."""
    return [] if threshold is None else [Line2D([], [], label=plain(f"threshold {threshold:g}{whose}"), **THRESHOLD)]


def _frame(axes: Axes, rows: Rows, varies: str, heading: str) -> None:
    levels = sorted({row[varies] for row in rows})
    if levels[0] > 0 and levels[-1] >= LOGARITHMIC_FROM * levels[0]:
        axes.set_xscale("log")
    axes.set_xticks(levels, _labels(axes, levels), fontsize=8)
    axes.set_xticks([], minor=True)
    axes.set_xlabel(wrapped(AXIS_LABELS[varies], PANEL_INCHES, 8), fontsize=8)
    axes.set_title(wrapped(heading, PANEL_INCHES, 8), fontsize=8, loc="left")
    axes.set_ylim(bottom=min(0.0, axes.get_ylim()[0]))
