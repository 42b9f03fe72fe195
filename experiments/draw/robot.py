"""Figures of robot trials: spikes along what the trials vary, potentials, their mechanism, and the paper's panels."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
import polars as pl
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from scipy.special import stdtrit

from experiments.base import palette
from experiments.declare.conditions import CONDITION_COLUMNS
from experiments.declare.experiment import BALANCED, PARTS, WHOLE
from experiments.draw import findings, style
from experiments.draw.findings import axis, drawn_of, level_text, unit
from experiments.judge.tests import LEAST_FOR_INTERVAL
from experiments.show.excitation import MOTION
from experiments.show.trial_rows import varying
from experiments.store.tables import origin

Row = Mapping[str, Any]
Thresholds = Mapping[str, float | None]
Floats = npt.NDArray[np.float64]
Lines = dict[tuple[Any, str], tuple[Floats, Floats]]
"""Level and other condition -> places along the axis, shape (T,), and the trials' values there, (trials, T)."""
PAPER = {"speed": "speed_cm_s", "distance": "distance_cm", "angular-approach": "angle_deg",
         "angular-recession": "angle_deg"}  # fmt: skip
"""The paper's systematic tests of the robot, and what each varies."""
DASHES: Sequence[Any] = ("-", "--", ":", "-.", (0, (6, 2, 1, 2)), (0, (1, 3)))
MARKERS = "osD^vP"
"""As many as there are dashes."""
MOST_TICKS = 6
"""Most levels of a number that have a tick each."""
CONDITIONS = 5
"""Most conditions of excitation in a row."""
BANDS = "Lines: means; bands: their 95 % interval; T: threshold. Below: filled HS, line HS with w_i = 1."
TIME, BEARING = ("time_s", "time (s)"), ("stimulus_bearing_deg", "bearing of the stimulus (°, right positive)")
"""Axes of potentials: column of the frames, and label."""
SUMS = {"excitation": ("excitation", palette.OTHERS[0]), "weighted_inhibition": ("inhibition", palette.OTHERS[1])}
HS = {"hs": ("HS", palette.CHANNELS["hs"]), "hs_w_i_1": ("HS, w_i = 1", palette.INK),
      "residue": ("leftover", palette.OTHERS[2])}  # fmt: skip
"""Columns of excitation -> their names and colours."""
POINTS = "Dots: trials; dark: their means; both are set apart sideways."
INTERVALS = ("Dots: trials; dark: means with 95 % intervals; both are set apart sideways. Titles compare only means"
             " whose intervals do not overlap.")  # fmt: skip
TRACES = "Potentials: means; bands: range of the trials; dashes: threshold T."

Panel = tuple[str, str, Mapping[str, str]]
"""A quantity in words, the label of its axis, and the columns of the trials' table that show it, each with a name."""
COUNT: Panel = ("spike count", "spikes per trial", {"spikes": ""})
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
            _points(axes, rows, COUNT, PAPER[name])
            axes.set(xlabel=axis(PAPER[name]), ylabel=COUNT[1])
            words = finding(rows, COUNT, PAPER[name])
            style.finding(axes, f"{name.rpartition('-')[2].capitalize()}: {words}", letter)
        _caption(figure, "", pl.concat(first.values(), how="diagonal_relaxed"))
    return figure


def _other_columns(trials: pl.DataFrame, varies: str) -> list[str]:
    """Return the variables that differ besides the one along the axis; a motion has its direction in words."""
    along = ("model", varies, *["direction"] * (varies == "motion"))
    return [name for name in varying(trials.to_dicts(), varies) if name not in along]


def _caption(figure: Figure, title: str, rows: pl.DataFrame, varies: str = "", notes: str = "") -> None:
    """Write below a figure what was run, n, and what colours, line styles and symbols mean."""
    counts, models = rows.group_by("model", *CONDITION_COLUMNS).len()["len"], style.levels(rows, "model")
    n = " to ".join(dict.fromkeys((str(counts.min()), str(counts.max()))))
    keys = ["Colours: " + "; lines, markers: ".join(unit(name)[0] for name in (varies, *_other_columns(rows, varies)))]
    run = [*[title] * bool(title), f"{f'{models[0]}, ' * (len(models) == 1)}n = {n} per condition"]
    symbols = INTERVALS if counts.max() >= LEAST_FOR_INTERVAL else POINTS  # type: ignore[operator]
    style.caption(figure, f"{'. '.join([*run, *keys * bool(varies)])}. {symbols} {notes}".rstrip())


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


