"""The figure of a run, in the manner of the paper's Figure 13: spikes per condition, every repeat visible."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import matplotlib as mpl
import numpy as np
import pyarrow as pa
from matplotlib.axes import Axes
from matplotlib.figure import Figure, SubFigure
from matplotlib.lines import Line2D

from experiments.bench.figures.palette import LINES, Mark, level_colours, marks
from experiments.bench.figures.plotting import STYLE, columns_of_key, headline, plain, wrapped
from experiments.bench.judging.statistics import LEAST_FOR_BOOTSTRAP, summarise
from experiments.bench.robot.rows import is_tracked, varying
from experiments.bench.store.parameters import in_title
from experiments.bench.store.rows import group

Rows = Sequence[Mapping[str, Any]]

AXIS_LABELS = {
    "speed_cm_s": "speed of the stimulus (cm/s)",
    "distance_cm": "distance camera to path (cm)",
    "far_cm": "distance camera to the far end (cm)",
    "angle_deg": "angle to the optical axis (degrees, right positive)",
    "shell_grey": "reflectance of the stimulus's shell",
    "wall_contrast": "contrast of the wall against the arena's own",
    "observer_speed_cm_s": "observer driving (cm/s)",
    "observer_turn_deg_s": "observer turning (degrees/s, left positive)",
    "acceleration_cm_s2": "acceleration of the stimulus (cm/s2)",
    "motion": "motion of the stimulus",
    "direction": "direction in the image",
}
UNITS = {
    "speed_cm_s": "cm/s",
    "distance_cm": "cm",
    "far_cm": "cm far",
    "angle_deg": "°",
    "shell_grey": "grey",
    "wall_contrast": "of wall",
    "observer_speed_cm_s": "cm/s own",
    "observer_turn_deg_s": "°/s own",
    "acceleration_cm_s2": "cm/s2",
}
COUNTS_INCHES = 4.0
"""Width of the panel of counts."""
MOST_NAMED = 4
"""Models that a title names."""
ACROSS = 4
"""Most panels of traces in a row."""
MOST_DOTTED = 4
"""Series beyond which single trials are left out of the panel of counts: means and intervals stay readable."""
FILLS: Sequence[Any] = ("full", "none", "left", "top", "right", "bottom")
"""Fillings of markers, of conditions: as words have no line between them, line styles would not tell them apart."""
SPREAD, NARROW = 0.62, 0.34
"""Width of all series at one level, as a share of the smallest gap between levels: of words, and of numbers."""
NEAR = 0.08
"""The largest such width on an axis of numbers, as a share of the axis."""


@dataclass(frozen=True, slots=True)
class Series:
    """The trials of one line of the panel of counts: of one model, under one combination of the other conditions.

    Parameters
    ----------
    label
        What tells it apart from the others.
    rows
        Its trials.
    mark
        Its model's.
    condition
        Number of the combination of its other conditions: it has a line style and a filling of the marker.
    """

    label: str
    rows: Rows
    mark: Mark
    condition: int


def title(
    name: str, models: Sequence[str], arena: str, repeats: int | str, changed: Mapping[str, Any], open_loop: bool
) -> str:
    """Return the title of a run's figure, with the parameters that were ``changed``. An empty ``arena`` is left out."""
    names = ", ".join(models) if len(models) <= MOST_NAMED else f"{models[0]} and {len(models) - 1} others"
    where, driven = f", {arena} arena" if arena else "", ", driven open loop" if open_loop else ""
    return f"{name}: {names}{where}{driven}, n = {repeats}{in_title(changed)}"


def figure(rows: Rows, frames: pa.Table, varies: str, title: str, thresholds: Mapping[str, float | None]) -> Figure:
    """Draw the counts of every trial, and the potential over each, a panel for each model.

    A bearing is left positive, here as in the tables; its axis has the left on the left, as the image has.

    Parameters
    ----------
    rows
        Of ``trials.parquet``.
    frames
        Of ``frames.parquet``.
    varies
        The column along the axis of the counts. An axis of numbers has their scale; words have no line between them.
    title
        Title of the figure.
    thresholds
        Each model's spiking threshold; ``None``: it does not spike.

    Returns
    -------
    matplotlib.figure.Figure
        Left: counts with means and 95 % intervals. With one model the colours are those of the levels, as on the
        right; with several, those of the models. Right: the HS potential of each model (of looming detectors theirs),
        coloured by level.
    """
    models = list(dict.fromkeys(row["model"] for row in rows))
    levels = list(dict.fromkeys(row[varies] for row in rows))
    if not isinstance(levels[0], str):
        levels.sort()
    colours = level_colours(levels)
    across = 1 if len(models) == 1 else 2 if len(models) <= 4 else ACROSS
    down = math.ceil(len(models) / across)
    with mpl.rc_context(STYLE):
        drawn = Figure(figsize=(4.4 + (4.4 if across == 1 else 3.1 * across), max(3.7, 2.4 * down + 0.9)),
                       layout="constrained")  # fmt: skip
        headline(drawn, title)
        left, right = drawn.subfigures(  # type: ignore[misc]  # two of them, as NumPy has them
            1, 2, width_ratios=[4.0, 4.8 if across == 1 else 3.1 * across]
        )
        counting = {row["model"] for row in rows if row["spikes"] is not None}
        silent = [model for model in models if thresholds.get(model, 0.0) is None or model not in counting]
        _counts(left, [row for row in rows if row["model"] not in silent], varies, levels,
                colours if len(models) == 1 else None, models, silent)  # fmt: skip
        panels = right.subplots(down, across, squeeze=False, sharex=True, sharey=True)
        axis = _trace_axis(rows)
        for axes, model in zip(panels.flat, models, strict=False):
            model_rows = [row for row in rows if row["model"] == model]
            _traces(axes, model_rows, frames, varies, colours, axis)
            _threshold(axes, thresholds.get(model), (1,) if _looming(model_rows[0]) else (1, -1))
            if len(models) > 1:
                axes.set_title(plain(model), fontsize=9, loc="left")
        for axes in list(panels.flat)[len(models) :]:
            axes.set_visible(False)
        looming = [_looming(next(row for row in rows if row["model"] == model)) for model in models]
        _frame(right, panels[0, 0], axis, "" if any(looming) else " of HS")
        _level_keys(right, colours, UNITS.get(varies, ""), _others(rows, varies, models))
    return drawn


