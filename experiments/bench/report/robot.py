"""Figures of robot trials: spikes along what the trials vary, potentials, their mechanism, and the paper's panels."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import matplotlib as mpl
import numpy as np
import numpy.typing as npt
import polars as pl
from matplotlib.axes import Axes
from matplotlib.figure import Figure, SubFigure
from scipy.special import stdtrit

from experiments.bench.report import style
from experiments.bench.run.parameters import in_title
from experiments.bench.run.rows import origin
from experiments.bench.sources.conditions import CONDITION_COLUMNS
from experiments.bench.sources.excitation import BALANCED, MOTION, PARTS, WHOLE
from experiments.bench.sources.trial_rows import varying
from experiments.bench.stats.tests import LEAST_FOR_INTERVAL, summarise

Row = Mapping[str, Any]
Thresholds = Mapping[str, float | None]
Floats = npt.NDArray[np.float64]
Lines = dict[tuple[Any, str], tuple[Floats, Floats]]
"""Level and other condition -> places along the axis, shape (T,), and the trials' values there, (trials, T)."""
UNITS = {"_cm_s2": "cm/s²", "_cm_s": "cm/s", "_deg_s": "°/s", "_hz": "Hz", "_deg": "°", "_cm": "cm"}
"""End of a column's name -> unit."""
SIGNED = {"angle_deg": "right positive", "observer_turn_deg_s": "left positive"}
PAPER = {"speed": "speed_cm_s", "distance": "distance_cm", "angular-approach": "angle_deg",
         "angular-recession": "angle_deg"}  # fmt: skip
"""The paper's systematic tests of the robot, and what each varies."""
NO_BREAK, MINUS = "\N{NO-BREAK SPACE}", "\N{MINUS SIGN}"
DASHES: Sequence[Any] = ("-", "--", ":", "-.", (0, (6, 2, 1, 2)), (0, (1, 3)))
MOST_NAMED = 2
"""Most models that a title names."""
BESIDE, ACROSS, CONDITIONS = 4, 4, 5
"""Models up to which potentials stand beside the counts; most models, and most conditions of excitation, in a row."""
LOGARITHMIC_FROM, QUIET = 10.0, 0.02
"""Ratio of levels from which an axis is logarithmic; share of the largest value below which an axis may end."""
BANDS = "Lines: means; bands: their 95 % interval. Below: filled HS, line HS with w_i = 1."
TIME, BEARING = ("sim_time_s", "time (s)"), ("stimulus_bearing_deg", "bearing of the stimulus (°, right positive)")
"""Axes of potentials: column of the frames, and label."""
SUMS = {"excitation": ("excitation", style.HUES[0]), "weighted_inhibition": ("inhibition", style.HUES[1])}
HS = {"hs": ("HS", style.INK), "hs_w_i_1": ("HS, w_i = 1", style.HUES[5]), "residue": ("leftover", style.HUES[3])}
"""Columns of excitation -> their names and colours."""
POINTS = "Dots: trials; dark: their means."
INTERVALS = "Dots: trials; dark: means with 95 % intervals. Titles order means with intervals apart."
TRACES = "Potentials: means; bands: range of the trials; dashes: threshold."


Measure = tuple[str, str, Mapping[str, str]]
"""A quantity in words, the label of its axis, and the columns of the trials' table that show it, each with a name."""
COUNT: Measure = ("spike count", "spikes per trial", {"spikes": ""})
IN_WINDOW: Measure = ("spike count", "spikes per trial", {"spikes": "crossing", "spikes_in_window": "window"})
MECHANISM: tuple[Measure, ...] = (
    ("time in view", "time in view (s)", {"seconds_in_view": ""}),
    ("firing rate", "firing rate in view (Hz)", {"rate_in_view_hz": ""}),
    ("peak potential", "potential", {"peak": "peak", "mean_hs_near_axis": "near axis"}),
)


