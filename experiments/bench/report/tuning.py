"""Tuning curves as figures, one for each family of clips, and on the terminal a line for each model."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import matplotlib as mpl
import numpy as np
import polars as pl
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator, NullLocator

from experiments.bench.report import style, terminal
from experiments.bench.run.parameters import in_title
from experiments.bench.stats import curves
from experiments.bench.stats.curves import CurveAxis

Row = Mapping[str, Any]
"""A model's preferences: `experiments.bench.tune.preferences`."""
ACROSS = 4
HEIGHT = 1.8
"""Height of a panel with its title, inches."""
CAPTIONS = {
    "curve": "Dots: one clip each, in the model's own unit.",
    "map": "One clip a cell. Circles: peaks of columns. Slope of best temporal over spatial frequency: 1 for speed.",
    "direction": "Dots: one grating each; 0 rightward, 90 downward. DSI: 1 one direction, 0.79 a cosine, 0 all alike.",
    "approach": "Dots: one clip each. l / v: half the object's size over its speed. Angle: the full one it spans.",
}
"""Kind of a figure -> n, and what its symbols mean."""
MEASURES = {"response": "peak above rest", "spikes": "spikes", "angle_deg": "first spike at (°)"}
"""What is drawn of approaches."""
ENDS = ("not_defined", "_low", "_high", "_inside")
"""Ends of the names of columns of ``preferences.csv`` that are not printed."""
NOTE = "≥, ≤: up to an end of what was shown. flat: alike everywhere. n.d.: not defined. See docs/how-to/.\n"