def finding(rows: pl.DataFrame, measure: Panel, varies: str) -> str:
    """Return what the curves of each model and other condition show; of one or two trials each, what is drawn."""
    noun, column = measure[0], next(iter(measure[2]))
    several = rows["model"].n_unique() > 1
    curves = {", ".join(filter(None, (model * several, other))): findings.curve(of, "level", column)
              for (model, other), of in style.by(rows.drop_nulls(column), "model", "other")}  # fmt: skip
    fewest = min((len(values) for _, samples in curves.values() for values in samples), default=LEAST_FOR_INTERVAL)
    if fewest < LEAST_FOR_INTERVAL:
        return drawn_of(noun, unit(varies)[0], fewest)
    things = "curves" if rows["other"].n_unique() > 1 else "models"
    return findings.finding(noun, curves.values(), *unit(varies), things, [*curves])


# --- along what the trials vary ---------------------------------------------------------------------------------------


def _points(axes: Axes, rows: pl.DataFrame, measure: Panel, varies: str) -> None:
    """Draw one model's trials as dots, means and intervals against the level, a line for each other condition."""
    shown = rows.select(*measure[2])
    if shown.null_count().sum_horizontal().item() == len(rows) * len(measure[2]):
        axes.set_yticks([])
        axes.annotate("no threshold,\nno spikes", (0.5, 0.4), xycoords="axes fraction", ha="center", color=palette.GREY)
        return
    levels = findings.curve(rows.with_columns(one=1.0), "level", "one")[0]
    words, colours = isinstance(levels[0], str), style.tints(levels, varies)
    places = dict(zip(levels, range(len(levels)) if words else levels, strict=True))
    gap = min(np.diff(list(places.values())), default=1.0)
    curves = [(", ".join(filter(None, (other, name))) or column, findings.curve(of, "level", column))
              for column, name in measure[2].items()
              for (other,), of in style.by(rows.drop_nulls(column), "other")]  # fmt: skip
    for place, (label, (found, samples)) in enumerate(curves):
        at = [places[level] + 0.12 * gap * (place - (len(curves) - 1) / 2) for level in found]
        line = "none" if words else DASHES[place % len(DASHES)]
        style.means(axes, at, samples, palette.INK, label, line=line, marker=MARKERS[place % len(MARKERS)], gap=gap,
                    dots=[colours[level] for level in found])  # fmt: skip
    if len(curves) > 1:
        axes.legend(loc="best", frameon=False, fontsize=style.SMALL, handlelength=2.0)
    if words:
        axes.set_xticks(range(len(levels)), [level_text(level).replace(" ", "\n") for level in levels])
        axes.tick_params(axis="x", labelrotation=90 if len(levels) > 3 else 0)
    elif len(levels) <= MOST_TICKS:
        axes.set_xticks(levels, map(level_text, levels))
    axes.margins(x=0.08, y=0.08)
    if shown.min().min_horizontal().item() >= 0.0:
        axes.set_ylim(0.0, 1.08 * axes.dataLim.y1 or 1.0)


def _grid(models: Sequence[str], labels: Sequence[str], found: Sequence[str], **options: Any) -> tuple[Figure, Any]:
    """Return a figure with a row for each model, and its panels: a column for each quantity; findings are above."""
    high = min(2.3 if len(models) == 1 else 1.4, (style.PAGE - 1.8) / len(models))
    figure = Figure((style.WIDTH, high * len(models) + 1.1 + 0.2 * len(labels)), layout="constrained")
    style.headline(figure, *map(style.sentence, found), letter="a")
    grid = figure.subplots(len(models), len(labels), squeeze=False, sharex="col", **options)
    for axes, label, letter in zip(grid[0], labels, "abcd", strict=False):
        axes.set_title(f"{letter}  {label}")
    for axes, model in zip(grid[:, 0], models if len(models) > 1 else (), strict=False):
        style.row_name(axes, model)
    for axes in grid.flat:
        axes.locator_params(axis="y", nbins=4)
    return figure, grid