def title(name: str, arena: str, rows: Sequence[Row], changed: Row, *, open_loop: bool) -> str:
    """Return what a figure's caption begins with: experiment, arena or a log's origin, parameters that changed."""
    return f"{name}, {origin(rows) or f'{arena} arena'}{', driven open loop' * open_loop}{in_title(changed)}"


def draw(
    kind: str, trials: Any, frames: Any, varies: str, thresholds: Thresholds, title: str, excitations: Any = (),
) -> Figure:  # fmt: skip
    """Draw the trials of a run.

    Parameters
    ----------
    kind
        ``spikes``: the count of every trial, and the potentials. ``mechanism``: count, time in view, firing rate and
        potential. ``excitation``: excitation and inhibition; without any ``excitations`` the counts.
    trials, frames
        Tables of polars or Arrow, or lists of rows: one for each trial and model, and for each frame of these.
    varies
        The column along the axis.
    thresholds
        Each model's spiking threshold; ``None``: it does not spike.
    title
        What was run; the caption begins with it.
    excitations
        Likewise, for each condition and frame means over trials: `experiments.bench.sources.excitation`.

    Returns
    -------
    matplotlib.figure.Figure
        With its findings as titles, and below it n and what the symbols mean.
    """
    frames, excitations = pl.DataFrame(frames), pl.DataFrame(excitations, infer_schema_length=None)
    rows = prepared(trials, frames, varies)
    with style.look():
        if len(excitations):
            return _excitation(rows, excitations, varies, thresholds[WHOLE], title)
        rows = rows.filter(~pl.col("model").is_in(PARTS)) if kind == "excitation" else rows
        if kind == "mechanism":
            return _mechanism(rows, varies, title)
        return _spikes(rows, frames, varies, thresholds, title)


def panels(runs: Mapping[str, Any]) -> Figure:
    """Draw the paper's four tests of the robot: spikes by speed, by distance, and by angle of approach and recession.

    Parameters
    ----------
    runs
        Name of an experiment -> its table of trials, or a list of their rows. Others than the four are ignored. Of each
        the first model is drawn.

    Returns
    -------
    matplotlib.figure.Figure
        A panel for each of the four that was run, with its finding as its title.
    """
    tables = {name: prepared(runs[name], None, varies) for name, varies in PAPER.items() if name in runs}
    first = {name: table.filter(model=table["model"][0]) for name, table in tables.items()}
    with style.look():
        figure = Figure((style.WIDTH, 2.15 * math.ceil(len(first) / 2) + 0.4), layout="constrained")
        for axes, letter, (name, rows) in zip(style.grid(figure, len(first), 2), "abcd", first.items(), strict=False):
            _points(axes, rows, COUNT, PAPER[name])
            axes.set(xlabel=_axis(PAPER[name]), ylabel=COUNT[1])
            words = finding(rows, COUNT, PAPER[name])
            style.finding(axes, f"{name.rpartition('-')[2].capitalize()}: {words}", letter)
        rows = pl.concat(first.values(), how="diagonal_relaxed")
        style.caption(figure, f"{_n(rows)}. {_symbols(rows)}")
    return figure


def _other_columns(trials: pl.DataFrame, varies: str) -> list[str]:
    """Return the conditions that differ beside the one along the axis; a motion's words say its direction."""
    along = ("model", varies, *["direction"] * (varies == "motion"))
    return [name for name in varying(trials.to_dicts(), varies) if name not in along]


def _caption(figure: Figure, title: str, rows: pl.DataFrame, varies: str, notes: str = "") -> None:
    """Write below a figure what was run, n, and what colours, line styles and symbols mean."""
    others = "".join(f"; line styles: {_unit(name)[0]}" for name in _other_columns(rows, varies))
    style.caption(
        figure, f"{title}. {_n(rows)}. Colours: {_unit(varies)[0]}{others}. {_symbols(rows)} {notes}".rstrip()
    )


def _symbols(rows: pl.DataFrame) -> str:
    """Return what dots and bars are; of one or two trials there are no bars."""
    most = max(rows.group_by("model", *CONDITION_COLUMNS).len()["len"])
    return INTERVALS if most >= LEAST_FOR_INTERVAL else POINTS


