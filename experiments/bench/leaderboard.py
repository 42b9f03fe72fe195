"""Every model on the same robot trials and the same off-line clips: run what is missing, then score."""

from __future__ import annotations

import contextlib
import dataclasses
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import pyarrow as pa

from colias_sim.gl import require_backend
from experiments.bench import console, figures, leaderboard_figure, offline_run, settings
from experiments.bench.contents import Contents, robot_contents
from experiments.bench.description import begun
from experiments.bench.leaderboard_scores import Standing, ranked, scores, table
from experiments.bench.leaderboard_speed import time_models
from experiments.bench.leaderboard_trials import REPEATS, ROBOT, clip_experiments
from experiments.bench.models import Chosen
from experiments.bench.offline import CLIP_SCHEMA, SERIES_SCHEMA, OfflineExperiment, Showing, clip_contents, show
from experiments.bench.plan import Plan, describe
from experiments.bench.pool import Pool, open_pool
from experiments.bench.results import FRAME_SCHEMA, TRIAL_SCHEMA, Failure, Finished, RunFolder
from experiments.bench.runner import Keep, work


@dataclass(frozen=True, slots=True)
class Part:
    """Trials, or clips, that have a folder of their own."""

    name: str
    things: str
    specs: Sequence[Any]
    description: Mapping[str, Any]
    contents: Contents
    schemas: tuple[pa.Schema, pa.Schema]
    work: Callable[[Any], Finished]
    size: Callable[[Any], float]
    """How much work one is, in any unit."""


@dataclass(frozen=True, slots=True)
class Done:
    """What became of a part."""

    rows: list[dict[str, Any]]
    failures: list[Failure]


@dataclass(frozen=True, slots=True)
class Board:
    """The leaderboard, best first; of trials and clips that failed, what went wrong."""

    folder: Path
    standings: list[Standing]
    failures: list[Failure]


def leaderboard(folder: Path, models: Sequence[str], repeats: int | None, seed: int, means: console.Means) -> Board:
    """Run what ``folder`` lacks of the trials, time the models, and write ``leaderboard.csv`` and the figure.

    ``models`` are names or files, ``repeats`` those of all that is random. The robot's trials take each model's
    parameters for the robot, the clips those for off-line tests. Raises `UsageError` on what cannot be run, and
    on a folder that holds other trials.
    """
    robot = settings.plan(ROBOT, models, (), repeats if repeats is not None else REPEATS, seed)
    clips = [_clip_plan(experiment, repeats, seed) for experiment in clip_experiments(models)]
    if means.cluster is None:
        require_backend()
    with open_pool(means.workers, means.cluster) as pool:
        folder.mkdir(parents=True, exist_ok=True)
        crossed, *watched = [_run(part, folder / part.name, pool, means) for part in _parts(robot, clips)]
    offline = clips[0].showings[0].models
    # After the workers have gone: nothing of this run's own competes for the processor.
    times = _times(robot.settings.models, offline, means)
    clip_rows = [row for done in watched for row in done.rows]
    standings = ranked(_standing(model, crossed.rows, clip_rows, times) for model in offline)
    RunFolder(folder).write_rows("leaderboard.csv", table(standings))
    figures.save(leaderboard_figure.draw(standings, robot.repeats), folder)
    return Board(folder, standings, [failure for done in (crossed, *watched) for failure in done.failures])


def _parts(robot: Plan, clips: Sequence[offline_run.OfflinePlan]) -> list[Part]:
    specs, schemas = robot.specs(), (CLIP_SCHEMA, SERIES_SCHEMA)
    crossings = robot_contents(specs, recordings=False, frames=False)
    own = (TRIAL_SCHEMA, FRAME_SCHEMA)
    trials = Part(ROBOT.name, "trials", specs, describe(robot), crossings, own, _trial, console.seconds)
    shown = [(p, clip_contents(p.showings, frames=False)) for p in clips]
    return [
        trials,
        *(
            Part(p.experiment.name, "clips", p.showings, p.describe(), known, schemas, _clip, offline_run.pixels)
            for p, known in shown
        ),
    ]


def _clip_plan(experiment: OfflineExperiment, repeats: int | None, seed: int) -> offline_run.OfflinePlan:
    # Where one repeat says it all, nothing in the clips is random: more would only count the same ones again.
    return offline_run.plan(experiment, (), (), repeats if experiment.repeats > 1 else None, seed)


_trial = partial(work, keep=Keep(recordings=False, frames=False))


def _clip(showing: Showing) -> Finished:
    """One clip in a worker; its frames are not kept."""
    return dataclasses.replace(show(showing), frames=SERIES_SCHEMA.empty_table())


def _run(part: Part, out: Path, pool: Pool, means: console.Means) -> Done:
    """Do what is missing of a part, with progress."""
    with contextlib.closing(RunFolder(out, *part.schemas)) as run:
        run.enter(part.description, begun(out), part.contents, means.other_code)
        left = len(part.specs) - len(run.done())
        if not means.quiet:
            said = f"{part.name}: {len(part.specs)} {part.things}, {left} of them to do, {console.where(means)}"
            console.error_console.print(said, markup=False)
        failures = console.do(part.name, part.specs, run, pool, means, part.work, part.things, part.size)
        return Done(run.rows(), failures)


def _times(robot: Sequence[Chosen], offline: Sequence[Chosen], means: console.Means) -> dict[str, dict[str, Any]]:
    """Measure -> label -> us per frame of every round."""
    if not means.quiet:
        console.error_console.print("timing: 99x72 and 320x180, in turns, one thread")
    return {"us_99x72": time_models(robot, (72, 99)), "us_320x180": time_models(offline, (180, 320))}


def _standing(
    model: Chosen, robot: Sequence[Mapping[str, Any]], clips: Sequence[Mapping[str, Any]],
    times: Mapping[str, Mapping[str, Any]],
) -> Standing:  # fmt: skip
    # A model without a potential, which says where motion is alone, has nothing that could be scored.
    known = model.label if model.counted else None
    own_robot, own_clips = ([row for row in rows if row["model"] == known] for rows in (robot, clips))
    us = {measure: taken[model.label] for measure, taken in times.items() if model.label in taken}
    looming = not {"hs", "vs"} & set(model.channels)
    spiking = any(threshold is not None for threshold in model.thresholds.values())
    return Standing(model.label, scores(own_robot, own_clips, us, looming, spiking))
