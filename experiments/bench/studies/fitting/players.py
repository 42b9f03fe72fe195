"""The player of a fit's settings, by a study, the leaderboard, or tuning curves.

Each batch of settings is a run of one of these kinds, and is played, counted and continued as any other run of it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from experiments.bench import leaderboard, sweep, sweep_plan, tune
from experiments.bench.grid import apart
from experiments.bench.measures import SPIKES
from experiments.bench.run.errors import UsageError
from experiments.bench.run.models import ask, look_up
from experiments.bench.run.runs import Resources
from experiments.bench.run.workers import Workers
from experiments.bench.store.rows import Failure
from experiments.bench.studies.fitting.box import Box, Setting, expanded
from experiments.bench.studies.fitting.fit import LEADERBOARD, TUNING, Fit
from experiments.bench.studies.fitting.scores import Reading, Score, readings, scores
from experiments.bench.study import Axis, Level, Study

AXIS = "setting"
APART = 1000
"""Distance between the seeds of two replicates of a leaderboard or of curves, whose repeats count on from them."""


@dataclass(frozen=True, slots=True)
class Player:
    """Plays settings in a folder of a fit.

    Parameters
    ----------
    fit
        The fit.
    out
        The fit's folder.
    resources
        Workers, or a cluster.
    failures
        Takes everything that fails.
    """

    fit: Fit
    out: Path
    resources: Resources
    failures: list[Failure]

    def play(
        self, name: str, settings: Sequence[Setting], seed: int, replicates: int, pool: Workers, *, anew: bool = False
    ) -> list[Score] | list[Reading]:
        """Play settings; return the score or the measures of each, in their order.

        Parameters
        ----------
        name
            Of the folder. What it holds of these trials is not played again.
        settings
            The settings; an empty one is the model as it is.
        seed
            Of replicate 0.
        replicates
            How many.
        pool
            The workers that play them.
        anew
            Whether they are judged anew, by whole replicates.
        """
        if not self.fit.board:
            study = replace(study_of(self.fit, anew=anew), axes=(axis_of(settings),), replicates=replicates)
            return self._studied(name, settings, study, seed, pool)
        measured: list[dict[str, list[float]]] = [{goal.name: [] for goal in self.fit.goals} for _ in settings]
        play = self._boarded if self.fit.board == LEADERBOARD else self._tuned
        for replicate in range(replicates):
            folder = self.out / (f"{name}-{replicate}" if replicates > 1 else name)
            for place, numbers in enumerate(play(folder, settings, seed + APART * replicate, pool)):
                for goal in self.fit.goals:
                    value = numbers.get(goal.name)
                    measured[place][goal.name].append(math.nan if value is None else value)
        return [
            Reading(setting, {goal: tuple(values) for goal, values in numbers.items()})
            for setting, numbers in zip(settings, measured, strict=True)
        ]

    def _studied(
        self, name: str, settings: Sequence[Setting], study: Study, seed: int, pool: Workers
    ) -> list[Score] | list[Reading]:
        plan = sweep_plan.planned(study, seed)
        batch = sweep.batch(plan, name)
        with batch.run(self.out / name, pool, self.resources) as folder:
            failed = folder.failures()
            self.failures.extend(failed)
            result = sweep.Sweep(plan, folder.trials().to_dicts(), failed)
        by_label = dict(zip(study.axes[0].labels, settings, strict=True))
        return scores(result, by_label) if self.fit.of_claims else readings(result, self.fit.goals, by_label)

    def _boarded(self, folder: Path, settings: Sequence[Setting], seed: int, pool: Workers) -> list[dict[str, Any]]:
        texts = [text_of(self.fit, setting) for setting in settings]
        plan = leaderboard.plan(list(dict.fromkeys(texts)), None, seed)
        responses, failures = leaderboard.play(plan, folder, pool, self.resources)
        self.failures.extend(failures)
        rows: dict[str, dict[str, Any]] = {}
        for table in leaderboard.rank(plan, responses).values():
            for row in table.iter_rows(named=True):
                rows.setdefault(row["model"], {}).update(row)
        return [rows.get(label, {}) for label in _labels(texts)]

    def _tuned(self, folder: Path, settings: Sequence[Setting], seed: int, pool: Workers) -> list[dict[str, Any]]:
        texts = [text_of(self.fit, setting) for setting in settings]
        plan = tune.plan(list(dict.fromkeys(texts)), (), (), seed)
        _, preferences, failures = tune.run(plan, folder, pool, self.resources)
        self.failures.extend(failures)
        rows = {row["model"]: row for row in preferences}
        return [rows.get(label, {}) for label in _labels(texts)]


def axis_of(settings: Sequence[Setting]) -> Axis:
    """Return the axis of a study whose levels are settings, by their numbers."""
    levels = (Level(str(n), tuple(f"{key}={value}" for key, value in expanded(setting)))
              for n, setting in enumerate(settings))  # fmt: skip
    return Axis(AXIS, tuple(levels))


def study_of(fit: Fit, *, anew: bool = False) -> Study:
    """Return the study that a fit plays: its own, with the measures that are its goals.

    Parameters
    ----------
    fit
        The fit.
    anew
        Whether settings are judged anew: the search may have fewer trials of each condition.
    """
    study = fit.study if anew or fit.search_repeats is None else replace(fit.study, repeats=fit.search_repeats)
    if fit.of_claims:
        return study
    spikes = any(goal.name.partition(":")[0] == SPIKES for goal in fit.goals)
    others = [goal.name for goal in fit.goals if goal.name.partition(":")[0] != SPIKES]
    return replace(study, measures=(*others, *([SPIKES] if spikes else [])))


def text_of(fit: Fit, setting: Setting) -> str:
    """Return the model of a fit with a setting, as ``--model`` takes it."""
    (model,) = fit.study.models
    parts = ",".join(f"{key.partition('.')[2]}={value}" for key, value in expanded(setting))
    return model if not parts else f"{model},{parts}" if ask(model).settings else f"{model}:{parts}"


def _labels(texts: Sequence[str]) -> list[str]:
    return [look_up([text])[0].chosen.label for text in texts]


def check_board(fit: Fit, box: Box) -> None:
    """Raise `UsageError` for what leaderboard and tuning curves do not take.

    Parameters
    ----------
    fit
        One to a board.
    box
        Its box.
    """
    if fit.study.assignments:
        raise UsageError(f"--set {fit.study.assignments[0]}: {fit.board} takes none; settle it in --model NAME:KEY=V")
    if fit.search_repeats is not None:
        raise UsageError(f"--repeats {fit.search_repeats}: {fit.board} has repeats of its own; --replicates has more"
                         " seeds")  # fmt: skip
    for part in box.ranges:
        if not part.network:
            raise UsageError(f"--over {part}: {fit.board} shows every model the same frames; only parameters of the"
                             " model are free")  # fmt: skip
        if any(apart(key)[1] for key in part.keys):
            raise UsageError(f"--over {part}: {fit.board} takes whole parameters, no first or last of several values")
    known = _BOARD_NAMES[fit.board]
    for goal in fit.goals:
        if goal.name not in known:
            option = "--minimise" if goal.least else "--maximise"
            raise UsageError(f"{option} {goal.name}: {fit.board} has no such number; it has {', '.join(known)}")


_BOARD_NAMES = {
    LEADERBOARD: tuple(
        name for panels in leaderboard.PANELS.values() for names in panels.values() for name in names
        if name not in leaderboard.TIMES
    ),
    TUNING: tune.NUMBERS,
}  # fmt: skip
"""The numbers that a fit may make large: no times, which another run would not repeat."""
