"""Rows of the benchmark, one a trial and model, and the measures that are computed from them alone."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import polars as pl

from dsnn.stimuli.looming import Looming
from experiments.judge.judge import SIGNED
from experiments.judge.roc import alarm_count, area, share
from experiments.judge.tests import Score, first_alarm_s, summarise
from experiments.paper.benchmark.tasks import CONTROLS, DIRECTION, LOOMING
from experiments.paper.claims.clips import answer
from experiments.settings.models import parse_label
from experiments.store.folder import RunFolder
from experiments.store.plan import Plan

RESPONSES = pl.Schema({
    "model": pl.String, "condition": pl.String, "shown": pl.String, "right": pl.Boolean, "strength": pl.Float64,
    "looming": pl.Float64, "spiked": pl.Boolean, "seconds": pl.Float64, "alarms": pl.Int64, "contact_s": pl.Float64,
})  # fmt: skip
"""Columns of what `response` returns."""


def response(row: Mapping[str, Any], trial: Any, frames: pl.DataFrame | None) -> dict[str, Any]:
    """Return what a model responded to a trial or clip: what scores are computed from.

    Parameters
    ----------
    row
        Of ``trials.parquet``.
    trial
        The job that the row is of.
    frames
        The model's rows of ``frames.parquet``; ``None`` where they were not kept, as of the robot's trials.

    Returns
    -------
    dict
        ``condition``, which is the same in all repeats; what was ``shown``: a direction, ``looming``, ``receding``,
        ``grating`` or ``background``; whether the direction is ``right``; the largest |HS| or |VS| as ``strength`` and
        the largest potential of ``looming``; whether any channel ``spiked``, ``None`` of a model without thresholds.
        Of clips the number of looming ``alarms`` in their ``seconds``, and the time to contact at the first, where one
        is approached.
    """
    if "direction" in row:  # a robot's trial
        shown = {"approach": "looming", "recession": "receding"}.get(row["motion"], str(row["direction"]))
    elif row["stimulus"] == "grating":
        shown = "grating"
    else:
        shown = "background" if row["object"] == "absent" or row["motion"] is None else str(row["motion"])
    counts = [row[name] for name in ("hs_spikes", "vs_spikes", "looming_spikes") if row[name] is not None]
    found = {
        "model": row["model"], "condition": f"{row['experiment']} {trial.label()}", "shown": shown,
        "right": answer(row) == shown, "strength": max(sign * row[column] for column, sign in SIGNED.values()),
        "looming": row["peak_looming"], "spiked": any(counts) if counts else None,
    }  # fmt: skip
    if frames is None or row["looming_spikes"] is None:
        return found | dict.fromkeys(("seconds", "alarms", "contact_s"))
    spikes, clip = frames["looming_spikes"].to_numpy(), trial.condition.build(trial.seed)
    contact_s = first_alarm_s(spikes, clip.contact_s()) if isinstance(clip, Looming) else None
    alarms = alarm_count(spikes, row["fps"])
    return found | {"seconds": row["frames"] / row["fps"], "alarms": alarms, "contact_s": contact_s}


KEPT: Mapping[str, type] = {
    "seeds": str, "task": str, "trial": int, "seed": int, "control": str, "cluster": str, "level": float,
    "flow_r": float, "on_target": float,
}  # fmt: skip
ROWS = pl.Schema([*pl.Schema(KEPT).items(), *(one for one in RESPONSES.items() if one[0] != "model")])
"""Columns of an entry's ``trials.parquet``. ``control`` is empty where the trial was shown as it was. ``cluster`` is
what alike trials share: the scene behind the object, or the condition. ``level`` is the background's speed, px a frame.
"""
Sides = list[dict[str, float]]
"""Cluster -> mean mark, of the trials that a measure is a mean over; of an area those of either side."""
FIRST, LEAST_CLUSTERS = 0, 6
"""Fewer pairs of clusters cannot reach 5 %, all one way: no order is stated."""
REACHED = 0.75
"""Share of crossings that have to be right at a speed of the background, and at all that are slower."""


def shown_in(part: Plan[Any], folder: RunFolder) -> Iterator[tuple[dict[str, Any], Any, pl.DataFrame | None]]:
    """Yield each row of a task's trials, its trial, and its model's rows of ``frames.parquet`` where it has any."""
    frames = folder.table("frames").partition_by("trial", "model", as_dict=True)
    for row in folder.table("trials").iter_rows(named=True):
        yield row, part.trials[row["trial"]], frames.get((row["trial"], row["model"]))


def row_of(seeds: str, task: str, row: Mapping[str, Any], trial: Any, frames: pl.DataFrame | None) -> dict[str, Any]:
    """Return the row of a trial and model, from its rows in ``trials.parquet`` and ``frames.parquet``.

    ``seeds`` is ``public`` or ``round``.
    """
    found, label = response(row, trial, frames), parse_label(row["model"])
    cluttered = row.get("stimulus") in ("cluttered", "target")
    return {
        **found, "model": label.model, "seeds": seeds, "task": task, "trial": row["trial"], "seed": row["seed"],
        "control": label.control,
        "cluster": f"scene {row['repeat']}" if cluttered else found["condition"],
        "level": abs(row["background_speed"]) / row["fps"] if cluttered else None, "flow_r": row.get("true_hs_flow_r"),
        "on_target": row.get("on_target"),
    }  # fmt: skip


@dataclass(frozen=True)
class Measure:
    """A number that a model gets for a task.

    Parameters
    ----------
    task, channels
        The task, and the models that it applies to: those with any of these channels.
    score, sides
        From the task's rows: the score with its interval, and the marks that two models are compared by.
    better
        1: more is better; -1: less; 0: models are not ordered by it.
    """

    task: str
    channels: tuple[str, ...]
    score: Callable[[pl.DataFrame], Score | None]
    sides: Callable[[pl.DataFrame], Sides]
    better: int = 1


def clustered(table: pl.DataFrame, column: str) -> dict[str, float]:
    """Return cluster -> the mean of a column; rows without a number do not count."""
    known = table.drop_nulls(column).group_by("cluster", maintain_order=True).agg(pl.col(column).cast(float).mean())
    return {cluster: round(mark, 6) for cluster, mark in known.iter_rows()}


def mean(task: str, channels: tuple[str, ...], column: str, better: int = 1,
         of: Callable[[pl.DataFrame], pl.DataFrame] = pl.DataFrame.clone) -> Measure:  # fmt: skip
    """Return the mean of a column over clusters, with its interval, of what ``of`` makes of the task's rows."""

    def score(rows: pl.DataFrame) -> Score | None:
        means = [*clustered(of(rows), column).values()]
        return summarise(means) if means else None

    return Measure(task, channels, score, lambda rows: [clustered(of(rows), column)], better)


