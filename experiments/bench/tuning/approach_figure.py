"""Curves of approaches: potential, spikes and time to contact at the first spike against l / v, a row for each line."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, NullFormatter, NullLocator

from dsnn.stimuli.looming import Looming
from experiments.bench.figures.palette import marks
from experiments.bench.figures.plotting import WIDTH, extra_widths, key_below, log_ticks, lowest, plain, wrapped
from experiments.bench.tuning.curves import TuningPoint
from experiments.bench.tuning.probes import Family

MEASURES: Mapping[str, Callable[[TuningPoint], float | None]] = {
    "peak potential above rest": lambda a: a.response,
    "spikes": lambda a: float(a.spikes),
    "time to contact at the first spike (s)": lambda a: a.contact_s,
}
"""Measures drawn against l / v."""
ANGLES_DEG = (10.0, 20.0, 60.0)
"""Full angles, whose time to contact is drawn for comparison."""
LABEL_INCHES = 1.7
"""Length of the label of a measure's axis."""
ANGLE: dict[str, Any] = {"color": "0.6", "lw": 0.7, "ls": ":"}
"""Look of the line of an angle."""


def draw(family: Family, given: Sequence[TuningPoint], channels: Mapping[str, Sequence[str]]) -> Figure:
    """Return a row for each line, a panel for each measure, a curve for each model with a looming potential.

    What never comes near has no time to contact, and no panel of it.
    """
    models = [model for model in channels if family.shown_to(channels[model])]
    tints = marks(models)
    places = sorted({probe.x for probe in family.probes})
    drawn = Figure(figsize=(WIDTH, 2.1 * len(family.lines) + 1.2), layout="constrained")
    panels = drawn.subplots(len(family.lines), len(MEASURES), sharex=True, sharey="col", squeeze=False)
    for row, line in zip(panels, family.lines, strict=True):
        row[-1].set_visible(_nears(family, line))
        for axes, (name, value) in zip(row, MEASURES.items(), strict=True):
            if not axes.get_visible():
                continue
            curves = [_curve(given, model, line, value) for model in models]
            heights = [[y for _, y in curve] for curve in curves]
            alike = 0.01 * max((abs(y) for height in heights for y in height), default=0.0)
            for model, curve, more in zip(models, curves, extra_widths(heights, alike), strict=True):
                if not curve:  # a line without points that is not clipped has no size, and the layout needs one
                    continue
                mark = tints[model]
                axes.plot([x for x, _ in curve], [y for _, y in curve], marker=mark.marker, ms=4 + more, lw=1.2 + more,
                          color=mark.colour, clip_on=False, zorder=3)  # fmt: skip
            axes.set_title(line, fontsize=8, loc="left")
            axes.set_ylabel(wrapped(name, LABEL_INCHES, 8), fontsize=8)
            if name.startswith("time"):
                _angles(axes, places, _most_deg(family))
                if not any(heights):
                    axes.text(0.5, 0.5, "no spike before contact", transform=axes.transAxes, ha="center", fontsize=8,
                              bbox={"fc": "white", "lw": 0, "pad": 1.0})  # fmt: skip
    for axes, name in zip(panels[0], MEASURES, strict=True):
        # From 0, or potentials that differ in the fourth place would fill the panel. It ends autoscaling of all rows.
        if not name.startswith("time"):
            axes.set_ylim(bottom=0.0)
        elif axes.get_visible():
            axes.yaxis.set_minor_formatter(NullFormatter())
            ticks = log_ticks(*axes.get_ylim())
            axes.set_yticks(ticks, [f"{tick:g}" for tick in ticks])
    for axes in lowest([[axes for axes in row if axes.get_visible()] for row in panels]):
        axes.tick_params(labelbottom=True)
        axes.set_xscale("log")
        axes.xaxis.set_minor_locator(NullLocator())
        axes.set_xticks(places)
        axes.xaxis.set_major_formatter(FuncFormatter(lambda x, _: f"{x:g}"))
        axes.set_xlabel(family.x.label)
    keys = [
        Line2D([], [], color=tints[model].colour, marker=tints[model].marker, ms=4, lw=1.2,
               label=plain(model))
        for model in models
    ]  # fmt: skip
    key_below(drawn, [*keys, Line2D([], [], label="the object spans that angle", **ANGLE)], 5)
    return drawn


def _curve(
    given: Sequence[TuningPoint], model: str, line: str, value: Callable[[TuningPoint], float | None]
) -> list[tuple[float, float]]:
    """Return a model's points (l / v, value) along one line; those without a value are left out."""
    points = sorted((a for a in given if (a.model, a.line) == (model, line)), key=lambda a: a.x)
    return [(a.x, values) for a in points if (values := value(a)) is not None]


def _nears(family: Family, line: str) -> bool:
    """Tell whether the object of a line comes nearer, so that there is a time to contact."""
    clips = [probe.clip.build(0) for probe in family.probes if probe.line == line]
    return any(isinstance(clip, Looming) and bool(np.isfinite(clip.contact_s()).any()) for clip in clips)


def _most_deg(family: Family) -> float:
    """Return the angle at which the objects of a family stop, where one is declared; otherwise that at contact."""
    return float(max(dict(probe.clip.changes).get("end_deg", 180.0) for probe in family.probes))


def _angles(axes: Axes, places: Sequence[float], most_deg: float) -> None:
    """Mark fixed angles up to ``most_deg``: what fires at one does so at a time to contact in proportion to l / v."""
    axes.set_yscale("log")
    for angle in (angle for angle in ANGLES_DEG if angle <= most_deg):
        times = [place / math.tan(math.radians(angle / 2)) for place in places]
        axes.plot(places, times, zorder=1, **ANGLE)
        axes.annotate(f"{angle:g}°", (places[-1], times[-1]), fontsize=8, color="0.4", ha="left", va="center")
