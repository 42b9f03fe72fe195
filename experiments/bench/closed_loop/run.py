"""Behaviours in an env, over seeds: play what is missing, in a run's folder, and score it against baselines."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

import cv2
import polars as pl
from gymnasium.envs.registration import load_env_creator
from threadpoolctl import threadpool_limits

from colias_sim.arena import Arena
from colias_sim.config import known_arena
from colias_sim.envs import ENVS
from colias_sim.envs.randomise import PRESET
from experiments.bench.closed_loop.behaviour import Behaviour
from experiments.bench.closed_loop.episode import EpisodeSpec, Setting, play_behaviour, play_entry, start_places
from experiments.bench.closed_loop.find import env_id, load_behaviour, members
from experiments.bench.closed_loop.scores import EPISODE_SCHEMA, STEP_SCHEMA, finished, scores
from experiments.bench.engine.terminal import count, progress
from experiments.bench.run.errors import UsageError, short
from experiments.bench.run.models import load_model
from experiments.bench.run.runs import Batch, Resources
from experiments.bench.run.settings import check_counts
from experiments.bench.run.user_code import is_file, is_own
from experiments.bench.run.workers import Workers
from experiments.bench.stats.scores import Score, Standing
from experiments.bench.store import provenance
from experiments.bench.store.drawing import drawn_here
from experiments.bench.store.rows import Failure, TrialRecord, known, recording_of
from scenes import is_arena_file

MAPPINGS = ("camera", "robot", "randomise")
"""The arguments of the envs that may be mappings."""
SET_BY_BEHAVIOUR = ("observation", "actions", "render_mode", "render_view", "render_width", "render_height", "model")


@dataclass(frozen=True, slots=True)
class BehaviourPlan:
    """Plan of who plays where: ``settings`` in order, the first being that asked for; each the same ``episodes``
    seeds.
    """

    settings: tuple[Setting, ...]
    episodes: int
    seed: int
    kind: str = "episodes"
    """As `experiments.bench.store.kinds` names it."""

    def specs(self) -> list[EpisodeSpec]:
        """Return every episode; those of equal repeat have equal seeds, so equal worlds."""
        return [
            EpisodeSpec(place * self.episodes + repeat, repeat, self.seed + repeat, setting)
            for place, setting in enumerate(self.settings)
            for repeat in range(self.episodes)
        ]

    def describe(self) -> dict[str, Any]:
        """Return what makes two runs one."""
        return {
            "kind": self.kind, "experiment": "behave", "seed": self.seed, "repeats": self.episodes,
            "trials": len(self.specs()),
            "settings": [dataclasses.asdict(setting) for setting in self.settings],
            **provenance.of(self._sources()),
        }  # fmt: skip

    def _sources(self) -> list[str]:
        """Return the behaviours, the models that they look through, and arenas; a file by its absolute path."""
        models = [load_behaviour(setting.behaviour).model for setting in self.settings]
        sources = [*(setting.behaviour for setting in self.settings), *models]
        sources += [file for setting in self.settings for file in arena_files(dict(setting.options).get("arena", ""))]
        return [str(Path(source).resolve()) if is_own(source) else source for source in dict.fromkeys(sources)]


@dataclass(frozen=True, slots=True)
class Played:
    """Results of a plan."""

    folder: Path
    env: str
    standings: list[Standing]
    """Each behaviour's scores, the one asked for first."""
    steps: pl.DataFrame
    """A row per frame, `STEP_SCHEMA`."""
    failures: list[Failure]
    options: tuple[tuple[str, Any], ...] = ()
    """The arguments of the env that were set."""
    starts: Mapping[str, tuple[float, float, float]] = field(default_factory=dict)
    """Poses of the robots at the start of the first episode: x and y in cm, heading in degrees. Empty where no
    paths are drawn."""


