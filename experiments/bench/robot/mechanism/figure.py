"""The figure of why counts go with speed or distance as they do: count, time in view, firing rate, potential."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from experiments.bench.figures.palette import HUES, LINES, marks
from experiments.bench.figures.plotting import STYLE, extra_widths, headline, plain
from experiments.bench.judging.statistics import Summary, summarise
from experiments.bench.robot.figure import AXIS_LABELS
from experiments.bench.robot.mechanism.windows import NEAR_AXIS_CM

Rows = Sequence[Mapping[str, Any]]

PANELS: tuple[tuple[str, tuple[tuple[str, str], ...]], ...] = (
    ("spikes per trial", (("spikes", "whole crossing"), ("spikes_in_window", "one window for all"))),
    ("time in view (s)", (("seconds_in_view", ""),)),
    ("firing rate in view (Hz)", (("rate_in_view_hz", ""),)),
    (
        "HS membrane potential",
        (("peak_hs", "peak"), ("mean_hs_near_axis", f"mean within {NEAR_AXIS_CM:g} cm of the axis")),
    ),
)
"""Title of a panel of the first model, and what it shows: column, and its name where there are several."""

COMPARED = (
    ("mean_hs_near_axis", f"mean HS within {NEAR_AXIS_CM:g} cm of the axis"), ("peak_hs", "peak HS"),
    ("spikes", "spikes per trial"),
)  # fmt: skip
"""Columns that all models are compared by: column, title of the panel."""

KEY_INCHES = 0.17
"""Height of a model's line in the key."""
LOGARITHMIC_FROM = 5.0
"""Ratio of the largest to the smallest level from which the axis is logarithmic."""


def figure(rows: Rows, varies: str, heading: str, threshold: float | None) -> Figure:
    """Draw the mechanism of a run of crossings.

    Parameters
    ----------
    rows
        Of ``trials.parquet``. Every point is a mean over trials with its 95 % interval.
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
        models: potential and spikes of each.
    """
    models = list(dict.fromkeys(row["model"] for row in rows))
    with mpl.rc_context(STYLE):
        lower = max(3.0, 0.3 + KEY_INCHES * len(models)) if len(models) > 1 else 0.0
        drawn = Figure(figsize=(11.0, 3.2 + lower), layout="constrained")
        parts = drawn.subfigures(2, 1, squeeze=False, height_ratios=[3.2, lower])[:, 0] if lower else [drawn]
        _first_model([row for row in rows if row["model"] == models[0]], varies, parts[0].subplots(1, 4), threshold)
        if len(models) > 1:
            _every_model(rows, models, varies, parts[1].subplots(1, 4), threshold)
        headline(drawn, heading)
    return drawn


def _first_model(rows: Rows, varies: str, places: Sequence[Axes], threshold: float | None) -> None:
    for axes, (heading, columns) in zip(places, PANELS, strict=True):
        columns_shown = [column for column in columns if column[0] != "spikes_in_window" or varies == "speed_cm_s"]
        for style, (column, name) in zip(LINES, columns_shown, strict=False):
            _curve(axes, rows, varies, column, HUES[0], style, name)
        if heading.startswith("HS"):
            _threshold(axes, threshold)
        _frame(axes, rows, varies, heading)
        if len(columns_shown) > 1:
            axes.legend(fontsize=7, frameon=False, handlelength=2.4)


def _every_model(
    rows: Rows, models: Sequence[str], varies: str, places: Sequence[Axes], threshold: float | None
) -> None:
    """A panel for each measure; the last place has the legend."""
    given = marks(models)
    for axes, (column, heading) in zip(places, COMPARED, strict=False):
        owned = [[row for row in rows if row["model"] == model] for model in models]
        curves = [[summary.mean for summary in _summaries(model_rows, varies, column).values()] for model_rows in owned]
        largest = max((abs(value) for curve in curves for value in curve), default=1.0)
        for model_rows, mark, extra in zip(owned, given.values(), extra_widths(curves, 0.01 * largest), strict=True):
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
            _threshold(axes, threshold, f" of {models[0]}")
        _frame(axes, rows, varies, heading)
    handles, labels = places[0].get_legend_handles_labels()
    places[-1].set_axis_off()
    places[-1].legend(handles, labels, loc="center left", fontsize=7, frameon=False, handlelength=2.6)


def _curve(
    axes: Axes, rows: Rows, varies: str, column: str, tint: Any, style: Any, name: str, width: float = 1.4,
    marker: str = "o",
) -> None:  # fmt: skip
    """Means against the level, with their 95 % intervals where there are any."""
    summaries = _summaries(rows, varies, column)
    if not summaries:
        return
    levels, means = list(summaries), [summary.mean for summary in summaries.values()]
    axes.plot(levels, means, color=tint, ls=style, lw=width, marker=marker, ms=1.9 + width, label=name)
    ranges = [(one.ci_low, one.ci_high) if one.n > 1 else (one.mean,) * 2 for one in summaries.values()]
    axes.vlines(levels, [low for low, _ in ranges], [high for _, high in ranges], color=tint, lw=1.0)


def _summaries(rows: Rows, varies: str, column: str) -> dict[float, Summary]:
    """The means of a column at each level where it has any value."""
    levels = sorted({row[varies] for row in rows if row[column] is not None})
    return {
        level: summarise([row[column] for row in rows if row[varies] == level and row[column] is not None])
        for level in levels
    }


def _threshold(axes: Axes, threshold: float | None, whose: str = "") -> None:
    if threshold is not None:
        axes.axhline(threshold, color="black", ls="--", lw=0.8)
        caption = plain(f"T = {threshold:g}{whose}")
        axes.annotate(caption, (0.99, threshold), xycoords=("axes fraction", "data"), va="bottom",
                      ha="right", fontsize=7)  # fmt: skip


def _frame(axes: Axes, rows: Rows, varies: str, heading: str) -> None:
    levels = sorted({row[varies] for row in rows})
    if levels[0] > 0 and levels[-1] >= LOGARITHMIC_FROM * levels[0]:
        axes.set_xscale("log")
    axes.set_xticks(levels, [f"{level:g}" for level in levels], fontsize=7)
    axes.set_xticks([], minor=True)
    axes.set_xlabel(AXIS_LABELS[varies], fontsize=8)
    axes.set_title(heading, fontsize=9, loc="left")
    axes.set_ylim(bottom=min(0.0, axes.get_ylim()[0]))
