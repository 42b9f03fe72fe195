"""The run of the plausible set: a sample of apparatus, the nearest judged again, and the check of the method."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import polars as pl

from experiments.base import console
from experiments.base.errors import UsageError
from experiments.base.files import Files
from experiments.declare.study import Study
from experiments.judge.sweep import Sweep
from experiments.kinds import sweep
from experiments.kinds.kind import Kind
from experiments.kinds.result import Run
from experiments.paper.studies import plausible as study
from experiments.store.asked import Asked
from experiments.store.description import begin_whole
from experiments.store.plan import Plan
from experiments.store.workers import Workers

if TYPE_CHECKING:
    from matplotlib.figure import Figure

TABLES = "plausible.json"
APART = 1_000_000
"""Between the seeds of the sample, of the nearest judged again, of the robots and of the pilot."""
SHOWN = ("Share of the sample", "Over one unknown", "Nearest points again", "Check")


def _swept(points: Sequence[study.Setting], seed: int, declared: Study = study.STUDY) -> Plan[Any]:
    """Return the plan of a sweep over points."""
    swept = study.study_of(points, declared)
    return sweep.plan_of(swept, Asked(kind="sweep", declared=swept, seed=seed))


def plan(asked: Asked) -> Plan[Any]:
    """Return the plan of the whole run, from what a run has stored."""
    return plan_of(study.STUDY, asked)


def plan_of(declared: Study, asked: Asked) -> Plan[Any]:
    """Return the plan of the whole run, of which the sample is the first part; the others follow from it."""
    if asked.options.get("over") or asked.models or asked.values:
        raise UsageError(f"{declared.name}: its file has box, model and settings; leave out --over, --set, --model")
    sampled = replace(declared, repeats=asked.repeats or declared.repeats)
    points = study.sample(study.POINTS, asked.seed), study.sample(study.POINTS, asked.seed, narrow=True)
    part = _swept([*points[0], *points[1]], asked.seed, sampled)
    resolved = {"experiment": declared.name, "seed": asked.seed, "box": study.BOX}
    asked = replace(asked, kind="plausible", what=(declared.name,))
    return Plan(asked, declared.name, resolved=resolved, declared=points, parts={"sample": part})


def pilot_of(declared: Study, asked: Asked) -> Plan[Any]:
    """Return the plan of the pilot, whose table has the bound of the check."""
    points = study.sample(study.PAIRS, asked.seed + 3 * APART)

    def tables(result: Sweep) -> dict[str, list[dict[str, Any]]]:
        return {"Bound": [study.bound(study.held(result), study.held(result, 1))]}

    return sweep.plan_of(study.study_of(points, declared), asked, further=tables)


def work(plan: Plan[Any], out: Path, pool: Workers) -> None:
    """Play the sample, the nearest points and the robots, and write the tables."""
    begin_whole(out, plan.document())
    (points, narrow), seed = plan.declared, plan.asked.seed
    every = study.held(sweep.played(plan.parts["sample"], out / "sample", pool))
    wide = every[: len(points)]

    def again(name: str, places: Sequence[int], apart: int, replicates: int) -> list[list[tuple[bool, ...]]]:
        """Play full designs of points of the sample; the verdicts of each replicate."""
        whole = replace(study.STUDY, name=name, repeats=study.PILOT.repeats, replicates=replicates)
        part = _swept([points[place] for place in places], seed + apart * APART, whole)
        played = sweep.played(part, out / name, pool)
        return [study.held(played, number) for number in range(replicates)]

    tables = {
        "Share of the sample": [*study.shares("whole box", points, wide),
                                *study.shares("halved", narrow, every[len(points) :])],
        "Over one unknown": study.over(1, points, wide), "Over two": study.over(2, points, wide),
    }  # fmt: skip
    if near := study.nearest(points, wide):
        fresh = again("near", near, 1, study.FRESH)
        tables["Nearest points again"] = [
            {"point": place, **points[place], **{str(claim): sum(one[row][column] for one in fresh)
                                                 for column, claim in enumerate(study.STUDY.claims)}}
            for row, place in enumerate(near)
        ]  # fmt: skip
    if robots := [place for place, own in enumerate(wide) if own[0]][: study.ROBOTS]:
        (seen,) = again("robots", robots, 2, 1)
        tables["Check"] = [study.accepted(wide, dict(zip(robots, seen, strict=True)))]
    Files(out).write_json(TABLES, tables)


def _tables(run: Run) -> Mapping[str, list[dict[str, Any]]]:
    path = run.folder / TABLES
    if not path.is_file():
        raise UsageError(f"{run.folder}: no {TABLES} there: the run is not finished")
    tables: Mapping[str, list[dict[str, Any]]] = json.loads(path.read_text(encoding="utf-8"))
    return tables


def draw(run: Run) -> Figure:
    """Refuse: the run has no figure."""
    raise UsageError(f"{run.folder}: such a run has no figure; {TABLES} has its tables")


def show(run: Run) -> None:
    """Print the tables, but that over two unknowns."""
    for title, rows in _tables(run).items():
        if title in SHOWN:
            console.show(pl.DataFrame(rows, infer_schema_length=None), title)
    console.show_places({"tables": run.folder / TABLES})


KIND = Kind(plan, work, draw, show, whole=True)
