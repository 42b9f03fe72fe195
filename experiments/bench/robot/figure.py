"""The figure of a run, in the manner of the paper's Figure 13: spikes per condition, every repeat visible."""

from __future__ import annotations

import itertools
import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import matplotlib as mpl
import numpy as np
import pyarrow as pa
from matplotlib.axes import Axes
from matplotlib.figure import Figure, SubFigure
from matplotlib.lines import Line2D
from matplotlib.transforms import ScaledTranslation, Transform

from experiments.bench.figures.palette import LINES, Mark, lanes, level_colours, marks
from experiments.bench.figures.plotting import (
    LETTER_INCHES,
    LINE,
    STYLE,
    TYPE,
    WIDTH,
    End,
    columns_of_key,
    extra_widths,
    headline,
    label_ends,
    lowest,
    plain,
    wrapped,
)
from experiments.bench.sources.rows import is_tracked, varying
from experiments.bench.stats.tests import LEAST_FOR_BOOTSTRAP, summarise
from experiments.bench.store.parameters import in_title
from experiments.bench.store.rows import group, looming_alone

Rows = Sequence[Mapping[str, Any]]

AXIS_LABELS = {
    "speed_cm_s": "speed of the stimulus (cm/s)",
    "distance_cm": "distance of the path (cm)",
    "far_cm": "distance of the far end (cm)",
    "angle_deg": "bearing of the far end (degrees, right positive)",
    "shell_grey": "reflectance of the stimulus's shell",
    "wall_contrast": "contrast of the wall against the arena's own",
    "observer_speed_cm_s": "observer driving (cm/s)",
    "observer_turn_deg_s": "observer turning (degrees/s, left positive)",
    "acceleration_cm_s2": "acceleration of the stimulus (cm/s²)",
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
    "observer_speed_cm_s": "cm/s of observer",
    "observer_turn_deg_s": "°/s of observer",
    "acceleration_cm_s2": "cm/s²",
}
OF_NOTHING_ELSE = ("cm/s", "cm", "°", "°/s", "cm/s²")
"""Units that stand alone where it is said beside them what they are of."""
COUNTS_INCHES = 2.8
"""Width of the panel of counts, where it stands beside the traces."""
AROUND = 0.6, 0.9
"""Width and height of its numbers, labels and caption, inches."""
MOST_BESIDE = 4
"""Models up to which it does."""
TRACE_ALPHA = 0.75
"""Opacity of the trace of a trial, and of its key."""
LABEL_INCHES = 1.05
"""Most length of the label of a panel's axis, inches."""
LANES_ACROSS = 3
"""Most lanes of counts in a row."""
DOT = 11.0
"""Area of the dot of a trial, square points."""
MOST_NAMED = 4
"""Models that a title names."""
ACROSS, MANY_ACROSS = 4, 5
"""Most panels of traces in a row, and where there are over `MANY` models: they fit on one page."""
MANY = 12
DODGE, MOST_DODGED = 4.0, 0.25
"""Points by which series stand beside each other at one number, so that no marker hides another; and the width of all
of them, as a share of the smallest gap between numbers, that they do not exceed."""
MOST_DOTTED = 4
"""Series beyond which single trials are left out of the panel of counts: means and intervals stay readable."""
FILLS: Sequence[Any] = ("full", "none", "left", "top", "right", "bottom")
"""Fillings of markers, of conditions: as words have no line between them, line styles would not tell them apart."""
SPREAD = 0.62
"""Width of all series at one word, as a share of the gap between words."""


@dataclass(frozen=True, slots=True)
class Series:
    """The trials of one line of the panel of counts: of one model, under one combination of the other conditions.

    Parameters
    ----------
    rows
        Its trials.
    mark
        Its model's.
    condition
        Number of the combination of its other conditions: it has a line style and a filling of the marker.
    words
        What that combination is called.
    label
        What tells the series from the others: these words, after the model's name where there are several models.
    """

    rows: Rows
    mark: Mark
    condition: int
    words: str
    label: str


