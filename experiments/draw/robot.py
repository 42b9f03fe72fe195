"""Figures of robot trials: spikes along what the trials vary, potentials, their mechanism, and the paper's panels."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import polars as pl
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from scipy.special import stdtrit

from experiments.base import palette
from experiments.declare.conditions import CONDITION_COLUMNS
from experiments.declare.experiment import BALANCED, PARTS, WHOLE
from experiments.draw import style
from experiments.draw.style import axis, drawn_of, level_text, unit
from experiments.judge.tests import LEAST_FOR_INTERVAL, Floats
from experiments.show.excitation import MOTION
from experiments.show.trial_rows import varying
from experiments.store.tables import origin

Row = Mapping[str, Any]
Thresholds = Mapping[str, float | None]
Lines = dict[tuple[Any, str], tuple[Floats, Floats]]
"""Level and other condition -> places along the axis, shape (T,), and the trials' values there, (trials, T)."""
PAPER = {"speed": "speed_cm_s", "distance": "distance_cm", "angular-approach": "angle_deg",
         "angular-recession": "angle_deg"}  # fmt: skip
"""The paper's systematic tests of the robot, and what each varies."""
DASHES: Sequence[Any] = ("-", "--", ":", "-.", (0, (6, 2, 1, 2)), (0, (1, 3)))
MARKERS = "osD^vP"
"""As many as there are dashes."""
MOST_ROWS = 24
MOST_TICKS = 6
"""Most levels of a number that have a tick each."""
CONDITIONS = 5
"""Most conditions of excitation in a row."""
FILLED = "Below: filled HS, line HS with w_i = 1."
TIME, BEARING = ("time_s", "time (s)"), ("stimulus_bearing_deg", "bearing of the stimulus (°, right positive)")
"""Axes of potentials: column of the frames, and label."""
_TEAL, _PINK, _BROWN, _ = palette.OTHERS.values()
SUMS = {"excitation": ("excitation", _TEAL), "weighted_inhibition": ("inhibition", _PINK)}
HS = {"hs": ("HS", palette.CHANNELS["hs"]), "hs_w_i_1": ("HS, w_i = 1", palette.INK), "residue": ("leftover", _BROWN)}
"""Columns of excitation -> their names and colours."""
ORDERS = ("rises", "falls", "largest", "least")
ORDERED = "Titles order only means whose intervals do not overlap."

Panel = tuple[str, str, Mapping[str, str]]
"""A quantity in words, the label of its axis, and the columns of the trials' table that show it, each with a name."""
COUNT: Panel = ("spike count", "spikes per trial", {"spikes": ""})
DIFFERENCE: Panel = ("HS (excitation minus inhibition)", "HS", {"farthest": ""})
IN_WINDOW: Panel = ("spike count", "spikes per trial", {"spikes": "crossing", "spikes_in_window": "window"})
MECHANISM: tuple[Panel, ...] = (
    ("time in view", "time in view (s)", {"seconds_in_view": ""}),
    ("firing rate", "firing rate in view (Hz)", {"rate_in_view_hz": ""}),
    ("peak |potential|", "potential", {"peak": "peak", "mean_hs_near_axis": "near axis"}),
)


def title(name: str, arena: str, rows: Sequence[Row], changed: Row, *, open_loop: bool) -> str:
    """Return what a figure's caption begins with: experiment, arena or a log's origin, parameters that changed."""
    return f"{name}, {origin(rows) or f'{arena} arena'}{', driven open loop' * open_loop}{style.in_title(changed)}"


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
        Likewise, for each condition and frame means over trials: `experiments.show.excitation`.

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
            _points(axes, rows, COUNT, style.tints(rows["level"], PAPER[name]))
            axes.set(xlabel=axis(PAPER[name]), ylabel=COUNT[1])
            words, _ = finding(rows, COUNT, PAPER[name])
            words = words.removeprefix("Spike count").lstrip(": ").removeprefix("is ")  # as the axis says
            style.finding(axes, f"{name.rpartition('-')[2].capitalize()}: {words}", letter)
        _caption(figure, "", pl.concat(first.values(), how="diagonal_relaxed"))
    return figure


def _other_columns(trials: pl.DataFrame, varies: str) -> list[str]:
    """Return the variables that differ besides the one along the axis; a motion has its direction in words."""
    along = ("model", varies, *["direction"] * (varies == "motion"))
    return [name for name in varying(trials.to_dicts(), varies) if name not in along]


