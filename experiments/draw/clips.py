"""Figures of clips: potentials over time, and responses along what the clips vary."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import polars as pl
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from experiments.base import console, palette
from experiments.declare.clip import ClipFigure
from experiments.draw import style
from experiments.judge.judge import SIGNED
from experiments.judge.tests import LEAST_FOR_INTERVAL

Thresholds = Mapping[str, float | None]
Lines = tuple[str, pl.DataFrame, str, str]
"""A part of a figure: a name, rows, the column along the axis, and the column with a line for each level."""
DEPTH = ("looming", "receding")
AXES = {
    "speed": "speed of the object ({unit})",
    "grey": "grey of the object (0 to 255)",
    "background_speed": "speed of the background ({unit})",
    "px_a_frame": "speed of the background (px a frame)",
}
LEVELS = {"speed": "{:g} {unit}", "grey": "grey {:g}", "background_speed": "{:g} {unit}", "shade": "{}"}
ACROSS, LEAST_ROW = 12, 0.42
"""Most clips side by side, with several models; inches: least height of a row."""
RESPONSE = "Response: largest |HS|, of vertical motion |VS|, else of looming."
MEANS = "Lines: means; bands: range of the trials."


def title(name: str, seed: int, changed: Mapping[str, Any]) -> str:
    """Return what a figure's caption begins with: experiment, seed, and parameters that were ``changed``."""
    return f"{name}, seed {seed}{style.in_title(changed)}"


def draw(figure: ClipFigure, trials: pl.DataFrame, frames: pl.DataFrame, thresholds: Thresholds, title: str) -> Figure:
    """Draw the clips of a run, in the kind of figure that their experiment declares.

    Parameters
    ----------
    figure
        ``kind``: ``traces``, ``peaks``, ``background``, ``ranges`` or ``contrast``; of peaks ``along``,
        ``lines`` and ``panels`` too, which name columns: see `experiments.ClipFigure`.
    trials
        A row for each clip, seed and model.
    frames
        A row for each frame of these clips and each model.
    thresholds
        Each model's spiking threshold; ``None``: it does not spike.
    title
        What was run; the caption begins with it.

    Returns
    -------
    matplotlib.figure.Figure
        With its finding as title, and below it n and what the symbols mean.
    """
    trials = with_responses(trials)
    with style.look():
        n = trials.n_unique("repeat")
        if figure.form == "traces":
            drawn, notes = _traces(trials, frames, thresholds)
            notes = [MEANS * (n > 1), *notes]
        elif figure.form == "ranges":
            drawn, notes = _ranges(trials, thresholds)
        else:
            drawn, notes = _curves(_parts(figure, trials), thresholds)
        style.caption(drawn, f"{title}. n = {console.count(n, 'trial')} of each clip and model.", *notes)
    return drawn


def with_responses(trials: pl.DataFrame) -> pl.DataFrame:
    """Add ``hs`` and ``vs``, the largest sizes of both, ``directed``, whether a model has any, and its ``response``."""
    sizes = {name: pl.max_horizontal(f"peak_{name}", -pl.col(f"trough_{name}")).abs() for name in ("hs", "vs")}
    vertical = pl.col("motion").is_in(["downward", "upward"]).fill_null(False)
    response = pl.when(~pl.col("directed")).then("peak_looming").when(vertical).then("vs").otherwise("hs")
    directed = pl.max_horizontal("hs", "vs").max().over("model") > 0.0
    return trials.with_columns(**sizes).with_columns(directed=directed).with_columns(response=response)


def _page(rows: int, high: float, around: float) -> Figure:
    """Return a figure with rows that are so high, or less on a full page; as low as `LEAST_ROW` they take more."""
    height = around + rows * min(high, max(LEAST_ROW, (style.PAGE - around) / rows))
    return Figure(figsize=(style.WIDTH, height), layout="constrained")


# --- findings ---------------------------------------------------------------------------------------------------------


