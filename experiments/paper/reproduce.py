"""Reproduction of the paper: its experiments in replicates, clips and behaviours are run, and every claim is judged.

The claims of the models' own papers are judged here too, on clips of their own.
"""

import dataclasses
import hashlib
import json
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from colias_sim.envs import ENVS
from experiments.base.console import error_console, out_console, show_files, show_places
from experiments.base.errors import UsageError
from experiments.base.files import Files, plain, read_json
from experiments.declare.behaviour import AVOIDANCE, FIXATION, OPTOMOTOR
from experiments.declare.claim import PAPER, Claim, claim_ids, texts
from experiments.declare.clip import OfflineExperiment
from experiments.declare.outcome import Outcome
from experiments.declare.study import Study
from experiments.draw import robot, style, sweep as report
from experiments.draw.terminal import show_verdicts
from experiments.judge import motion
from experiments.judge.judge import PATH_TOLERANCE_MM, SPEED_TOLERANCE, judge as judge_rows
from experiments.judge.replicates import EVERY_MODEL, MODEL, Replicate, judged, places_of, replicate
from experiments.judge.scores import LEAST_SEEDS
from experiments.judge.sweep import Sweep, read
from experiments.judge.verdict import (
    Verdict,
    count,
    document,
    plain as as_json,
    verdict_of,
    verdicts as stored_verdicts,
)
from experiments.kinds import clips as offline, episodes, registry, sweep, sweep_plan, trials as robot_run
from experiments.kinds.result import Kind, Run, load, whole_networks
from experiments.kinds.tables import OFFLINE, kind_of
from experiments.paper import page
from experiments.paper.claims import footage
from experiments.paper.claims.clips import LEAST_GREYS, with_model
from experiments.paper.claims.models import CLIPS, model_claims
from experiments.paper.claims.readings import DELAYS, READINGS, UNITS, WINDOW, bears_on
from experiments.paper.claims.robot import FALLING, ROBOT_SPEEDS
from experiments.paper.clips import PER_FRAME, prefix
from experiments.paper.page import READ_OFF, REPLICATES, SCALES, SENSITIVITY, SENSITIVITY_CLIPS, Scale
from experiments.paper.studies.clips import SENSITIVITY as SENSITIVE_ON_CLIPS
from experiments.paper.studies.onboard import BEST, STUDY as ONBOARD, probe_of
from experiments.paper.studies.robot import DEFAULTS, SENSITIVITY as SENSITIVE
from experiments.show.episodes import short_name
from experiments.store import provenance
from experiments.store.asked import Asked
from experiments.store.folder import THRESHOLDS, begin_whole
from experiments.store.plan import Plan, filled
from experiments.store.workers import Workers

PLAYERS: Mapping[str, tuple[str, ...]] = {
    AVOIDANCE: ("hybrid", "lgmd", "lgmd-hybrid", "straight"),
    OPTOMOTOR: ("optomotor-pi", "optomotor", "still", "oracle-heading"),
    FIXATION: ("fixation-pi", "fixation", "still", "oracle-target"),
}
"""Env -> who plays there."""
MORE_MODELS = ("dsn2017",)
"""The models shown with the DSNN unless others are named."""
SHOWN = ("distance-mechanism", "approach-mechanism", "recession-mechanism")
"""Experiments without claims that the report shows, at the first seed alone."""
Shown = tuple[Plan[Any], Sequence[Mapping[str, Any]]]
"""An off-line experiment and its rows."""
NEEDS: Mapping[str, str] = {
    "clips": "its off-line experiment was not run (--quick and --robot-only leave some out)",
    "footage": "needs footage of your own: colias watch FILE --judge",
    "robot": "none of the experiments here declares this claim",
}
"""What a claim is judged on -> what it would take to judge it, where nothing here does."""


# What is run.


