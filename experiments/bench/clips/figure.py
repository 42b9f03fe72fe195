"""Figures of off-line experiments in the paper's manner: potentials against frames, peaks against speed."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

import matplotlib as mpl
import numpy as np
import pyarrow as pa
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from experiments.bench.clips import edges_figure
from experiments.bench.clips import panels as model_panels
from experiments.bench.clips import thresholds as threshold_lines
from experiments.bench.clips.panels import ModelPanels
from experiments.bench.figures.palette import LEVELS as LEVEL_SHADES
from experiments.bench.figures.palette import Mark, lanes, level_colours, marks
from experiments.bench.figures.plotting import (
    STYLE,
    WIDTH,
    extra_widths,
    grid_of_panels,
    headline,
    key_below,
    lowest,
    plain,
    wrapped,
)
from experiments.bench.sources.clips import Figure as Drawing
from experiments.bench.store.parameters import in_title
from experiments.bench.store.rows import looming_alone

Rows = Sequence[Mapping[str, Any]]
SYSTEMS = {"hs": ("HS", "-"), "vs": ("VS", ":")}
LEVELS = {"speed": "object", "grey": "grey", "background_speed": "background"}
ACROSS, MANY_ACROSS = 3, 6
"""Most panels of clips side by side: of up to `MANY` models, and of more."""
MANY = 9
PANEL_INCHES = 2.0
"""Width of the title of one of `ACROSS` panels."""
BLOCKS_AROUND = 1.2
"""Height of what stands above and below blocks of panels, inches."""
TRACES_HIGH, TWO_KEYS = 2.6, 2.0
"""Height of the traces above the peaks of contrasts, and of the titles and keys of all, inches."""
TRACES_OF_ROWS = 1.8
"""Height of the traces above rows, inches."""
SAME = 0.004
"""Difference of two potentials that look like one."""
THRESHOLD: dict[str, Any] = {"color": "black", "ls": "-", "lw": 1.2}
"""Look of the threshold in the row of its model."""
NAMES = {
    "speed": "speed of the object ({unit})",
    "grey": "grey of the object (0 to 255)",
    "background_speed": "background speed ({unit})",
}


def title(name: str, seed: int, changed: Mapping[str, Any]) -> str:
    """Return the title of a run's figure: of experiment ``name``, with the parameters that were ``changed``."""
    return f"{name}, seed {seed}{in_title(changed)}"


def draw(drawing: Drawing, rows: Rows, frames: pa.Table, thresholds: Mapping[str, float | None], title: str) -> Figure:
    """Draw the clips of one seed, as their experiment's ``figure`` says.

    Models that answer by looming alone are named and left out, as all is about HS and VS, where there are others.

    Parameters
    ----------
    drawing
        The kind of figure.
    rows, frames
        Of ``trials.parquet``, of one seed, and of ``frames.parquet``.
    thresholds
        Each model's spiking threshold; ``None``: it does not spike.
    title
        Of the figure.
    """
    looming = looming_alone(rows)
    directional = [row for row in rows if row["model"] not in looming]
    if looming and directional:
        left_out = dict.fromkeys(row["model"] for row in rows if row["model"] in looming)
        rows, title = directional, f"{title}\nwithout HS and VS, so not drawn: {', '.join(left_out)}"
        thresholds = {model: level for model, level in thresholds.items() if model not in looming}
    with mpl.rc_context(STYLE):
        match drawing.kind:
            case "traces":
                drawn = _traces(rows, frames, thresholds)
            case "background":
                drawn = _background(rows, thresholds)
            case "edges":
                drawn = edges_figure.draw(rows, frames, thresholds)
            case "ranges":
                drawn = _ranges(rows, thresholds)
            case "contrast":
                drawn = _contrast(rows, frames, thresholds)
            case _:
                drawn = _peaks(drawing, rows, thresholds)
        headline(drawn, title)
    return drawn


