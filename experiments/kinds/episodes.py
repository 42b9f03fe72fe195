"""Episodes of behaviours in an env: plan them, and score, judge, draw and show a run of them."""

from __future__ import annotations

import dataclasses
import json
import os
from collections.abc import Mapping
from functools import partial
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import polars as pl

from colias_sim.arena import arena_files
from colias_sim.config import known_arena
from colias_sim.envs import ENVS
from colias_sim.envs.options import checked
from colias_sim.envs.randomise import PRESET
from experiments.base.console import count, progress, show_files
from experiments.base.errors import UsageError, check_known, check_unique
from experiments.base.user_code import declared, is_own
from experiments.declare.behaviour import ENDING, Behaviour, load_policy
from experiments.draw.terminal import show_verdicts
from experiments.judge import scores as scoring
from experiments.judge.tests import Score
from experiments.judge.verdict import document
from experiments.kinds.registry import claims_on
from experiments.kinds.result import Kind, Run, concluding, load
from experiments.kinds.tables import BEHAVIOURS, shipped
from experiments.settings.models import choose, named_model
from experiments.settings.settings import check_counts
from experiments.show.episodes import EPISODES, FROZEN, STEPS, EpisodeTrial, env_id, play, record
from experiments.show.play import one_thread
from experiments.store import provenance
from experiments.store.asked import Asked
from experiments.store.folder import RunFolder
from experiments.store.plan import Plan
from experiments.store.tables import TrialRecord, drawn_here, recording_of
from scenes import is_arena_file

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SET_BY_BEHAVIOUR = ("observation", "actions", "model")
EPISODES_EACH = 20
"""Episodes of each behaviour, where none are asked for."""


# What is run.


def plan(asked: Asked) -> Plan[EpisodeTrial]:
    """Return the plan of episodes; those of equal repeat have equal seeds, so equal worlds.

    Parameters
    ----------
    asked
        What was asked for: behaviours by name, group, .py file or policy, and arguments of the env as values. A group
        is played with its reference in the place of the env's baselines. Its options are ``env``, otherwise that of the
        first behaviour; ``baselines``, whether to play these too; ``steps``, frames of an episode, otherwise the env's
        own number; ``recordings``, whether to record the first behaviour's episodes; ``controls``, whether those that
        are named, and see, play again in the same worlds with a vision model that is shown its first frame throughout.

    Raises
    ------
    UsageError
        It cannot be played so.
    """
    groups, references = (shipped(BEHAVIOURS[name]) for name in ("groups", "references"))
    named = dict.fromkeys(member for name in asked.what for member in groups.get(name, (_source(name),)))
    first = load_behaviour(next(iter(named)))
    where = env_id(str(asked.option("env", first.env)))
    options = env_options(where, asked.values, first.options)
    compared = [member for name in asked.what for member in references.get(name, ())]
    others = (compared or ENVS[where].baselines) if asked.option("baselines", True) else ()
    played = tuple(dict.fromkeys([*named, *others]))
    number = EPISODES_EACH if asked.repeats is None else asked.repeats
    check_counts(asked.seed, number, "--episodes")
    reference, loaded = (compared or [first.name])[0], list(map(load_behaviour, played))
    check_unique("two behaviours", [behaviour.name for behaviour in loaded])
    processor = checked(ENVS[where].options_type, options).processor
    trials: list[EpisodeTrial] = []
    for source, behaviour in zip(played, loaded, strict=True):
        sees_by = (choose(behaviour.model, processor=processor),) if behaviour.senses == "neural" else ()
        frozen = [source + FROZEN] if asked.option("controls", False) and source in named and sees_by else []
        for shown, repeat in product([source, *frozen], range(number)):
            trials.append(EpisodeTrial("behave", len(trials), repeat, asked.seed + repeat, shown, sees_by))
    arena, steps = options.get("arena", ""), asked.option("steps")
    recorded = number if asked.option("recordings", False) else 0
    files = [*map(str, arena_files(arena))] if isinstance(arena, str) and is_arena_file(arena) else []
    sources = [*played, *(behaviour.model for behaviour in loaded), *files]
    resolved = {
        "experiment": "behave", "behaviours": played, "env": where, "options": options, "episodes": number,
        "seed": asked.seed, "steps": steps, "trials": len(trials), "recorded": recorded, "reference": reference,
        **provenance.of(map(_source, dict.fromkeys(sources))),
    }  # fmt: skip
    return Plan(
        asked,
        "behave",
        # A seed's episodes of all behaviours one after the other: the first tell how long the rest takes.
        sorted(trials, key=lambda trial: (trial.repeat, trial.index)),
        partial(play_trial, env=where, options=options, steps=steps, recorded=recorded),
        resolved,
        (EPISODES, STEPS),
        tuple(behaviour.name for behaviour in loaded),
        things="episodes",
    )