def plan(asked: Asked) -> Plan[Any]:
    """Plan a reproduction.

    Parameters
    ----------
    asked
        What was asked for: ``models`` that see the experiments' frames too, as the claims are judged on the DSNN;
        experiments in ``what``, names or files, that are run and shown too. Its options are ``scale``, a name of
        `SCALES`, and ``robot_only``, which leaves out clips and behaviours.

    Returns
    -------
    Plan
        Its parts by folder: experiments with the robot, the paper's first, then clips, behaviours and sweeps. What is
        declared is the scale.

    Raises
    ------
    UsageError
        It cannot be run so.
    """
    scale = asked.declared or SCALES[asked.option("scale", "usual")]
    return Plan(asked, "reproduction", declared=scale, parts=dict(_parts(asked, scale)))


def _parts(asked: Asked, scale: Scale) -> Iterator[tuple[str, Plan[Any]]]:
    """Yield the folder and the plan of each part."""
    seed, clips_too = asked.seed, not asked.option("robot_only", False)
    labels = [MODEL, *(name for name in (*MORE_MODELS, *asked.models) if name != MODEL)]
    robot = [robot_run.plan(Asked(kind="trials", what=(name,), models=_models(name, labels), only=True,
                                  repeats=scale.repeats, seed=seed))
             for name in (*registry.paper_experiments(), *SHOWN, *asked.what)]  # fmt: skip
    names = [part.name for part in robot]
    ours = (REPLICATES, SENSITIVITY, SENSITIVITY_CLIPS, *OFFLINE, *map(_behaved, PLAYERS))
    for name in names:
        if names.count(name) > 1 or name in ours:
            raise UsageError(f"--experiment {name}: that name is taken in a reproduction; give it another")
    yield from zip(names, robot, strict=True)
    for name in scale.offline if clips_too else ():
        several = registry.find(name).repeats > 1
        clips = Asked(kind="clips", what=(name,), repeats=scale.offline_replicates if several else None, seed=seed)
        yield name, offline.plan(clips)
    for env in PLAYERS if clips_too else ():  # all at the same seeds
        steps = min(scale.steps or ENVS[env].max_episode_steps, ENVS[env].max_episode_steps)
        options = {"env": env, "baselines": False, "steps": steps}
        played = Asked(kind="episodes", what=PLAYERS[env], repeats=scale.episodes, seed=seed, options=options)
        yield _behaved(env), episodes.plan(played)
    if scale.replicates > 1:
        again = replicates_plan(scale.replicates - 1, scale.repeats, seed + 1, onboard=scale.onboard)
        swept = Asked(kind="sweep", declared=again.study, seed=seed + 1)
        yield REPLICATES, sweep.of_checked(again, swept, probe_of(MODEL, BEST) if scale.onboard else None)
    if scale.moves:
        moved = dataclasses.replace(SENSITIVE, repeats=scale.repeats)
        yield SENSITIVITY, sweep.plan(Asked(kind="sweep", declared=moved, seed=seed))
    if scale.moves and clips_too:
        yield SENSITIVITY_CLIPS, sweep.plan(Asked(kind="sweep", declared=SENSITIVE_ON_CLIPS, seed=seed))


def _behaved(env: str) -> str:
    """Return the folder of an env's episodes."""
    return f"behave-{short_name(env).partition('-')[0].lower()}"


def _models(experiment: str, labels: Sequence[str]) -> tuple[str, ...]:
    """Return the models of one experiment: its own, those of all, and the looming detectors where a claim needs them.

    An experiment that compares variants of the DSNN, or is shown for its mechanism, has its own alone.
    """
    declared = registry.load(experiment)
    if len(declared.models) > 1 or experiment in SHOWN:
        return declared.models
    return tuple(dict.fromkeys([*declared.models, *labels, *registry.asked_models(declared)]))