def _spikes(rows: pl.DataFrame, frames: pl.DataFrame, varies: str, thresholds: Thresholds, title: str) -> Figure:
    """Draw the counts of every trial and the potentials: a row for each model."""
    models, potentials = style.levels(rows, "model"), _potentials(frames)
    column, label = BEARING if _crosses(rows, frames) else TIME
    traced, fewest = finding(rows, MECHANISM[-1], varies), style.by(rows, "model", "level", "other").len()["len"].min()
    if fewest < LEAST_FOR_INTERVAL:
        traced = drawn_of("Potential", "bearing" if column == BEARING[0] else "time", fewest)
    names = [f"{model} (looming)" if potentials.get(model) == "looming" else model for model in models]
    figure, grid = _grid(names, (COUNT[1], "potential (HS right positive)"), (finding(rows, COUNT, varies), traced),
                         width_ratios=[2.9, 4.2])  # fmt: skip
    table = frames.join(rows.select("trial", "model", "level", "other"), on=["trial", "model"], maintain_order="left")
    lines = [resampled(table.filter(model=model), column, potentials.get(model, "hs")) for model in models]
    peaks = []
    for (counts, traces), model, of in zip(grid, models, lines, strict=True):
        _points(counts, rows.filter(model=model), COUNT, varies)
        peaks.append(_traces(traces, of, varies))
        low, high = traces.dataLim.y0, traces.dataLim.y1
        style.threshold(traces, thresholds.get(model), signed=low < -0.3 * high, most=1.5 * max(high, -low))
    grid[-1, 0].set_xlabel(axis(varies))
    grid[-1, 1].set_xlabel(label)
    _caption(figure, title, rows, varies, TRACES)
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


def _traces(axes: Axes, lines: Lines, varies: str) -> list[tuple[float, str, Any]]:
    """Draw the mean of the trials of each condition, and their range; return peak, name and colour of each level."""
    colours = style.tints((level for level, _ in lines), varies) if lines else {}
    others = list(dict.fromkeys(other for _, other in lines))
    peaks: dict[Any, tuple[float, str, Any]] = {}
    for (level, other), (grid, values) in lines.items():
        mean, name = np.nanmean(values, axis=0), level_text(level, unit(varies)[1])
        axes.fill_between(grid, np.nanmin(values, axis=0), np.nanmax(values, axis=0), color=colours[level], alpha=0.25,
                          lw=0)  # fmt: skip
        axes.plot(grid, mean, color=colours[level], lw=1.2, ls=DASHES[others.index(other) % len(DASHES)], label=name)
        peaks.setdefault(level, (float(mean[np.abs(mean).argmax()]), name, colours[level]))
    axes.margins(y=0.06)
    return list(peaks.values())


# --- mechanism --------------------------------------------------------------------------------------------------------


def _mechanism(rows: pl.DataFrame, varies: str, title: str) -> Figure:
    """Draw why counts go as they do: a row for each model with count, time in view, firing rate and potential."""
    models = style.levels(rows, "model")
    measures = (IN_WINDOW if varies == "speed_cm_s" else COUNT, *MECHANISM)
    found = [finding(rows, measure, varies) for measure in measures]
    figure, grid = _grid(models, [measure[1] for measure in measures], found)
    for panels, model in zip(grid, models, strict=True):
        for axes, measure in zip(panels, measures, strict=True):
            _points(axes, rows.filter(model=model), measure, varies)
    for axes in grid[-1]:
        axes.set_xlabel(axis(varies))
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
    whole, balanced = (finding(rows.filter(model=model), COUNT, varies) for model in (WHOLE, BALANCED))
    n, w_i = excitations.select("n", "w_i").row(0)
    words = style.sentence(f"{whole}; with w_i = 1 the {balanced}")
    style.headline(
        figure, words if n >= LEAST_FOR_INTERVAL else drawn_of("Excitation and inhibition", unit(varies)[0], n)
    )
    left = f"Inhibition has its weight, w_i = {w_i:g}; leftover: {1.0 - w_i:.2g} (E + I) / 2, of symmetric motion."
    style.caption(figure, f"{title}. {WHOLE}, n = {n} per condition. {BANDS} {left}")
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
        if first:
            axes.legend(loc="best", handlelength=0.0, labelcolor="linecolor", edgecolor="none", fontsize=style.SMALL)
    style.threshold(panels[1], threshold, signed=True, named=first)
    panels[2].fill_between(time, of["firing"] / n, step="mid", color=HS["hs"][1], alpha=0.4, lw=0)
    panels[2].step(time, of["firing_w_i_1"] / n, where="mid", color=HS["hs_w_i_1"][1], lw=1.0)
    panels[2].set_ylim(0.0, 1.05)