def _source(name: str) -> str:
    """Return a behaviour or a model as a worker finds it: a file by its absolute path."""
    return str(Path(name).resolve()) if is_own(name) else name


def env_options(env: str, values: Mapping[str, Any], defaults: Mapping[str, Any] | None = None) -> dict[str, Any]:
    """Return values, over the ``defaults``, as the env's keyword arguments, checked; a text may read as a number.

    An argument that is a mapping may be given entry by entry, ``NAME.ENTRY``; ``NAME`` is its preset then.
    Raises `UsageError` for an invalid argument.
    """
    options = dict(defaults or {})
    for key, given in values.items():
        name, dot, entry = key.partition(".")
        before, value = options.get(name, {}), _value(given)
        entries = {**(before if isinstance(before, Mapping) else {PRESET: before}), entry: value}
        options[name] = entries if dot else value
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


def _value(given: Any) -> Any:
    """Return a value as it is, but of a text that reads as one a number, true or false."""
    try:
        return json.loads(given) if isinstance(given, str) else given
    except ValueError:
        return given


def play_trial(
    trial: EpisodeTrial, *, env: str, options: Mapping[str, Any], steps: int | None, recorded: int
) -> TrialRecord:
    """Play one episode in a worker; the first ``recorded`` of the run with their recordings."""
    kept = trial.index < recorded
    with one_thread():
        behaviour, frozen = load_behaviour(trial.condition.removesuffix(FROZEN)), trial.condition.endswith(FROZEN)
        episode = play(behaviour, env, options, trial.seed, steps, images=kept, frozen=frozen)
    row = {**episode.row(), "trial": trial.index, "repeat": trial.repeat}
    recording = recording_of(lambda: record(episode)) if kept else None
    done = TrialRecord(trial.index, (row,), episode.steps(trial.index), recording)
    return drawn_here(done) if episode.responses else done  # one that senses the state sees no picture


def load_behaviour(source: str) -> Behaviour:
    """Return the registered behaviour ``source``, the ``BEHAVIOUR`` of a .py file, or the policy in an .npz file.

    Raises
    ------
    UsageError
        The name is unknown, or the file declares no `Behaviour` or holds no policy.
    """
    if source.endswith(ENDING):
        return load_policy(Path(source)).behaviour(Path(source).stem)
    if not is_own(source):
        known, groups = shipped(BEHAVIOURS["behaviours"]), shipped(BEHAVIOURS["groups"])
        check_known("behaviour", source, known if source in groups else (*groups, *known))
        return cast(Behaviour, known[source])
    entry = declared(Path(source), "BEHAVIOUR", Behaviour)
    env_id(entry.env)
    return dataclasses.replace(entry, model=named_model(Path(source), entry.model, "BEHAVIOUR.model"))


# What it comes to.


def conclude(plan: Plan[EpisodeTrial], folder: RunFolder) -> None:
    """Score the episodes in ``folder``, judge claims about them, and write verdicts, summary and figure."""
    from experiments.draw import style  # not before: workers do without matplotlib

    played, env, trials = plan.resolved, plan.resolved["env"], folder.table("trials")
    claims = () if played["options"] else claims_on("behaviours").values()  # a claim is about the env as it is
    folder.write_json("claims.json", document(scoring.verdicts(claims, env, plan.declared, trials)))
    summary = scoring.summary(trials, env, played["reference"])
    if not summary.is_empty():
        folder.write_rows("summary.csv", summary.to_dicts())
        style.save(load(folder.folder).figure(), folder.folder / "figure")


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


# Reading it.


def draw(run: Run) -> Figure:
    """Draw the figure of a run of episodes, from its folder alone."""
    from experiments.draw import behaviours  # not before: matplotlib takes its time to load

    return behaviours.draw(run.trials, run.frames, behaviours.caption(run.description))


def show(run: Run) -> None:
    """Print what a run comes to: each behaviour's measures, the verdicts, and where everything is."""
    from experiments.draw import behaviours  # not before: matplotlib takes its time to load

    if run.done:
        behaviours.show(run.summary, behaviours.caption(run.description))
        show_verdicts(run.verdicts)
        show_files(run.folder, count(run.trials.height, "episode"))


def words(run: Run) -> str:
    """Say what a run shows."""
    return f"The measures of each behaviour in {run.description['env']}."


KIND = Kind(plan, concluding(conclude), draw, show, chapter="Behaviours", words=words)