def replicates_plan(
    replicates: int, repeats: int, seed: int, *, onboard: bool = False,
) -> Sweep:  # fmt: skip
    """Plan replicates of the paper's experiments with the robot: a study without a grid.

    Parameters
    ----------
    replicates, repeats, seed
        How many replicates, trials of each condition in one, and the seed of the first.
    onboard
        Whether the network in the robot's own arithmetic watches too.
    """
    models = {
        name: [
            *registry.asked_models(declared),
            *((BEST,) if onboard and len(declared.models) == 1 else ()),  # others compare moves of the network
        ]
        for name in registry.paper_experiments()
        for declared in [registry.load(name)]
    }
    study = Study(
        REPLICATES, "the paper's experiments at several seeds", claims=tuple(registry.answering()),
        experiments=registry.paper_experiments(), models=(MODEL,), repeats=repeats, replicates=replicates,
    )  # fmt: skip
    return sweep_plan.sweep_of(study, seed, models)


def design(whole: Plan[Any]) -> dict[str, Any]:
    """Return what ``design.json`` holds beside scale and seed: versions, and a digest of all that decides the numbers.

    The digest is of every experiment, parameter, seed and number of repeats, and of the claims' words and bounds; not
    of versions and code. Two reproductions with one digest should differ in no number.
    """
    parts_of = whole.parts.values()
    studies = [part.declared for part in parts_of if isinstance(part.declared, Sweep)]
    runs = [part.resolved for part in parts_of if not isinstance(part.declared, Sweep)]
    computes = (*provenance.KEYS, "form", THRESHOLDS, "recordings", "recorded", "reference")
    parts = {
        "runs": [{name: value for name, value in run.items() if name not in computes} for run in runs],
        "studies": [(swept.study.name, swept.specs) for swept in studies],
        "claims": {claim: (texts()[claim]["says"], texts()[claim]["source"]) for claim in claim_ids(PAPER)},
        "least": [{claim.id: claim.least for claim in registry.claims_on("robot").values()},
                  {claim.id: claim.conditions for claim in registry.claims_on("clips").values()},
                  LEAST_GREYS, motion.LEAST_SECONDS, LEAST_SEEDS],
        "bounds": [SPEED_TOLERANCE, PATH_TOLERANCE_MM],
    }  # fmt: skip
    digest = hashlib.sha256(json.dumps(parts, default=plain).encode()).hexdigest()
    return {"digest": digest, "versions": provenance.versions()}


# Running and judging.


def work(whole: Plan[Any], folder: Path, pool: Workers) -> None:
    """Run what is missing in a folder, judge every claim, and write verdicts, figures of studies and the page.

    The verdicts on the paper's claims are in ``claims.json``, ours about behaviours in ``behaviours.json``.
    """
    if not pool.quiet:
        error_console.print(f"{pool.where()}, into {folder}")
    begin_whole(folder, whole.document())
    counts: dict[str, Sweep] = {}
    for name, part in whole.parts.items():
        if isinstance(part.declared, Sweep):
            counts[name] = sweep.played(part, folder / name, pool)
        else:
            kind_of(part.asked.kind).work(part, folder / name, pool)
    conclude(whole, folder, counts)
    page.write(folder)


def conclude(whole: Plan[Any], folder: Path, counts: dict[str, Sweep]) -> None:
    """Judge every claim on the runs in a folder, and write the verdicts and the figures of studies there."""
    scale, plans = whole.declared, whole.parts
    runs = {name: load(folder / name) for name in plans if name not in counts}
    shows = [(plans[name], whole_networks(run)) for name, run in runs.items() if name in OFFLINE]
    specs = [spec for name in registry.paper_experiments() for spec in plans[name].trials]
    every = [replicate(specs, [row for name in registry.paper_experiments() for row in whole_networks(runs[name])])]
    if REPLICATES in counts:
        every += counts.pop(REPLICATES).replicates[(), EVERY_MODEL]
    studies = [*_read_off(shows), *counts.values()]
    if scale.onboard and SENSITIVITY in counts:
        studies.append(onboard(every, counts[SENSITIVITY]))
    own = [verdict for env in PLAYERS if _behaved(env) in runs for verdict in runs[_behaved(env)].verdicts]
    files = Files(folder)
    files.write_json("design.json", {
        "seed": whole.asked.seed, "scale": dataclasses.asdict(scale), **design(whole),
        "parts": list(dict.fromkeys([*plans, *(counted.study.name for counted in studies)])),
    })  # fmt: skip
    files.write_json("claims.json", document(verdicts(every, shows)))
    files.write_json("behaviours.json", document(own))
    files.write_json("pooled.json", {claim: as_json(outcome) for claim, outcome in pooled(every).items()})
    files.write_json("readings.json", list(other_readings(every, shows, list(counts.values()))))
    for counted in studies:
        described = counted.described()
        files.write_json(f"{counted.study.name}.json", described)
        style.save(report.draw(described), folder / counted.study.name)