def counted(words: str, trials: pl.DataFrame, so: pl.Expr, of: str) -> str:
    """Return a finding that tells in how many of the trials it is so, and for how many models in all of them.

    Parameters
    ----------
    words
        What may be so.
    trials, so
        The cases, and which of them it is so in.
    of
        What a case is, in the plural.
    """
    counts = style.by(trials, "model").agg(so=so.sum(), cases=pl.len())
    total, cases = counts["so"].sum(), counts["cases"].sum()
    text = f"{words} in {total} of {cases} {of}"
    if len(counts) == 1 or total in (0, cases):
        return text
    return f"{text}, in all for {counts.filter(pl.col('so') == pl.col('cases')).height} of {len(counts)} models"


def shared(counts: str, plain: str) -> tuple[str, str]:
    """Return the title of a figure and what its caption adds: of counts that differ between models a plain label."""
    head, _, models = counts.partition(", in all for ")
    return (plain, f"{counts}.") if models else (style.title(head, plain), "")


def course_finding(rows: pl.DataFrame, along: str, lines: str) -> tuple[str, str]:
    """Return what the responses of each model, line and seed share, and how many have their commonest order."""
    points = style.by(rows.sort(along), "model", lines, "repeat", along).agg(pl.col("response").mean())
    curves = [style.curve(of, along, "response") for _, of in style.by(points, "model", lines, "repeat")]
    noun = AXES[along].partition(" (")[0]
    found = style.orders(curves, noun)
    return style.shared("response", found, noun), style.commonest("response", found)


def direction_finding(trials: pl.DataFrame, thresholds: Thresholds) -> str:
    """Return in how many trials the largest potential has the motion's direction, or without one is over threshold."""
    one_way = pl.col("motion").is_in(list(SIGNED)) & pl.col("movers").ne_missing("opposite")
    moving = trials.filter(one_way, pl.col("object").ne_missing("absent"), "directed")
    if moving.is_empty():
        return threshold_finding(trials, thresholds)
    reached = {way: sign * pl.col(column) for way, (column, sign) in SIGNED.items()}
    signal = pl.max_horizontal(pl.when(motion=way).then(value) for way, value in reached.items())
    others = pl.max_horizontal(pl.when(pl.col("motion") != way).then(value) for way, value in reached.items())
    so = (signal > 0.0) & (signal > others)  # a model at its ceiling both ways tells nothing
    return counted("The largest potential follows the motion", moving, so, "translations")


def threshold_finding(trials: pl.DataFrame, thresholds: Thresholds) -> str:
    """Return in how many trials the models that have a threshold reach it."""
    levels = {model: level for model in style.levels(trials, "model") if (level := thresholds.get(model)) is not None}
    spiking = trials.filter(pl.col("model").is_in(list(levels)))
    if spiking.is_empty():
        return "None of these models has a threshold"
    threshold = pl.col("model").replace_strict(levels, return_dtype=pl.Float64)
    reached = pl.max_horizontal("hs", "vs", "peak_looming") >= threshold
    return counted("The threshold is reached", spiking, reached, "trials")


# --- over time --------------------------------------------------------------------------------------------------------