def right(task: str) -> Measure:
    """Return the measure of direction: the share of crossings in which the strongest of HS and VS is the object's."""
    return Measure(task, DIRECTION, lambda rows: share(crossings(rows).with_columns(condition="cluster"), "right"),
                   lambda rows: [clustered(crossings(rows), "right")])  # fmt: skip


def apart(task: str, *others: str) -> Measure:
    """Return the measure of looming: the area under the ROC curve of its peak in approaches against ``others``."""

    def sides(rows: pl.DataFrame) -> Sides:
        parts = [rows.filter(pl.col("shown").is_in(kinds)) for kinds in (("looming",), others)]
        above = np.sign(np.subtract.outer(*(part["looming"].to_numpy() for part in parts))) / 2 + 0.5
        marks = zip(parts, (above.mean(axis=1), above.mean(axis=0)), strict=True)
        return [clustered(part.with_columns(mark=values), "mark") for part, values in marks]

    def score(rows: pl.DataFrame) -> Score | None:
        return area(rows.with_columns(condition="cluster"), "looming", ("looming",), others)

    return Measure(task, LOOMING, score, sides)


def crossings(rows: pl.DataFrame) -> pl.DataFrame:
    """Return what showed translation."""
    return rows.filter(pl.col("shown").is_in([*SIGNED]))


def calm(rows: pl.DataFrame) -> pl.DataFrame:
    """Return what showed no approach and no recession, with its alarms a minute: every one is false."""
    rate = 60.0 * pl.col("alarms") / pl.col("seconds")
    return rows.filter(~pl.col("shown").is_in(["looming", "receding"])).with_columns(rate=rate)


