"""Behaviours in an env, over seeds: play what is missing, in a run's folder, and score it against baselines."""

from __future__ import annotations

import contextlib
import dataclasses
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import cv2
import gymnasium as gym
import pyarrow as pa
from threadpoolctl import threadpool_limits

from colias_sim.envs import ENVS
from colias_sim.gl import require_backend
from experiments.behaviours import BASELINES
from experiments.bench import console, provenance
from experiments.bench.behaving import Behaviour, env_id, in_file, load_behaviour
from experiments.bench.contents import Contents, Planned
from experiments.bench.description import begun
from experiments.bench.episode_scores import EPISODE_SCHEMA, STEP_SCHEMA, Score, finished, scores
from experiments.bench.episodes import EpisodeSpec, Setting, play_behaviour, play_entry
from experiments.bench.files import UsageError, is_file
from experiments.bench.pool import Pool, open_pool
from experiments.bench.progress import progress
from experiments.bench.results import Failure, Finished, RunFolder, known
from experiments.bench.settings import check_counts

SET_BY_BEHAVIOUR = ("observation", "actions", "render_mode", "render_view", "render_width", "render_height", "model")
DEFAULT_GAP_CM = 10.0


@dataclass(frozen=True, slots=True)
class BehaviourPlan:
    """Who plays where: ``settings`` in order, the first being that asked for; each the same ``episodes`` seeds."""

    settings: tuple[Setting, ...]
    episodes: int
    seed: int

    def specs(self) -> list[EpisodeSpec]:
        """Every episode; those of equal repeat have equal seeds, so equal worlds."""
        return [
            EpisodeSpec(place * self.episodes + repeat, repeat, self.seed + repeat, setting)
            for place, setting in enumerate(self.settings)
            for repeat in range(self.episodes)
        ]

    def describe(self) -> dict[str, Any]:
        """What makes two runs one."""
        return {
            "experiment": "behave", "seed": self.seed, "repeats": self.episodes, "trials": len(self.specs()),
            "settings": [dataclasses.asdict(setting) for setting in self.settings],
            **provenance.of(self._sources()),
        }  # fmt: skip

    def _sources(self) -> list[str]:
        """The user's own files that decide the numbers: of behaviours, and of the models that they look through."""
        models = [str(Path(m).resolve()) for s in self.settings if is_file(m := load_behaviour(s.behaviour).model)]
        return [*(setting.behaviour for setting in self.settings if in_file(setting.behaviour)), *models]

    def contents(self, recorded: int) -> Contents:
        """What the run's folder may hold, with recordings of the first ``recorded`` episodes."""
        names = {setting.behaviour: load_behaviour(setting.behaviour).name for setting in self.settings}
        trials = {}
        for spec in self.specs():
            setting = spec.condition
            columns = {"experiment": "behave", "repeat": spec.repeat, "seed": spec.seed, "env": setting.env}
            trials[spec.index] = Planned(columns, (names[setting.behaviour],), spec.index < recorded)
        return Contents(trials)


@dataclass(frozen=True, slots=True)
class Standing:
    """One behaviour's scores in one env, and the rows they are of."""

    behaviour: str
    env: str
    scores: Mapping[str, Score]
    rows: Sequence[Mapping[str, Any]]


@dataclass(frozen=True, slots=True)
class Played:
    """What became of a plan."""

    folder: Path
    standings: list[Standing]
    steps: pa.Table
    """A row per frame, `STEP_SCHEMA`."""
    failures: list[Failure]


def plan(
    behaviour: str, env: str | None, assignments: Sequence[str], episodes: int, seed: int, baselines: bool
) -> BehaviourPlan:
    """A checked plan of one behaviour and its baselines; `UsageError` for what cannot be played."""
    check_counts(seed, episodes, "--episodes")
    entry = load_behaviour(behaviour)
    where = env_id(env) if env is not None else env_id(entry.env)
    options = _options(where, assignments)
    source = str(Path(behaviour).resolve()) if in_file(behaviour) else behaviour
    others = [name for name in BASELINES.get(where, ()) if name != behaviour] if baselines else []
    settings = tuple(Setting(name, where, options) for name in (source, *others))
    return BehaviourPlan(settings, episodes, seed)


