"""Sweeps: plan replicates at every point of a grid, and conclude, draw and show a run of them."""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import polars as pl

from experiments.base.console import count, show_files
from experiments.base.errors import UsageError
from experiments.base.files import read_json
from experiments.declare.clip import Clip
from experiments.declare.study import Levels, Study
from experiments.judge.sweep import ClaimAt, Fewer, Play, Sweep, Tables, Then, read
from experiments.kinds import trials
from experiments.kinds.clips import play_clip
from experiments.kinds.registry import shipped_study, typed
from experiments.kinds.result import Kind, Run
from experiments.kinds.sweep_plan import sweep_of
from experiments.kinds.tables import PLANS, STUDIES, shipped
from experiments.show import clips
from experiments.show.play import FRAMES, Trial, show as shown_to, tabulate
from experiments.show.trial_rows import FRAME_SCHEMA, TRIAL_SCHEMA, TRUE_TRIALS
from experiments.store.asked import Asked
from experiments.store.folder import RunFolder
from experiments.store.plan import Plan, filled
from experiments.store.tables import TrialRecord, drawn_here
from experiments.store.workers import Workers

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SAME = "where nothing is random one replicate is run, and the verdict is that at any seed"
Probe = tuple[Callable[[Any], Mapping[str, Mapping[str, Any]]], Mapping[str, Any]]

# What is run.


def plan(asked: Asked) -> Plan[Any]:
    """Return the plan of a sweep.

    Parameters
    ----------
    asked
        What was asked for: experiments, or a study, by name or file. Its options are ``over``, the axes as
        ``KEY=V1,V2`` texts; ``claims`` and ``measures``; and ``replicates``. What is left out is the study's own.

    Raises
    ------
    UsageError
        It cannot be run so.
    """
    study = study_of(asked)
    ships = study.name in STUDIES and study.summary == shipped_study(study.name).summary
    made: Plan[Any] = (shipped(PLANS["studies"]).get(study.name, plan_of) if ships else plan_of)(study, asked)
    return made


def study_of(asked: Asked, **fields: Any) -> Study:
    """Return the study that was asked for; ``fields`` are further ones of it."""
    own = any(isinstance(claim, Mapping) for claim in asked.option("claims", ()))  # as run.json has a script's
    if own or (asked.declared is None and not asked.what):
        raise UsageError("a script gave it an experiment, study or claim of its own: run the script")
    named = asked.declared if asked.declared is not None else ",".join(asked.what)
    options = {name: asked.option(name) for name in ("claims", "measures", "replicates")}
    return typed(
        named, asked.option("over", ()), models=asked.models or None,
        assignments=asked.values, **options, **fields,
    )  # fmt: skip


def _probed(trial: Trial, *, columns: Any) -> TrialRecord:
    """Play one trial with the robot in a worker; its rows have a probe's columns too."""
    began_s = time.perf_counter()
    showings = shown_to(trial)
    record = tabulate(trial, showings, time.perf_counter() - began_s, frames=False)
    more = columns(showings)
    return drawn_here(dataclasses.replace(record, rows=tuple({**row, **more[row["model"]]} for row in record.rows)))


def plan_of(
    study: Study, asked: Asked, *, probe: Probe | None = None, further: Callable[[Sweep], Tables] | None = None,
    only: Levels | None = None, claim_at: ClaimAt | None = None, fewer: Fewer | None = None, then: Then | None = None,
) -> Plan[Any]:  # fmt: skip
    """Return the plan of a study; ``probe`` as of `of_checked`, ``further`` of a `Sweep`, the others of `sweep_of`."""
    checked = sweep_of(study, asked.seed, repeats=asked.repeats, only=only, claim_at=claim_at, fewer=fewer)
    return of_checked(dataclasses.replace(checked, further=further, then=then), asked, probe)


def of_checked(sweep: Sweep, asked: Asked, probe: Probe | None = None) -> Plan[Any]:
    """Return the plan of a checked sweep. Its trials leave neither recordings nor frames.

    A ``probe`` adds columns to the rows of each model: what makes them, by label, of what a trial with the robot showed
    (`experiments.show.play.Showing` of each eye), a function of a module as it is pickled; and their types.
    """
    on_clips = isinstance(sweep.specs[0].condition, Clip)
    robot = TRUE_TRIALS if sweep.specs[0].truth else TRIAL_SCHEMA
    done: Any = partial(play_clip, frames=False) if on_clips else trials.play_trial
    return Plan(
        asked, sweep.study.name, sweep.specs, partial(_probed, columns=probe[0]) if probe else done,
        {**sweep.resolved, "experiment": sweep.study.name},
        (clips.TRIALS, FRAMES) if on_clips
        else (robot | pl.Schema(probe[1] if probe else {}), FRAME_SCHEMA),
        sweep, parameters=sweep.parameters, things="clips" if on_clips else "trials",
        notes=(SAME,) if sweep.fixed else (),
    )  # fmt: skip


def played(plan: Plan[Any], out: Path, pool: Workers) -> Sweep:
    """Do what a folder lacks of a sweep, and read what it has; no table is written."""
    with filled(plan, out, pool) as folder:
        return read(plan.declared, folder.table("trials").to_dicts(), folder.failures())


def work(plan: Plan[Any], out: Path, pool: Workers) -> None:
    """Do what a folder lacks of a sweep, and conclude."""

    def play(study: Study, seed: int) -> Sweep:
        further = plan_of(study, Asked(kind="sweep", declared=study, seed=seed))
        return played(further, out / study.name, pool)

    with filled(plan, out, pool) as folder:
        conclude(plan, folder, play)


def conclude(plan: Plan[Any], folder: RunFolder, play: Play) -> None:
    """Judge the claims, and write ``outcomes.csv``, ``counts.csv``, ``NAME.json`` and ``NAME.svg``."""
    from experiments.draw import style, sweep as report  # not before: workers do without matplotlib

    result = read(plan.declared, folder.table("trials").to_dicts(), folder.failures())
    described, name = result.described(), plan.name
    if result.then:
        described["tables"] = {**described["tables"], **result.then(result, play)}
    folder.write_rows("outcomes.csv", result.table.to_dicts())
    folder.write_rows("counts.csv", [*described["counts"], *described["numbers"]])
    folder.write_json(f"{name}.json", described)
    if result.claims or result.axes:
        style.save(report.draw(described), folder.folder / name)


# Reading it.


def described(run: Run) -> Mapping[str, Any]:
    """Return a run of a sweep as its ``NAME.json`` has it; `UsageError` where it is not finished."""
    path = run.folder / f"{run.name}.json"
    if not path.is_file():
        raise UsageError(f"{run.folder}: no {path.name} there: the sweep is not finished")
    return dict(read_json(path))


def draw(run: Run) -> Figure:
    """Draw the figure of a sweep, from its folder alone."""
    from experiments.draw import sweep as report  # not before: matplotlib takes its time to load

    return report.draw(described(run))


def show(run: Run) -> None:
    """Print a sweep, from its folder alone, and where its files are."""
    from experiments.draw import sweep as report  # not before: matplotlib takes its time to load

    report.show(described(run))
    show_files(run.folder, count(run.done, "trial"))


KIND = Kind(plan, work, draw, show, summary="counts.csv")