def title(
    name: str, models: Sequence[str], arena: str, repeats: int | str, changed: Mapping[str, Any], open_loop: bool
) -> str:
    """Return the title of a run's figure, with the parameters that were ``changed``. An empty ``arena`` is left out."""
    names = ", ".join(models) if len(models) <= MOST_NAMED else f"{models[0]} and {len(models) - 1} others"
    where, driven = f", {arena} arena" if arena else "", ", driven open loop" if open_loop else ""
    trials = "1 trial" if str(repeats) == "1" else f"{repeats} trials"
    return f"{name}: {names}{where}{driven}, {trials} of each condition{in_title(changed)}"


def figure(rows: Rows, frames: pa.Table, varies: str, title: str, thresholds: Mapping[str, float | None]) -> Figure:
    """Draw the counts of every trial, and the potential over each, a panel for each model.

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
        Left, or above the traces of many models: counts with means, and from `LEAST_FOR_BOOTSTRAP` trials on with
        95 % intervals. With one model the colours are those of the levels, as in the traces; with several, those of
        the models, and no two of a panel have one. Then the HS potential of each model (of looming detectors theirs),
        coloured by level.
    """
    models = list(dict.fromkeys(row["model"] for row in rows))
    levels = list(dict.fromkeys(row[varies] for row in rows))
    if not isinstance(levels[0], str):
        levels.sort()
    colours = level_colours(levels)
    silent = _silent(rows, models, thresholds)
    counted = [row for row in rows if row["model"] not in silent]
    groups = lanes(model for model in models if model not in silent) or [[]]
    beside = len(models) <= MOST_BESIDE
    blocks = _blocks(rows, models)
    across = min(2 if beside else ACROSS if len(models) <= MANY else MANY_ACROSS, max(map(len, blocks)))
    down = sum(math.ceil(len(block) / across) for block in blocks)
    lane = 1.5 + 0.15 * max(map(len, groups))
    heights = (lane * math.ceil(len(groups) / LANES_ACROSS) + 0.8, (1.35 if across <= ACROSS else 1.15) * down + 0.8)
    with mpl.rc_context(STYLE):
        high = max(3.1, 1.9 * down + 0.8) if beside else sum(heights) + 0.3
        drawn = Figure(figsize=(WIDTH, high), layout="constrained")
        if beside:
            left, right = drawn.subfigures(1, 2, width_ratios=[COUNTS_INCHES, WIDTH - COUNTS_INCHES])  # type: ignore[misc]
        else:
            left, right = drawn.subfigures(2, 1, height_ratios=heights)  # type: ignore[misc]
        headline(drawn, title)
        _counts(left, counted, varies, levels, colours if len(models) == 1 else None, models, groups, silent)
        _potentials(right, rows, frames, varies, colours, thresholds, blocks, across)
    return drawn


def _silent(rows: Rows, models: Sequence[str], thresholds: Mapping[str, float | None]) -> list[str]:
    """Return the models that do not spike."""
    counting = {row["model"] for row in rows if row["spikes"] is not None}
    return [model for model in models if thresholds.get(model, 0.0) is None or model not in counting]


