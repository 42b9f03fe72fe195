"""Curves of approaches: potential, spikes and time to contact at the first spike against l / v, a row for each line."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, NullFormatter, NullLocator

from experiments.bench.figures.palette import marks
from experiments.bench.figures.plotting import WIDTH, extra_widths, key_below, plain, wrapped
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


def draw(family: Family, given: Sequence[TuningPoint], channels: Mapping[str, Sequence[str]]) -> Figure:
    """Return a row for each line, a panel for each measure, a curve for each model with a looming potential."""
    models = [model for model in channels if family.shown_to(channels[model])]
    tints = marks(models)
    places = sorted({probe.x for probe in family.probes})
    drawn = Figure(figsize=(WIDTH, 2.1 * len(family.lines) + 1.2), layout="constrained")
    panels = drawn.subplots(len(family.lines), len(MEASURES), sharex=True, sharey="col", squeeze=False)
    for row, line in zip(panels, family.lines, strict=True):
        for axes, (name, value) in zip(row, MEASURES.items(), strict=True):
            curves = [_curve(given, model, line, value) for model in models]
            heights = [[y for _, y in curve] for curve in curves]
            alike = 0.01 * max((abs(y) for height in heights for y in height), default=0.0)
            for model, curve, more in zip(models, curves, extra_widths(heights, alike), strict=True):
                mark = tints[model]
                axes.plot([x for x, _ in curve], [y for _, y in curve], marker=mark.marker, ms=4 + more, lw=1.2 + more,
                          color=mark.colour)  # fmt: skip
            axes.set_title(wrapped(f"{line}: {name}", 1.9, 8), fontsize=8, loc="left")
            if name.startswith("time"):
                _angles(axes, places)
                if not any(heights):
                    axes.text(0.5, 0.5, "no spike before contact", transform=axes.transAxes, ha="center", fontsize=8)
    for axes, name in zip(panels[0], MEASURES, strict=True):
        # From 0, or potentials that differ in the fourth place would fill the panel. It ends autoscaling of all rows.
        if not name.startswith("time"):
            axes.set_ylim(bottom=0.0)
    for axes in panels[-1]:
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
    key_below(drawn, keys, 5)
    return drawn


def _curve(
    given: Sequence[TuningPoint], model: str, line: str, value: Callable[[TuningPoint], float | None]
) -> list[tuple[float, float]]:
    """Return a model's points (l / v, value) along one line; those without a value are left out."""
    points = sorted((a for a in given if (a.model, a.line) == (model, line)), key=lambda a: a.x)
    return [(a.x, values) for a in points if (values := value(a)) is not None]


def _angles(axes: Axes, places: Sequence[float]) -> None:
    """Mark fixed angles: what fires at one does so at a time to contact in proportion to l / v."""
    axes.set_yscale("log")
    axes.yaxis.set_minor_formatter(NullFormatter())
    axes.yaxis.set_major_formatter(FuncFormatter(lambda y, _: f"{y:g}"))
    for angle in ANGLES_DEG:
        times = [place / math.tan(math.radians(angle / 2)) for place in places]
        axes.plot(places, times, color="0.6", lw=0.7, ls=":", zorder=1)
        axes.annotate(f"{angle:g}°", (places[-1], times[-1]), fontsize=8, color="0.4", ha="left", va="center")