def said(level: Any) -> str:
    """Return a level as axes and keys show it."""
    return level if isinstance(level, str) else f"{level:g}"


def _trace_axis(rows: Rows) -> str:
    """Bearing where the stimulus crosses the view, the observer stands and poses are known; else time."""
    crossing = all(row["motion"] == "translation" for row in rows)
    still = not any(row["observer_speed_cm_s"] or row["observer_turn_deg_s"] for row in rows)
    return "stimulus_bearing_deg" if crossing and still and all(is_tracked(row) for row in rows) else "sim_time_s"


def _conditions(rows: Rows, varies: str) -> list[str]:
    """The columns beside ``varies`` and the model that tell conditions apart."""
    return [name for name in varying(rows, varies) if name not in (varies, "model")]


def _condition(row: Mapping[str, Any], names: Sequence[str]) -> str:
    values = [(name, row[name]) for name in names]
    return plain(", ".join(f"{v:g} {UNITS[n]}" if n in UNITS and v is not None else str(v) for n, v in values))


def _others(rows: Rows, varies: str, models: Sequence[str]) -> dict[str, Any]:
    """Label -> line style of each combination of the other conditions, in the traces; none where there is one."""
    names = _conditions(rows, varies)
    first_rows = [row for row in rows if row["model"] == models[0]]
    labels = list(dict.fromkeys(_condition(row, names) for row in first_rows))
    return {label: LINES[i % len(LINES)] for i, label in enumerate(labels)} if len(labels) > 1 else {}


def _series(rows: Rows, varies: str, models: Sequence[str]) -> list[Series]:
    """A series for every model and combination of the other conditions: colours tell ``models``, lines the others."""
    names, model_marks, several = _conditions(rows, varies), marks(models), len({row["model"] for row in rows}) > 1
    series = []
    for (model,), chosen in group(rows, "model").items():
        parts = list(group(chosen, *names).values()) if names else [chosen]
        for place, part in enumerate(parts):
            words = [*([plain(model)] if several else []), *([_condition(part[0], names)] if names else [])]
            style = model_marks[model]
            series.append(Series(", ".join(words), part, style, place))
    return series


def _counts(
    place: SubFigure, rows: Rows, varies: str, levels: Sequence[Any], colours: Mapping[Any, str] | None,
    models: Sequence[str], silent: Sequence[str],
) -> None:  # fmt: skip
    """Spikes of every trial with means and intervals; ``colours`` of the levels where there is one model.

    Models that do not spike, ``silent``, are named instead of being drawn at 0.
    """
    axes, series = place.subplots(), _series(rows, varies, models)
    ordinal = isinstance(levels[0], str)
    ticks = {level: float(i) if ordinal else float(level) for i, level in enumerate(levels)}
    gaps = [b - a for a, b in zip(list(ticks.values()), list(ticks.values())[1:], strict=False)]
    width = SPREAD if ordinal else min(NARROW * min(gaps), NEAR * sum(gaps)) if gaps else 1.0
    for index, one_series in enumerate(series):
        shift = 0.0 if len(series) == 1 else width * (index / (len(series) - 1) - 0.5)
        step = width / len(series)
        means = []
        for level, tick in ticks.items():
            spikes = [row["spikes"] for row in one_series.rows if row[varies] == level]
            if spikes:
                tint = colours[level] if colours else one_series.mark.colour
                means.append(
                    (tick + shift, _level(axes, spikes, tick + shift, step, tint, one_series.mark, len(series)))
                )
        style = "none" if ordinal else LINES[one_series.condition % len(LINES)]
        line = "black" if colours else one_series.mark.colour
        axes.plot(*zip(*means, strict=True), color=line, lw=0.9, ls=style, label=one_series.label, zorder=2,
                  marker=one_series.mark.marker if len(series) > 1 else None, ms=4,
                  fillstyle=FILLS[one_series.condition % len(FILLS)])  # fmt: skip
    axes.set_xticks(list(ticks.values()), [said(level) for level in levels], fontsize=7 if len(levels) > 6 else 9)
    axes.set(xlabel=AXIS_LABELS[varies], ylabel="spikes per trial")
    axes.set_ylim(bottom=min(-2.0, -0.04 * axes.get_ylim()[1]))
    if len(series) > 1:
        columns = columns_of_key([sery.label for sery in series], COUNTS_INCHES, 7)
        place.legend(fontsize=7, handlelength=3, frameon=False, loc="outside upper center", ncols=min(columns, 3))
    if silent:
        left_out = f"not drawn, as without spikes: {', '.join(silent)}"
        axes.set_title(plain(wrapped(left_out, COUNTS_INCHES, 7)), fontsize=7, loc="left")


