"""Every model on the same robot trials and the same off-line clips: run what is missing, then score."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from experiments.bench.clips import plan as clips_plan
from experiments.bench.clips import run as clips_run
from experiments.bench.clips.experiment import OfflineExperiment
from experiments.bench.clips.plan import OfflinePlan
from experiments.bench.core.batch import Batch, Resources
from experiments.bench.core.figures import plotting
from experiments.bench.core.models import ConfiguredModel
from experiments.bench.core.pool import Pool
from experiments.bench.core.scores import Standing
from experiments.bench.core.store.files import Files
from experiments.bench.core.store.rows import Failure
from experiments.bench.core.terminal import error_console
from experiments.bench.leaderboard import figure as leaderboard_figure
from experiments.bench.leaderboard.scores import ranked, scores, table
from experiments.bench.leaderboard.stimuli import REPEATS, ROBOT, clip_experiments
from experiments.bench.leaderboard.timing import time_models
from experiments.bench.robot import plan as robot_plan
from experiments.bench.robot import run as robot_run
from experiments.bench.robot.plan import Plan


@dataclass(frozen=True, slots=True)
class Board:
    """The leaderboard, best first; of trials and clips that failed, what went wrong."""

    folder: Path
    standings: list[Standing]
    failures: list[Failure]


def run(folder: Path, models: Sequence[str], repeats: int | None, seed: int, resources: Resources) -> Board:
    """Run what ``folder`` lacks of the trials, time the models, and write ``leaderboard.csv`` and the figure.

    The robot's trials take each model's parameters for the robot, the clips those for off-line tests.

    Parameters
    ----------
    folder
        A new one, or one that holds a part of this run.
    models
        Names, or paths of files.
    repeats
        Those of all that is random; ``None`` for the design's own.
    seed
        Of the whole run.
    resources
        Workers, or a cluster.

    Raises
    ------
    UsageError
        Something cannot be run, or the folder holds other trials.
    """
    robot = robot_plan.plan(ROBOT, models, (), repeats if repeats is not None else REPEATS, seed)
    clips = [_clip_plan(experiment, repeats, seed) for experiment in clip_experiments(models)]
    with resources.pool() as pool:
        folder.mkdir(parents=True, exist_ok=True)
        batches: list[Batch[Any]] = [_robot_batch(robot), *(clips_run.batch(made, frames=False) for made in clips)]
        crossed, *watched = [_run(batch, folder / batch.name, pool, resources) for batch in batches]
    offline = clips[0].showings[0].models
    # After the workers have gone: nothing of this run's own competes for the processor.
    times = _times(robot.settings.models, offline, resources)
    clip_rows = [row for rows, _ in watched for row in rows]
    standings = ranked(_standing(model, crossed[0], clip_rows, times) for model in offline)
    Files(folder).write_rows("leaderboard.csv", table(standings))
    plotting.save(leaderboard_figure.draw(standings, robot.repeats), folder)
    return Board(folder, standings, [failure for _, failures in (crossed, *watched) for failure in failures])


def _robot_batch(robot: Plan) -> Batch[Any]:
    return robot_run.batch(robot, robot_run.ROWS_ONLY)


def _run(batch: Batch[Any], out: Path, pool: Pool, resources: Resources) -> tuple[list[dict[str, Any]], list[Failure]]:
    """Do what is missing of a batch; its rows, and what failed."""
    with closing(batch.open(out, resources)) as folder:
        failures = batch.fill(folder, pool, resources)
        return folder.rows(), failures


def _clip_plan(experiment: OfflineExperiment, repeats: int | None, seed: int) -> OfflinePlan:
    # Where one repeat says it all, nothing in the clips is random: more would only count the same ones again.
    return clips_plan.plan(experiment, (), (), repeats if experiment.repeats > 1 else None, seed)


def _times(
    robot: Sequence[ConfiguredModel], offline: Sequence[ConfiguredModel], resources: Resources
) -> dict[str, dict[str, Any]]:
    """Measure -> label -> us per frame of every round."""
    if not resources.quiet:
        error_console.print("timing: 99x72 and 320x180, in turns, one thread")
    return {"us_99x72": time_models(robot, (72, 99)), "us_320x180": time_models(offline, (180, 320))}


def _standing(
    model: ConfiguredModel, robot: Sequence[Mapping[str, Any]], clips: Sequence[Mapping[str, Any]],
    times: Mapping[str, Mapping[str, Any]],
) -> Standing:  # fmt: skip
    # A model without a potential, which says where motion is alone, has nothing that could be scored.
    known = model.label if model.counted else None
    own_robot, own_clips = ([row for row in rows if row["model"] == known] for rows in (robot, clips))
    us = {measure: taken[model.label] for measure, taken in times.items() if model.label in taken}
    looming = not {"hs", "vs"} & set(model.channels)
    spiking = any(threshold is not None for threshold in model.thresholds.values())
    return Standing(model.label, scores(own_robot, own_clips, us, looming, spiking))
