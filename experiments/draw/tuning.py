"""Tuning curves as figures, one for each curve, and on the terminal a line for each model."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

import matplotlib as mpl
import numpy as np
import polars as pl
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from dsnn import MODELS
from experiments.base import console, palette
from experiments.draw import style
from experiments.judge import curves

Row = Mapping[str, Any]
"""A model's preferences: `experiments.kinds.tuning.preferences`."""
ACROSS = 4
HEIGHT = 1.8
"""Height of a panel with its title, inches."""
LABELS = {
    "speed_px_s": "speed (px/s)", "size_px": "size (px)", "contrast": "contrast",
    "cycles_px": "spatial frequency (cycles/px)", "temporal_hz": "temporal frequency (Hz)",
    "direction_deg": "direction of motion (degrees)", "l_over_v_s": "l / v (s)",
}  # fmt: skip
"""Column of an axis -> what it is called."""
OBJECTS, GRATINGS = "Dots: one clip each, in the model's own unit.", "Dots: one grating each; 0 rightward, 90 downward."
APPROACHES = "Dots: one clip each. l / v: half the object's size over its speed. Angle: the full one it spans."
CAPTIONS = {
    "speed": ("A dark square of 24 px, rightward", OBJECTS),
    "size": ("A dark square, rightward at 120 px/s", OBJECTS),
    "contrast": ("A square of 24 px at 120 px/s on grey 127; a grating of wavelength 24 px at 2 Hz", OBJECTS),
    "frequency": ("Drifting sine gratings, rightward", "One clip a cell."),
    "direction": ("A grating of 24 px at 2 Hz in 16 directions; a dark square of 24 px at 120 px/s in 4", GRATINGS),
    "l-over-v": ("A square that looms at the centre, through the robot's lens", APPROACHES),
    "disc": ("A disc that grows from 8 to 40 degrees, shrinks, or crosses at 40", APPROACHES),
}
"""Curve -> what is shown, and what the symbols mean."""
MEASURES = {"response": "peak above rest", "spikes": "spikes", "angle_deg": "first spike at (°)"}
"""What is drawn of approaches."""
ENDS = ("not_defined", "_low", "_high", "_inside")
"""Ends of the names of columns of ``preferences.csv`` that are not printed."""
NOTE = "≥, ≤: up to an end of what was shown. flat: alike everywhere. Blank: not shown, or not defined."


def draw(points: pl.DataFrame, along: Sequence[str], changed: Row) -> Figure:
    """Draw a curve, or a map over two axes: a panel for each model, of approaches a row of panels.

    Parameters
    ----------
    points
        Of one curve (`curves.points_schema`).
    along
        The columns of its axes.
    changed
        Parameters that are not at their defaults, by key and model; the caption names them.
    """
    (shown, symbols), approach = CAPTIONS[points["curve"][0]], "l_over_v_s" in along
    x, *y = (LABELS[name] for name in along)
    models = sorted(style.levels(points, "model"), key=MODELS.__contains__)  # one's own come first
    columns = tuple(MEASURES) if approach else ("response",)
    across = len(columns) if approach else min(ACROSS, len(models))
    down = math.ceil(len(models) * len(columns) / across)
    height = min(HEIGHT * (1.4 if len(models) == 1 else 1.0), (style.PAGE - 0.8) / down)
    angle = 2 * (pl.col("x") / pl.col("contact_s")).arctan().degrees()
    with style.look():
        figure = Figure((min(style.WIDTH, 4.4 * across), height * down + 0.8), layout="constrained")
        panels = style.grid(figure, len(models) * len(columns), across, sharex=approach)
        inches = figure.get_figwidth() / across - 0.55
        for place, model in enumerate(models):
            own = points.filter(pl.col("repeat") == 0, model=model).sort("x", maintain_order=True)
            if "direction_deg" in along:
                own = own.filter(line="grating")
            if "direction_deg" in along and (own["vs"] != 0.0).any():
                both = own.select("x", "contact_s", "hs", "vs")
                own = both.unpivot(["hs", "vs"], index=["x", "contact_s"], variable_name="line", value_name="response")
            group = panels[place * len(columns) :][: len(columns)]
            label = y[0] if y else "response"
            for axes, column in zip(group, columns, strict=True):
                _map(axes, own) if y else _lines(axes, own.with_columns(angle_deg=angle), column)
                axes.set_ylabel(MEASURES[column] if approach else "" if place % across else label)
            group[0].set_title(style.wrapped(model, inches, style.BODY), fontweight="bold")
        for axes in panels[-across:]:
            axes.set_xlabel(style.wrapped(x, inches))
        if y:
            scale = mpl.cm.ScalarMappable(mpl.colors.Normalize(-1, 1), palette.SIGNED)
            figure.colorbar(scale, ax=panels, aspect=30, shrink=0.6).set_label("response (share of largest)")
        style.headline(figure, f"Response by {' and '.join(label.partition(' (')[0] for label in (x, *y))}")
        style.legend(figure, panels[:1])
        style.caption(figure, f"{shown}{style.in_title(changed)}.", symbols)
    return figure


def _lines(axes: Axes, own: pl.DataFrame, column: str) -> None:
    """Draw a column of each line of points against x."""
    places = own["x"].unique().sort().to_list()
    several = own["line"].n_unique() > 1
    tints: dict[str, str] = palette.of_others(own["line"]) if several else {own["line"][0]: palette.INK}
    for line, tint in (tints | dict(palette.CHANNELS)).items():
        part = own.filter(pl.col("line") == line).drop_nulls(column)
        if len(part):
            wider = 1.2 * (own["line"].n_unique() - len(axes.lines))  # than the lines above it, which may lie on it
            axes.plot(part["x"], part[column], "-o", lw=wider, ms=wider + 1.0, color=tint, clip_on=False, zorder=3,
                      label=palette.TITLES.get(line, line))  # fmt: skip
    if places[0] > 0 and places[-1] >= 4 * places[0]:
        axes.set_xscale("log")
        ticks = [digit * 10.0**power for power in range(-4, 4) for digit in (1, 3)]
        places = [tick for tick in ticks if places[0] <= tick <= places[-1]]
    style.plain_numbers(axes, places[:: math.ceil(len(places) / 5)])
    axes.yaxis.set_major_locator(MaxNLocator(3))
    axes.axhline(0.0, color=palette.GREY, lw=0.5)


def _map(axes: Axes, own: pl.DataFrame) -> None:
    """Draw a map of responses."""
    places, rates, responses = curves.grid(own)
    largest = max(np.nanmax(np.abs(responses)), curves.NOTHING)
    axes.imshow(responses / largest, origin="lower", aspect="auto", cmap=palette.SIGNED, vmin=-1, vmax=1)
    axes.set_xticks(range(0, len(places), 2), [f"1/{1 / place:.0f}" for place in places[::2]])
    axes.set_yticks(range(0, len(rates), 3), [f"{rate:g}" for rate in rates[::3]])


def show(table: pl.DataFrame) -> None:
    """Print what each model prefers, a row a model, and why something is not defined."""
    prefers = pl.when(pl.col("dsi").cast(pl.Float64) >= curves.SOME_DSI).then("prefers_deg").alias("prefers_deg")
    names = [name for name in table.columns if not name.endswith(ENDS) and table[name].count()]
    console.show(table.with_columns(prefers).select(names).with_columns(pl.selectors.float().round(2)))
    console.out_console.print(NOTE)
    for model, why in table.filter(pl.col("not_defined") != "").select("model", "not_defined").rows():
        console.out_console.print(f"{model}: not defined: {why}")
