"""Every model on the same robot trials, and on the clips of its kind: run what is missing, then score."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import polars as pl

from dsnn.stimuli.looming import Looming
from experiments.bench import offline
from experiments.bench import trials as robot_plan
from experiments.bench import trials as robot_run
from experiments.bench.engine.alarms import alarm_count, first_alarm_s
from experiments.bench.engine.terminal import error_console
from experiments.bench.figures import plotting
from experiments.bench.leaderboard import figure as leaderboard_figure
from experiments.bench.leaderboard import looming_scores, scores
from experiments.bench.leaderboard.kinds import DIRECTION, LOOMING, Ranking
from experiments.bench.leaderboard.looming_scores import ShownClip
from experiments.bench.leaderboard.looming_stimuli import looming_experiments
from experiments.bench.leaderboard.stimuli import REPEATS, ROBOT, clip_experiments
from experiments.bench.leaderboard.timing import time_models
from experiments.bench.offline import OfflinePlan
from experiments.bench.run.models import ConfiguredModel, shown_models
from experiments.bench.run.play import Trial
from experiments.bench.run.runs import Batch, Resources
from experiments.bench.run.settings import watchers
from experiments.bench.run.workers import Workers
from experiments.bench.sources.clips import OfflineExperiment
from experiments.bench.stats.scores import Standing
from experiments.bench.store.files import Files
from experiments.bench.store.kinds import LEADERBOARD
from experiments.bench.store.record import begin_whole
from experiments.bench.store.rows import Failure

Row = Mapping[str, Any]
Times = Mapping[str, Mapping[str, Sequence[float]]]
"""Measure -> label -> us per frame of every round."""


@dataclass(frozen=True, slots=True)
class Board:
    """The leaderboard, a ranking for each kind of which there is a model; of what failed, what went wrong."""

    folder: Path
    rankings: tuple[Ranking, ...]
    failures: list[Failure]


def run(folder: Path, models: Sequence[str], repeats: int | None, seed: int, resources: Resources) -> Board:
    """Run what ``folder`` lacks of the trials, time the models, and write a table and a figure of each kind.

    A model that answers by hs or vs is shown the clips of direction, one that answers by looming those of looming.
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
    with resources.pool() as pool:
        played = play(folder, models, repeats, seed, pool, resources)
    offline, _ = watchers(shown_models((), models, only=True), ())
    # After the workers have gone: nothing of this run's own competes for the processor.
    rankings = played.rankings(_times(played.robot.settings.models, offline, resources))
    for ranking in rankings:
        Files(folder).write_rows(ranking.kind.table, ranking.rows())
        plotting.save(leaderboard_figure.draw(ranking, played.robot.repeats), folder, ranking.kind.figure)
    return Board(folder, rankings, played.failures)


@dataclass(frozen=True, slots=True)
class Played:
    """The trials and clips of a leaderboard, as every model answered them.

    Parameters
    ----------
    robot
        The plan of the trials.
    crossed
        Their rows.
    direction, looming
        The models that stand in either ranking.
    clip_rows
        The rows of the clips of direction.
    clips
        The clips of looming.
    failures
        Everything that failed.
    """

    robot: robot_plan.Plan
    crossed: list[dict[str, Any]]
    direction: tuple[ConfiguredModel, ...]
    looming: tuple[ConfiguredModel, ...]
    clip_rows: list[dict[str, Any]]
    clips: list[ShownClip]
    failures: list[Failure]

    def rankings(self, times: Times) -> tuple[Ranking, ...]:
        """Return a ranking for each kind of which there is a model, with ``times`` of a frame by measure and label."""
        rankings = []
        if self.direction:
            standings = [_standing(model, self.crossed, self.clip_rows, times) for model in self.direction]
            rankings.append(_ranking(DIRECTION, standings))
        if self.looming:
            standings = [_looming_standing(model, self.crossed, self.clips, times) for model in self.looming]
            rankings.append(_ranking(LOOMING, standings))
        return tuple(rankings)


def play(
    folder: Path, models: Sequence[str], repeats: int | None, seed: int, pool: Workers, resources: Resources
) -> Played:
    """Run what ``folder`` lacks of the trials and clips.

    Parameters
    ----------
    folder, models, repeats, seed, resources
        As of `run`.
    pool
        What runs them.

    Raises
    ------
    UsageError
        Something cannot be run, or the folder holds other trials.
    """
    robot = robot_plan.plan(ROBOT, models, (), repeats if repeats is not None else REPEATS, seed)
    directional, looming = of_kinds(models)
    of_direction = [
        _clip_plan(experiment, repeats, seed) for experiment in (clip_experiments(directional) if directional else ())
    ]
    of_looming = [
        _clip_plan(experiment, repeats, seed) for experiment in (looming_experiments(looming) if looming else ())
    ]
    batches: list[Batch[Any]] = [
        robot_run.batch(robot, robot_run.ROWS_ONLY),
        *(offline.batch(plan, frames=False) for plan in of_direction),
        *(offline.batch(plan) for plan in of_looming),
    ]
    begin_whole(folder, LEADERBOARD)
    done = [_run(batch, folder / batch.name, pool, resources) for batch in batches]
    watched, loomed = done[1 : 1 + len(of_direction)], done[1 + len(of_direction) :]
    return Played(
        robot,
        done[0].rows,
        of_direction[0].models if of_direction else (),
        of_looming[0].models if of_looming else (),
        [row for experiment in watched for row in experiment.rows],
        [clip for plan, experiment in zip(of_looming, loomed, strict=True) for clip in _shown(plan, experiment)],
        [failure for experiment in done for failure in experiment.failures],
    )


