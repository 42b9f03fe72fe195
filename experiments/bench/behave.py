"""Run behaviours in an env: plan their episodes, play them into a folder, score them, judge claims, draw."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import polars as pl

from colias_sim.arena import arena_files
from colias_sim.config import known_arena
from colias_sim.envs import ENVS
from colias_sim.envs.randomise import PRESET
from experiments.bench.report.terminal import progress
from experiments.bench.result import Run, load
from experiments.bench.run import provenance
from experiments.bench.run.errors import UsageError, check_unique
from experiments.bench.run.models import choose
from experiments.bench.run.play import one_thread
from experiments.bench.run.rows import TrialRecord, drawn_here, recording_of
from experiments.bench.run.runs import Batch
from experiments.bench.run.settings import check_counts
from experiments.bench.run.user_code import is_own
from experiments.bench.run.workers import Workers
from experiments.bench.sources import episode_scores as scoring
from experiments.bench.sources.behaviour import Behaviour
from experiments.bench.sources.episodes import (
    EPISODES,
    STEPS,
    EpisodeTrial,
    env_id,
    load_behaviour,
    play,
    record,
)  # fmt: skip
from experiments.bench.stats import stored
from experiments.bench.stats.tests import Score
from scenes import is_arena_file

SET_BY_BEHAVIOUR = ("observation", "actions", "model")


def episodes(
    behaviours: Sequence[str], env: str, options: Mapping[str, Any], count: int, seed: int, steps: int | None = None,
    reference: str = "",
) -> Batch[EpisodeTrial]:  # fmt: skip
    """Return the episodes of behaviours in an env as a batch; those of equal repeat have equal seeds, so equal worlds.

    Parameters
    ----------
    behaviours
        Registered names, or absolute paths of files.
    env, options
        The env, and the arguments of it that are set.
    count, seed
        Episodes of each behaviour, and the seed of the first.
    steps
        Number of frames of an episode; otherwise the env's own number.
    reference
        Name of the behaviour that collisions are compared with; otherwise the first one's.
    """
    loaded = list(map(load_behaviour, behaviours))
    specs = []
    for place, behaviour in enumerate(loaded):
        sees_by = (choose(behaviour.model),) if behaviour.senses == "neural" else ()
        for repeat in range(count):
            index = place * count + repeat
            specs.append(EpisodeTrial("behave", index, repeat, seed + repeat, behaviours[place], sees_by))
    arena = options.get("arena", "")
    files = [*map(str, arena_files(arena))] if isinstance(arena, str) and is_arena_file(arena) else []
    sources = [*behaviours, *(behaviour.model for behaviour in loaded), *files]
    description = {
        "kind": "episodes", "experiment": "behave", "behaviours": behaviours, "env": env, "options": options,
        "episodes": count, "seed": seed, "steps": steps, "trials": len(specs), "recorded": 0,
        "reference": reference or loaded[0].name, **provenance.of(map(_source, dict.fromkeys(sources))),
    }  # fmt: skip
    return Batch(
        name="behave",
        # A seed's episodes of all behaviours one after the other: the first tell how long the rest takes.
        specs=sorted(specs, key=lambda trial: (trial.repeat, trial.index)),
        work=partial(play_trial, env=env, options=options, steps=steps, recorded=0),
        description=description,
        schemas=(EPISODES, STEPS),
        things="episodes",
    )


def plan(
    names: Sequence[str], env: str | None = None, assignments: Sequence[str] = (), count: int = 20, seed: int = 0,
    *, baselines: bool = True,
) -> Batch[EpisodeTrial]:  # fmt: skip
    """Return the episodes of behaviours in one env, and of what they are compared with, checked.

    Parameters
    ----------
    names
        Behaviours: names, groups of them, .py files, or policies. A group is played with its reference in the place of
        the env's baselines.
    env
        Otherwise that of the first behaviour.
    assignments
        ``NAME=VALUE`` texts: arguments of the env.
    count, seed
        Episodes of each behaviour, and the seed of the first.
    baselines
        Whether to play the baselines too.

    Raises
    ------
    UsageError
        It cannot be played so.
    """
    from experiments.behaviours import GROUPS, REFERENCE

    asked = dict.fromkeys(member for name in names for member in GROUPS.get(name, (_source(name),)))
    first = load_behaviour(next(iter(asked)))
    where = env_id(env or first.env)
    options = env_options(where, assignments, first.options)
    references = [member for name in names for member in REFERENCE.get(name, ())]
    others = (references or ENVS[where].baselines) if baselines else ()
    played = tuple(dict.fromkeys([*asked, *others]))
    check_counts(seed, count, "--episodes")
    check_unique("two behaviours", [load_behaviour(name).name for name in played])
    return episodes(played, where, options, count, seed, reference=(references or [first.name])[0])


def _source(name: str) -> str:
    """Return a behaviour or a model as a worker finds it: a file by its absolute path."""
    return str(Path(name).resolve()) if is_own(name) else name


def env_options(env: str, assignments: Sequence[str], defaults: Mapping[str, Any] | None = None) -> dict[str, Any]:
    """Return ``NAME=VALUE`` texts, over the ``defaults``, as the env's keyword arguments, checked.

    An argument that is a mapping may be typed entry by entry, ``NAME.ENTRY=VALUE``; ``NAME=TEXT`` is its preset then.
    Raises `UsageError` for an invalid argument.
    """
    options = dict(defaults or {})
    for text in assignments:
        key, equals, value = text.partition("=")
        name, dot, entry = key.partition(".")
        if not equals:
            raise UsageError(f"--set {text}: expected NAME=VALUE, for example robots=5")
        before = options.get(name, {})
        entries = {**(before if isinstance(before, Mapping) else {PRESET: before}), entry: _value(value)}
        options[name] = entries if dot else _value(value)
    check_options(env, options, "--set")
    if isinstance(arena := options.get("arena"), str):
        options["arena"] = known_arena(arena)
    return dict(sorted(options.items()))


def check_options(env: str, options: Mapping[str, Any], origin: str) -> None:
    """Make an env with keyword arguments; `UsageError`, beginning with ``origin``, for an invalid one."""
    if own := next((name for name in SET_BY_BEHAVIOUR if name in options), None):
        raise UsageError(f"{origin}: the behaviour sets {own} itself")
    try:
        ENVS[env](**options, observation="state").close()
    except (ValueError, TypeError) as error:
        raise UsageError(f"{origin}: {error}") from error


def _value(text: str) -> Any:
    """Return a number, true or false, or the text itself."""
    try:
        return json.loads(text)
    except ValueError:
        return text


def play_trial(
    trial: EpisodeTrial, *, env: str, options: Mapping[str, Any], steps: int | None, recorded: int
) -> TrialRecord:
    """Play one episode in a worker; the first ``recorded`` of the run with their recordings."""
    kept = trial.index < recorded
    with one_thread():
        episode = play(load_behaviour(trial.condition), env, options, trial.seed, steps, images=kept)
    row = {**episode.row(), "trial": trial.index, "repeat": trial.repeat}
    recording = recording_of(lambda: record(episode)) if kept else None
    done = TrialRecord(trial.index, (row,), episode.steps(trial.index), recording)
    return drawn_here(done) if episode.responses else done  # one that senses the state sees no picture


def run(batch: Batch[EpisodeTrial], out: Path, pool: Workers, *, recordings: int = 0) -> Run:
    """Play the episodes that a folder lacks, score, judge and draw.

    Parameters
    ----------
    batch
        From `plan` or `episodes`.
    out
        The run's folder: a new one, or one that holds a part of this run.
    pool
        Where the episodes are played.
    recordings
        How many episodes, from the first, to record for Rerun.
    """
    from experiments.bench.report import style  # not before: workers do without matplotlib

    env, names = batch.description["env"], [load_behaviour(name).name for name in batch.description["behaviours"]]
    work: Any = batch.work
    description = {**batch.description, "recorded": recordings}
    with replace(batch, work=partial(work, recorded=recordings), description=description).run(out, pool) as folder:
        trials = folder.table("trials")
        # A claim is about the env as it is.
        judged = [] if batch.description["options"] else scoring.verdicts(env, names, trials)
        folder.write_json("claims.json", stored.document(judged))
        played = load(out)
        summary = scoring.summary(trials, env, batch.description["reference"])
        if not summary.is_empty():
            folder.write_rows("summary.csv", summary.to_dicts())
            style.save(played.figure(), out / "figure")
    return played


def score(
    behaviour: Behaviour | str | os.PathLike[str], *, episodes: int = 20, seed: int = 0, env: str | None = None,
    quiet: bool = False, **options: Any,
) -> Mapping[str, Score]:  # fmt: skip
    """Play a behaviour in this process, with progress, and score it.

    ``colias behave`` does the same on all cores, with recordings and against baselines.

    Parameters
    ----------
    behaviour
        A `Behaviour`, the name of one that ships, the path of a .py file that declares ``BEHAVIOUR``, or that of a
        policy's .npz file.
    episodes
        How many to play; episode r has the seed ``seed + r``.
    seed
        Seed of the first episode, 0 or more.
    env
        One of the four, as ``Avoidance`` or by its whole id; otherwise the behaviour's own.
    quiet
        Whether to show no progress.
    **options
        Arguments of the env, as ``robots=5``.

    Returns
    -------
    Mapping
        Measure -> `Score`, with its 95 % interval; those that do not apply are left out.

    Raises
    ------
    UsageError
        There is no such behaviour or env, or a number or an argument of the env is invalid. It is a ``ValueError``.

    Examples
    --------
    >>> from experiments import score
    >>> {name: str(value) for name, value in score("fixation", episodes=5).items()}
    """
    entry = behaviour if isinstance(behaviour, Behaviour) else load_behaviour(str(behaviour))
    check_counts(seed, episodes, "--episodes")
    where = env_id(str(env or entry.env))
    options = {**entry.options, **options}
    check_options(where, options, "score")
    with progress(entry.name, episodes, quiet, "episodes") as advance:
        rows = []
        for repeat in range(episodes):
            rows.append(play(entry, where, options, seed + repeat).row())
            advance()
    return scoring.scores(pl.DataFrame(rows, EPISODES, strict=False), where)