def prepared(table: Any, frames: pl.DataFrame | None, varies: str) -> pl.DataFrame:
    """Add ``level``, ``other`` and ``peak`` to a table of trials; without ``frames`` every potential is HS.

    Returns
    -------
    polars.DataFrame
        ``level`` is what stands along the axis; words of a motion say its direction. ``other`` are the other
        conditions that differ, in words. ``peak`` is the largest size of the model's potential; one that has looming
        alone has no HS near the axis.
    """
    trials = pl.DataFrame(table, infer_schema_length=None)
    words = [pl.Series(name, [_text(value, name) for value in trials[name]], pl.String)
             for name in _other_columns(trials, varies)]  # fmt: skip
    level = pl.format("{} {}", "direction", "motion") if varies == "motion" else pl.col(varies)
    looming = [] if frames is None else [model for model, name in _potentials(frames).items() if name == "looming"]
    size = pl.max_horizontal(pl.col("peak_hs", "trough_hs").cast(pl.Float64).abs())
    directed = ~pl.col("model").is_in(looming)
    return trials.with_columns(
        level=level, other=pl.concat_str(*words, separator=", ") if words else pl.lit(""),
        peak=pl.when(directed).then(size).otherwise("peak_looming"),
        mean_hs_near_axis=pl.when(directed).then("mean_hs_near_axis"),
    )  # fmt: skip


def _potentials(frames: pl.DataFrame) -> dict[str, str]:
    """Return the column of each model's potential: HS, or looming where that alone is ever other than 0."""
    sizes = frames.group_by("model", maintain_order=True).agg(pl.col("hs", "looming").abs().max().fill_null(0.0))
    return {model: "looming" if looming > 0.0 == hs else "hs" for model, hs, looming in sizes.iter_rows()}


def _unit(column: str) -> tuple[str, str]:
    """Return what a column is called, and its unit."""
    end = next((end for end in UNITS if column.endswith(end)), "")
    return column.removesuffix(end).replace("_", " "), UNITS.get(end, "")


def _axis(column: str) -> str:
    noun, unit = _unit(column)
    more = ", ".join(filter(None, (unit, SIGNED.get(column))))
    return f"{noun} ({more})" if more else noun


def _text(level: Any, column: str) -> str:
    """Return a level as keys and titles show it."""
    if level is None or isinstance(level, str):
        return level or "default"
    unit = _unit(column)[1]
    return f"{level:g}{'' if unit[:1] in '°' else NO_BREAK}{unit}".replace("-", MINUS)


def _n(rows: pl.DataFrame) -> str:
    models = style.levels(rows, "model")
    counts = sorted(set(rows.group_by("model", *CONDITION_COLUMNS).len()["len"]))
    of = f"{models[0]}, " if len(models) == 1 else ""
    return f"{of}n = {' to '.join(map(str, dict.fromkeys((counts[0], counts[-1]))))} per condition"


# --- findings ---------------------------------------------------------------------------------------------------------


