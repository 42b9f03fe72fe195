"""Figures of off-line experiments in the paper's manner: potentials against frames, peaks against speed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import matplotlib as mpl
import numpy as np
import pyarrow as pa
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from experiments.bench.clips import edges_figure
from experiments.bench.clips.experiment import Figure as Drawing
from experiments.bench.core.figures.palette import colours
from experiments.bench.core.figures.plotting import STYLE, plain

Rows = Sequence[Mapping[str, Any]]
SYSTEMS = {"hs": ("HS", "-"), "vs": ("VS", ":")}
ACROSS = 4
NAMES = {"speed": "speed of the object ({unit})", "grey": "grey", "background_speed": "background ({unit})"}


def draw(drawing: Drawing, rows: Rows, frames: pa.Table, thresholds: Mapping[str, float | None]) -> Figure:
    """The figure of one seed's clips, as their experiment's ``figure`` says."""
    with mpl.rc_context(STYLE):
        if drawing.kind == "traces":
            return _traces(rows, frames, thresholds)
        if drawing.kind == "background":
            return _background(rows, thresholds)
        if drawing.kind == "edges":
            return edges_figure.draw(rows, frames, thresholds)
        if drawing.kind == "ranges":
            return _ranges(rows, thresholds)
        return _peaks(drawing, rows, thresholds)


def _traces(rows: Rows, frames: pa.Table, thresholds: Mapping[str, float | None]) -> Figure:
    """A panel for each clip: HS solid and VS dotted against the frame, one colour a model."""
    clips = list(dict.fromkeys(row["clip"] for row in rows))
    models = list(dict.fromkeys(row["model"] for row in rows))
    tints = colours(models)
    across = min(ACROSS, len(clips))
    down = -(-len(clips) // across)
    drawn = Figure(figsize=(2.1 * across + 0.6, 1.7 * down + 0.7), layout="constrained")
    panels = drawn.subplots(down, across, sharey=True, squeeze=False)
    trial, name = frames["trial"].to_numpy(), np.asarray(frames["model"])
    columns = {system: frames[system].to_numpy() for system in SYSTEMS}
    for axes, clip in zip(panels.flat, clips, strict=False):
        for row in (row for row in rows if row["clip"] == clip):
            own = (trial == row["trial"]) & (name == row["model"])
            for system, (_, style) in SYSTEMS.items():
                axes.plot(columns[system][own], ls=style, lw=1.1, color=tints[row["model"]])
        _limits(axes, thresholds, models)
        axes.set_title(plain(clip), fontsize=8)
    for axes in list(panels.flat)[len(clips) :]:
        axes.set_visible(False)
    for axes in panels[-1]:
        axes.set_xlabel("frame", fontsize=8)
    for axes in panels[:, 0]:
        axes.set_ylabel("SMP", fontsize=8)
    _legend(drawn, models, {said: style for said, style in SYSTEMS.values()})
    return drawn


def _peaks(shape: Drawing, rows: Rows, thresholds: Mapping[str, float | None]) -> Figure:
    """Largest |HS| and |VS| along one parameter: panels by another and by model, a line for each of a third."""
    shown = [row for row in rows if row["object"] != "absent"]
    names = {name: said.format(unit=shown[0]["speed_unit"]) for name, said in NAMES.items()}
    models = list(dict.fromkeys(row["model"] for row in shown))
    rowsof = sorted({row[shape.panels] for row in shown})
    lines = sorted({row[shape.lines] for row in shown})
    shades = mpl.colormaps["viridis"](np.linspace(0, 0.92, max(len(lines), 2)))
    drawn = Figure(figsize=(max(2.7 * len(models) + 0.8, 4.8), 2.2 * len(rowsof) + 0.6), layout="constrained")
    panels = drawn.subplots(len(rowsof), len(models), squeeze=False, sharex=True, sharey="row")
    for down, level in enumerate(rowsof):
        for place, model in enumerate(models):
            axes = panels[down, place]
            for value, shade in zip(lines, shades, strict=False):
                own = [r for r in shown if (r["model"], r[shape.panels], r[shape.lines]) == (model, level, value)]
                own.sort(key=lambda row: row[shape.along])
                for system, (_, style) in SYSTEMS.items():
                    peaks = [max(row[f"peak_{system}"], -row[f"trough_{system}"]) for row in own]
                    axes.plot([r[shape.along] for r in own], peaks, "o", ls=style, ms=3, lw=1, color=shade)
            _limits(axes, thresholds, [model])
            axes.set_title(plain(f"{model}, {names[shape.panels]} {level:g}"), fontsize=8)
    for axes in panels[:, 0]:
        axes.set_ylim(bottom=0.0)  # when all of its row is drawn: what is set before would hold for later panels
    for axes in panels[-1]:
        axes.set_xlabel(names[shape.along], fontsize=8)
    for axes in panels[:, 0]:
        axes.set_ylabel("largest |SMP|", fontsize=8)
    keys = [Line2D([], [], color=shade, marker="o", ms=3, label=f"{names[shape.lines]} {value:g}")
            for value, shade in zip(lines, shades, strict=False)]  # fmt: skip
    keys += [Line2D([], [], color="black", ls=style, label=said) for said, style in SYSTEMS.values()]
    drawn.legend(handles=keys, loc="outside upper center", ncols=3 if len(models) > 1 else 2, frameon=False, fontsize=7)
    return drawn


DEPTH = ("looming", "receding")
ALONE = "background alone"
PAPER_PX_FRAME = 8.0 / 30.0
"""The paper's background speed, as it is read here."""