def of_kinds(models: Sequence[str]) -> tuple[list[str], list[str]]:
    """Return those of ``models`` that stand in the ranking of direction, and those that stand in that of looming.

    A model that answers by neither, which tells where motion is alone, stands among those of direction.
    """
    chosen = [(text, watchers((text,), ())[0][0].channels) for text in dict.fromkeys(models)]
    looming = [text for text, channels in chosen if "looming" in channels]
    return [text for text, channels in chosen if {"hs", "vs"} & set(channels) or text not in looming], looming


@dataclass(frozen=True, slots=True)
class _Done:
    """Results of a batch; ``frames`` has a row for each frame and model, where they are kept."""

    rows: list[dict[str, Any]]
    frames: pl.DataFrame
    failures: list[Failure]


def _run(batch: Batch[Any], out: Path, pool: Workers, resources: Resources) -> _Done:
    """Do what is missing of a batch."""
    with batch.run(out, pool, resources) as folder:
        return _Done(folder.trials().to_dicts(), folder.frames(), folder.failures())


def _clip_plan(experiment: OfflineExperiment, repeats: int | None, seed: int) -> OfflinePlan:
    # Where one repeat says it all, nothing in the clips is random: more would only count the same ones again.
    return offline.plan(experiment, (), (), repeats if experiment.repeats > 1 else None, seed)


def _times(
    robot: Sequence[ConfiguredModel], offline: Sequence[ConfiguredModel], resources: Resources
) -> dict[str, dict[str, Any]]:
    """Measure -> label -> us per frame of every round."""
    if not resources.quiet:
        error_console.print("timing: 99x72 and 320x180, in turns, one thread")
    return {"us_99x72": time_models(robot, (72, 99)), "us_320x180": time_models(offline, (180, 320))}


def _shown(plan: OfflinePlan, done: _Done) -> list[ShownClip]:
    """Return every clip of a plan as each looming model answered it."""
    trials = {trial.index: trial for trial in plan.trials}
    frames = done.frames.partition_by("trial", "model", as_dict=True)
    return [
        _answered(trials[row["trial"]], row, frames[row["trial"], row["model"]]["looming_spikes"].to_numpy())
        for row in done.rows
    ]


def _answered(trial: Trial, row: Row, spikes: Any) -> ShownClip:
    """Return one clip and one model's spikes in it, (T,)."""
    first, shade, ways = None, "", dict(trial.condition.changes)
    centred = row["stimulus"] == "looming" and not {"azimuth_deg", "background"} & ways.keys()
    if centred and row["motion"] == "looming":
        clip = trial.condition.build(trial.seed)
        assert isinstance(clip, Looming)
        first = first_alarm_s(spikes, clip.contact_s())
        shade = "dark" if clip.params.grey < clip.params.background_grey else "light"
    return ShownClip(row, row["frames"] / row["fps"], alarm_count(spikes, row["fps"]), first, shade)


def _ranking(kind: Any, standings: Sequence[Standing]) -> Ranking:
    return Ranking(kind, kind.ranked(standings))


def _spikes(model: ConfiguredModel, *channels: str) -> bool:
    """Tell whether a model has a threshold in any of some channels."""
    return any(model.thresholds.get(channel) is not None for channel in channels)


def _own(model: ConfiguredModel, times: Times) -> dict[str, Sequence[float]]:
    """Return the times of one model, by measure."""
    return {measure: taken[model.label] for measure, taken in times.items() if model.label in taken}


def _standing(model: ConfiguredModel, robot: Sequence[Row], clips: Sequence[Row], times: Times) -> Standing:
    # A model without a potential, which says where motion is alone, has nothing that could be scored.
    known = model.label if model.counted else None
    own_robot, own_clips = ([row for row in rows if row["model"] == known] for rows in (robot, clips))
    spiking = any(threshold is not None for threshold in model.thresholds.values())
    return Standing(model.label, scores.scores(own_robot, own_clips, _own(model, times), spiking))


def _looming_standing(
    model: ConfiguredModel, robot: Sequence[Row], clips: Sequence[ShownClip], times: Times
) -> Standing:
    own_robot = [row for row in robot if row["model"] == model.label]
    own_clips = [clip for clip in clips if clip.row["model"] == model.label]
    values = looming_scores.scores(own_robot, own_clips, _own(model, times), _spikes(model, "looming"))
    return Standing(model.label, values)
