"""Rows of the benchmark, one a trial and model, and the measures that are computed from them alone."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import polars as pl

from dsnn.stimuli.looming import Looming
from experiments.base.files import read_json
from experiments.judge.judge import SIGNED
from experiments.judge.roc import alarm_count, area, share
from experiments.judge.tests import Score, first_alarm_s, summarise
from experiments.paper.benchmark.tasks import CONTROLS, FILE
from experiments.paper.claims.clips import answer
from experiments.settings.models import parse_label
from experiments.store.folder import RunFolder
from experiments.store.plan import Plan

ROWS = pl.Schema({
    "seeds": str, "task": str, "trial": int, "seed": int, "control": str, "cluster": str, "level": float,
    "flow_r": float, "on_target": float, "condition": str, "shown": str, "right": bool, "strength": float,
    "looming": float, "spiked": bool, "seconds": float, "alarms": int, "contact_s": float,
})  # fmt: skip
"""Columns of an entry's ``trials.parquet``: those of `row_of`, but for the model."""


def rows_in(name: str, part: Plan[Any], folder: RunFolder) -> list[dict[str, Any]]:
    """Return the rows of a task, such as ``public/robot``, from its folder."""
    seeds, _, task = name.rpartition("/")
    frames = folder.table("frames").partition_by("trial", "model", as_dict=True)
    trials, found = {trial.index: trial for trial in part.trials}, []
    for row in folder.table("trials").iter_rows(named=True):
        of_model = frames.get((row["trial"], row["model"]))
        found.append({"seeds": seeds, "task": task, **row_of(row, trials[row["trial"]], of_model)})
    return found


def row_of(row: Mapping[str, Any], trial: Any, frames: pl.DataFrame | None) -> dict[str, Any]:
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
        ``control``, empty where the trial was shown as it was. ``cluster``, which alike trials share: the scene behind
        the object, or the condition. ``level``, the background's speed, px a frame. ``condition``, which is the same in
        all repeats. What was ``shown``: a direction, ``looming``, ``receding``, ``grating`` or ``background``. Whether
        the direction is ``right``; the largest |HS| or |VS| as ``strength`` and the largest potential of ``looming``.
        Whether any channel ``spiked``, ``None`` of a model without thresholds. Of clips the number of looming
        ``alarms`` in their ``seconds``, and the time to contact at the first, where one is approached.
    """
    if "direction" in row:  # a robot's trial
        shown = {"approach": "looming", "recession": "receding"}.get(row["motion"], str(row["direction"]))
    elif row["stimulus"] == "grating":
        shown = "grating"
    else:
        shown = "background" if row["object"] == "absent" or row["motion"] is None else str(row["motion"])
    label, condition = parse_label(row["model"]), f"{row['experiment']} {trial.label()}"
    counts = [row[name] for name in ("hs_spikes", "vs_spikes", "looming_spikes") if row[name] is not None]
    cluttered = row.get("stimulus") in ("cluttered", "target")
    seconds = alarms = contact_s = None
    if frames is not None and row["looming_spikes"] is not None:
        spikes, clip = frames["looming_spikes"].to_numpy(), trial.condition.build(trial.seed)
        contact_s = first_alarm_s(spikes, clip.contact_s()) if isinstance(clip, Looming) else None
        seconds, alarms = row["frames"] / row["fps"], alarm_count(spikes, row["fps"])
    return {
        "model": label.model, "trial": row["trial"], "seed": row["seed"], "control": label.control,
        "cluster": f"scene {row['repeat']}" if cluttered else condition,
        "level": abs(row["background_speed"]) / row["fps"] if cluttered else None, "flow_r": row.get("true_hs_flow_r"),
        "on_target": row.get("on_target"), "condition": condition, "shown": shown, "right": answer(row) == shown,
        "strength": max(sign * row[column] for column, sign in SIGNED.values()), "looming": row["peak_looming"],
        "spiked": any(counts) if counts else None, "seconds": seconds, "alarms": alarms, "contact_s": contact_s,
    }  # fmt: skip


Sides = list[dict[str, float]]
"""Cluster -> mean mark, of the trials that a measure is a mean over; of an area those of either side."""
FIRST, LEAST_CLUSTERS = 0, 6
"""Fewer pairs of clusters cannot reach 5 %, all one way: no order is stated."""
REACHED = 0.75
"""Share of crossings that have to be right at a speed of the background, and at all that are slower."""


@dataclass(frozen=True)
class Measure:
    """A number that a model gets for a task, as ``measures.json`` declares it.

    Parameters
    ----------
    task, channels
        The task, and the models that it applies to: those with any of these channels.
    column
        Of the rows. Its mean over clusters is the score, and of words their share. ``rate`` is of alarms, 1/min,
        ``alarmed`` whether there is one, and ``level`` is the `fastest` background.
    shown
        What the rows have to show; empty: anything.
    against
        If any, the score is the area under the ROC curve of the column for ``shown`` against these.
    better
        1: more is better; -1: less; 0: models are not ordered by it.
    """

    task: str
    channels: Sequence[str]
    column: str
    shown: Sequence[str] = ()
    against: Sequence[str] = ()
    better: int = 1

    def score(self, rows: pl.DataFrame) -> Score | None:
        """Return the score of a task's rows, with its interval; ``None`` where there was no response."""
        if self.against:
            return area(rows.with_columns(condition="cluster"), self.column, self.shown, self.against)
        if rows.schema.get(self.column) == pl.Boolean:
            return share(showing(rows, self.shown).with_columns(condition="cluster"), self.column)
        means = [*self.sides(rows)[0].values()]
        return summarise(means) if means else None

    def sides(self, rows: pl.DataFrame) -> Sides:
        """Return the marks of a task's rows that two models are compared by."""
        if self.column == "level":
            return [clustered(fastest(rows), self.column)]
        if not self.against:
            return [clustered(showing(rows, self.shown), self.column)]
        parts = [showing(rows, kinds) for kinds in (self.shown, self.against)]
        above = np.sign(np.subtract.outer(*(part[self.column].to_numpy() for part in parts))) / 2 + 0.5
        marks = zip(parts, (above.mean(axis=1), above.mean(axis=0)), strict=True)
        return [clustered(part.with_columns(mark=values), "mark") for part, values in marks]