def _level(
    axes: Axes, spikes: Sequence[float], place: float, step: float, tint: str, mark: Mark, several: int
) -> float:
    """Draw the trials of one series at one level; return their mean.

    Fewer than `LEAST_FOR_BOOTSTRAP` trials stand for themselves. No interval of a count goes below 0.
    """
    if several <= MOST_DOTTED:
        beside = place - np.linspace(0.2, 0.55, len(spikes)) * step  # left of the mean, so that neither hides the other
        axes.scatter(beside, spikes, s=11, color=tint, alpha=0.55, linewidths=0, marker=mark.marker, zorder=3)
    summary = summarise(spikes)
    if summary.n >= LEAST_FOR_BOOTSTRAP:
        error = [[summary.mean - max(summary.ci_low, 0.0)], [summary.ci_high - summary.mean]]
        edge = "black" if several == 1 else tint
        axes.errorbar(place, summary.mean, yerr=error, fmt="_", color=edge, capsize=2.5, lw=1.2, zorder=4)
    return summary.mean


def _traces(axes: Axes, rows: Rows, frames: pa.Table, varies: str, colours: Mapping[Any, str], axis: str) -> None:
    """The potential of one model over each of its trials."""
    model_frames = frames.filter(np.asarray(frames["model"]) == rows[0]["model"])
    looming = _looming(rows[0])
    names, styles = _conditions(rows, varies), _others(rows, varies, [rows[0]["model"]])
    trial, potential, place = (
        model_frames[name].to_numpy() for name in ("trial", "looming" if looming else "hs", axis)
    )
    for row in rows:
        chosen = trial == row["trial"]
        style = styles.get(_condition(row, names), "-")
        axes.plot(place[chosen], potential[chosen], color=colours[row[varies]], ls=style, lw=0.6, alpha=0.6)
    if looming:
        axes.annotate("of the looming detector", (0.99, 0.02), xycoords="axes fraction", ha="right", fontsize=7)


def _looming(row: Mapping[str, Any]) -> bool:
    """Tell whether a trial's model answers by a looming potential alone: a channel that is not declared is 0
    throughout.
    """
    return row["hs_spikes"] is None and bool(row["peak_looming"]) and not (row["peak_hs"] or row["trough_hs"])


def _threshold(axes: Axes, threshold: float | None, signs: Sequence[int]) -> None:
    """The threshold as dashed lines: of either sign for HS, the positive one for looming."""
    if threshold is None:
        return
    for sign in signs:
        axes.axhline(sign * threshold, color="black", ls="--", lw=0.8)
    text, lowest = f"{'±' if len(signs) > 1 else ''}T = {threshold:g}", min(signs) * threshold
    axes.annotate(text, (0.01, lowest - 0.02), xycoords=("axes fraction", "data"), va="top", fontsize=7)


def _frame(place: SubFigure, axes: Axes, axis: str, of: str) -> None:
    """Draw what all panels of traces have in common; ``of`` says whose potential all of them show."""
    bearing = axis == "stimulus_bearing_deg"
    xlabel = "bearing of the stimulus (degrees, left positive)" if bearing else "time in the trial (s)"
    axes.set_ylim(-1.02, 1.02)
    axes.xaxis.set_inverted(bearing)  # left on the left, as in the image: rightward motion goes to the right
    place.supxlabel(xlabel, fontsize=9)
    place.supylabel(f"membrane potential{of}", fontsize=9)


def _level_keys(place: SubFigure, colours: Mapping[Any, str], unit: str, others: Mapping[str, Any]) -> None:
    """Draw the key of the colours and the line styles of the traces."""
    keys = [Line2D([], [], color=tint, lw=2, label=f"{said(level)} {unit}".strip()) for level, tint in colours.items()]
    keys += [Line2D([], [], color="black", lw=0.8, ls=style, label=label) for label, style in others.items()]
    longest = max(len(str(key.get_label())) for key in keys)
    place.legend(handles=keys, columnspacing=1.2, frameon=False, loc="outside upper center", fontsize=7,
                 ncols=max(1, min(6, 60 // (6 + longest))))  # fmt: skip
