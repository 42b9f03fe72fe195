"""The figure of why counts go with speed or distance as they do: count, time in view, firing rate, potential."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from experiments.bench.core.figures.palette import HUES, LINES, marks
from experiments.bench.core.figures.plotting import STYLE, plain
from experiments.bench.core.statistics import summarise
from experiments.bench.robot.figure import AXIS_LABELS, title
from experiments.bench.robot.mechanism.windows import NEAR_AXIS_CM
from experiments.bench.robot.plan import Plan
from experiments.bench.robot.rows import caption

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
"""What all models are compared by: column, title of the panel."""

LOGARITHMIC_FROM = 5.0
"""Ratio of the largest to the smallest level from which the axis is logarithmic."""


def draw(rows: Rows, plan: Plan) -> Figure:
    """`figure` of a run."""
    settings, labels = plan.settings, [model.label for model in plan.settings.models]
    blind = settings.robot.open_loop
    name, arena, repeats = caption(plan.experiment.name, settings.scene.arena, plan.repeats, rows)
    said = title(name, labels, arena, repeats, open_loop=blind)
    return figure(rows, plan.experiment.varies, said, settings.models[0].threshold)


def figure(rows: Rows, varies: str, said: str, threshold: float | None) -> Figure:
    """Draw the mechanism of a run of crossings.

    Parameters
    ----------
    rows
        Of ``trials.parquet``. Every point is a mean over trials with its 95 % interval.
    varies
        The column along the axes, a number.
    said
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
        drawn = Figure(figsize=(11.0, 6.2 if len(models) > 1 else 3.2), layout="constrained")
        parts = drawn.subfigures(2, 1, squeeze=False)[:, 0] if len(models) > 1 else [drawn]
        _first_model([row for row in rows if row["model"] == models[0]], varies, parts[0].subplots(1, 4), threshold)
        if len(models) > 1:
            _every_model(rows, models, varies, parts[1].subplots(1, 4), threshold)
        drawn.suptitle(plain(said), fontsize=10, x=0.01, ha="left")
    return drawn


def _first_model(rows: Rows, varies: str, places: Sequence[Axes], threshold: float | None) -> None:
    for axes, (heading, columns) in zip(places, PANELS, strict=True):
        shown = [each for each in columns if each[0] != "spikes_in_window" or varies == "speed_cm_s"]
        for style, (column, name) in zip(LINES, shown, strict=False):
            _curve(axes, rows, varies, column, HUES[0], style, name)
        if heading.startswith("HS"):
            _threshold(axes, threshold)
        _frame(axes, rows, varies, heading)
        if len(shown) > 1:
            axes.legend(fontsize=7, frameon=False, handlelength=2.4)


def _every_model(
    rows: Rows, models: Sequence[str], varies: str, places: Sequence[Axes], threshold: float | None
) -> None:
    """A panel for each measure; the last place has the legend."""
    given = marks(models)
    for axes, (column, heading) in zip(places, COMPARED, strict=False):
        for index, model in enumerate(models):
            own = [row for row in rows if row["model"] == model]
            mark = given[model]
            _curve(
                axes, own, varies, column, mark.colour, mark.line, plain(model), 2.2 if index == 0 else 1.1, mark.marker
            )
        if column != "spikes":
            _threshold(axes, threshold)
        _frame(axes, rows, varies, heading)
    handles, labels = places[0].get_legend_handles_labels()
    places[-1].set_axis_off()
    places[-1].legend(handles, labels, loc="center left", fontsize=8, frameon=False, handlelength=2.6)


def _curve(
    axes: Axes, rows: Rows, varies: str, column: str, tint: Any, style: Any, name: str, width: float = 1.4,
    marker: str = "o",
) -> None:  # fmt: skip
    """Means against the level, with their 95 % intervals where there are any."""
    levels = sorted({row[varies] for row in rows if row[column] is not None})
    if not levels:
        return
    found = [summarise([row[column] for row in rows if row[varies] == level and row[column] is not None])
             for level in levels]  # fmt: skip
    means = [summary.mean for summary in found]
    axes.plot(levels, means, color=tint, ls=style, lw=width, marker=marker, ms=3, label=name)
    ranges = [(summary.ci_low, summary.ci_high) if summary.n > 1 else (summary.mean,) * 2 for summary in found]
    axes.vlines(levels, [low for low, _ in ranges], [high for _, high in ranges], color=tint, lw=1.0)


def _threshold(axes: Axes, threshold: float | None) -> None:
    if threshold is not None:
        axes.axhline(threshold, color="black", ls="--", lw=0.8)
        axes.annotate(f"T = {threshold:g}", (0.99, threshold), xycoords=("axes fraction", "data"), va="bottom",
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