def order(levels: Sequence[Any], samples: Sequence[Sequence[float]], varies: str) -> str:
    """Say what the 95 % intervals of means tell about their order, and no more.

    Parameters
    ----------
    levels
        Levels of the column ``varies``, in its order.
    samples
        The values of the trials at each level, three or more.

    Returns
    -------
    str
        One mean is called larger than another only where its interval lies above the other's.
    """
    summaries = [summarise(values) for values in samples]
    count = len(levels)
    if count == 1:
        return "is {0.mean:.3g}, with 95 % interval {0.ci_low:.3g} to {0.ci_high:.3g}".format(*summaries)
    if not any(map(any, samples)):
        return "is 0 throughout"
    above = np.array([[one.ci_low > other.ci_high for other in summaries] for one in summaries])
    words, ends = isinstance(levels[0], str), []
    for verb, beyond in (("rises", above.T), ("falls", above)):
        if not words and np.diagonal(beyond, 1).all():
            return f"{verb} with {_unit(varies)[0]}"
    means = [summary.mean for summary in summaries]
    for word, beyond, end in (("largest", above, int(np.argmax(means))), ("least", above.T, int(np.argmin(means)))):
        alike = [_text(level, varies) for level, less in zip(levels, beyond[end], strict=True) if not less]
        if len(alike) <= min(2, count // 2):
            ends.append(f"{word} {'for' if words else 'at'} {' or '.join(alike)}")
    return f"is {' and '.join(ends)}" if ends else "shows no clear order"


def finding(rows: pl.DataFrame, measure: Measure, varies: str) -> str:
    """Return the commonest order of a measure among the curves, one for each model and other condition.

    Which models rise and fall is always told, or of many how many. Of one or two trials each, whose means have no
    intervals, it names what is drawn.
    """
    noun, column = measure[0], next(iter(measure[2]))
    curves = {key: _samples(of, column) for key, of in style.by(rows.drop_nulls(column), "model", "other")}
    fewest = min((len(values) for _, samples in curves.values() for values in samples), default=LEAST_FOR_INTERVAL)
    if fewest < LEAST_FOR_INTERVAL:
        return drawn_of(noun, _unit(varies)[0], fewest)
    most = max((len(levels) for levels, _ in curves.values()), default=0)
    orders = {key: order(*curve, varies) for key, curve in curves.items() if len(curve[0]) > 1 or most == 1}
    (common, so), *others = Counter(orders.values()).most_common() or [("is not known", 0)]
    if len(orders) < 2:
        return f"{noun} {common}"
    several, along = rows["other"].n_unique() > 1, f" with {_unit(varies)[0]}"
    whose = {text: [model for (model, _), own in orders.items() if own == text] for text in orders.values()}
    named = {text: f"for {' and '.join(models)}" for text, models in whose.items()
             if len(models) <= MOST_NAMED and not several}  # fmt: skip
    counted = f"in {so} of {len(orders)} {'curves' if several else 'models'}"
    parts = [f"{noun} {common} {named.get(common, counted)}"]
    for text, n in others:
        if text.endswith(along) or len(others) == 1:
            short = text.removesuffix(along) if common.endswith(along) else text
            parts.append(f"{short} {named.get(text, f'in {n}')}")
    return ", ".join(parts)


def drawn_of(noun: str, along: str, n: int) -> str:
    """Name what is drawn along an axis where n, one or two trials of each condition, carries no finding."""
    return f"{noun} by {along}, {'one trial' if n == 1 else 'two trials'} each"


def _samples(rows: pl.DataFrame, column: str) -> tuple[list[Any], list[list[float]]]:
    """Return the levels, numbers in order, and the values of the trials at each."""
    rows = rows.drop_nulls(column)
    table = style.by(rows if rows["level"].dtype == pl.String else rows.sort("level"), "level").agg(column)
    return table["level"].to_list(), table[column].to_list()


# --- along what the trials vary ---------------------------------------------------------------------------------------


def tints(levels: Sequence[Any]) -> dict[Any, Any]:
    """Return a colour for each level: words apart, numbers from dark to light, signed ones blue, grey and red."""
    if isinstance(levels[0], str):
        return style.colours(levels)
    if min(levels) >= 0.0:
        return style.shades(levels)
    most, blend = max(map(abs, levels)), mpl.colormaps[style.DIVERGING]
    return {level: blend(0.5 + math.copysign(0.2 + 0.3 * abs(level) / most, level)) if level else style.GREY
            for level in sorted(levels)}  # fmt: skip


def _places(levels: Sequence[Any]) -> dict[Any, float]:
    """Return where levels stand along an axis: numbers to scale, over a wide range that of their logarithms."""
    if isinstance(levels[0], str):
        return {level: float(place) for place, level in enumerate(levels)}
    wide = levels[0] > 0 and levels[-1] >= LOGARITHMIC_FROM * levels[0]
    return {level: math.log(level) if wide else float(level) for level in levels}


def _points(axes: Axes, rows: pl.DataFrame, measure: Measure, varies: str) -> list[tuple[float, float, str, str]]:
    """Draw one model's trials as dots, means and intervals against the level, a line for each other condition.

    Returns the lines' ends, names and colours.
    """
    if rows.select(*measure[2]).null_count().sum_horizontal().item() == len(rows) * len(measure[2]):
        axes.set(xticks=[], yticks=[])
        axes.annotate("no threshold,\nno spikes", (0.5, 0.4), xycoords="axes fraction", ha="center", color=style.GREY)
        return []
    levels = _samples(rows.with_columns(one=1.0), "one")[0]
    places, colours = _places(levels), tints(levels)
    gap = min(np.diff(list(places.values())), default=1.0)
    ends: list[tuple[float, float, str, str]] = []
    size = 3.2 if axes.bbox.height > 0.8 * axes.figure.dpi else 2.2
    for column, name in measure[2].items():
        for (other,), of in style.by(rows.drop_nulls(column), "other"):
            shown, samples = _samples(of, column)
            summaries = [summarise(values) for values in samples]
            aside = 0.12 * gap * (len(ends) - (len(measure[2]) * rows["other"].n_unique() - 1) / 2)
            at, means = [places[level] + aside for level in shown], [summary.mean for summary in summaries]
            label = ", ".join(filter(None, (other, name)))
            line = "none" if isinstance(shown[0], str) else DASHES[len(ends) % len(DASHES)]
            axes.plot(at, means, "o", ls=line, lw=0.9, ms=size, color=style.INK, label=label or column, zorder=3)
            for place, level, values, summary in zip(at, shown, samples, summaries, strict=True):
                spread = place + gap * np.linspace(-0.22, 0.22, len(values) + 2)[1:-1]
                axes.plot(spread, values, "o", ms=size, mec="none", color=colours[level], alpha=0.75, zorder=2,
                          clip_on=False)  # fmt: skip
                if len(values) >= LEAST_FOR_INTERVAL:
                    axes.vlines(place, summary.ci_low, summary.ci_high, color=style.INK, lw=1.4, zorder=3)
            ends.append((at[-1], means[-1], label, style.INK))
    _ticks(axes, places, (0.6 if len(ends) > 1 else 1.0) * axes.bbox.width / axes.figure.dpi)
    axes.margins(y=0.08)
    low, high = axes.get_ylim()
    signed = rows.select(*measure[2]).min().min_horizontal().item() < 0.0
    axes.set_ylim(*((low, high) if signed else (0.0, 1.08 * axes.dataLim.y1 or 1.0)))
    if axes.dataLim.y1 == axes.dataLim.y0 == 0.0:
        axes.set_yticks([0.0])  # no count reached any other
    return ends if len(ends) > 1 else []


def _ticks(axes: Axes, places: Mapping[Any, float], inches: float) -> None:
    """Write the levels at their places: words upright where they would touch, no number that would touch the last."""
    x, step = list(places.values()), min(np.diff(list(places.values())), default=1.0)
    axes.set_xlim(x[0] - 0.5 * step, x[-1] + 0.5 * step)
    texts = [_text(level, "").replace(" ", "\n") for level in places]
    wide = max(len(word) for text in texts for word in text.split("\n")) * 0.5 * style.SMALL / 72.0
    wide *= (x[-1] - x[0] + step) / inches
    if words := isinstance(next(iter(places)), str):
        axes.tick_params(axis="x", labelrotation=90 if wide > step else 0)
    last = -math.inf
    for index, place in enumerate(x):
        texts[index] = texts[index] if words or place - last > 1.2 * wide else ""
        last = place if texts[index] else last
    axes.set_xticks(x, texts)


def _grid(part: SubFigure, names: Sequence[str], across: int, **options: Any) -> list[Axes]:
    """Return a panel for each model, with its name where there are several."""
    inches = part.bbox.width / part.figure.dpi / across - 0.3
    panels = style.grid(part, len(names), min(across, len(names)), **options)
    for axes, name in zip(panels, names, strict=True):
        axes.set_title(style.wrapped(name, inches, style.SMALL) if len(names) > 1 else "", fontsize=style.SMALL)
        axes.locator_params(axis="y", nbins=4)
    return panels


def _headlines(parts: Sequence[SubFigure], findings: Sequence[str]) -> None:
    """Write a finding above each part, with a letter; all take as many lines, so that panels stand level."""
    for part, words, letter in zip(parts, findings, "abcd", strict=False):
        style.headline(part, style.sentence(words), letter)
    texts = [part.get_suptitle() for part in parts]
    most = max(text.count("\n") for text in texts)
    for part, text in zip(parts, texts, strict=True):
        part.suptitle(text + "\n" * (most - text.count("\n")), x=0.01, ha="left", fontsize=style.TITLE,
                      fontweight="bold")  # fmt: skip


def _spikes(rows: pl.DataFrame, frames: pl.DataFrame, varies: str, thresholds: Thresholds, title: str) -> Figure:
    """Draw the counts of every trial and the potentials, a panel of each for each model."""
    models, potentials = style.levels(rows, "model"), _potentials(frames)
    few = len(models) <= BESIDE
    down = len(models) if few else 2 * math.ceil(len(models) / ACROSS)
    high = min((2.3 if len(models) == 1 else 1.45) * down, style.PAGE - 1.5)
    figure = Figure((style.WIDTH, high + (0.9 if few else 1.5)), layout="constrained")
    parts: Any = figure.subfigures(1, 2, width_ratios=[2.9, 4.2]) if few else figure.subfigures(2, 1)
    across = 1 if few else ACROSS
    counts = _grid(parts[0], models, across)
    ends = [_points(axes, rows.filter(model=model), COUNT, varies) for axes, model in zip(counts, models, strict=True)]
    axis, label = BEARING if _crosses(rows, frames) else TIME
    names = [f"{model} (looming)" if potentials.get(model) == "looming" else model for model in models]
    shown = _grid(parts[1], names, across, sharex=True)
    table = frames.join(rows.select("trial", "model", "level", "other"), on=["trial", "model"], maintain_order="left")
    lines = [resampled(table.filter(model=model), axis, potentials.get(model, "hs")) for model in models]
    peaks = [_traces(axes, of, varies) for axes, of in zip(shown, lines, strict=True)]
    for axes, model in zip(shown, models, strict=True):
        low, high, level = axes.dataLim.y0, axes.dataLim.y1, thresholds.get(model)
        name = f"{'threshold ' if few and axes is shown[0] else ''}{level or 0.0:.3g}"
        style.threshold(axes, level, signed=low < -0.3 * high, name=name, most=1.5 * max(high, -low))
    shown[0].set_xlim(*_busy(lines))
    for part, x, y in zip(parts, (_axis(varies), label), (COUNT[1], "potential (HS right positive)"), strict=True):
        part.supxlabel(x, fontsize=style.BODY)
        part.supylabel(y, fontsize=style.BODY)
    traced, fewest = finding(rows, MECHANISM[-1], varies), style.by(rows, "model", "level", "other").len()["len"].min()
    if fewest < LEAST_FOR_INTERVAL:
        traced = drawn_of("Potential", "bearing" if axis == BEARING[0] else "time", fewest)
    _headlines(parts, [finding(rows, COUNT, varies), traced])
    _caption(figure, title, rows, varies, TRACES)
    last = min(across, len(shown)) - 1
    figure.draw_without_rendering()  # labels stand clear of each other in panels that have their heights
    style.label_ends(counts[0], ends[0])
    style.label_ends(shown[last], [(shown[last].get_xlim()[1], *peak) for peak in peaks[last]])
    return figure


# --- over a trial -----------------------------------------------------------------------------------------------------


def _crosses(rows: pl.DataFrame, frames: pl.DataFrame) -> bool:
    """Tell whether every stimulus crosses the view of an observer that stands still, and its bearing is known."""
    still = pl.col("observer_speed_cm_s", "observer_turn_deg_s") == 0.0
    crossing = pl.all_horizontal(still, pl.col("motion") == "translation").all()
    return bool(rows.select(crossing).item()) and frames["stimulus_bearing_deg"].null_count() == 0


def resampled(frames: pl.DataFrame, axis: str, potential: str) -> Lines:
    """Return one model's potential in each condition, all trials at the same places of the ``axis``, else NaN."""
    lines = {}
    for (level, other), of in style.by(frames.drop_nulls([axis, potential]), "level", "other"):
        trials = of.sort(axis, maintain_order=True).partition_by("trial")
        grid = np.linspace(of[axis].min(), of[axis].max(), max(map(len, trials)))
        values = [np.interp(grid, trial[axis], trial[potential], np.nan, np.nan) for trial in trials]
        lines[level, other] = (grid, np.stack(values))
    return lines


def _traces(axes: Axes, lines: Lines, varies: str) -> list[tuple[float, str, Any]]:
    """Draw the mean of the trials of each condition, and their range; return each level's peak, name and colour."""
    ends: dict[Any, tuple[float, str, Any]] = {}
    levels = list(dict.fromkeys(level for level, _ in lines))
    colours = tints(levels) if levels else {}
    others = list(dict.fromkeys(other for _, other in lines))
    for (level, other), (grid, values) in lines.items():
        dash = DASHES[others.index(other) % len(DASHES)]
        mean, name = np.nanmean(values, axis=0), _text(level, varies)
        band = np.nanmin(values, axis=0), np.nanmax(values, axis=0)
        axes.fill_between(grid, *band, color=colours[level], alpha=0.25, lw=0)
        axes.plot(grid, mean, color=colours[level], ls=dash, lw=1.2, label=name)
        ends.setdefault(level, (float(mean[np.abs(mean).argmax()]), name, colours[level]))
    axes.margins(y=0.06)
    return list(ends.values())


def _busy(panels: Iterable[Lines]) -> tuple[float, float]:
    """Return from where to where any line is above `QUIET` of the largest of its panel, with room for a name."""
    places: list[Floats] = []
    for lines in panels:
        most = max(float(np.nanmax(np.abs(values))) for _, values in lines.values())
        places += [x[(np.abs(values) >= QUIET * most).any(axis=0)] for x, values in lines.values()]
    busy = np.concatenate(places)
    reach = float(np.ptp(busy)) or 1.0
    return float(busy.min()) - 0.2 * reach, float(busy.max()) + 0.02 * reach


# --- mechanism --------------------------------------------------------------------------------------------------------


def _mechanism(rows: pl.DataFrame, varies: str, title: str) -> Figure:
    """Draw why counts go as they do: a row for each model with count, time in view, firing rate and potential."""
    models = style.levels(rows, "model")
    high = min(2.0 if len(models) == 1 else 1.3, (style.PAGE - 1.6) / len(models))
    figure = Figure((style.WIDTH, high * len(models) + 1.3), layout="constrained")
    measures = (IN_WINDOW if varies == "speed_cm_s" else COUNT, *MECHANISM)
    parts: Any = figure.subfigures(1, len(measures))
    for part, measure in zip(parts, measures, strict=True):
        shown = _grid(part, models, 1, sharex=True)
        named = [axes for axes, model in zip(shown, models, strict=True)
                 if _points(axes, rows.filter(model=model), measure, varies)]  # fmt: skip
        for axes in named[:1]:  # names beside the lines would take a third of so narrow a panel
            axes.legend(loc="best", frameon=False, fontsize=style.SMALL, handlelength=2.0, markerscale=0.0)
        part.supxlabel(_axis(varies), fontsize=style.BODY)
        part.supylabel(measure[1], fontsize=style.BODY)
    _headlines(parts, [finding(rows, measure, varies) for measure in measures])
    _caption(figure, title, rows, varies)
    return figure


def _excitation(rows: pl.DataFrame, excitations: pl.DataFrame, varies: str, level: float | None, title: str) -> Figure:
    """Draw excitation, inhibition, HS and the share of trials that spike over time, a column for each condition."""
    conditions = excitations.partition_by(MOTION, maintain_order=True)
    across = min(len(conditions), CONDITIONS)
    down = math.ceil(len(conditions) / across)
    figure = Figure((style.WIDTH, min(4.2, (style.PAGE - 1.2) / down) * down + 1.0), layout="constrained")
    grid = figure.subplots(3 * down, across, squeeze=False, sharex=True, sharey="row", height_ratios=[3, 4, 2] * down)
    for axes in grid[-3:, (len(conditions) - 1) % across + 1 :].flat:
        axes.set_visible(False)
    curves: Lines = {}
    for place, of in enumerate(conditions):
        panels = grid[3 * (place // across) : 3 * (place // across) + 3, place % across]
        _over_time(panels, of, level, "threshold" if place == len(conditions) - 1 else "", labelled=place == 0)
        motion, angle, distance = of.select("motion", "angle_deg", "distance_cm").row(0)
        where = _text(distance, "distance_cm") if angle is None else _text(angle, "angle_deg")
        panels[0].set_title(style.wrapped(f"{motion} {where}", style.WIDTH / across - 0.3), fontsize=style.BODY)
        panels[2].set_xlabel("time (s)")
        curves[place, ""] = of["sim_time_s"].to_numpy(), of.select(*SUMS, *HS).to_numpy().T
    labels = ("excitation, inhibition", "HS (right positive)", "share of trials that spike") * down
    for axes, label in zip(grid[:, 0], labels, strict=True):
        axes.set_ylabel(style.wrapped(label, 0.9), fontsize=style.BODY)
    grid[0, 0].set_xlim(*_busy([curves]))
    whole, balanced = (finding(rows.filter(model=model), COUNT, varies) for model in (WHOLE, BALANCED))
    n, w_i = excitations.select("n", "w_i").row(0)
    words = style.sentence(f"{whole}; with w_i = 1 the {balanced}")
    style.headline(
        figure, words if n >= LEAST_FOR_INTERVAL else drawn_of("Excitation and inhibition", _unit(varies)[0], n)
    )
    left = f"Inhibition has its weight, w_i = {w_i:g}; leftover: {1.0 - w_i:.2g} (E + I) / 2, of symmetric motion."
    style.caption(figure, f"{title}. {WHOLE}, n = {n} per condition. {BANDS} {left}")
    return figure


def _over_time(panels: Any, of: pl.DataFrame, threshold: float | None, name: str, *, labelled: bool) -> None:
    """Draw one condition: excitation and inhibition, HS, and the share of trials that spike."""
    time, n = of["sim_time_s"].to_numpy(), of["n"].to_numpy()
    for axes, names in zip(panels, (SUMS, HS), strict=False):
        for column, (label, colour) in names.items():
            mean = of[column].to_numpy()
            axes.plot(time, mean, color=colour, label=label)
            half = stdtrit(n - 1, 0.975) * of[f"{column}_sd"].fill_null(np.nan).to_numpy() / np.sqrt(n)
            axes.fill_between(time, mean - half, mean + half, color=colour, alpha=0.3, lw=0)
        if labelled:
            axes.legend(loc="best", handlelength=0.0, labelcolor="linecolor", edgecolor="none", fontsize=style.SMALL)
    style.threshold(panels[1], threshold, signed=True, name=name)
    panels[2].fill_between(time, of["firing"] / n, step="mid", color=HS["hs"][1], alpha=0.4, lw=0)
    panels[2].step(time, of["firing_w_i_1"] / n, where="mid", color=HS["hs_w_i_1"][1], lw=1.0)
    panels[2].set_ylim(0.0, 1.05)