def _background(rows: Rows, thresholds: Mapping[str, float | None]) -> Figure:
    """Largest |HS| and |VS| against the background's speed in px a frame: a column a model.

    The first row has the background alone, on a logarithmic axis; below are objects in depth, and translations of the
    darkest and of the lightest object with a line a speed, where there are such clips.
    """
    models = list(dict.fromkeys(row["model"] for row in rows))
    speeds = sorted({row["speed"] for row in _moving(rows)})
    shades = dict(zip(speeds, mpl.colormaps["viridis"](np.linspace(0, 0.92, max(len(speeds), 2))), strict=False))
    parts, ticks = _background_parts(rows, shades), sorted({_px_a_frame(row) for row in rows})
    drawn = Figure(figsize=(max(2.7 * len(models) + 0.8, 4.8), 2.2 * len(parts) + 0.8), layout="constrained")
    panels = drawn.subplots(len(parts), len(models), squeeze=False, sharex=True, sharey="row")
    for down, (title, lines) in enumerate(parts):
        for across, model in enumerate(models):
            axes = panels[down, across]
            for colour, series in lines:
                _against_background(axes, [row for row in series if row["model"] == model], colour)
            axes.axvline(PAPER_PX_FRAME, color="black", lw=0.6, ls="-.")
            axes.set_xscale("log")
            axes.set_xticks(ticks, [f"{tick:.2g}" for tick in ticks], fontsize=6)
            axes.set_xticks([], minor=True)
            axes.set_title(plain(f"{model}, {title}"), fontsize=8)
            for level in (t for t in (thresholds.get(model),) if t is not None):
                axes.axhline(level, color="black", ls="--", lw=0.7)
        if title == ALONE:
            panels[down, 0].set_yscale("log")
            panels[down, 0].set_ylim(1e-5, 1.5)
        else:
            panels[down, 0].set_ylim(bottom=0.0)
    for axes in panels[-1]:
        axes.set_xlabel("background (px a frame)", fontsize=8)
    for axes in panels[:, 0]:
        axes.set_ylabel("largest |SMP|", fontsize=8)
    keys = [Line2D([], [], color=shade, label=f"object {speed:g} px/s") for speed, shade in shades.items()]
    keys += [Line2D([], [], color="black", ls=style, label=said) for said, style in SYSTEMS.values()]
    keys += [Line2D([], [], color="black", ls="-.", lw=0.6, label="the paper's 8 px/s")]
    drawn.legend(handles=keys, loc="outside upper center", ncols=4, frameon=False, fontsize=7)
    return drawn


def _moving(rows: Rows) -> list[Mapping[str, Any]]:
    """Translations of an object."""
    return [row for row in rows if row["object"] != "absent" and row["motion"] not in DEPTH]