def _potentials(
    place: SubFigure, rows: Rows, frames: pa.Table, varies: str, colours: Mapping[Any, str],
    thresholds: Mapping[str, float | None], blocks: Sequence[Sequence[str]], across: int,
) -> None:  # fmt: skip
    """Draw a panel of traces for each model, at most ``across`` in a row; each of the ``blocks`` begins one."""
    looks, axis, looming = marks(itertools.chain(*blocks)), _trace_axis(rows), looming_alone(rows)
    panels, inches = _blocks_of_panels(place, blocks, across)
    for block, shown in zip(blocks, panels, strict=True):
        potential = "looming potential" if block[0] in looming else "HS potential (right positive)"
        for axes, model in zip(shown, block, strict=True):
            _traces(axes, [row for row in rows if row["model"] == model], frames, varies, colours, axis)
            _limits(axes, 0.0 if model in looming else -1.0)
            if len(looks) > 1:
                _name(axes, wrapped(model, inches[0], 8), looks[model])
        for axes, left in zip(shown, [None, *shown], strict=False):
            spec = axes.get_subplotspec()
            assert spec is not None
            if spec.is_first_col() and len(blocks) > 1:
                axes.set_ylabel(wrapped(potential, LABEL_INCHES, 8), fontsize=8)
            same = left is not None and axes.get_ylim() == left.get_ylim()
            axes.tick_params(labelleft=spec.is_first_col() or not same)
    for axes in lowest(panels):
        axes.tick_params(labelbottom=True)
    for axes, model in zip(itertools.chain(*panels), itertools.chain(*blocks), strict=True):
        # When all traces are drawn: they have one axis of time.
        _threshold(axes, thresholds.get(model), (1,) if model in looming else (1, -1), inches)
    bearing = axis == "stimulus_bearing_deg"
    place.supxlabel("bearing of the stimulus (degrees, right positive)" if bearing else "time in the trial (s)",
                    fontsize=8)  # fmt: skip
    if len(blocks) == 1:
        place.supylabel(potential, fontsize=8)
    _level_keys(place, colours, varies, _others(rows, varies, blocks[0]))


def _blocks(rows: Rows, models: Sequence[str]) -> list[list[str]]:
    """Return the models that answer by direction, and the looming detectors, whose potential has another scale."""
    looming = looming_alone(rows)
    kinds = [[model for model in models if (model in looming) == looms] for looms in (False, True)]
    return [block for block in kinds if block]