def showing(rows: pl.DataFrame, kinds: Sequence[str]) -> pl.DataFrame:
    """Return the rows that showed something of these kinds; all for none."""
    return rows.filter(pl.col("shown").is_in(kinds)) if kinds else rows


def clustered(table: pl.DataFrame, column: str) -> dict[str, float]:
    """Return cluster -> the mean of a column; rows without a number do not count."""
    known = table.drop_nulls(column).group_by("cluster", maintain_order=True).agg(pl.col(column).cast(float).mean())
    return {cluster: round(mark, 6) for cluster, mark in known.iter_rows()}


def fastest(rows: pl.DataFrame) -> pl.DataFrame:
    """Return of each scene the fastest background up to which `REACHED` are right, px a frame; 0 for none."""
    means = rows.group_by("cluster", "level").agg(pl.col("right").mean()).sort("cluster", "level")
    kept = pl.col("right").ge(REACHED).cum_min().over("cluster") * pl.col("level")
    return means.with_columns(level=kept).group_by("cluster", maintain_order=True).agg(pl.col("level").max())


DECLARED = read_json(FILE.with_name("measures.json"))
MEASURES: Mapping[str, Measure] = {kept.pop("name"): Measure(**kept) for kept in DECLARED["measures"]}
"""Name -> measure, but for the gains and costs. AUC: area under the ROC curve of the looming potential's peak."""
MARGINS: Mapping[str, float] = DECLARED["margins"]
"""Column -> difference that another renderer or CPU explains; shares of its value as large are explained too."""
GAINS: Mapping[str, str] = DECLARED["gains"]
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
    rows = rows.with_columns(rate=60.0 * pl.col("alarms") / pl.col("seconds"), alarmed=pl.col("alarms") > 0)
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