def _background_parts(rows: Rows, shades: Mapping[float, Any]) -> list[tuple[str, list[tuple[Any, Rows]]]]:
    """The rows of panels that there are clips for: a title, and a colour for each line's clips."""
    alone = [row for row in rows if row["object"] == "absent"]
    depth = [row for row in rows if row["object"] != "absent" and row["motion"] in DEPTH]
    moving = _moving(rows)
    greys = sorted({row["grey"] for row in moving})
    parts: list[tuple[str, list[tuple[Any, Rows]]]] = [(ALONE, [("black", alone)])] if alone else []
    if depth:
        parts.append(("in depth", [("black", depth)]))
    for grey in dict.fromkeys(greys[i] for i in (0, -1) if greys):
        own = [row for row in moving if row["grey"] == grey]
        lines: list[tuple[Any, Rows]] = [
            (shade, [row for row in own if row["speed"] == speed]) for speed, shade in shades.items()
        ]
        parts.append((f"object of grey {grey:g}", lines))
    return parts


def _against_background(axes: Axes, rows: Rows, colour: Any) -> None:
    """HS solid and VS dotted: at each speed of the background the largest of the clips there."""
    by_speed: dict[float, list[Mapping[str, Any]]] = {}
    for row in rows:
        by_speed.setdefault(_px_a_frame(row), []).append(row)
    speeds = sorted(by_speed)
    for system, (_, style) in SYSTEMS.items():
        peaks = [max(max(row[f"peak_{system}"], -row[f"trough_{system}"]) for row in by_speed[s]) for s in speeds]
        axes.plot(speeds, peaks, "o", ls=style, ms=2.5, lw=1, color=colour)


def _px_a_frame(row: Mapping[str, Any]) -> float:
    """How fast the background shifts, either way."""
    return float(abs(row["background_speed"]) / (row["fps"] if row["speed_unit"] == "px/s" else 1.0))


def _ranges(rows: Rows, thresholds: Mapping[str, float | None]) -> Figure:
    """A bar a model: from the smallest to the largest peak |HS| of translations; below it that without an object."""
    models = list(dict.fromkeys(row["model"] for row in rows))
    drawn = Figure(figsize=(6.4, 0.9 + 0.28 * len(models)), layout="constrained")
    axes = drawn.subplots()
    kinds = (("an object crosses", _moving(rows), "tab:blue", -0.16),
             ("background alone", [row for row in rows if row["object"] == "absent"], "tab:gray", 0.2))  # fmt: skip
    for said, shown, tint, lower in kinds:
        for place, model in enumerate(models):
            peaks = [max(row["peak_hs"], -row["trough_hs"]) for row in shown if row["model"] == model]
            if peaks:
                axes.plot([min(peaks), max(peaks)], [place + lower] * 2, "-|", color=tint, lw=4, ms=9,
                          label=said if place == 0 else None)  # fmt: skip
    axes.set_yticks(range(len(models)), [plain(model) for model in models], fontsize=7)
    axes.invert_yaxis()
    for level in sorted({t for m in models if (t := thresholds.get(m)) is not None}):
        axes.axvline(level, color="black", ls="--", lw=0.7, label=f"T = {level:g}")
    axes.set_xlabel("largest |HS| of a clip: smallest to largest", fontsize=8)
    drawn.legend(loc="outside upper center", ncols=3, frameon=False, fontsize=7)
    return drawn


def _limits(axes: Axes, thresholds: Mapping[str, float | None], models: Sequence[str]) -> None:
    """The thresholds, dashed."""
    for level in sorted({t for m in models if (t := thresholds.get(m)) is not None}):
        for sign in (1, -1):
            axes.axhline(sign * level, color="black", ls="--", lw=0.7)


def _legend(drawn: Figure, models: Sequence[str], systems: Mapping[str, str]) -> None:
    keys = [Line2D([], [], color=tint, lw=2, label=plain(model)) for model, tint in colours(models).items()]
    keys += [Line2D([], [], color="black", ls=style, label=said) for said, style in systems.items()]
    drawn.legend(handles=keys, loc="outside upper center", ncols=len(keys), frameon=False, fontsize=8)