def fastest(rows: pl.DataFrame) -> pl.DataFrame:
    """Return of each scene the fastest background up to which `REACHED` are right, px a frame; 0 for none."""
    means = rows.group_by("cluster", "level").agg(pl.col("right").mean()).sort("cluster", "level")
    kept = pl.col("right").ge(REACHED).cum_min().over("cluster") * pl.col("level")
    return means.with_columns(level=kept).group_by("cluster", maintain_order=True).agg(pl.col("level").max())


WORDS = {
    "robot": "robot", "gamma": "eye ov7670-gamma", "dim": "a quarter of the light", "pale": "low contrast",
    "noise": "four times the noise", "15-fps": "15 frames/s", "60-fps": "60 frames/s",
}  # fmt: skip
MEASURES: Mapping[str, Measure] = {
    **{f"direction, {words}": right(task) for task, words in WORDS.items()},
    "direction, own turns": right("turns"),
    "direction, clutter": right("clutter"),
    "break point in clutter (px a frame)": mean("clutter", DIRECTION, "level", of=fastest),
    "correlation of HS with true flow": mean("robot", DIRECTION, "flow_r", of=crossings),
    **{f"AUC against all else, {words}": apart(task, *SIGNED, "receding") for task, words in WORDS.items()},
    "AUC against translation, even": apart("looming", *SIGNED),
    "AUC against recession, even": apart("looming", "receding"),
    "AUC against translation, scenes": apart("moving", *SIGNED),
    "AUC against recession, moving": apart("moving", "receding"),
    "AUC against background": apart("moving", "background"),
    "time to contact at the first spike (s)": mean("looming", LOOMING, "contact_s", 0),
    "small targets, share of frames": mean("target", ("target",), "on_target"),
    "false alarms (1/min)": mean("moving", LOOMING, "rate", -1, calm),
}  # fmt: skip
"""Name -> measure, but for the gains and costs. AUC: area under the ROC curve of the looming potential's peak."""
GAINS = {f"gain of {name} over the best control": f"{name}{more}, robot"
         for name, more in (("direction", ""), ("AUC", " against all else"))}  # fmt: skip
"""Gain over the best control -> the measure whose score it is of."""


def difference(own: Sides, other: Sides) -> Score:
    """Return how far marks are above others of the same clusters, with Student's 95 % interval of the paired clusters.

    Of an area both sides vary, as in DeLong's test. The interval is NaN with fewer than `LEAST_CLUSTERS` on a side.

    References
    ----------
    DeLong, DeLong and Clarke-Pearson 1988, Comparing the areas under two or more correlated receiver operating
    characteristic curves, Biometrics 44.
    """
    from scipy import special  # not before: it takes its time to load

    pairs = [np.array([mine[name] - yours[name] for name in mine if name in yours])
             for mine, yours in zip(own, other, strict=True)]  # fmt: skip
    least = min((len(values) for values in pairs), default=0)
    if not least:
        return Score(math.nan, math.nan, math.nan, 0)
    value = float(pairs[FIRST].mean())
    if least < LEAST_CLUSTERS:
        return Score(value, math.nan, math.nan, least)
    error = math.sqrt(sum(float(values.var(ddof=1)) / len(values) for values in pairs))
    half = float(special.stdtrit(least - 1, 0.975)) * error
    return Score(value, value - half, value + half, least)


def summed(rows: pl.DataFrame, channels: Sequence[str]) -> tuple[dict[str, Score | None], dict[str, Sides]]:
    """Return the scores of a model from all its rows, controls included, and the marks that models are compared by.

    Parameters
    ----------
    rows
        Of `ROWS`, of one model at one seed.
    channels
        Those that the model declares. A measure for other channels does not apply, and is not there.
    """
    scores: dict[str, Score | None] = {}
    marks: dict[str, Sides] = {}
    parts = rows.partition_by("task", "control", as_dict=True)
    for name, measure in MEASURES.items():
        own = parts.get((measure.task, ""))
        if {*measure.channels} & {*channels} and own is not None:
            scores[name], marks[name] = measure.score(own), measure.sides(own)
    for gain, name in GAINS.items():
        if name in scores:
            measure = MEASURES[name]
            others = [table for control in CONTROLS if (table := parts.get((measure.task, control))) is not None]
            best = max(others, key=lambda table: getattr(measure.score(table), "value", -1.0), default=None)
            scores[gain] = difference(marks[name], measure.sides(best)) if best is not None else None
    return scores, marks
