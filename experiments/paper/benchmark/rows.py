"""Rows of the benchmark, one a trial and model, and the measures that are computed from them alone."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np
import polars as pl

from dsnn.stimuli.looming import Looming
from experiments.judge.judge import SIGNED
from experiments.judge.roc import alarm_count, alarm_rate, area, median_interval, share
from experiments.judge.tests import Score, first_alarm_s, summarise
from experiments.paper.benchmark.tasks import BACKGROUND_PX, CONTROLS, DIRECTION, LOOMING, TASKS
from experiments.paper.claims.clips import answer
from experiments.settings.models import parse_label
from experiments.store.tables import table

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


ROWS = pl.Schema({
    "seeds": pl.String, "task": pl.String, "trial": pl.Int64, "seed": pl.Int64, "control": pl.String,
    "cluster": pl.String, "level": pl.Float64,
    **{name: kind for name, kind in RESPONSES.items() if name != "model"}, "flow_r": pl.Float64,
})  # fmt: skip
"""Columns of an entry's ``trials.parquet``. ``control`` is empty where the trial was shown as it was. ``cluster`` is
what alike trials share: the scene behind the object, or the condition. ``level`` is the background's speed, px a frame.
"""
Sides = list[dict[str, float]]
"""Cluster -> mean mark, of the trials that a measure is a mean over; of an area those of either side."""
FIRST, LEAST_CLUSTERS = 0, 6
"""Fewer pairs of clusters cannot reach 5 %, all one way: no order is stated."""
REACHED = 0.75
"""Share of crossings that have to be right at a speed of the background, and at all that are slower."""


def row_of(seeds: str, task: str, row: Mapping[str, Any], trial: Any, frames: pl.DataFrame | None) -> dict[str, Any]:
    """Return the row of a trial and model, from its rows in ``trials.parquet`` and ``frames.parquet``.

    ``seeds`` is ``public`` or ``round``.
    """
    found = response(row, trial, frames)
    cluttered = row.get("stimulus") == "cluttered"
    return {
        **found, "seeds": seeds, "task": task, "trial": row["trial"], "seed": row["seed"],
        "control": parse_label(found["model"]).control,
        "cluster": f"scene {row['repeat']}" if cluttered else found["condition"],
        "level": abs(row["background_speed"]) / row["fps"] if cluttered else None, "flow_r": row.get("true_hs_flow_r"),
    }  # fmt: skip


@dataclass(frozen=True)
class Measure:
    """A number that a model gets for a task.

    Parameters
    ----------
    task, channels
        The task, and the models that it applies to: those with any of these channels.
    words
        What it is.
    score, sides
        From the task's rows: the score with its interval, and the marks that two models are compared by.
    better
        1: more is better; -1: less; 0: models are not ordered by it.
    """

    task: str
    channels: tuple[str, ...]
    words: str
    score: Callable[[pl.DataFrame], Score | None]
    sides: Callable[[pl.DataFrame], Sides]
    better: int = 1


def clustered(table: pl.DataFrame, column: str) -> dict[str, float]:
    """Return cluster -> the mean of a column; rows without a number do not count."""
    known = table.drop_nulls(column).group_by("cluster", maintain_order=True).agg(pl.col(column).cast(float).mean())
    return dict(known.iter_rows())


def of_clusters(table: pl.DataFrame, column: str) -> Score | None:
    """Return the mean of a column over clusters, with its interval; ``None`` where no row has a number."""
    means = [*clustered(table, column).values()]
    return summarise(means) if means else None


def right(task: str, words: str) -> Measure:
    """Return the measure of direction: the share of crossings in which the strongest of HS and VS is the object's."""

    def score(rows: pl.DataFrame) -> Score | None:
        return share(_by_cluster(_crossings(rows)), "right")

    return Measure(task, DIRECTION, f"direction, {words}", score, lambda rows: [clustered(_crossings(rows), "right")])


def apart(task: str, words: str, others: Sequence[str], *more: str) -> Measure:
    """Return the measure of looming: the area under the ROC curve of its peak in approaches against ``others``."""

    def sides(rows: pl.DataFrame) -> Sides:
        parts = [rows.filter(pl.col("shown").is_in(kinds)) for kinds in (("looming",), others)]
        above = np.sign(np.subtract.outer(*(part["looming"].to_numpy() for part in parts))) / 2 + 0.5
        marks = zip(parts, (above.mean(axis=1), above.mean(axis=0)), strict=True)
        return [clustered(part.with_columns(mark=values), "mark") for part, values in marks]

    return Measure(task, LOOMING, f"AUC, looming against {words}",
                   lambda rows: area(_by_cluster(rows), "looming", ("looming",), others), sides)  # fmt: skip


