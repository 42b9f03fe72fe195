"""The figure of a run, in the manner of the paper's Figure 13: spikes per condition, every repeat visible."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import matplotlib as mpl
import numpy as np
import pyarrow as pa
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from experiments.bench.core.plotting import COLOURS, LINES, STYLE, plain
from experiments.bench.core.statistics import summarise
from experiments.bench.core.store.rows import group
from experiments.bench.robot.plan import Plan
from experiments.bench.robot.rows import varying

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
MOST_NAMED = 4
"""Models that a title names."""
LEGEND: dict[str, Any] = {"frameon": False, "loc": "lower center", "bbox_to_anchor": (0.5, 0.99)}


def draw(rows: Rows, frames: pa.Table, plan: Plan) -> Figure:
    """`figure` of a run: its first model's traces, every model's counts."""
    settings, varies = plan.settings, plan.experiment.varies
    models, blind = [model.label for model in settings.models], settings.robot.open_loop
    said = title(plan.experiment.name, models, settings.scene.arena, plan.repeats, open_loop=blind)
    return figure(rows, frames, varies, said, settings.models[0].threshold)


def title(name: str, models: Sequence[str], arena: str, repeats: int, *, open_loop: bool = False) -> str:
    """Return the title of a run's figure."""
    shown = ", ".join(models) if len(models) <= MOST_NAMED else f"{models[0]} and {len(models) - 1} others"
    return f"{name}: {shown}, {arena} arena{', driven open loop' if open_loop else ''}, n = {repeats}"


def figure(rows: Rows, frames: pa.Table, varies: str, title: str, threshold: float | None) -> Figure:
    """Left: spikes of every trial, with means and 95 % intervals. Right: HS against bearing, or against time.

    A bearing is left positive, here as in the tables; its axis has the left on the left, as the image has.
    One colour per level of ``varies``; one line style for each combination of the conditions that differ beside it.
    """
    with mpl.rc_context(STYLE):
        drawn = Figure(figsize=(8.4, 3.6), layout="constrained")
        counts, traces = drawn.subplots(1, 2, width_ratios=[1, 1.25])
        levels = list(dict.fromkeys(row[varies] for row in rows))
        if not isinstance(levels[0], str):
            levels.sort()
        colours = _colours(levels)
        series = _series(rows, varies)
        axis = _trace_axis(rows)
        for place, (label, chosen) in enumerate(series.items()):
            style = LINES[place % len(LINES)]
            _counts(counts, chosen, varies, colours, _place(place, len(series)), style, label)
            shown = [row for row in chosen if row["model"] == rows[0]["model"]]
            _traces(traces, shown, frames, varies, colours, style, axis)
        if len(series) > 1:
            counts.legend(fontsize=7, handlelength=3, **LEGEND, ncols=2)
        counts.set_xticks(range(len(levels)), [_said(level) for level in levels])
        counts.set(xlabel=AXIS_LABELS[varies], ylabel="spikes per trial", ylim=(-2, None))
        _frame(traces, colours, UNITS.get(varies, ""), threshold, axis)
        drawn.suptitle(plain(title), fontsize=10, x=0.01, ha="left")
    return drawn


def _said(level: Any) -> str:
    return level if isinstance(level, str) else f"{level:g}"


def _trace_axis(rows: Rows) -> str:
    """Bearing where the stimulus crosses the view and the observer stands; else time."""
    crossing = all(row["motion"] == "translation" for row in rows)
    still = not any(row["observer_speed_cm_s"] or row["observer_turn_deg_s"] for row in rows)
    return "stimulus_bearing_deg" if crossing and still else "sim_time_s"


def _colours(levels: Sequence[Any]) -> dict[Any, Any]:
    """A colour for each level, none twice."""
    if len(levels) <= len(COLOURS):
        return dict(zip(levels, COLOURS, strict=False))
    return dict(zip(levels, mpl.colormaps["viridis"](np.linspace(0, 0.92, len(levels))), strict=True))


def _series(rows: Rows, varies: str) -> dict[str, Rows]:
    """Label -> its rows, for every combination of model and other conditions that differ between trials."""
    others = [name for name in varying(rows, varies) if name != varies]
    return {
        plain(
            ", ".join(
                f"{v:g} {UNITS[c]}" if c in UNITS and v is not None else str(v)
                for c, v in zip(others, values, strict=True)
            )
        ): chosen
        for values, chosen in group(rows, *others).items()
    }


def _place(index: int, count: int) -> float:
    """Offset of the dots of series ``index`` of ``count`` from their tick."""
    return 0.0 if count == 1 else min(0.6, 0.3 * (count - 1)) * (index / (count - 1) - 0.5)


def _counts(
    axes: Axes, rows: Rows, varies: str, colours: Mapping[Any, Any], shift: float, style: Any, label: str
) -> None:
    means: dict[float, float] = {}
    for tick, (level, colour) in enumerate(colours.items()):
        spikes = [row["spikes"] for row in rows if row[varies] == level]
        if not spikes:
            continue
        place = tick + shift
        wobble = np.linspace(-0.06, 0.06, len(spikes)) if len(spikes) > 1 else np.zeros(1)
        axes.scatter(place + wobble, spikes, s=11, color=colour, alpha=0.65, linewidths=0, zorder=3)
        summary = summarise(spikes)
        means[place + 0.12] = summary.mean
        if summary.n > 1:
            error = [[summary.mean - summary.ci_low], [summary.ci_high - summary.mean]]
            axes.errorbar(place + 0.12, summary.mean, yerr=error, fmt="_", color="black", capsize=3, lw=1.2, zorder=4)
    axes.plot(list(means), list(means.values()), color="black", lw=0.9, ls=style, label=label, zorder=2)


def _traces(
    axes: Axes, rows: Rows, frames: pa.Table, varies: str, colours: Mapping[Any, Any], style: Any, axis: str
) -> None:
    if not rows:
        return
    own = frames.filter(np.asarray(frames["model"]) == rows[0]["model"])
    trial, hs, place = (own[name].to_numpy() for name in ("trial", "hs", axis))
    for row in rows:
        chosen = trial == row["trial"]
        axes.plot(place[chosen], hs[chosen], color=colours[row[varies]], ls=style, lw=0.6, alpha=0.6)


def _columns(labels: Sequence[Any]) -> int:
    """How many columns of a legend fit above the traces."""
    return max(1, min(6, 44 // (6 + max(len(str(label)) for label in labels))))


def _frame(axes: Axes, colours: Mapping[Any, Any], unit: str, threshold: float | None, axis: str) -> None:
    """Thresholds, labels and the colours' legend about the traces."""
    if threshold is not None:
        for sign in (1, -1):
            axes.axhline(sign * threshold, color="black", ls="--", lw=0.8)
        axes.annotate(f"±T = {threshold:g}", (0.01, -threshold - 0.02), xycoords=("axes fraction", "data"), va="top")
    bearing = axis == "stimulus_bearing_deg"
    xlabel = "bearing of the stimulus (degrees, left positive)" if bearing else "time in the trial (s)"
    axes.set(xlabel=xlabel, ylabel="HS membrane potential", ylim=(-1, 1))
    axes.xaxis.set_inverted(bearing)  # left on the left, as in the image: rightward motion goes to the right
    keys = [
        Line2D([], [], color=colour, lw=2, label=f"{_said(level)} {unit}".strip()) for level, colour in colours.items()
    ]
    axes.legend(handles=keys, columnspacing=1.2, **LEGEND, ncols=_columns([key.get_label() for key in keys]))