def draw(family: Any, points: pl.DataFrame, preferences: Sequence[Row], changed: Row) -> Figure:
    """Draw the curves of one family: a panel for each model, of approaches a row of panels.

    Parameters
    ----------
    family
        An `experiments.bench.tune.Family`.
    points
        Of this family (`curves.points_schema`).
    preferences
        Of each model.
    changed
        Parameters that are not at their defaults, by key and model; the caption names them.
    """
    kind, x, y = family.kind, family.x, family.y
    rows = [row for row in preferences if row["model"] in points["model"]]
    columns = tuple(MEASURES) if kind == "approach" else ("response",)
    across = len(columns) if kind == "approach" else min(ACROSS, len(rows))
    down = math.ceil(len(rows) * len(columns) / across)
    height = min(HEIGHT * (1.4 if len(rows) == 1 else 1.0), (style.PAGE - 0.8) / down)
    angle = 2 * (pl.col("x") / pl.col("contact_s")).arctan().degrees()
    with style.look():
        figure = Figure((min(style.WIDTH, 4.4 * across), height * down + 0.8), layout="constrained")
        panels = style.grid(figure, len(rows) * len(columns), across, sharex=kind == "approach")
        inches = figure.get_figwidth() / across - 0.55
        for place, row in enumerate(rows):
            own = points.filter(pl.col("model") == row["model"], pl.col("repeat") == 0).sort("x", maintain_order=True)
            if kind == "direction":
                own = own.filter(line="grating")
            if kind == "direction" and row["vs_dsi"] is not None:
                both = own.select("x", "contact_s", "hs", "vs")
                own = both.unpivot(["hs", "vs"], index=["x", "contact_s"], variable_name="line", value_name="response")
            group = panels[place * len(columns) :][: len(columns)]
            for axes, column in zip(group, columns, strict=True):
                _map(axes, own, row) if y else _lines(axes, own.with_columns(angle_deg=angle), column)
                axes.set_ylabel(MEASURES[column] if kind == "approach" else "")
            title = f"{row['model']}: {finding(kind, own, row, x)}"
            middle = group[len(group) // 2]  # the layout makes room for the middle of a title
            middle.set_title(style.wrapped(title, inches * len(group), style.BODY), fontweight="bold",
                             loc="left" if len(group) == 1 else "center")  # fmt: skip
        for axes in panels[-across:]:
            axes.set_xlabel(style.wrapped(x.label, inches))
        if y:
            scale = mpl.cm.ScalarMappable(mpl.colors.Normalize(-1, 1), style.DIVERGING)
            figure.colorbar(scale, ax=panels, aspect=30, shrink=0.6).set_label("response (share of largest)")
        figure.supylabel(y.label if y else "" if kind == "approach" else "response", fontsize=style.BODY)
        style.caption(figure, f"{family.summary}{in_title(changed)}. {CAPTIONS[kind]}")
    return figure


def finding(kind: str, own: pl.DataFrame, row: Row, axis: CurveAxis) -> str:
    """Say what a model prefers along a curve, or that nothing can be called preferred."""
    if kind == "approach" and "disc" in own["curve"]:
        peak, spikes = (f"{row[f'looming_by_{name}'] or 0.0:.0%}" for name in ("potential", "spikes"))
        return f"looming beats receding and crossing at {peak} of l / v by the peak, at {spikes} by spikes"
    if kind == "approach":
        fires = "no spike before contact" if row["fires_deg"] is None else f"first spike at {row['fires_deg']:.0f}°"
        return f"{fires} of dark looming"
    if kind == "direction":
        if row["dsi"] is None:
            return "preferred direction not defined" if "dsi: " in row["not_defined"] else "no response"
        prefers = f"prefers {round(row['prefers_deg']) % 360}°" if row["dsi"] >= curves.SOME_DSI else "no preference"
        return f"{prefers}, DSI {row['dsi']:.2f}"
    if kind == "map":
        if row["temporal_hz"] is None:
            return "no peak" if "temporal_hz: " in row["not_defined"] else "no response"
        if row["temporal_hz"] == row["wavelength_px"] == "flat":
            return "all responses are alike"
        slope = "" if row["slope"] is None else f", slope {row['slope']:z.2f}"
        return f"largest at {row['temporal_hz']} Hz, {row['wavelength_px']} px{slope}"
    first = own.filter(line=own["line"][0])
    best = curves.preferred(first["x"], first["response"])
    text = best and curves.range_text(first["x"], best)
    if not text:
        return "no response along the motion"
    if text != "flat" and curves.undefined_peak(first["response"]):
        return f"no preferred {axis.noun}"
    return "all responses are alike" if text == "flat" else f"largest response at {text} {axis.unit}".strip()


def _lines(axes: Axes, own: pl.DataFrame, column: str) -> None:
    """Draw a column of each line of points against x; label the lines in the first panel of a figure."""
    places = own["x"].unique().sort().to_list()
    ends: list[tuple[float, float, str, str]] = []
    for line, tint in style.colours(own["line"]).items():
        part = own.filter(pl.col("line") == line).drop_nulls(column)
        if len(part):
            wider = 1.2 * (own["line"].n_unique() - len(ends))  # than the lines above it, which may lie on it
            axes.plot(part["x"], part[column], "-o", lw=wider, ms=wider + 1.0, color=tint, clip_on=False, zorder=3)
            ends.append((part["x"][-1], part[column][-1], line, tint))
    if places[0] > 0 and places[-1] >= 4 * places[0]:
        axes.set_xscale("log")
        axes.xaxis.set_minor_locator(NullLocator())
    ticks = places[:: math.ceil(len(places) / 4)]
    axes.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
    axes.yaxis.set_major_locator(MaxNLocator(3))
    heights = np.nan_to_num(own[column].to_numpy())
    axes.set_ylim(1.05 * min(heights.min(), 0.0), 1.05 * max(heights.max(), 0.0) or 1.0)
    axes.axhline(0.0, color=style.GREY, lw=0.5)
    if own["line"].n_unique() > 1 and axes is axes.figure.axes[0]:
        style.label_ends(axes, ends)


def _map(axes: Axes, own: pl.DataFrame, row: Row) -> None:
    """Draw a map of responses with the best of each column."""
    places, rates, responses = curves.grid(own)
    largest = max(np.nanmax(np.abs(responses)), curves.NOTHING)
    axes.imshow(responses / largest, origin="lower", aspect="auto", cmap=style.DIVERGING, vmin=-1, vmax=1)
    axes.set_xticks(range(0, len(places), 2), [f"1/{1 / place:.0f}" for place in places[::2]])
    axes.set_yticks(range(0, len(rates), 3), [f"{rate:g}" for rate in rates[::3]])
    if row["temporal_hz"] is not None:
        best = np.interp(np.log(curves.best_rows(rates, responses)), np.log(rates), range(len(rates)))
        axes.plot(best, "o", ms=3.5, mfc="white", mec="black", mew=0.8)


def show(preferences: Sequence[Row]) -> None:
    """Print what each model prefers, a row a model, and why something is not defined."""
    cells = pl.DataFrame([{name: _cell(row, name) for name in row if not name.endswith(ENDS)} for row in preferences])
    terminal.show(cells.select(pl.col(name) for name in cells.columns if set(cells[name]) != {"-"}))
    terminal.show_line(NOTE)
    for row in preferences:
        if row["not_defined"]:
            terminal.show_line(f"{row['model']}: not defined: {row['not_defined']}", 4)


def _cell(row: Row, name: str) -> str:
    """Return a preference as the table has it: no direction of a model that prefers none."""
    value = row[name]
    if f"{name}: " in row["not_defined"]:
        return "n.d."
    if value is None or (name == "prefers_deg" and row["dsi"] < curves.SOME_DSI):
        return "-"
    return value if isinstance(value, str) else f"{value:z.2f}"