def _options(env: str, assignments: Sequence[str]) -> tuple[tuple[str, Any], ...]:
    """``NAME=VALUE`` texts as the env's keyword arguments, each tried on the env."""
    options: dict[str, Any] = {}
    for text in assignments:
        name, equals, value = text.partition("=")
        if not equals:
            raise UsageError(f"--set {text}: expected NAME=VALUE, for example robots=5")
        if name in SET_BY_BEHAVIOUR:
            raise UsageError(f"--set {text}: the behaviour sets that itself")
        options[name] = _value(value)
    try:
        gym.make(env, observation="state", **options).close()
    except (ValueError, TypeError) as error:
        raise UsageError(f"--set: {error}") from None
    return tuple(sorted(options.items()))


def _value(text: str) -> Any:
    """A number, true or false, or the text itself."""
    try:
        return json.loads(text)
    except ValueError:
        return text


def score(
    behaviour: Behaviour, *, episodes: int = 20, seed: int = 0, env: str | None = None, **options: Any
) -> dict[str, Score]:
    """Play a behaviour here and now, with progress: its measures by name, with their 95 % intervals.

    ``options`` are the env's arguments. Raises ``ValueError`` for what is not legal.
    """
    check_counts(seed, episodes, "--episodes")
    where = env_id(env or behaviour.env)
    rows: list[dict[str, Any]] = []
    wanted = float(options.get("distance_cm", DEFAULT_GAP_CM))
    with progress(behaviour.name, episodes, False, "episodes") as advance:
        for repeat in range(episodes):
            episode = play_entry(behaviour, where, options, seed + repeat)
            rows += finished(episode, repeat, repeat, wanted, None).rows
            advance()
    return scores(rows, where)


def work(spec: EpisodeSpec, *, recorded: int) -> Finished:
    """One episode in a worker; the first ``recorded`` of the run with their recordings."""
    cv2.setNumThreads(1)
    with threadpool_limits(1):
        record = spec.index < recorded
        episode = play_behaviour(spec, images=record)
        recording = None
        if record:
            from experiments.bench import log_episode

            recording = log_episode.record(episode)
        wanted = float(dict(spec.condition.options).get("distance_cm", DEFAULT_GAP_CM))
        return finished(episode, spec.index, spec.repeat, wanted, recording)


def run(made: BehaviourPlan, out: Path, means: console.Means, recordings: bool) -> Played:
    """Play what ``out`` lacks, with a pool of its own; goes on with a run begun there."""
    if means.cluster is None:
        require_backend()
    with open_pool(means.workers, means.cluster) as pool:
        return run_with(made, out, pool, means, made.episodes if recordings else 0)


def run_with(made: BehaviourPlan, out: Path, pool: Pool, means: console.Means, recorded: int) -> Played:
    """Play what is missing, and score; the first ``recorded`` episodes leave recordings."""
    specs = made.specs()
    with contextlib.closing(RunFolder(out, EPISODE_SCHEMA, STEP_SCHEMA)) as folder:
        description = {**made.describe(), "recorded": recorded}
        folder.enter(description, begun(out), made.contents(recorded), means.other_code)
        left = len(specs) - len(folder.done())
        if not means.quiet:
            names = [Path(setting.behaviour).stem for setting in made.settings]
            kept = f"; those of {names[0]} are recorded" if recorded else ""
            size = f"{console.count(len(specs), 'episode')} ({', '.join(names)}){kept}"
            said = f"{size}, {left} of them to do, {console.where(means)}, into {out}"
            console.error_console.print(said, soft_wrap=True, markup=False)
        failures = console.do("behave", specs, folder, pool, means, partial(work, recorded=recorded), "episodes")
        standings = _standings(made, folder.rows())
        folder.write_rows("scores.csv", table(standings))
        return Played(out, standings, folder.frames(), failures)


def _standings(made: BehaviourPlan, rows: Sequence[Mapping[str, Any]]) -> list[Standing]:
    found = []
    for place, setting in enumerate(made.settings):
        first = place * made.episodes
        own = [row for row in rows if first <= row["trial"] < first + made.episodes]
        if own:
            found.append(Standing(own[0]["model"], setting.env, scores(own, setting.env), own))
    return found


def table(standings: Sequence[Standing]) -> list[dict[str, Any]]:
    """A row per behaviour and measure."""
    return [
        {
            "env": standing.env, "behaviour": standing.behaviour, "measure": name, "episodes": len(standing.rows),
            "value": known(score.value), "ci_low": known(score.low), "ci_high": known(score.high),
        }
        for standing in standings
        for name, score in standing.scores.items()
    ]  # fmt: skip


def longest(made: BehaviourPlan) -> int:
    """The frames of the plan, if every episode went on to its end."""
    return sum(made.episodes * (s.steps or ENVS[s.env].max_episode_steps) for s in made.settings)