def _crossings(rows: pl.DataFrame) -> pl.DataFrame:
    return rows.filter(pl.col("shown").is_in([*SIGNED]))


def _by_cluster(rows: pl.DataFrame) -> pl.DataFrame:
    return rows.with_columns(condition="cluster")


def break_point(rows: pl.DataFrame) -> Score | None:
    """Return the fastest background up to which `REACHED` are right, px a frame: the median over scenes; 0 for none."""
    reached = [*clustered(_fastest(rows), "level").values()]
    return Score(float(np.median(reached)), *median_interval(reached), len(reached)) if reached else None


def _fastest(rows: pl.DataFrame) -> pl.DataFrame:
    """Return scene and the fastest background that it allows."""
    means = rows.group_by("cluster", "level").agg(pl.col("right").mean()).sort("cluster", "level")
    kept = pl.col("right").ge(REACHED).cum_min().over("cluster")
    return means.with_columns(level=pl.when(kept).then("level").otherwise(0.0)).group_by("cluster").agg(
        pl.col("level").max()).sort("cluster")  # fmt: skip


def contact(rows: pl.DataFrame) -> Score | None:
    """Return the time to contact at the first spike, s: the median over approaches that have one."""
    times = rows["contact_s"].drop_nulls().to_list()
    return Score(float(np.median(times)), *median_interval(times), len(times)) if times else None


def _calm(rows: pl.DataFrame) -> pl.DataFrame:
    """Return what showed no approach and no recession: every alarm is false."""
    return rows.filter(~pl.col("shown").is_in(["looming", "receding"])).with_columns(
        rate=60.0 * pl.col("alarms") / pl.col("seconds"))  # fmt: skip


ACROSS, ALL = tuple(SIGNED), (*SIGNED, "receding")
WORDS = {
    "robot": "robot", "gamma": "eye ov7670-gamma", "dim": "a quarter of the light", "pale": "low contrast",
    "noise": "four times the noise", "15-fps": "15 frames/s", "60-fps": "60 frames/s",
}  # fmt: skip
MEASURES: Mapping[str, Measure] = {
    **{f"direction {task}": right(task, words) for task, words in WORDS.items()},
    "direction turns": right("turns", "own turns"),
    "direction clutter": right("clutter", "clutter"),
    "break point": Measure("clutter", DIRECTION, "break point in clutter (px a frame)", break_point,
                           lambda rows: [clustered(_fastest(rows), "level")]),
    "flow": Measure("robot", DIRECTION, "correlation of HS with true flow",
                    lambda rows: of_clusters(_crossings(rows), "flow_r"),
                    lambda rows: [clustered(_crossings(rows), "flow_r")]),
    **{f"looming {task}": apart(task, f"all else, {words}", ALL) for task, words in WORDS.items()},
    "looming translation": apart("looming", "translation, even", ACROSS),
    "looming recession": apart("looming", "recession, even", ("receding",)),
    "looming moving translation": apart("moving", "translation, scenes", ACROSS),
    "looming moving recession": apart("moving", "recession, moving", ("receding",)),
    "looming moving background": apart("moving", "background", ("background",)),
    "contact": Measure("looming", LOOMING, "time to contact at the first spike (s)", contact, lambda _: [], 0),
    "false alarms": Measure("moving", LOOMING, "false alarms (1/min)",
                            lambda rows: alarm_rate(_by_cluster(_calm(rows))),
                            lambda rows: [clustered(_calm(rows), "rate")], -1),
}  # fmt: skip
"""Name -> measure, but for the gains and costs."""
GAINS = {"gain direction": "direction robot", "gain looming": "looming robot"}
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


def probe(channels: Sequence[str]) -> dict[str, Any]:
    """Return the scores of made-up rows, to four digits: what they are computed by is frozen with the tasks."""
    kinds = [*ALL, "looming", "background"]
    rows = []
    for task, control, i in product(TASKS, ("", *CONTROLS), range(96)):
        value = (7919 * (i + 11 * len(task) + 5 * len(control)) % 97) / 97
        rows.append({
            "task": task, "control": control, "cluster": f"c{i % 8}", "level": BACKGROUND_PX[i // 8 % 6],
            "shown": kinds[i % 7], "right": value < 0.9, "looming": value, "seconds": 2.0, "alarms": i % 3,
            "contact_s": value, "flow_r": value,
        })  # fmt: skip
    scores, _ = summed(table(rows, ROWS), channels)
    return {name: score and [f"{value:.4g}" for value in (score.value, score.low, score.high)]
            for name, score in scores.items()}  # fmt: skip