# Reading it.


def draw(run: Run) -> Figure:
    """Draw the panels of the robot's experiments, from the folder alone."""
    return robot.panels(
        {part.name: whole_networks(part) for part in run.parts if part.done and part.name in robot.PAPER}
    )


def show(run: Run) -> None:
    """Print how many claims hold, the verdicts on the paper's and on ours, and where the page is."""
    own = read_json(run.folder / "behaviours.json")
    ours, found = stored_verdicts(own), page.totals((one.id, one.count) for one in run.verdicts)
    besides = f"besides, {len(ours)} claims of our own: {', '.join(one.id for one in ours)}"
    out_console.print("; ".join([*(text.partition(":")[0] for text in found), besides]))
    show_verdicts([*run.verdicts, *ours])
    show_files(run.folder, "reproduction")
    show_places({"page": run.folder / "report.html"})


def _read_off(shows: Sequence[Shown]) -> Iterator[Sweep]:
    """Yield the counts of the studies whose points are clips of off-line experiments."""
    for part, shown in shows:
        if part.name in READ_OFF:
            repeats = len({trial.repeat for trial in part.trials})
            study = dataclasses.replace(registry.shipped_study(part.name), replicates=repeats)
            yield read(sweep_plan.sweep_of(study, part.asked.seed), shown)
            yield read(sweep.plan(Asked(kind="sweep", declared=study, seed=part.asked.seed)).declared, shown)


def onboard(every: Sequence[Replicate], moved: Sweep) -> Sweep:
    """Count the claims in the robot's own arithmetic, on the reproduction's own replicates.

    It watched replicate 0 with the moves of the network, whose seed is the same.
    """
    labels = (MODEL, BEST)
    study = dataclasses.replace(ONBOARD, models=labels, repeats=moved.study.repeats, replicates=len(every))
    defaults = (("moved", DEFAULTS),)
    given: dict[Any, Sequence[Replicate]] = {
        ((), model): [moved.replicates[defaults, model][0], *every[1:]] for model in labels
    }
    again: Sweep = sweep.plan(Asked(kind="sweep", declared=study, seed=moved.seed)).declared
    return dataclasses.replace(again, replicates=given)


def verdicts(every: Sequence[Replicate], shows: Sequence[Shown]) -> list[Verdict]:
    """Judge every claim of the paper, in its order; one that nothing here judges says what it would take.

    Parameters
    ----------
    every
        The experiments with the robot, in each replicate, replicate 0 first.
    shows
        The off-line experiments. A claim that a silent network would satisfy is held against the clips of all.
    """
    every_clip = [row for _, shown in shows for row in shown]
    by_clips = {verdict.id: verdict for part, shown in shows for verdict in offline.verdicts(part, shown, every_clip)}
    return [_verdict(claim, every, by_clips.get(claim)) for claim in claim_ids(PAPER)]