def _caption(figure: Figure, title: str, rows: pl.DataFrame, varies: str = "", *notes: str) -> None:
    """Write below a figure what was run, n, what colours, line styles and symbols mean, and the order of means."""
    counts, models = rows.group_by("model", *CONDITION_COLUMNS).len()["len"], style.levels(rows, "model")
    n = " to ".join(dict.fromkeys((str(counts.min()), str(counts.max()))))
    run = [*[title] * bool(title), f"{f'{models[0]}, ' * (len(models) == 1)}n = {n} per condition"]
    most: Any = counts.max()
    ordered = any(word in axes.get_title("left") for axes in figure.axes for word in ORDERS)
    symbols = f"Dots: trials{'; dark: means' * (most > 1)}{', 95 % intervals' * (most >= LEAST_FOR_INTERVAL)}."
    style.caption(figure, f"{'. '.join(run)}.", symbols, ORDERED * ordered, *notes)


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
    words = [pl.Series(name, [level_text(value, unit(name)[1]) for value in trials[name]], pl.String)
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


def finding(rows: pl.DataFrame, measure: Panel, varies: str) -> tuple[str, str]:
    """Return a panel's title, and the order of the means of each model and other condition where it is not that.

    Of one or two trials each, what is drawn.
    """
    noun, column = measure[0], next(iter(measure[2]))
    several = rows["model"].n_unique() > 1
    curves = {", ".join(filter(None, (model * several, other))): style.curve(of, "level", column)
              for (model, other), of in style.by(rows.drop_nulls(column), "model", "other")}  # fmt: skip
    fewest = min((len(values) for _, samples in curves.values() for values in samples), default=LEAST_FOR_INTERVAL)
    if fewest < LEAST_FOR_INTERVAL:
        return style.sentence(style.drawn_of(f"{noun} by {unit(varies)[0]}", fewest)), ""
    title = style.shared(noun, style.orders(curves.values(), *unit(varies)), unit(varies)[0])
    each = [f"{name} {text.removeprefix('is ')}" for name, one in curves.items()
            for text in style.orders([one], *unit(varies))]  # fmt: skip
    return title, style.sentence(f"{noun}: {', '.join(each)}.") if f" by {unit(varies)[0]}" in title else ""


# --- along what the trials vary ---------------------------------------------------------------------------------------


def _points(axes: Axes, rows: pl.DataFrame, measure: Panel, tints: Mapping[Any, str]) -> None:
    """Draw one model's trials as dots, means and intervals against the level, a line for each other condition."""
    shown = rows.select(*measure[2])
    if shown.null_count().sum_horizontal().item() == len(rows) * len(measure[2]):
        axes.set_yticks([])
        axes.annotate("no threshold, no spikes", (0.5, 0.4), xycoords="axes fraction", ha="center",
                      fontsize=style.SMALL, color=palette.GREY)  # fmt: skip
        return
    levels = style.curve(rows.with_columns(one=1.0), "level", "one")[0]
    words = isinstance(levels[0], str)
    places = dict(zip(levels, range(len(levels)) if words else levels, strict=True))
    gap = min(np.diff(list(places.values())), default=1.0)
    curves = [(", ".join(filter(None, (other, name))) or column, style.curve(of, "level", column))
              for column, name in measure[2].items()
              for (other,), of in style.by(rows.drop_nulls(column), "other")]  # fmt: skip
    for place, (label, (found, samples)) in enumerate(curves):
        at = [places[level] + 0.12 * gap * (place - (len(curves) - 1) / 2) for level in found]
        line = "none" if words else DASHES[place % len(DASHES)]
        style.means(axes, at, samples, palette.INK, label, line=line, marker=MARKERS[place % len(MARKERS)], gap=gap,
                    dots=[tints[level] for level in found])  # fmt: skip
    if words:
        axes.set_xticks(range(len(levels)), [level_text(level).replace(" ", "\n") for level in levels])
        axes.tick_params(axis="x", labelrotation=90 if len(levels) > 3 else 0)
    elif 1 < len(levels) <= MOST_TICKS:
        axes.set_xticks(levels, map(level_text, levels))
    axes.margins(x=0.08, y=0.08)
    if shown.min().min_horizontal().item() >= 0.0:
        top = 1.08 * axes.dataLim.y1 or 1.0
        axes.set_ylim(-0.05 * top, top)
        if not axes.dataLim.y1:
            axes.set_yticks([0.0])


def _rows(rows: pl.DataFrame) -> list[tuple[str, pl.DataFrame]]:
    """Return what each row of panels is called, and its trials: those of a model and of a level of a second factor.

    More than `MOST_ROWS` would be too low: then a model has one row, with a line for each other condition.
    """
    by = ["model", "other"] if rows.select("model", "other").n_unique() <= MOST_ROWS else ["model"]
    several = [name for name in by if rows[name].n_unique() > 1]
    return [(", ".join(filter(None, of.select(several).row(0))) if several else "", of)
            for _, own in style.by(rows, "model") for _, of in style.by(own, *by)]  # fmt: skip


def _grid(names: Sequence[str], labels: Sequence[str], titles: Sequence[str], **options: Any) -> tuple[Figure, Any]:
    """Return a figure with a row for each name, and its panels: a column for each quantity, below its title."""
    high = min(2.3 if len(names) == 1 else 1.4, (style.PAGE - 1.6) / len(names))
    figure = Figure((style.WIDTH, high * len(names) + 1.3), layout="constrained")
    grid = figure.subplots(len(names), len(labels), squeeze=False, sharex="col", **options)
    for axes, title, label, letter in zip(grid[0], titles, labels, "abcd", strict=False):
        style.finding(axes, title, letter, label)
    for axes in grid.flat:
        axes.locator_params(axis="y", nbins=4)
    return figure, grid


def _spikes(rows: pl.DataFrame, frames: pl.DataFrame, varies: str, thresholds: Thresholds, title: str) -> Figure:
    """Draw the counts of every trial and the potentials: a row for each model."""
    potentials, panels = _potentials(frames), _rows(rows)
    column, label = BEARING if _crosses(rows, frames) else TIME
    (counted, order), (traced, rise) = (finding(rows, measure, varies) for measure in (COUNT, MECHANISM[-1]))
    sizes = style.by(rows, "model", "level", "other").len()["len"]
    fewest: Any = sizes.min()
    if rise or fewest < LEAST_FOR_INTERVAL:
        traced = drawn_of(f"Potential {'by bearing' if column == BEARING[0] else 'over time'}", fewest)
    kinds = dict.fromkeys(potentials.get(of["model"][0], "hs") for _, of in panels)
    shown = "; ".join(palette.TITLES[name] + ", right positive" * (name == "hs") for name in kinds)
    figure, grid = _grid([name for name, _ in panels], (COUNT[1], f"potential ({shown})"), (counted, traced),
                         width_ratios=[2.9, 4.2])  # fmt: skip
    peaks, tints = [], style.tints(rows["level"], varies)
    for (counts, traces), (name, of) in zip(grid, panels, strict=True):
        model, kept = of["model"][0], of.select("trial", "model", "level", "other")
        potential, level = potentials.get(model, "hs"), thresholds.get(model)
        _points(counts, of, COUNT, tints)
        table = frames.join(kept, on=["trial", "model"], maintain_order="left")
        peaks.append(_traces(traces, resampled(table, column, potential), varies, tints))
        low, high = traces.dataLim.y0, traces.dataLim.y1
        style.threshold(traces, level, signed=low < -0.3 * high, named=not name, most=1.5 * max(high, -low))
        style.row_name(counts, name + (" (looming)" if name and potential == "looming" else ""), level)
    grid[-1, 0].set_xlabel(axis(varies))
    grid[-1, 1].set_xlabel(label)
    style.legend(figure, grid[:, 0])
    traces = "Potentials: means; bands: range of the trials; dashes: T." if sizes.max() != 1 else "Dashes: T."
    _caption(figure, title, rows, varies, traces, order, rise)
    figure.draw_without_rendering()  # labels stand clear of each other in panels that have their heights
    right = grid[0, 1].get_xlim()[1]
    style.label_ends(grid[0, 1], [(right, *peak) for peak in peaks[0]])
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


def _traces(axes: Axes, lines: Lines, varies: str, tints: Mapping[Any, str]) -> list[tuple[float, str, Any]]:
    """Draw the mean of the trials of each condition, and their range; return peak, name and colour of each level."""
    others = list(dict.fromkeys(other for _, other in lines))
    peaks: dict[Any, tuple[float, str, Any]] = {}
    for (level, other), (grid, values) in lines.items():
        mean, (noun, of) = np.nanmean(values, axis=0), unit(varies)
        name = level_text(level, of) if of or isinstance(level, str) else f"{noun} {level_text(level)}"
        axes.fill_between(grid, np.nanmin(values, axis=0), np.nanmax(values, axis=0), color=tints[level], alpha=0.25,
                          lw=0)  # fmt: skip
        axes.plot(grid, mean, color=tints[level], lw=1.2, ls=DASHES[others.index(other) % len(DASHES)], label=name)
        peaks.setdefault(level, (float(mean[np.abs(mean).argmax()]), name, tints[level]))
    axes.margins(y=0.06)
    return list(peaks.values())


# --- mechanism --------------------------------------------------------------------------------------------------------


def _mechanism(rows: pl.DataFrame, varies: str, title: str) -> Figure:
    """Draw why counts go as they do: a row for each model with count, time in view, firing rate and potential."""
    panels, measures = _rows(rows), (IN_WINDOW if varies == "speed_cm_s" else COUNT, *MECHANISM)
    titles, orders = zip(*(finding(rows, measure, varies) for measure in measures), strict=True)
    figure, grid = _grid([name for name, _ in panels], [measure[1] for measure in measures], titles)
    tints = style.tints(rows["level"], varies)
    for row, (name, of) in zip(grid, panels, strict=True):
        style.row_name(row[0], name)
        for axes, measure in zip(row, measures, strict=True):
            _points(axes, of, measure, tints)
    for axes in grid[-1]:
        axes.set_xlabel(axis(varies))
    style.legend(figure, grid[0])
    _caption(figure, title, rows, varies, *orders)
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
    for place, of in enumerate(conditions):
        panels = grid[3 * (place // across) : 3 * (place // across) + 3, place % across]
        _over_time(panels, of, level, first=place == 0)
        motion, angle, distance = of.select("motion", "angle_deg", "distance_cm").row(0)
        where = level_text(distance, "cm") if angle is None else level_text(angle, "°")
        panels[0].set_title(style.wrapped(f"{motion} {where}", style.WIDTH / across - 0.3), fontsize=style.BODY)
        panels[2].set_xlabel("time (s)")
    labels = ("excitation, inhibition", "HS (right positive)", "share of trials that spike") * down
    for axes, label in zip(grid[:, 0], labels, strict=True):
        axes.set_ylabel(style.wrapped(label, 0.9), fontsize=style.BODY)
    rightward = pl.col("peak_hs") >= -pl.col("trough_hs")
    signed = rows.with_columns(farthest=pl.when(rightward).then("peak_hs").otherwise("trough_hs"))
    (whole, _), (balanced, _) = (finding(signed.filter(model=model), DIFFERENCE, varies) for model in (WHOLE, BALANCED))
    n, w_i = excitations.select("n", "w_i").row(0)
    style.headline(figure, whole)
    style.legend(figure, grid[:2, 0])
    left = f"Leftover: {1.0 - w_i:.2g} (E + I) / 2, of symmetric motion, as w_i = {w_i:g}."
    run, bands = f"{title}. {WHOLE}, n = {n} per condition.", "Lines: means; bands: 95 % intervals." * (n > 1)
    style.caption(figure, run, bands, FILLED, left, f"With w_i = 1: {balanced}.")
    return figure


def _over_time(panels: Any, of: pl.DataFrame, threshold: float | None, *, first: bool) -> None:
    """Draw one condition: excitation and inhibition, HS, and the share of trials that spike."""
    time, n = of["time_s"].to_numpy(), of["n"].to_numpy()
    for axes, names in zip(panels, (SUMS, HS), strict=False):
        for column, (label, colour) in names.items():
            mean = of[column].to_numpy()
            axes.plot(time, mean, color=colour, label=label)
            half = stdtrit(n - 1, 0.975) * of[f"{column}_sd"].fill_null(np.nan).to_numpy() / np.sqrt(n)
            axes.fill_between(time, mean - half, mean + half, color=colour, alpha=0.3, lw=0)
    style.threshold(panels[1], threshold, signed=True, named=first)
    panels[2].fill_between(time, of["firing"] / n, step="mid", color=HS["hs"][1], alpha=0.4, lw=0)
    panels[2].step(time, of["firing_w_i_1"] / n, where="mid", color=HS["hs_w_i_1"][1], lw=1.0)
    panels[2].set_ylim(0.0, 1.05)
