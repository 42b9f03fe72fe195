"""Trials with the robot: plan an experiment's trials, and conclude, draw and show a run of them."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from functools import partial
from itertools import combinations
from typing import TYPE_CHECKING, Any

import polars as pl
from pydantic import ValidationError

from experiments.base import console
from experiments.base.console import count, out_console, show_files
from experiments.base.errors import UsageError, check_known
from experiments.declare.conditions import CONDITION_COLUMNS, SCRIPTED
from experiments.declare.experiment import Experiment
from experiments.draw.terminal import show_controls, show_silent, show_verdicts
from experiments.judge.judge import flaws, judge
from experiments.judge.tests import LEVEL, least_of_pairs, p_text, summary_rows
from experiments.judge.verdict import Verdict, document, verdict_of
from experiments.kinds import registry
from experiments.kinds.compare import corrected, tested
from experiments.kinds.controls import conclude_controls
from experiments.kinds.result import COMPARISONS, Kind, Run, concluding, load, whole_networks
from experiments.settings.models import EYE, shown_models
from experiments.settings.parameters import Parameters
from experiments.settings.pictures import Pictures, digests, folder_pictures
from experiments.settings.settings import Settings, changes, check_counts, configure
from experiments.show import course
from experiments.show.controls import controls
from experiments.show.play import play
from experiments.show.robot import TRUE, RobotTrial, camera, is_random, trials_of
from experiments.show.trial_rows import FRAME_SCHEMA, TRIAL_SCHEMA, TRUE_FRAMES, TRUE_TRIALS, drawable, varying
from experiments.store import provenance
from experiments.store.asked import Asked
from experiments.store.folder import THRESHOLDS, RunFolder
from experiments.store.plan import Plan
from experiments.store.tables import RESPONSES, TrialRecord, drawn_here, without_controls
from scenes import arena_name

if TYPE_CHECKING:
    from matplotlib.figure import Figure

QUANTITIES = (
    "spikes", "firing_rate_hz", "peak_hs", "trough_hs", "peak_vs", "achieved_speed_cm_s", "path_error_mm", "drift_mm",
    "seconds_in_view", "spikes_in_view", "rate_in_view_hz", "mean_hs_in_view", "mean_hs_near_axis", "spikes_in_window",
    "spikes_in_inner_window",
)  # fmt: skip
NEGATIVE = ("peak_hs", "trough_hs", "peak_vs", "drift_mm", "mean_hs_in_view", "mean_hs_near_axis")
"""Those of them that can be negative: of the others no interval goes below 0."""
SHOWN = {"spikes": ("mean", "ci_low", "ci_high"), "firing_rate_hz": ("mean",), "peak_hs": ("mean",),
         "trough_hs": ("mean",), "peak_looming": ("mean",)}  # fmt: skip
"""Quantities that the table of a run has, as far as its models have them -> their columns of the summary; a mean has
the name of its quantity."""


# What is run.


def plan(asked: Asked) -> Plan[RobotTrial]:
    """Return the plan of an experiment's trials.

    Parameters
    ----------
    asked
        What was asked for. Its options are ``eyes``, ``one`` or ``both``: each model sees through the model of the
        robot's eye too; ``pictures``, the folder of a user's own, of which the arena's wall has the first;
        ``recordings`` and ``frames``, whether to keep these; ``truth``, whether frames have what truly moved;
        ``controls``, whether models see each trial again as controls.

    Returns
    -------
    Plan
        The trials, with the experiment under its settings as what is declared.

    Raises
    ------
    UsageError
        It cannot be run so.
    """
    experiment: Experiment = registry.declaration(asked)
    folder, eyes = asked.option("pictures"), asked.option("eyes", "one")
    check_known("--eyes", eyes, ("one", "both"))
    pictures = folder_pictures(folder) if folder else None
    models = shown_models(experiment.models, asked.models, asked.only)
    whole, settings, repeats = checked(experiment, models, asked, pictures)
    settings = both_eyes(settings) if eyes == "both" else settings
    truth, recordings = bool(asked.option("truth")), bool(asked.option("recordings", True))
    again = controls if asked.option("controls") else None
    trials = trials_of(whole, settings, repeats, asked.seed, truth=truth, controls=again)
    tables = (TRUE_TRIALS, TRUE_FRAMES) if truth else (TRIAL_SCHEMA, FRAME_SCHEMA)
    resolved, changed = resolve(asked, experiment, whole, settings, repeats, len(trials), pictures)
    done = partial(play_trial, recordings=recordings, frames=bool(asked.option("frames", True)))
    return Plan(
        asked, whole.name, trials, done, {**resolved, "recordings": recordings}, tables, whole, settings.models,
        changed, random=is_random(settings),
    )  # fmt: skip


def checked(
    experiment: Experiment, models: Sequence[str], asked: Asked, pictures: Pictures | None = None
) -> tuple[Experiment, Settings, int]:
    """Check what was asked of an experiment, and apply it.

    Returns
    -------
    experiment, settings, repeats
        The experiment with the design that was asked for, the settings of its trials, and trials of each condition.

    Raises
    ------
    UsageError
        It cannot be run so.
    """
    repeats = experiment.repeats if asked.repeats is None else asked.repeats
    whole, settings = configure(experiment, models, asked.values)
    if pictures and settings.scene.wall:
        raise UsageError(f"--set scene.wall={settings.scene.wall}: --pictures sets the wall; give one of them")
    if pictures:  # a run is replicate 0
        settings = dataclasses.replace(settings, scene=dataclasses.replace(settings.scene, wall=pictures[0]))
    check_counts(asked.seed, repeats, f"{experiment.name}: repeats" if asked.repeats is None else "--repeats")
    course.check(whole.conditions(), settings)
    return whole, settings, repeats


def both_eyes(settings: Settings) -> Settings:
    """Return settings with each of the models seeing through the model of the robot's eye too.

    Raises
    ------
    UsageError
        The camera is that eye already, or has a size or a clock that the eye cannot have.
    """
    try:
        eye = camera(settings, TRUE)
    except ValidationError as error:
        reason = error.errors()[0]["msg"]
        raise UsageError(f"--eyes both: preset {TRUE} cannot have the set size or rate: {reason}") from None
    if eye == settings.camera:
        raise UsageError(f"--eyes both: the camera is that of preset {TRUE} already; leave out --set camera.*")
    more = tuple(dataclasses.replace(model, label=f"{model.label}{EYE}{TRUE}") for model in settings.models)
    return dataclasses.replace(settings, models=(*settings.models, *more))


def play_trial(trial: RobotTrial, *, recordings: bool = False, frames: bool = False) -> TrialRecord:
    """Play one trial in a worker, with a row per frame and its recording as far as they are wanted."""
    if not recordings:
        return drawn_here(play(trial, frames=frames))
    from experiments.show.recording import record  # not before: Rerun takes its time to load

    return drawn_here(play(trial, record, frames=frames, maps=True))


def resolve(
    asked: Asked, declared: Experiment, experiment: Experiment, settings: Settings, repeats: int, number: int,
    pictures: Pictures | None = None,
) -> tuple[dict[str, Any], Parameters]:  # fmt: skip
    """Return what ``run.json`` has of checked trials, and the parameters that are not at their defaults.

    Parameters
    ----------
    asked
        What was asked for.
    declared, experiment
        The experiment before and after ``--set`` changed its design.
    settings, repeats, number
        Settings of the trials, trials of each condition, and of all.
    pictures
        A user's own, of which the arena's wall has the first.
    """
    scene = dataclasses.replace(settings.scene, wall="") if pictures else settings.scene  # they are noted apart
    changed = changes(experiment, settings, declared.design, pictures)
    paths = {  # of conditions of one's own: rows have no column for them
        condition.label(): {name: getattr(condition, name) for name in SCRIPTED if name != "hand" or condition.hand}
        for condition in experiment.conditions()
        if condition.path is not None or condition.hand is not None
    }
    return {
        "experiment": experiment,
        "repeats": repeats,
        "seed": asked.seed,
        "trials": number,
        "settings": settings,
        **({"paths": paths} if paths else {}),
        **({"pictures": digests(pictures)} if pictures else {}),
        **({"changed": changed} if changed else {}),
        THRESHOLDS: {model.label: model.thresholds for model in settings.models},
        "recordings": False,
        **provenance.of([*(model.source for model in settings.models), *course.files(scene)], experiment),
    }, changed


# What it comes to.


def conclude(plan: Plan[Any], folder: RunFolder) -> None:
    """Judge the claims of the trials in ``folder``, and write verdicts, summary, tests between models and figure."""
    experiment, models = plan.declared, plan.models
    rows = without_controls(folder.table("trials")).to_dicts()
    folder.write_json("claims.json", document(_verdicts(plan, rows, folder.failures())))
    run = load(folder.folder)
    if not rows:
        return
    from experiments.draw import style  # not before: workers do without matplotlib

    conclude_controls(plan, folder, lambda: ways(rows))
    whole = whole_networks(run)
    folder.write_rows("summary.csv", summary_rows(whole, ("model", *CONDITION_COLUMNS), QUANTITIES, NEGATIVE))
    if compared := compare(whole, models[0].label if len(experiment.models) > 1 else ""):
        folder.write_rows("comparisons.csv", compared)
    if run.excitations.height:
        folder.write_rows("excitation.csv", run.excitations.to_dicts())
    style.save(run.figure(), folder.folder / "figure")


def ways(rows: Sequence[Any]) -> dict[int, str]:
    """Return what a stimulus did in each trial, in the words of clips: a direction, ``looming`` or ``receding``."""
    depth = {"approach": "looming", "recession": "receding"}
    return {row["trial"]: depth.get(row["motion"], row["direction"]) for row in rows}


def _verdicts(plan: Plan[Any], rows: Sequence[Any], failures: Sequence[Any]) -> list[Verdict]:
    """Judge each claim, for each model that it is about, or once for the models that it compares."""
    experiment, models, random = plan.declared, plan.models, plan.random
    claims = [registry.find_claim(claim, "robot") for claim in experiment.claims]
    asked = [
        (claim, model.label)
        for model in models
        for claim in claims
        if not claim.models and (claim.about == "looming") != ("hs" in model.channels)
    ]
    asked += [(claim, "") for claim in claims if claim.models]
    verdicts = []
    for claim, label in asked:
        about = [row for row in rows if label in ("", row["model"])]
        lost = sum(failure["model"] in ("", label, *claim.models) for failure in failures)
        failed = f"{lost} trial{'s' * (lost != 1)} of the run failed" if lost else ""
        outcome = judge(claim, about, plan.thresholds.get(label or claim.spiking)).noting(failed)
        verdicts.append(verdict_of(claim, [outcome], random=random, model=label, experiment=experiment.name))
    return verdicts


def compare(rows: Sequence[Any], reference: str = "") -> list[dict[str, Any]]:
    """Models on the same trials, per condition: a paired test of their spikes, p by Holm over all rows.

    A model that does not spike has nothing to be tested.

    Parameters
    ----------
    rows
        Of ``trials.parquet``.
    reference
        The model that all others are compared with; empty: every two models are.
    """
    table = pl.DataFrame(rows, infer_schema_length=None)
    found = [
        row
        for _, chosen in table.group_by(CONDITION_COLUMNS, maintain_order=True)
        for pair in combinations(table["model"].unique(maintain_order=True), 2)
        if reference in ("", pair[0])
        for row in tested(chosen, chosen, pair, CONDITION_COLUMNS, "trial")  # one may have failed in some
    ]
    return corrected(found, COMPARISONS).to_dicts()


# Reading it.


def draw(run: Run) -> Figure:
    """Draw the figure of a run of trials, from its folder alone."""
    from experiments.draw import robot  # not before: matplotlib takes its time to load

    described, rows, frames = run.description, without_controls(run.trials).to_dicts(), without_controls(run.frames)
    declared, settings = described["experiment"], described["settings"]
    title = robot.title(declared["name"], arena_name(settings["scene"]["arena"]), rows, described.get("changed") or {},
                        open_loop=settings["robot"]["open_loop"])  # fmt: skip
    return robot.draw(drawable(declared["figure"], rows), rows, frames, declared["varies"],
                      run.thresholds, title, run.excitations)  # fmt: skip


def show(run: Run) -> None:
    """Print what a run comes to: its table, the verdicts, tests between models, and where everything is."""
    rows = whole_networks(run)
    models = {row["model"] for row in rows}
    varies = varying(rows, run.description["experiment"]["varies"])
    if rows:
        console.show(_table(run, models, varies))
    out_console.print()
    named = len(models | {verdict.model for verdict in run.verdicts if verdict.model}) > 1
    show_verdicts(run.verdicts, model=named, provenance=run.provenance if run.measured else "")
    for model in sorted(models):
        if (own := model.removesuffix("@frames")) in models - {model}:
            robot, shown = (run.frames.filter(model=name) for name in (own, model))
            logged = [name for name in RESPONSES if not robot[name].has_nulls()]
            equal = robot.join(shown, on=["trial", "frame", *logged]).height
            out_console.print(f"{own}, {model}: {equal} of {robot.height} frames have equal responses")
    show_silent(rows)
    if rows and run.comparisons.height:
        names = [name for name in varies if name != "model"]
        columns = [*names, "model", "against", "n", "mean_difference", "rank_biserial", "p_holm"]
        title = f"\nmodels in the same trials ({run.comparisons['test'][0]}; p after Holm)"
        few = {n: least for n in run.comparisons["n"].unique().sort() if (least := least_of_pairs(n)) > LEVEL}
        words = ["n < 6" if n in few else p_text(p, 0.0) for p, n in run.comparisons.select("p_holm", "n").rows()]
        difference = pl.col("mean_difference").round(3) + 0.0  # a difference below a thousandth is 0, and 0 has no sign
        console.show(run.comparisons.select(columns).with_columns(difference, p_holm=pl.Series(words)), title)
        if few:
            told = (f"with {count(n, 'pair')} no p is below {least:.2g}" for n, least in few.items())
            out_console.print("n < 6:", ", ".join(told))
    elif rows and len(models) > 1:
        out_console.print("\nmodels are not compared: fewer than two of them spiked or were silent in the same trial")
    show_controls(run.controls)
    if rows and (beware := flaws(without_controls(run.trials).to_dicts())):
        out_console.print(f"\nbeware: {beware}", style="red")
    show_files(run.folder, count(len({row["trial"] for row in rows}), "trial"))


def _table(run: Run, models: set[str], varies: Sequence[str]) -> pl.DataFrame:
    """Return the table that is printed: a row per condition and model, with means of what its models have."""
    keys, shown = ["model", *CONDITION_COLUMNS], run.summary.filter(pl.col("model").is_in([*models]))
    known = [name for name in SHOWN if name in shown["quantity"]]
    values = [pl.col(column).filter(quantity=name).first().alias(name if column == "mean" else column)
              for name in known for column in SHOWN[name]]  # fmt: skip
    table = shown.group_by(keys, maintain_order=True).agg(pl.col("n").max(), *values)
    table = pl.concat(table.partition_by("model", maintain_order=True))
    return table.select(*varies, "n", *table.columns[len(keys) + 1 :])


def words(run: Run) -> str:
    """Say what a run shows, and what its robots did not do as planned."""
    problems = flaws(without_controls(run.trials).to_dicts()) if run.done else ""
    return f"{run.description['experiment']['summary']}.{f' Beware: {problems}.' if problems else ''}"


KIND = Kind(plan, concluding(conclude), draw, show, chapter="Robot trials", words=words)