def _verdict(claim: str, every: Sequence[Replicate], clips: Verdict | None) -> Verdict:
    place = registry.answering().get(claim, "")
    if clips is not None and place:  # the clips at their first seed are a part of each replicate with the robot
        parts = [{"clips": clips.outcome, "the robot": judge(claim, part)} for part in every]
        experiment = f"{clips.experiment}, {place}"
        return verdict_of(
            registry.find_claim(claim, "robot"), list(map(Outcome.together, parts)), experiment=experiment
        )
    if clips is not None:
        return clips
    if not _about_the_robot(claim):
        on = next(on for on in NEEDS if claim in registry.claims_on(on))
        return verdict_of(registry.find_claim(claim, on), [Outcome.unjudged(NEEDS[on])])
    asked = registry.find_claim(claim, "robot")
    places = places_of(asked, place, {row["experiment"] for part in every for row in part.rows})
    return verdict_of(asked, [judge(claim, part) for part in every], experiment=", ".join(places))


def _about_the_robot(claim: str) -> bool:
    """Return whether trials with the robot alone answer for a claim."""
    return claim in registry.answering() and claim not in registry.claims_on("clips") and claim != footage.CLAIM


def judge(claim: str, trials: Replicate) -> Outcome:
    """Judge a claim in one replicate: for the DSNN, for the models it compares, or for each looming detector."""
    return judged(registry.find_claim(claim, "robot"), trials, registry.answering()[claim])


def pooled(every: Sequence[Replicate]) -> dict[str, Outcome]:
    """Judge each claim about the robot on the trials of all replicates together."""
    rows = tuple(row for part in every for row in part.rows)
    lost = sum((Counter(part.lost) for part in every), Counter[tuple[str, str]]())
    together = Replicate(rows, lost, every[0].thresholds)
    return {claim: judge(claim, together) for claim in claim_ids(PAPER) if _about_the_robot(claim)}


def other_readings(
    every: Sequence[Replicate], shows: Sequence[Shown], moved: Sequence[Sweep]
) -> Iterator[dict[str, str]]:
    """Yield what claims came to under other readings of the paper than those taken, as far as any was run.

    Parameters
    ----------
    every, shows
        The experiments with the robot in each replicate, and the off-line ones.
    moved
        The studies of sensitivity, whose levels have the names of the other readings.

    Yields
    ------
    dict of str to str
        ``reading``, ``claim``, the other reading in ``under``, and what it ``came_to``.
    """
    levels = {
        (point[0][1], claim): outcomes
        for counts in moved
        for (point, model, claim), outcomes in counts.outcomes.items()
        if model == MODEL
    }
    for reading, others in READINGS.items():
        for claim in bears_on(reading):
            for other in others:
                outcomes: Sequence[Outcome] = levels.get((other, claim), ())
                if reading == DELAYS:
                    outcomes = [_with_falling_delays(claim, part) for part in every]
                elif reading == UNITS:
                    outcomes = _by_frame(claim, shows)
                elif reading == WINDOW:
                    outcomes = [judge("C29", part) for part in every]  # C29 says the same of one time window
                if outcomes:
                    held = count(outcome.verdict for outcome in outcomes).sentence()
                    came_to = f"{held}; decided by: {outcomes[0].deciding}"
                    yield {"reading": reading, "claim": claim, "under": other, "came_to": came_to}


def _with_falling_delays(claim: str, trials: Replicate) -> Outcome:
    """Judge a claim on the variant of ensembles whose delays fall with spacing, at the paper's speeds."""
    rows = [row for row in trials.of(FALLING) if row["experiment"] == "ensembles"]
    rows = [row for row in rows if row["speed_cm_s"] in ROBOT_SPEEDS]
    outcome = judge_rows(registry.find_claim(claim, "robot"), rows, trials.threshold(FALLING))
    lost = trials.lost.get(("ensembles", FALLING), 0)
    return outcome.withheld(f"{lost} trial{'s' * (lost != 1)} failed") if lost else outcome


