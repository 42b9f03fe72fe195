"""Many robots that all see: plan a scenario's trials, play them, and conclude, draw and show a run of them."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from itertools import product
from typing import TYPE_CHECKING, Any

import cloudpickle
import polars as pl

from colias_sim.config import CameraConfig, RobotConfig
from colias_sim.envs.options import FPS
from experiments.base import console
from experiments.declare.behaviour import BLIND, Scenario
from experiments.declare.outcome import Outcome
from experiments.draw.terminal import show_verdicts
from experiments.judge.tests import summary_rows
from experiments.judge.verdict import document, verdict_of
from experiments.kinds import registry
from experiments.kinds.clips import words
from experiments.kinds.result import Kind, Run, concluding, load
from experiments.settings.models import look_up, shown_models
from experiments.settings.parameters import differing
from experiments.settings.settings import applied, by_section, check_counts, with_values
from experiments.show.episodes import SWARM_STEPS, SWARMS, SwarmTrial, play_swarm
from experiments.show.play import one_thread
from experiments.store import provenance
from experiments.store.asked import Asked
from experiments.store.folder import THRESHOLDS, RunFolder
from experiments.store.plan import Plan
from experiments.store.tables import TrialRecord, drawn_here, group

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def plan(asked: Asked) -> Plan[SwarmTrial]:
    """Return the plan of a scenario: every number of robots and speed, by every model, in equal starts.

    Parameters
    ----------
    asked
        What was asked for. Values are of the sections ``swarm``, ``robot``, ``camera`` and of the models. Its option is
        ``recordings``, whether to keep these.

    Raises
    ------
    UsageError
        It cannot be run so.
    """
    scenario: Scenario = registry.declaration(asked)
    repeats = scenario.repeats if asked.repeats is None else asked.repeats
    check_counts(asked.seed, repeats)
    shown = shown_models(scenario.models, asked.models, asked.only)
    looking = look_up([name for name in shown if name != BLIND])
    usual = {"robot": RobotConfig(), "camera": CameraConfig(), "swarm": scenario.design}
    given = by_section(asked.values, {model.section: model.network for model in looking} | usual)
    models = applied(looking, given)
    settings = {name: with_values(name, value, given.get(name, {})) for name, value in usual.items()}
    changed = differing(models, others={name: (usual[name], value) for name, value in settings.items()})
    design = settings.pop("swarm")
    densities = [*product(design.robots, design.speeds_cm_s)]
    cases = product(range(repeats), densities, [*((model,) for model in models), *[()] * (BLIND in shown)])
    trials = [SwarmTrial(scenario.name, index, repeat, asked.seed + repeat, condition, seen_by)
              for index, (repeat, condition, seen_by) in enumerate(cases)]  # fmt: skip
    declared = {name: getattr(scenario, name) for name in ("name", "summary", "figure", "along")}
    resolved = {
        "experiment": declared, "repeats": repeats, "seed": asked.seed, "trials": len(trials), "models": models,
        "swarm": design, **({"changed": changed} if changed else {}),
        THRESHOLDS: {model.label: model.thresholds for model in models},
        "chance": [(*case, scenario.chance(*case)) for case in densities] if scenario.chance else [],
        **provenance.of((model.source for model in models), scenario),
    }  # fmt: skip
    # A worker finds the scenario by its name or its file; one of a script travels with its functions.
    source = scenario.file or (scenario.name if asked.declared is None else cloudpickle.dumps(scenario))
    work = partial(play, source=source, options={**settings, "arena": scenario.arena},
                   frames=round(design.seconds * FPS), recorded=bool(asked.option("recordings", True)))  # fmt: skip
    columns = pl.Schema({**SWARMS, **dict.fromkeys(scenario.measures, float)})
    return Plan(asked, scenario.name, trials, work, resolved, (columns, SWARM_STEPS), scenario, models)


def play(
    trial: SwarmTrial, *, source: str | bytes, options: Mapping[str, Any], frames: int, recorded: bool = False
) -> TrialRecord:  # fmt: skip
    """Play a trial in a worker."""
    with one_thread():
        scenario = cloudpickle.loads(source) if isinstance(source, bytes) else registry.find(source)
        done = play_swarm(trial, scenario, options, frames, recorded=recorded)
    return drawn_here(done) if trial.models else done


def conclude(plan: Plan[SwarmTrial], folder: RunFolder) -> None:
    """Judge the claims, a repeat being a replicate, and write verdicts, summary and figure."""
    from experiments.draw import style  # not before: workers do without matplotlib

    if not (rows := folder.table("trials").to_dicts()):
        return
    lost, size = Outcome.unjudged("trials of its swarms failed or were not asked for"), len(group(rows, *CASE))
    repeats, shown = group(rows, "repeat").values(), {row["model"] for row in rows}
    found = []
    for claim in plan.declared.claims:
        whole = [len(part) == size and claim.models <= shown for part in repeats]
        judged = [claim.evaluate(part) if there else lost for part, there in zip(repeats, whole, strict=True)]
        found.append(verdict_of(claim, judged, experiment=plan.name))
    folder.write_json("claims.json", document(found))
    measured = [name for name, kind in plan.schemas[0].items() if kind == pl.Float64 and name not in CASE]
    folder.write_rows("summary.csv", summary_rows(rows, CASE, measured, ()))
    style.save(load(folder.folder).figure(), folder.folder / "figure")


CASE = ("model", "robots", "speed_cm_s")


def draw(run: Run) -> Figure:
    """Draw the scenario's column against what it varies, a line a swarm, and what it is by chance."""
    from experiments.draw import behaviours  # not before: matplotlib takes its time to load

    return behaviours.draw_swarms(run.trials, run.description)


def show(run: Run) -> None:
    """Print means over repeats, the verdicts, and where everything is."""
    if run.done:
        column = run.description["experiment"]["figure"][0]
        console.show(run.summary.filter(quantity=column).drop("quantity"), column)
        show_verdicts(run.verdicts)
        console.show_files(run.folder, console.count(run.trials.height, "trial"))


KIND = Kind(plan, concluding(conclude), draw, show, chapter="Swarms", words=words)
