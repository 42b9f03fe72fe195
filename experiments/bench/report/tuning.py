"""Tuning curves as figures, a panel for each model, and as a table on the terminal."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import matplotlib as mpl
import numpy as np
import polars as pl
from matplotlib.axes import Axes
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator, NullLocator

from experiments.bench.report import style, terminal
from experiments.bench.run.parameters import in_title
from experiments.bench.stats import curves
from experiments.bench.stats.curves import CurveAxis

Row = Mapping[str, Any]
"""A model's preferences: `experiments.bench.tune.preferences`."""
ACROSS = 4
HEIGHTS = {"curve": 1.8, "map": 1.8, "polar": 2.0, "approach": 1.5}
"""Kind of a figure -> the height of its panels with their titles, inches."""
CAPTIONS = {
    "curve": "Dots: one clip each, in the model's own unit.",
    "map": "One clip a cell. Circles: peaks of columns. Slope of best temporal over spatial frequency: 1 for speed.",
    "polar": "Directions as in the image; radius: share of the largest. Filled: to gratings at one phase of five (HS"
    " black, VS dotted). Squares: to the object. DSI: 1 one direction alone, 0.79 a cosine, 0 all alike.",
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
    per_model = len(MEASURES) if kind == "approach" else 1
    across = per_model if per_model > 1 else min(ACROSS, len(rows))
    down = math.ceil(len(rows) * per_model / across)
    height = min(HEIGHTS[kind] * (1.4 if len(rows) == 1 else 1.0), (style.PAGE - 0.8) / down)
    with style.look():
        figure = Figure((min(style.WIDTH, 4.4 * across), height * down + 0.8), layout="constrained")
        looks = {"projection": "polar"} if kind == "polar" else {}
        flat = style.grid(figure, len(rows) * per_model, across, sharex=per_model > 1, subplot_kw=looks)
        panels = [flat[first : first + per_model] for first in range(0, len(flat), per_model)]
        inches = figure.get_figwidth() / (across if per_model == 1 else 1) - 0.55
        for group, row in zip(panels, rows, strict=True):
            own = points.filter(pl.col("model") == row["model"], pl.col("repeat") == 0).sort("x", maintain_order=True)
            finding = KINDS[kind](group, own, row, x)
            title = style.wrapped(f"{row['model']}: {finding}", inches, style.BODY)
            middle = group[per_model // 2]  # the layout makes room for the middle of a title
            middle.set_title(title, loc="left" if per_model == 1 else "center", fontweight="bold")
        for axes in flat[-across:]:
            axes.set_xlabel("" if kind == "polar" else style.wrapped(x.label, inches / per_model))
        if y:
            scale = mpl.cm.ScalarMappable(mpl.colors.Normalize(-1, 1), style.DIVERGING)
            figure.colorbar(scale, ax=flat, aspect=30, shrink=0.6).set_label("response (share of largest)")
        figure.supylabel(y.label if y else "response" if kind == "curve" else "", fontsize=style.BODY)
        style.caption(figure, f"{family.summary}{in_title(changed)}. {CAPTIONS[kind]}")
    return figure


def peak_finding(x: Sequence[float], responses: Sequence[float], axis: CurveAxis) -> str:
    """Say where a response is largest, or that no value of x can be called preferred."""
    best = curves.preferred(x, responses)
    if best is None:
        return "no response" if np.abs(responses).max(initial=0.0) <= curves.NOTHING else "no response along the motion"
    text = curves.range_text(x, best)
    if text == "flat":
        return "all responses are alike"
    if curves.undefined_peak(responses):
        return f"no preferred {axis.noun}"
    return f"largest response at {text} {axis.unit}".strip()


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
    if own["line"].n_unique() > 1 and axes is axes.figure.axes[0]:
        style.label_ends(axes, ends)


def _curve(group: Any, own: pl.DataFrame, row: Row, x: CurveAxis) -> str:
    """Draw the response along x; return the finding, that of the first line where lines differ."""
    _lines(group[0], own, "response")
    group[0].axhline(0.0, color=style.GREY, lw=0.5)
    lines = own.partition_by("line", maintain_order=True)
    findings = [peak_finding(line["x"].to_list(), line["response"].to_list(), x) for line in lines]
    return findings[0] if len(set(findings)) == 1 else f"{findings[0]} ({own['line'][0]})"


def _map(group: Any, own: pl.DataFrame, row: Row, x: CurveAxis) -> str:
    """Draw a heat map of responses with the best of each column; return where the largest is."""
    places, rates, responses = curves.grid(own)
    largest = max(np.nanmax(np.abs(responses)), curves.NOTHING)
    group[0].imshow(responses / largest, origin="lower", aspect="auto", cmap=style.DIVERGING, vmin=-1, vmax=1)
    group[0].set_xticks(range(0, len(places), 2), [f"1/{1 / place:.0f}" for place in places[::2]])
    group[0].set_yticks(range(0, len(rates), 3), [f"{rate:g}" for rate in rates[::3]])
    if row["temporal_hz"] is None:
        return (
            "no peak, neighbours are no more alike than by chance"
            if "temporal_hz: " in row["not_defined"]
            else "no response"
        )
    best = np.interp(np.log(curves.best_rows(rates, responses)), np.log(rates), range(len(rates)))
    group[0].plot(best, "o", ms=3.5, mfc="white", mec="black", mew=0.8)
    rate, wave = (f"{row[name]} {unit}" for name, unit in (("temporal_hz", "Hz"), ("wavelength_px", "px")))
    slope = "" if row["slope"] is None else f", slope {row['slope']:z.2f}"
    return f"largest at {rate}, {wave}{slope}".replace("flat Hz", "any frequency").replace("flat px", "any wavelength")


def _polar(group: Any, own: pl.DataFrame, row: Row, x: CurveAxis) -> str:
    """Draw the lobes of a response, and of HS and VS; return the preferred direction."""
    axes, is_grating = group[0], pl.col("line") == "grating"
    gratings, objects = own.filter(is_grating), own.filter(~is_grating)
    directional = row["vs_dsi"] is not None
    around, shown = (
        np.radians([*gratings["x"], *gratings["x"][:1]]),
        ("response", "hs", "vs")[: 3 if directional else 1],
    )
    lobes = np.maximum(gratings.select(shown).to_numpy(), 0.0)
    shares = np.vstack([lobes, lobes[:1]]) / lobes.max(initial=curves.NOTHING)
    axes.fill(around, shares[:, 0], fc=to_rgba(style.HUES[0], 0.15), ec=style.HUES[0], lw=1.3)
    for share, look in zip(shares.T[1:], ("-", ":"), strict=False):
        axes.plot(around, share, look, color="black", lw=0.9)
    heights = objects["response"].to_numpy()
    object_shares = np.maximum(heights, 0.0) / heights.max(initial=curves.NOTHING)
    axes.plot(np.radians(objects["x"]), object_shares, "s", ms=4, mfc="white", mec=style.HUES[1], clip_on=False)
    axes.set_xticks(np.arange(4) * np.pi / 2, [""] * 4)
    axes.set(theta_direction=-1, ylim=(0, 1), yticks=[0.5], yticklabels=[""])
    if row["dsi"] is None:
        return "preferred direction not defined" if "dsi: " in row["not_defined"] else "no response"
    if row["dsi"] < curves.SOME_DSI:
        return f"no preferred direction, DSI {row['dsi']:.2f}"
    return f"{'HS ' * directional}prefers {round(row['prefers_deg']) % 360}°, DSI {row['dsi']:.2f}"


def _approach(group: Any, own: pl.DataFrame, row: Row, x: CurveAxis) -> str:
    """Draw potential, spikes and the angle at the first spike against l / v; return what the model responds to."""
    angle = 2 * (pl.col("x") / pl.col("contact_s")).arctan().degrees()
    for axes, (column, label) in zip(group, MEASURES.items(), strict=True):
        _lines(axes, own.with_columns(angle_deg=angle), column)
        axes.set_ylabel(label)
    if "disc" in own["curve"]:
        peak, spikes = (f"{row[f'looming_by_{name}'] or 0.0:.0%}" for name in ("potential", "spikes"))
        return f"looming beats receding and crossing at {peak} of l / v by the peak, at {spikes} by spikes"
    fires = "no spike before contact" if row["fires_deg"] is None else f"first spike at {row['fires_deg']:.0f}°"
    return f"{fires} of dark looming"


KINDS = {"curve": _curve, "map": _map, "polar": _polar, "approach": _approach}


def show(preferences: Sequence[Row]) -> None:
    """Print what each model prefers, a row a model, and why something is not defined."""
    cells = pl.DataFrame([{name: _cell(row, name) for name in row if not name.endswith(ENDS)} for row in preferences])
    cells = cells.select(pl.col(name) for name in cells.columns if set(cells[name]) != {"-"})
    terminal.show(cells)
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