def _blocks_of_panels(
    place: SubFigure, blocks: Sequence[Sequence[str]], across: int
) -> tuple[list[list[Axes]], tuple[float, float]]:
    """Return a panel for each model, a list for each of the ``blocks``; and width and height of each, inches, about."""
    down = [-(-len(block) // across) for block in blocks]
    grid = place.subplots(sum(down), across, squeeze=False, sharex=True)
    for axes in grid.flat:
        axes.set_visible(False)
    panels = []
    for block, first, rows in zip(blocks, itertools.accumulate([0, *down]), down, strict=False):
        panels.append(list(grid[first : first + rows].flat)[: len(block)])
        for axes in panels[-1]:
            axes.set_visible(True)
    whole = place.bbox.width / place.figure.dpi, place.bbox.height / place.figure.dpi
    return panels, (float(whole[0]) / across - 0.3, (float(whole[1]) - AROUND[1]) / sum(down) - 0.25)


def _limits(axes: Axes, lowest: float) -> None:
    """Have potentials from ``lowest`` to 1, or further both ways where a model's go: those of `flow` are in px."""
    largest = max((float(np.abs(line.get_ydata()).max(initial=0.0)) for line in axes.get_lines()), default=0.0)
    if largest <= 1.0:
        axes.set_ylim(lowest - 0.02, 1.02)
        if not lowest:
            axes.set_yticks([0.0, 0.5, 1.0])
    else:
        axes.set_ylim(-1.02 * largest if lowest else -0.02, 1.02 * largest)


def level_text(level: Any) -> str:
    """Return a level as axes and keys show it."""
    return level if isinstance(level, str) else f"{level:g}".replace("-", "\N{MINUS SIGN}")


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
    return plain(", ".join(_with_unit(v, UNITS[n]) if n in UNITS and v is not None else str(v) for n, v in values))


def _with_unit(level: Any, unit: str) -> str:
    return f"{level_text(level)}{'' if unit.startswith('°') else ' '}{unit}".strip()


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
            words = _condition(part[0], names)
            label = ", ".join(filter(None, [plain(model) if several else "", words]))
            series.append(Series(part, model_marks[model], place, words, label))
    return series


def _counts(
    place: SubFigure, rows: Rows, varies: str, levels: Sequence[Any], colours: Mapping[Any, str] | None,
    models: Sequence[str], groups: Sequence[Sequence[str]], silent: Sequence[str],
) -> None:  # fmt: skip
    """Spikes of every trial with means and intervals; ``colours`` of the levels where there is one model.

    There is a lane for each of the ``groups`` of models. Models that do not spike, ``silent``, are named instead of
    being drawn at 0.
    """
    down = math.ceil(len(groups) / LANES_ACROSS)
    panels = place.subplots(down, math.ceil(len(groups) / down), squeeze=False, sharex=True, sharey=True)
    series = _series(rows, varies, models)
    ordinal = isinstance(levels[0], str)
    ticks = {level: float(i) if ordinal else float(level) for i, level in enumerate(levels)}
    most = max(
        (len([row for row in one.rows if row[varies] == level]) for one in series for level in levels), default=0
    )
    dotted = len(series) <= MOST_DOTTED or (ordinal and most < LEAST_FOR_BOOTSTRAP)
    broad = False
    for axes, lane in zip(panels.flat, groups, strict=False):
        in_lane = [one for one in series if one.rows[0]["model"] in lane]
        curves = [_means(one, varies, levels) for one in in_lane]
        extra = extra_widths(curves, 0.01 * max((max(curve) for curve in curves), default=1.0))
        broad |= any(extra)
        beside = _dodged(axes, len(in_lane), [] if ordinal else levels, len(panels[0]))
        # Numbers stand at their place on the axis, words have room beside theirs.
        places, step = _beside_words(in_lane, ticks, varies) if ordinal else ([ticks] * len(in_lane), 0.0)
        for index, one_series in enumerate(in_lane):
            _draw_series(axes, one_series, places[index], varies, colours,
                         step=step, extra=0.0 if ordinal else extra[index], ordinal=ordinal, alone=len(series) == 1,
                         dotted=dotted, beside=axes.transData if ordinal else beside[index])  # fmt: skip
        axes.set_xticks(list(ticks.values()), [level_text(level) for level in levels], fontsize=8)
        if ordinal:
            axes.set_xlim(-0.5, len(levels) - 0.5)
        else:
            axes.tick_params(axis="x", labelrotation=90 if _crowded(levels, len(panels[0])) else 0)
    for axes in list(panels.flat)[len(groups) :]:
        axes.set_visible(False)
    place.supxlabel(AXIS_LABELS[varies], fontsize=8)
    place.supylabel("spikes per trial", fontsize=8)
    top = panels[0, 0].get_ylim()[1]
    panels[0, 0].set_ylim(-0.06 * max(top, 1.0), 1.04 * max(top, 1.0))
    inches = float(place.bbox.width / place.figure.dpi)
    if most >= LEAST_FOR_BOOTSTRAP:
        notes = ["dots: trials; bars: 95 % intervals of means" if dotted else "bars: 95 % intervals of means"]
    elif dotted and most > 1:
        notes = [
            "pale: trials; strong: means" if ordinal else "pale: trials, larger where several agree; strong: means"
        ]
    else:
        notes = []
    if not ordinal and max(map(len, groups)) > 1:
        notes.append(f"models stand side by side{', broad lines under others' if broad else ''}")
    if silent:
        notes.append(f"without a threshold, so not drawn: {', '.join(silent)}")
    caption = plain(wrapped("; ".join(notes), inches - 0.6, 8))
    keys = _condition_keys(series, ordinal=ordinal)
    if len(groups) > 1:
        for axes, lane in zip(panels.flat, groups, strict=False):
            axes.legend(handles=_model_keys(series, lane, ordinal=ordinal), fontsize=8, handlelength=1.6, frameon=False,
                        loc="lower left", bbox_to_anchor=(-0.05, 1.0))  # fmt: skip
    elif len(groups[0]) > 1 and (
        ordinal or keys or not _label_ends(panels[0, 0], series, varies, levels, place, caption)
    ):
        keys = [*_model_keys(series, groups[0], ordinal=ordinal), *keys]
    if keys and len(groups) == 1:
        columns = columns_of_key([str(key.get_label()) for key in keys], inches, 8)
        place.legend(handles=keys, fontsize=8, frameon=False, loc="outside upper center", ncols=columns)
    if len(groups) > 1 and keys:
        place.legend(handles=keys, title=caption, alignment="left", title_fontsize=8, fontsize=8, frameon=False,
                     loc="outside upper left", ncols=len(keys))  # fmt: skip
    elif len(groups) > 1:
        place.suptitle(caption, fontsize=8, x=0.01, ha="left")
    else:
        panels[0, 0].set_title(caption, fontsize=8, loc="left")


def _beside_words(
    series: Sequence[Series], ticks: Mapping[Any, float], varies: str
) -> tuple[list[dict[Any, float]], float]:
    """Return where each series stands at each word, and the room that it has there.

    Those that have trials at a word stand about its tick, side by side.
    """
    there = {level: [any(row[varies] == level for row in one.rows) for one in series] for level in ticks}
    step = SPREAD / max((sum(present) for present in there.values()), default=1)
    places = [
        {level: tick + step * (sum(there[level][:index]) - (sum(there[level]) - 1) / 2)
         for level, tick in ticks.items()}
        for index in range(len(series))
    ]  # fmt: skip
    return places, step


def _label_ends(
    axes: Axes, series: Sequence[Series], varies: str, levels: Sequence[Any], place: SubFigure, caption: str
) -> bool:
    """Name the lines of models at their ends, where the names fit below the ``caption``; tell whether they did."""
    inches = float(place.bbox.width / place.figure.dpi), float(place.bbox.height / place.figure.dpi)
    ends = [
        End(max(row[varies] for row in one.rows), _means(one, varies, levels)[-1], one.label, one.mark.colour)
        for one in series
    ]
    high = inches[1] - AROUND[1] - LINE * caption.count("\n")
    return label_ends(axes, ends, (inches[0] - AROUND[0], high), 7.0 + DODGE * (len(series) - 1) / 2)


def _model_keys(series: Sequence[Series], models: Sequence[str], *, ordinal: bool) -> list[Line2D]:
    """Return the key of the colours and markers of ``models``."""
    looks = {one.rows[0]["model"]: one.mark for one in series}
    return [Line2D([], [], color=looks[model].colour, marker=looks[model].marker, ms=4, lw=0.9,
                   ls="none" if ordinal else "-", label=plain(model)) for model in models]  # fmt: skip


def _condition_keys(series: Sequence[Series], *, ordinal: bool) -> list[Line2D]:
    """Return the key of the conditions beside that of the axis: of fillings of markers, and of lines between them."""
    words = {one.condition: one.words for one in series}
    if len(words) < 2:
        return []
    return [Line2D([], [], color="black", marker="o", ms=4, lw=0.9, fillstyle=FILLS[place % len(FILLS)], label=label,
                   ls="none" if ordinal else LINES[place % len(LINES)]) for place, label in words.items()]  # fmt: skip


def _means(series: Series, varies: str, levels: Sequence[Any]) -> list[float]:
    """Return the mean count at each level that the series has."""
    counts = [[row["spikes"] for row in series.rows if row[varies] == level] for level in levels]
    return [float(np.mean(spikes)) for spikes in counts if spikes]


def _panel_inches(across: int) -> float:
    """Return the width of one of so many panels of counts in a row."""
    return (COUNTS_INCHES if across == 1 else WIDTH / across) - 0.7


def _dodged(axes: Axes, count: int, levels: Sequence[float], across: int) -> list[Transform]:
    """Return for each of ``count`` series where it is drawn: beside the others at a number, by points of the page."""
    gaps = [b - a for a, b in itertools.pairwise(levels)]
    room = MOST_DODGED * 72.0 * _panel_inches(across) * min(gaps) / sum(gaps) if gaps else math.inf
    step = min(DODGE, room / max(count - 1, 1)) / 72.0
    whole = axes.get_figure(root=True)
    assert whole is not None
    shifts = [(place - (count - 1) / 2) * step for place in range(count)]
    return [axes.transData + ScaledTranslation(shift, 0.0, whole.dpi_scale_trans) for shift in shifts]


def _crowded(levels: Sequence[float], across: int) -> bool:
    """Tell whether the numbers of an axis would lie on each other, side by side."""
    gaps = [b - a for a, b in itertools.pairwise(levels)]
    inches = _panel_inches(across)
    widest = max(len(level_text(level)) for level in levels) * LETTER_INCHES + 0.05
    return bool(gaps) and min(gaps) / sum(gaps) * inches < widest


def _draw_series(
    axes: Axes, series: Series, ticks: Mapping[Any, float], varies: str, colours: Mapping[Any, str] | None, *,
    step: float, extra: float, ordinal: bool, alone: bool, dotted: bool, beside: Transform,
) -> None:  # fmt: skip
    means = []
    for level, tick in ticks.items():
        spikes = [row["spikes"] for row in series.rows if row[varies] == level]
        if spikes:
            tint = colours[level] if colours else series.mark.colour
            mean = _level(axes, spikes, tick, step, tint, series.mark, alone=alone, dotted=dotted, beside=beside)
            means.append((tick, mean))
    style = "none" if ordinal else LINES[series.condition % len(LINES)]
    line = "black" if colours else series.mark.colour
    lines = axes.plot(*zip(*means, strict=True), color=line, lw=0.9 + extra, ls=style, label=series.label, zorder=2,
              marker=None if alone else series.mark.marker, ms=4 + extra,
              fillstyle=FILLS[series.condition % len(FILLS)])  # fmt: skip
    for artist in lines:  # when drawn: limits are those of the numbers
        artist.set_transform(beside)


def _level(
    axes: Axes, spikes: Sequence[float], place: float, step: float, tint: str, mark: Mark, *, alone: bool, dotted: bool,
    beside: Transform,
) -> float:  # fmt: skip
    """Draw the trials of one series at one level, beside it by shares of ``step``; return their mean.

    Fewer than `LEAST_FOR_BOOTSTRAP` trials stand for themselves, and one that is alone has the marker of the mean, if
    that has one. No interval of a count goes below 0. At a number, where there is no room beside it, trials of one
    count are one dot, with their area together.
    """
    summary = summarise(spikes, 0.0)
    if summary.n == 1 and not alone:  # beside its mean, or on it, a dot would show nothing more
        return summary.mean
    if dotted and step:
        left = place - np.linspace(0.2, 0.55, len(spikes)) * step  # of the mean, so that neither hides the other
        axes.scatter(left, spikes, s=11, color=tint, alpha=0.55, linewidths=0, marker=mark.marker, zorder=3)
    elif dotted:
        counts = Counter(spikes)
        dots = axes.scatter([place] * len(counts), list(counts), s=[DOT * many for many in counts.values()], color=tint,
                     alpha=0.55, linewidths=0, marker=mark.marker, zorder=3)  # fmt: skip
        dots.set_offset_transform(beside)
    if summary.n >= LEAST_FOR_BOOTSTRAP:
        error = [[summary.mean - summary.ci_low], [summary.ci_high - summary.mean]]
        tone = "black" if alone else tint
        bar = axes.errorbar(place, summary.mean, yerr=error, fmt="_", color=tone, capsize=2.5, lw=1.2, zorder=4)
        for artist in bar.get_children():
            artist.set_transform(beside)
    return summary.mean


def _traces(axes: Axes, rows: Rows, frames: pa.Table, varies: str, colours: Mapping[Any, str], axis: str) -> None:
    """The potential of one model over each of its trials."""
    model_frames = frames.filter(np.asarray(frames["model"]) == rows[0]["model"])
    looming = bool(looming_alone(rows))
    names, styles = _conditions(rows, varies), _others(rows, varies, [rows[0]["model"]])
    trial, potential, place = (
        model_frames[name].to_numpy() for name in ("trial", "looming" if looming else "hs", axis)
    )
    for row in rows:
        chosen = trial == row["trial"]
        style = styles.get(_condition(row, names), "-")
        axes.plot(place[chosen], potential[chosen], color=colours[row[varies]], ls=style, lw=0.7, alpha=TRACE_ALPHA)


def _name(axes: Axes, name: str, mark: Mark) -> None:
    """Write a model's name above its panel, beside the mark that it has in the panel of counts."""
    key = Line2D([], [], ls="none", marker=mark.marker, color=mark.colour, ms=4, label=plain(name))
    axes.legend(handles=[key], fontsize=8, frameon=False, loc="lower left", bbox_to_anchor=(0.0, 1.0),
                borderpad=0.0, borderaxespad=0.3, handlelength=0.8, handletextpad=0.4)  # fmt: skip


def _threshold(axes: Axes, threshold: float | None, signs: Sequence[int], inches: tuple[float, float]) -> None:
    """Draw the threshold as dashed lines: of either sign for HS, the positive one for looming.

    Its value stands in the corner of a panel of so many ``inches`` where there is least of the traces.
    """
    if threshold is None:
        return
    traces = axes.get_lines()
    for sign in signs:
        axes.axhline(sign * threshold, color="black", ls="--", lw=0.8)
    words = f"threshold {'±' if len(signs) > 1 else ''}{threshold:.3g}"
    points = np.concatenate([axes.transLimits.transform(line.get_xydata()) for line in traces])
    wide, high = LETTER_INCHES * len(words) / inches[0], 1.6 * TYPE / 72.0 / inches[1]

    def covered(corner: tuple[float, float]) -> int:
        x, y = (np.abs(points[:, side] - corner[side]) for side in (0, 1))
        return int(((x < wide) & (y < high)).sum())

    right, top = min(((1.0, 0.0), (1.0, 1.0), (0.0, 0.0), (0.0, 1.0)), key=covered)
    axes.annotate(words, (0.01 + 0.98 * right, 0.02 + 0.96 * top), xycoords="axes fraction", fontsize=8,
                  ha="right" if right else "left", va="top" if top else "bottom",
                  bbox={"fc": "white", "alpha": 0.7, "lw": 0, "pad": 0.5})  # fmt: skip


def _level_keys(place: SubFigure, colours: Mapping[Any, str], varies: str, others: Mapping[str, Any]) -> None:
    """Draw the key of the shades and the line styles of the traces, with what the shades are of."""
    quantity, unit = AXIS_LABELS[varies].partition(" (")[0], UNITS.get(varies, "").partition(" ")[0]
    unit = unit if unit in OF_NOTHING_ELSE else ""
    keys = [Line2D([], [], color=tint, lw=2, alpha=TRACE_ALPHA, label=_with_unit(level, unit))
            for level, tint in colours.items()]  # fmt: skip
    keys += [Line2D([], [], color="black", lw=0.8, ls=style, label=label) for label, style in others.items()]
    if len(keys) == 1:  # the axis of counts has the one level
        return
    inches = float(place.bbox.width / place.figure.dpi)
    across = columns_of_key([str(key.get_label()) for key in keys], inches, 8, 1.4)
    title = f"shade: {quantity}{'; line: what else differs' if others else ''}"
    place.legend(handles=keys, handlelength=1.4, columnspacing=1.2, frameon=False, fontsize=8, ncols=across,
                 loc="outside upper center", title=title, title_fontsize=8)  # fmt: skip