def _traces(rows: Rows, frames: pa.Table, thresholds: Mapping[str, float | None]) -> Figure:
    """A panel for each clip: HS solid and VS dotted against time, one colour a model.

    There are as many rows of panels as lanes of models, with a key for each.
    """
    clips = list(dict.fromkeys(row["clip"] for row in rows))
    models = list(dict.fromkeys(row["model"] for row in rows))
    looks, groups = marks(models), lanes(models)
    most = ACROSS if len(models) <= MANY else MANY_ACROSS
    down = -(-len(clips) // min(most, len(clips)))
    heights = [(1.9 if most == ACROSS else 1.2) * down + 1.0 + 0.08 * len(group) for group in groups]
    drawn = Figure(figsize=(WIDTH, sum(heights)), layout="constrained")
    parts = drawn.subfigures(len(groups), 1, squeeze=False, height_ratios=heights)[:, 0] if len(groups) > 1 else [drawn]
    trial, name = frames["trial"].to_numpy(), np.asarray(frames["model"])
    columns = {system: frames[system].to_numpy() for system in SYSTEMS}
    for part, group in zip(parts, groups, strict=True):
        broad = False
        (panels,) = grid_of_panels(part, 1, len(clips), most, sharey=True)
        for axes, clip in zip(panels, clips, strict=True):
            clip_rows = [row for row in rows if row["clip"] == clip and row["model"] in group]
            for system, (_, style) in SYSTEMS.items():
                curves = [columns[system][(trial == row["trial"]) & (name == row["model"])] for row in clip_rows]
                extras = extra_widths(curves, SAME)
                broad |= any(extras)
                for row, curve, extra in zip(clip_rows, curves, extras, strict=True):
                    mark = looks[row["model"]]
                    axes.plot(np.arange(len(curve)) / row["fps"], curve, ls=style, lw=1.1 + extra, color=mark.colour,
                              **_dots(mark, len(curve)))  # fmt: skip
            threshold_lines.draw(axes, thresholds, group, models, signed=True)
            axes.set_title(plain(wrapped(clip, _title_inches(most), 8)), fontsize=8)
        for axes in lowest([panels]):
            axes.set_xlabel("time (s)", fontsize=8)
        part.supylabel("potential (right, down positive)", fontsize=8)
        keys = [Line2D([], [], color=looks[model].colour, lw=1.1, label=plain(model), **_dots(looks[model], 1))
                for model in group]  # fmt: skip
        keys += [*_system_keys(), *threshold_lines.keys(thresholds, group, models, sign="±")]
        key_below(part, [*keys, *[Line2D([], [], color="0.6", lw=4.0, label="broad: under another")] * broad])
    return drawn


def _title_inches(across: int) -> float:
    """Return the width of the title of one of so many panels side by side."""
    return PANEL_INCHES * ACROSS / max(across, ACROSS)


def _dots(mark: Mark, count: int) -> dict[str, Any]:
    """Return the model's markers along a line of ``count`` points."""
    return {"marker": mark.marker, "ms": 4, "markevery": max(count // 8, 1)}


def _peaks(shape: Drawing, rows: Rows, thresholds: Mapping[str, float | None]) -> Figure:
    """Largest |HS| and |VS| along one parameter: panels by another and by model, a line for each of a third."""
    object_rows = [row for row in rows if row["object"] != "absent"]
    unit = object_rows[0]["speed_unit"]
    models = list(dict.fromkeys(row["model"] for row in object_rows))
    levels_of_panels = sorted({row[shape.panels] for row in object_rows})
    shades = level_colours(sorted({row[shape.lines] for row in object_rows}))
    titles = [_level(shape.panels, level, unit) for level in levels_of_panels]
    drawn, panels = _by_model(models, titles, NAMES[shape.along].format(unit=unit))
    for level, block in zip(levels_of_panels, panels.blocks, strict=True):
        for axes, model in zip(block, models, strict=True):
            panel_rows = [row for row in object_rows if (row["model"], row[shape.panels]) == (model, level)]
            _by_level(axes, panel_rows, shape.lines, shades, shape.along, panels.dots)
            threshold_lines.draw(axes, thresholds, [model])
    panels.from_zero(panels.blocks)
    keys = _level_keys(shape.lines, shades, unit)
    key_below(drawn, [*keys, *_system_keys(), *threshold_lines.key_of_panels(thresholds, models)])
    return drawn


def _contrast(rows: Rows, frames: pa.Table, thresholds: Mapping[str, float | None]) -> Figure:
    """HS over time by grey and by speed, then peaks along speed and along grey (the paper's simu-sys-grayscale).

    The traces are the first model's: every grey at the middle speed, and the darkest grey at every speed.
    """
    object_rows = [row for row in rows if row["object"] != "absent"]
    unit = object_rows[0]["speed_unit"]
    models = list(dict.fromkeys(row["model"] for row in object_rows))
    speeds, greys = (sorted({row[name] for row in object_rows}) for name in ("speed", "grey"))
    middle = speeds[len(speeds) // 2]
    in_rows = model_panels.in_rows(len(models), 2, TRACES_HIGH + TWO_KEYS)
    peaks_high = model_panels.blocks_inches(len(models), 1)
    heights = [TRACES_HIGH, peaks_high, peaks_high]
    if in_rows:
        around = TRACES_OF_ROWS + model_panels.AROUND_ROWS
        heights = [TRACES_OF_ROWS, model_panels.rows_inches(models, 2, around) + model_panels.AROUND_ROWS]
    size = (WIDTH if len(models) > 1 else 5.4, sum(heights) + (0.0 if in_rows else TWO_KEYS))
    drawn = Figure(figsize=size, layout="constrained")
    top, *lower = np.asarray(drawn.subfigures(len(heights), 1, height_ratios=heights)).tolist()
    first = [row for row in object_rows if row["model"] == models[0]]
    trial, who, hs = frames["trial"].to_numpy(), np.asarray(frames["model"]), frames["hs"].to_numpy()
    for axes, name, traced, caption in zip(
        top.subplots(1, 2, sharey=True),
        ("grey", "speed"),
        ([row for row in first if row["speed"] == middle], [row for row in first if row["grey"] == greys[0]]),
        (_level("speed", middle, unit), _level("grey", greys[0], unit)),
        strict=True,
    ):
        shades = level_colours(sorted({row[name] for row in traced}))
        ordered = sorted(traced, key=partial(_number, name))
        curves = [hs[(trial == row["trial"]) & (who == row["model"])] for row in ordered]
        for row, curve, extra in zip(ordered, curves, extra_widths(curves, SAME), strict=True):
            axes.plot(np.arange(len(curve)) / row["fps"], curve, lw=1.1 + extra, color=shades[row[name]])
        threshold_lines.draw(axes, thresholds, models[:1])
        axes.set_title(plain(f"HS of {models[0]}, {caption}; by {name}, as below"), fontsize=8)
        axes.set_xlabel("time (s)", fontsize=8)
    sides = (("speed", "grey", level_colours(greys)), ("grey", "speed", level_colours(speeds)))
    words = [NAMES[along].format(unit=unit) for along, _, _ in sides]
    if in_rows:
        groups = [model_panels.of_rows(lower[0], models, [f"by {lines}" for _, lines, _ in sides], words)]
    else:
        groups = [model_panels.in_blocks(part, models, [""], [word]) for part, word in zip(lower, words, strict=True)]
    blocks = [block for panels in groups for block in panels.blocks]
    for block, (along, lines, shades) in zip(blocks, sides, strict=True):
        for axes, model in zip(block, models, strict=True):
            of_model = [row for row in object_rows if row["model"] == model]
            _by_level(axes, of_model, lines, shades, along, groups[0].dots)
            threshold_lines.draw(axes, thresholds, [model])
    for panels in groups:
        panels.from_zero(panels.blocks)
    keys = [_level_keys(lines, shades, unit) for _, lines, shades in sides]
    others = [*_system_keys(), *threshold_lines.key_of_panels(thresholds, models)]
    if in_rows:  # beside each other: a shade is a grey in one and a speed in the other
        for side, handles in zip(("left", "center", "right"), (*keys, others), strict=True):
            lower[0].legend(handles=handles, loc=f"outside lower {side}", frameon=False, fontsize=8)
    else:
        for part, level_keys in zip(lower, keys, strict=True):
            key_below(part, [*level_keys, *others])
    return drawn


def _level(name: str, value: float, unit: str) -> str:
    """Return a level of a parameter in words."""
    return f"{LEVELS[name]} {value:g}{'' if name == 'grey' else f' {unit}'}"


def _by_model(models: Sequence[str], titles: Sequence[str], along: str) -> tuple[Figure, ModelPanels]:
    """Return a figure with a panel for every model in each block, which ``titles`` name."""
    in_rows = model_panels.in_rows(len(models), len(titles), BLOCKS_AROUND)
    if in_rows:
        high = model_panels.rows_inches(models, len(titles), model_panels.AROUND_ROWS) + model_panels.AROUND_ROWS
    else:
        high = model_panels.blocks_inches(len(models), len(titles)) + BLOCKS_AROUND
    drawn = Figure(figsize=(WIDTH if len(models) > 1 else 5.4, high), layout="constrained")
    make = model_panels.of_rows if in_rows else model_panels.in_blocks
    return drawn, make(drawn, models, titles, [along] * len(titles))


def _along(rows: Rows, place: Callable[[Mapping[str, Any]], float]) -> dict[float, list[Mapping[str, Any]]]:
    """The rows by their ``place`` along the axis, in its order."""
    by_value: dict[float, list[Mapping[str, Any]]] = {}
    for row in sorted(rows, key=place):
        by_value.setdefault(place(row), []).append(row)
    return by_value


def _by_level(axes: Axes, rows: Rows, name: str, shades: Mapping[Any, str], along: str, dots: float) -> None:
    """Draw a line for each level of the parameter ``name``, in its shade, along another."""
    lines = [(shade, [row for row in rows if row[name] == level]) for level, shade in shades.items()]
    _systems(axes, [(shade, _along(line, partial(_number, along))) for shade, line in lines], dots)


def _level_keys(name: str, shades: Mapping[Any, str], unit: str) -> list[Line2D]:
    """Return a key for each level of the parameter ``name``."""
    return [Line2D([], [], color=shade, marker="o", ms=3, label=_level(name, level, unit))
            for level, shade in shades.items()]  # fmt: skip


def _number(name: str, row: Mapping[str, Any]) -> float:
    return float(row[name])


def _systems(axes: Axes, lines: Sequence[tuple[Any, Mapping[float, Rows]]], dots: float) -> None:
    """Draw each line in its colour, HS solid and VS dotted: at each place the largest size of the clips there.

    Dots, and what curves on each other are drawn wider by, are ``dots`` times as large as usual.
    """
    for system, (_, style) in SYSTEMS.items():
        curves = [
            [max(max(row[f"peak_{system}"], -row[f"trough_{system}"]) for row in place) for place in places.values()]
            for _, places in lines
        ]
        for (colour, places), curve, extra in zip(lines, curves, extra_widths(curves, SAME), strict=True):
            axes.plot(list(places), curve, "o", ls=style, ms=dots * (3 + extra), lw=1 + dots * extra / 2, color=colour)


DEPTH = ("looming", "receding")
ALONE = "background alone"
LOG_NUMBERS = (0.0001, 0.1)
"""Numbers of the logarithmic axis of a row."""
PAPER_PX_FRAME = 8.0 / 30.0
"""The paper's background speed, as it is read here."""


def _background(rows: Rows, thresholds: Mapping[str, float | None]) -> Figure:
    """Largest |HS| and |VS| against the background's speed in px a frame: a column a model.

    The first row has the background alone, on a logarithmic axis; below are objects in depth, and translations of the
    darkest and of the lightest object with a line a speed, where there are such clips.
    """
    models = list(dict.fromkeys(row["model"] for row in rows))
    shades = level_colours(sorted({row["speed"] for row in _moving(rows)}))
    parts, ticks = _background_parts(rows, shades), sorted({_px_a_frame(row) for row in rows})
    drawn, panels = _by_model(models, [title for title, _ in parts], "background speed (px a frame)")
    for (title, lines), block in zip(parts, panels.blocks, strict=True):
        for axes, model in zip(block, models, strict=True):
            _systems(axes, [(shade, _along([row for row in line_rows if row["model"] == model], _px_a_frame))
                            for shade, line_rows in lines], panels.dots)  # fmt: skip
            axes.axvline(PAPER_PX_FRAME, color="black", lw=0.6, ls="-.")
            axes.set_xscale("log")
            axes.set_xticks(ticks, [f"{tick:.2g}" for tick in ticks], fontsize=8, rotation=90)
            axes.set_xticks([], minor=True)
            if title == ALONE:
                axes.set_yscale("log")
                axes.set_ylim(1e-5, max(1.5, 1.2 * axes.dataLim.y1))
                if panels.in_rows:
                    axes.set_yticks(LOG_NUMBERS, [f"{number:g}" for number in LOG_NUMBERS])
                    axes.set_yticks([], minor=True)
            threshold_lines.draw(axes, thresholds, [model])
    panels.from_zero([block for (title, _), block in zip(parts, panels.blocks, strict=True) if title != ALONE])
    keys = [Line2D([], [], color=shade, label=f"object {speed:g} px/s") for speed, shade in shades.items()]
    keys += [
        *_system_keys(),
        Line2D([], [], color="black", ls="-.", lw=0.6, label="the paper's 8, as px/s: 0.27 px a frame"),
    ]
    key_below(drawn, [*keys, *threshold_lines.key_of_panels(thresholds, models)])
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
        grey_rows = [row for row in moving if row["grey"] == grey]
        lines: list[tuple[Any, Rows]] = [
            (shade, [row for row in grey_rows if row["speed"] == speed]) for speed, shade in shades.items()
        ]
        parts.append((f"object of grey {grey:g}", lines))
    return parts


def _px_a_frame(row: Mapping[str, Any]) -> float:
    """Tell how fast the background shifts, either way."""
    return float(abs(row["background_speed"]) / (row["fps"] if row["speed_unit"] == "px/s" else 1.0))


def _ranges(rows: Rows, thresholds: Mapping[str, float | None]) -> Figure:
    """A bar a model: from the smallest to the largest peak |HS| of translations; below it that without an object."""
    models = list(dict.fromkeys(row["model"] for row in rows))
    drawn = Figure(figsize=(WIDTH, 1.2 + 0.28 * len(models)), layout="constrained")
    axes = drawn.subplots()
    dark, light = LEVEL_SHADES
    kinds = (("an object crosses", _moving(rows), dark, -0.16),
             (ALONE, [row for row in rows if row["object"] == "absent"], light, 0.2))  # fmt: skip
    for _, labels, tint, lower in kinds:
        for place, model in enumerate(models):
            peaks = [max(row["peak_hs"], -row["trough_hs"]) for row in labels if row["model"] == model]
            if peaks:
                axes.plot([min(peaks), max(peaks)], [place + lower] * 2, "-|", color=tint, lw=4, ms=9)
    axes.set_yticks(range(len(models)), [plain(model) for model in models], fontsize=8)
    axes.invert_yaxis()
    for place, model in enumerate(models):  # in its model's row, so that it is no other's
        if (level := thresholds.get(model)) is not None:
            axes.plot([level] * 2, [place - 0.42, place + 0.42], **THRESHOLD)
    axes.set_xlabel("peak |HS| potential (bars: smallest to largest of the clips)", fontsize=8)
    limits = (
        [Line2D([], [], label="threshold of the model", **THRESHOLD)]
        if any(thresholds.get(model) is not None for model in models)
        else []
    )
    kind_keys = (Line2D([], [], color=tint, lw=4, label=caption) for caption, _, tint, _ in kinds)
    key_below(drawn, [*kind_keys, *limits])
    return drawn


def _system_keys() -> list[Line2D]:
    return [Line2D([], [], color="black", ls=style, label=caption) for caption, style in SYSTEMS.values()]