def plan(
    behaviour: str, env: str | None, assignments: Sequence[str], episodes: int, seed: int, baselines: bool,
    against: str | None = None,
) -> BehaviourPlan:  # fmt: skip
    """Return a checked plan of one behaviour and its baselines; `UsageError` for what cannot be played.

    A group of behaviours is played whole, with what it is held against in the place of the baselines. ``against`` is
    another behaviour, whose collisions are compared with the first one's. It takes the place of the baselines.
    """
    asked, reference = members(behaviour)
    entry = load_behaviour(asked[0])
    where = env_id(env) if env is not None else env_id(entry.env)
    options = env_options(where, assignments)
    usual = reference or ENVS[where].baselines
    others = [name for name in usual if name not in asked] if baselines else []
    if against is not None:
        if len(asked) > 1:
            raise UsageError(f"--power {against}: {behaviour} is a group of behaviours; legal is one of them")
        others = [_comparable(against, entry.name, where)]
    settings = tuple(Setting(_source(name), where, options) for name in (*asked, *others))
    check_counts(seed, episodes, "--episodes", len(settings), "behaviours")
    return BehaviourPlan(settings, episodes, seed)


def _source(name: str) -> str:
    """Return the behaviour as a worker finds it: a file by its absolute path."""
    return str(Path(name).resolve()) if is_own(name) else name


def _comparable(against: str, name: str, env: str) -> str:
    """Return the behaviour after ``--power``, checked: another one, where collisions are counted."""
    if all(measure.kind != "collision_rate" for measure in ENVS[env].all_measures):
        counted = ", ".join(
            known.partition("/")[2] for known, entry in ENVS.items()
            if any(measure.kind == "collision_rate" for measure in entry.all_measures)
        )  # fmt: skip
        short = env.partition("/")[2]
        raise UsageError(f"--power {against}: {short} counts no collisions; legal is a behaviour in {counted}")
    if load_behaviour(against).name == name:
        raise UsageError(f"--power {against}: that is the behaviour itself; legal is another one")
    return against


def env_options(env: str, assignments: Sequence[str]) -> tuple[tuple[str, Any], ...]:
    """``NAME=VALUE`` texts as the env's keyword arguments, checked by `check_options`.

    An argument that is a mapping may be typed entry by entry, ``NAME.ENTRY=VALUE``; ``NAME=TEXT`` is its preset then.
    Raises `UsageError` for what is not legal.
    """
    options: dict[str, Any] = {}
    for text in assignments:
        key, equals, value = text.partition("=")
        if not equals:
            raise UsageError(f"--set {text}: expected NAME=VALUE, for example robots=5")
        name, dot, entry = key.partition(".")
        if name in SET_BY_BEHAVIOUR:
            raise UsageError(f"--set {text}: the behaviour sets that itself")
        if not dot:
            options[name] = _value(value)
            continue
        if name not in MAPPINGS:
            raise UsageError(f"--set {text}: only {', '.join(MAPPINGS)} have entries")
        before = options.get(name, {})
        options[name] = {**(before if isinstance(before, dict) else {PRESET: before}), entry: _value(value)}
    check_options(env, options, "--set")
    if isinstance(arena := options.get("arena"), str):
        options["arena"] = known_arena(arena)
    return tuple(sorted(options.items()))


def arena_files(arena: Any) -> list[str]:
    """List the user's own files that an arena is made of, by their paths; none of one that ships."""
    return [str(path) for path in Arena.read(arena).files] if isinstance(arena, str) and is_arena_file(arena) else []


def check_options(env: str, options: Mapping[str, Any], origin: str) -> None:
    """Make an env with keyword arguments; raise `UsageError` for what is not legal, beginning with their origin."""
    try:
        load_env_creator(ENVS[env].entry_point)(**{**options, "observation": "state"}).close()
    except (ValueError, TypeError) as error:
        raise UsageError(f"{origin}: {error}") from error


def _value(text: str) -> Any:
    """Return a number, true or false, or the text itself."""
    try:
        return json.loads(text)
    except ValueError:
        return text