def _by_frame(claim: str, shows: Sequence[Shown]) -> list[Outcome]:
    """Judge a claim at every seed, on those clips of clutter-frames that are its own in pixels a frame."""
    begins = next(prefix(experiment) for experiment in PER_FRAME if claim in experiment.claims)
    outcomes = []
    for part, shown in (show for show in shows if show[0].name == "clutter-frames"):
        own = [row for row in shown if row["clip"].startswith(begins)]
        for repeat in sorted({row["repeat"] for row in own}):
            of_seed = [row for row in own if row["repeat"] == repeat]
            about = registry.find_claim(claim, "clips")
            outcomes.append(judge_rows(about, of_seed, part.thresholds[about.spiking], shown))
    return outcomes


# The claims of the models' own papers.

SEEDS = 5
"""Seeds of those clips of the models' claims in which anything is random."""


def claims_of(models: Sequence[str]) -> list[tuple[Claim, str]]:
    """Return the claims of models, with settings or without, each with the model's name; ``all``: those that have some.

    A claim names the variants of the model that it is about. Raises `UsageError` for a model whose paper has no claim.
    """
    names = dict.fromkeys(name for model in models for name in (model_claims() if model == "all" else (model,)))
    found = []
    for name in names:
        base, _, settings = name.partition(":")
        if base not in model_claims():
            known = ", ".join(model_claims())
            raise UsageError(f"--model {name}: no claims of its own paper are written down; they are of {known}, all")
        for claim in model_claims()[base]:
            for label in sorted(claim.models) if settings else ():
                claim = with_model(claim, label, f"{label}{',' if ':' in label else ':'}{settings}")
            found.append((claim, name))
    return found


def judge_models(
    folder: Path, models: Sequence[str], seed: int, pool: Workers
) -> tuple[list[Verdict], list[dict[str, Any]]]:
    """Show models the clips that the claims of their own papers are about, judge, and write ``model_claims.json``.

    Parameters
    ----------
    folder
        A new one, or one that holds a part of this run.
    models
        As of `claims_of`.
    seed
        Seed of the first replicate.
    pool
        Workers, or a cluster.

    Returns
    -------
    list of Verdict, list of mapping
        A verdict for each claim and model, and the clips that failed.
    """
    wanted = claims_of(models)
    labels = tuple(dict.fromkeys(label for claim, _ in wanted for label in sorted(claim.models)))
    names = dict.fromkeys(name for claim, _ in wanted for name in claim.conditions.get("clip", ()))
    differ = {name for name in names if CLIPS[name].is_random}
    rows: list[dict[str, Any]] = []
    failures: list[dict[str, Any]] = []
    thresholds: dict[str, float | None] = {}
    with pool.running():
        for name, repeats in (("even", 1), ("gratings", SEEDS)):
            clips = tuple(CLIPS[clip] for clip in names if (clip in differ) == (repeats > 1))
            if clips:
                shown = OfflineExperiment(name, "clips of claims", clips, labels, repeats=repeats, recorded=False)
                options = {"frames": False, "recordings": False}
                part = offline.plan(Asked(kind="clips", declared=shown, seed=seed, options=options))
                thresholds |= part.thresholds
                with filled(part, folder / name, pool) as run:
                    failures += run.failures()
                    rows += run.table("trials").to_dicts()
    found = []
    for claim, model in wanted:
        random = not differ.isdisjoint(claim.conditions.get("clip", ()))
        outcomes: list[Any] = []
        for repeat in range(SEEDS if random else 1):  # once, where nothing in it is random
            of_seed = [row for row in rows if row["experiment"] == "even" or row["repeat"] == repeat]
            if claim.conditions:
                outcomes.append(judge_rows(claim, of_seed, thresholds.get(claim.spiking)))
            else:  # no clip tests it, and its judge says why
                outcomes.append(claim.judge([], 0.0))
        found.append(verdict_of(claim, outcomes, random=random, model=model, experiment="clips"))
    Files(folder).write_json("model_claims.json", document(found))
    return found, failures


KIND = Kind(plan, work, draw, show, whole=True)