def _traces(trials: pl.DataFrame, frames: pl.DataFrame, thresholds: Thresholds) -> tuple[Figure, list[str]]:
    """Draw the potentials of each model in a row, of each clip in a column; more clips lie below."""
    models, clips = style.levels(trials, "model"), style.levels(trials, "clip")
    table = frames.join(trials.select("trial", "model", "clip", "fps"), on=["trial", "model"])
    table = table.with_columns(time=pl.col("frame") / pl.col("fps")).sort("time")
    hues = {**palette.CHANNELS, "target": palette.INK}
    values = pl.col(*hues)
    ends = [getattr(values, end)().name.suffix(f"_{end}") for end in ("mean", "min", "max")]
    cells = style.by(table, "model", "clip", "time").agg(ends)
    most = min({1: 6, 2: 8, 3: 8}.get(len(models), ACROSS), len(clips))
    across = max((n for n in range(4, most + 1) if len(clips) % n == 0), default=most)  # rows alike, as of one shade
    bands = -(-len(clips) // across)
    drawn = _page(bands * len(models), 0.95, 1.3)
    panels = drawn.subplots(bands * len(models), across, squeeze=False, sharey="row")
    for axes in panels.flat:
        axes.set_visible(False)
    for row, model in enumerate(models):
        of_model, level = cells.filter(model=model), thresholds.get(model)
        shown = [name for name in hues if of_model[f"{name}_mean"].abs().max()] or ["hs"]
        for place, clip in enumerate(clips):
            axes = panels[place // across * len(models) + row, place % across]
            axes.set_visible(True)
            axes.margins(y=0.15)
            axes.locator_params(nbins=3)
            axes.tick_params(labelbottom=row == len(models) - 1)
            style.threshold(axes, level, signed=shown != ["looming"], named=False)
            cell = of_model.filter(clip=clip)
            for name in shown if len(cell) else ():
                label, colour = palette.TITLES.get(name, name), hues[name]
                axes.plot(cell["time"], cell[f"{name}_mean"], color=colour, label=label)
                axes.fill_between(cell["time"], cell[f"{name}_min"], cell[f"{name}_max"], color=colour, alpha=0.3, lw=0)
            if row == 0:
                small = min(style.SMALL, 72.0 / across)
                inches = (style.WIDTH - style.NAME_INCHES) / across - 0.1
                axes.set_title(style.wrapped(clip, inches, small), fontsize=small)
            if place % across == 0:
                style.row_name(axes, model, level)
            axes.set_xlabel("time (s)" if row == len(models) - 1 else "", fontsize=style.SMALL)
    style.legend(drawn, panels.flat)
    title, counts = shared(direction_finding(trials, thresholds), "Potentials over time")
    style.headline(drawn, title)
    scale = ", on each model's own scale" * (len(models) > 1)
    return drawn, [f"Potentials: right and down are positive; dashes: T{scale}.", counts]


# --- along what the clips vary ----------------------------------------------------------------------------------------


def _parts(figure: ClipFigure, trials: pl.DataFrame) -> list[Lines]:
    """Return what each panel of a model has."""
    moved = pl.format("{}, grey {}", "motion", pl.col("grey").cast(int))
    shade = pl.when(pl.col("object").ne_missing("absent")).then(moved).otherwise(pl.lit(""))
    rate = pl.when(speed_unit="px/s").then("fps").otherwise(1.0)
    trials = trials.with_columns(shade=shade, px_a_frame=pl.col("background_speed").abs() / rate)
    present = trials.filter(pl.col("object").ne_missing("absent"))
    if figure.form == "peaks":
        levels = present.sort(figure.panels).partition_by(figure.panels)
        return [(_level(rows, figure.panels), rows, figure.along, figure.lines) for rows in levels]
    if figure.form == "contrast":
        return [("", present, "speed", "grey"), ("", present, "grey", "speed")]
    crossing = present.filter(~pl.col("motion").is_in(DEPTH))
    parts = [("background alone", trials.filter(object="absent"), "shade"),
             ("in depth", present.filter(pl.col("motion").is_in(DEPTH)), "shade")]  # fmt: skip
    shades = crossing.sort("grey").partition_by("grey")
    parts += [(_level(rows, "grey"), rows, "speed") for rows in shades[:: max(len(shades) - 1, 1)]]
    return [(name, rows, "px_a_frame", by) for name, rows, by in parts if not rows.is_empty()]


def _level(rows: pl.DataFrame, column: str) -> str:
    return LEVELS[column].format(rows[column][0], unit=rows["speed_unit"][0])


def _curves(parts: Sequence[Lines], thresholds: Thresholds) -> tuple[Figure, list[str]]:
    """Draw responses along a parameter: a row for each model, a column for each part."""
    models = list(dict.fromkeys(model for _, rows, _, _ in parts for model in style.levels(rows, "model")))
    drawn = _page(len(models), 1.9, 1.3)
    grid = drawn.subplots(len(models), len(parts), squeeze=False, sharex="col", sharey="row")
    ends, unit, orders = {}, parts[0][1]["speed_unit"][0], []
    largest = dict(pl.concat(rows for _, rows, _, _ in parts).group_by("model").agg("response").iter_rows())
    for place, (name, rows, along, by) in enumerate(parts):
        for axes, model in zip(grid[:, place], models, strict=True):
            ends[axes] = _lines(axes, rows.filter(model=model), along, by)
            axes.axhline(0.0, color=palette.INK, lw=0.4)
            level, most = thresholds.get(model), 3.0 * max(largest[model])
            style.threshold(axes, level, named=len(models) == 1 and not place, most=most)
            if along == "px_a_frame":
                axes.set_xscale("log")
                style.plain_numbers(axes, sorted(rows[along].unique())[::2])
        (title, order), letter = course_finding(rows, along, by), "abcdefgh"[place]
        title = f"{style.sentence(name)}: {title[:1].lower()}{title[1:]}" if name else title
        style.finding(grid[0, place], title, letter, "response" * (place == 0))
        orders.append(f"{letter}: {order}.")
        grid[-1, place].set_xlabel(style.wrapped(AXES[along].format(unit=unit), style.WIDTH / len(parts) - 0.3))
    for axes, model in zip(grid[:, 0], models if len(models) > 1 else (), strict=False):
        style.row_name(axes, model, thresholds.get(model))
    for axes in ends:
        axes.margins(y=0.1)
        axes.set_ylim(bottom=-0.05 * axes.get_ylim()[1])
    for axes in list(ends)[:: len(models)]:
        style.label_ends(axes, ends[axes])
    lines = " and ".join(dict.fromkeys(AXES[by].format(unit=unit) for *_, by in parts if by in AXES))
    trials: Any = max(style.by(rows, "model", by, along).len()["len"].max() for _, rows, along, by in parts)
    dots = f"Filled: means{', 95 % intervals' * (trials >= LEAST_FOR_INTERVAL)}; open: trials." * (trials > 1)
    return drawn, [f"Lines: {lines}." if lines else "", dots, RESPONSE, *orders]


def _lines(axes: Axes, rows: pl.DataFrame, along: str, by: str) -> list[tuple[float, float, str, str]]:
    """Draw a line of means for each level of a column; return their ends, names and colours."""
    ends, levels = [], rows.sort(by).partition_by(by)
    tints = style.tints([level[by][0] for level in levels], by)
    for level in levels:
        colour = tints[level[by][0]]
        points = style.by(level.sort(along), along).agg("response")
        x, samples = points[along].to_list(), points["response"].to_list()
        style.means(axes, x, samples, colour, _level(level, by))
        ends.append((x[-1], float(np.mean(samples[-1])), _level(level, by), colour))
    return ends


# --- ranges ----------------------------------------------------------------------------------------------------------


def _ranges(trials: pl.DataFrame, thresholds: Thresholds) -> tuple[Figure, list[str]]:
    """Draw for each model from where to where its responses to crossing objects reach, and those to the background."""
    models = style.levels(trials, "model")
    crossing = trials.filter(pl.col("object").ne_missing("absent"), ~pl.col("motion").is_in(DEPTH))
    alone = trials.filter(object="absent")
    drawn = _page(len(models), 0.32, 1.3)
    axes = drawn.subplots()
    for kind, rows, colour, aside in (("object crosses", crossing, palette.INK, -0.18),
                                      ("background alone", alone, palette.OTHERS["teal"], 0.18)):  # fmt: skip
        for (model,), of_model in style.by(rows, "model"):
            values, height = of_model["response"].to_numpy(), models.index(model) + aside
            axes.plot([values.min(), values.max()], [height] * 2, color=colour, lw=4, alpha=0.35, label=kind)
            axes.plot(values, [height] * len(values), "o", ms=2, color=colour)
            if model == models[0]:
                style.label_ends(axes, [(values.max(), height, kind, colour)])
    axes.set_yticks(range(len(models)), models)
    axes.set_ylim(len(models) - 0.5, -0.5)
    for place, model in enumerate(models):
        if (level := thresholds.get(model)) is not None:
            look: Any = {"color": palette.THRESHOLD, "ls": "--", "lw": 0.8, "label": "threshold"}
            axes.plot([level] * 2, [place - 0.4, place + 0.4], **look)
    style.decades(axes, trials["response"])
    axes.set_xlabel("response" + ", on a logarithmic scale" * (axes.get_xscale() != "linear"))
    compared = crossing.join(alone.group_by("model").agg(most=pl.col("response").max()), on="model")
    if compared.is_empty():
        words = threshold_finding(crossing, thresholds)
    else:
        exceeds = pl.col("response") > pl.col("most")
        words = counted("Crossings exceed the background alone", compared, exceeds, "trials")
    title, counts = shared(words, "Responses to crossings and to the background alone")
    style.headline(drawn, title)
    return drawn, [f"Dots: clips; bars: smallest to largest; grey: threshold T. {RESPONSE}", counts]