def score(
    behaviour: Behaviour, *, episodes: int = 20, seed: int = 0, env: str | None = None, quiet: bool = False,
    **options: Any,
) -> dict[str, Score | None]:  # fmt: skip
    """Play a behaviour here and now, with progress unless ``quiet``: its measures by name, with 95 % intervals.

    ``options`` are the env's arguments. Raises `UsageError` for what is not legal.
    """
    check_counts(seed, episodes, "--episodes")
    where = env_id(env or behaviour.env)
    for name, value in options.items():
        if name in SET_BY_BEHAVIOUR and name != "model":
            raise UsageError(f"score: {name}={short(value)}: the behaviour sets that itself")
    check_options(where, options, "score")
    model = options.get("model", behaviour.model)
    if behaviour.senses == "neural" and isinstance(model, str | Path) and is_file(str(model)):
        options["model"] = load_model(str(model))  # once: an edit meanwhile would give later episodes another model
    rows: list[dict[str, Any]] = []
    with progress(behaviour.name, episodes, quiet, "episodes") as advance:
        for repeat in range(episodes):
            episode = play_entry(behaviour, where, options, seed + repeat)
            rows += finished(episode, repeat, repeat, None).rows
            advance()
    return scores(rows, where)


def work(spec: EpisodeSpec, *, recorded: int) -> TrialRecord:
    """Return one episode in a worker; the first ``recorded`` of the run with their recordings."""
    cv2.setNumThreads(1)
    with threadpool_limits(1):
        record = spec.index < recorded
        episode = play_behaviour(spec, images=record)
        recording = None
        if record:
            from experiments.bench.closed_loop import recording as closed_loop_recording

            recording = recording_of(partial(closed_loop_recording.record, episode))
        done = finished(episode, spec.index, spec.repeat, recording)
        if episode.series is None:  # one that senses the state sees no picture
            return done
        return drawn_here(done)


def batch(plan: BehaviourPlan, recorded: int) -> Batch[EpisodeSpec]:
    """Return the episodes of a plan as a batch; the first ``recorded`` leave recordings."""
    # A seed's episodes of all behaviours one after the other, so that the first episodes tell how long the rest takes.
    specs = sorted(plan.specs(), key=lambda spec: (spec.repeat, spec.index))
    names = [Path(setting.behaviour).stem for setting in plan.settings]
    kept = f"; those of {names[0]} are recorded" if recorded else ""
    return Batch(
        name="behave",
        specs=specs,
        work=partial(work, recorded=recorded),
        description={**plan.describe(), "recorded": recorded},
        schemas=(EPISODE_SCHEMA, STEP_SCHEMA),
        things="episodes",
        amount=lambda: f"{count(len(specs), 'episode')} ({', '.join(names)}){kept}",
        size=longest,
    )


def run(plan: BehaviourPlan, out: Path, pool: Workers, resources: Resources, *, recordings: int = 0) -> Played:
    """Play what is missing, and score it.

    Parameters
    ----------
    plan
        From `plan`.
    out
        The run's folder: a new one, or one that holds a part of this run.
    pool, resources
        Where the episodes are played.
    recordings
        How many episodes, from the first, to record for Rerun.
    """
    episodes = batch(plan, recordings)
    with episodes.run(out, pool, resources) as folder:
        failures = folder.failures()
        standings = _standings(plan, folder.trials().to_dicts())
        folder.write_rows("scores.csv", table(plan.settings[0].env, standings))
        first = plan.settings[0]
        drawn = standings and ENVS[first.env].draws_paths
        starts = start_places(first.env, dict(first.options), standings[0].rows[0]["seed"]) if drawn else {}
        return Played(out, first.env, standings, folder.frames(), failures, first.options, starts)


def _standings(plan: BehaviourPlan, rows: Sequence[Mapping[str, Any]]) -> list[Standing]:
    standings = []
    for place, setting in enumerate(plan.settings):
        first = place * plan.episodes
        setting_rows = [row for row in rows if first <= row["trial"] < first + plan.episodes]
        if setting_rows:
            standings.append(Standing(setting_rows[0]["model"], scores(setting_rows, setting.env), setting_rows))
    return standings


def table(env: str, standings: Sequence[Standing]) -> list[dict[str, Any]]:
    """Return a row per behaviour and measure."""
    return [
        {
            "env": env, "behaviour": standing.name, "measure": name, "episodes": len(standing.rows),
            "value": known(score.value), "ci_low": known(score.low), "ci_high": known(score.high),
        }
        for standing in standings
        for name, score in standing.scores.items()
        if score is not None
    ]  # fmt: skip


def longest(spec: EpisodeSpec) -> float:
    """Return the steps of an episode that goes on to its end."""
    return float(spec.condition.steps or ENVS[spec.condition.env].max_episode_steps)
