"""Reproduction of the paper's claims: its experiments, the studies of replicates and sensitivity, the verdicts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import ExitStack, closing
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from experiments.bench import offline
from experiments.bench.closed_loop import claims as closed_loop_claims
from experiments.bench.closed_loop import figure as closed_loop_figure
from experiments.bench.closed_loop import run as closed_loop_run
from experiments.bench.closed_loop.run import BehaviourPlan, Played
from experiments.bench.engine.pictures import Pictures
from experiments.bench.engine.terminal import error_console
from experiments.bench.offline import OfflineReport
from experiments.bench.reproduction import claims, readings
from experiments.bench.reproduction.plan import (
    BESIDE,
    REPLICATES,
    SENSITIVITY,
    SENSITIVITY_CLIPS,
    Planned,
    Scale,
    design,
    planned,
)
from experiments.bench.robot import run as robot_run
from experiments.bench.robot.summary import Report, conclude
from experiments.bench.run.errors import UsageError
from experiments.bench.run.folder import RunFolder
from experiments.bench.run.models import shown_models
from experiments.bench.run.runs import Resources
from experiments.bench.run.workers import Workers
from experiments.bench.stats import stored
from experiments.bench.stats.verdict import Outcome, Verdict
from experiments.bench.store.files import Files
from experiments.bench.store.kinds import REPRODUCTION
from experiments.bench.store.record import begin_whole
from experiments.bench.store.rows import Failure
from experiments.bench.studies import registry as study_registry
from experiments.bench.studies import run as study_run
from experiments.bench.studies.clips import points_of_run
from experiments.bench.studies.counts import Counts
from experiments.bench.studies.grid import Point
from experiments.bench.studies.plan import EVERY_MODEL, StudyPlan
from experiments.bench.studies.replicates import MODEL, Replicate, replicate
from experiments.bench.trials import Plan, describe
from experiments.studies.onboard import BEST, FORMATS
from experiments.studies.onboard import STUDY as ONBOARD
from experiments.studies.sensitivity import DEFAULTS

READ_OFF = ("background", "constants-2017", "constants-emd")
"""The studies whose points are read off the clips of an off-line experiment of the same name."""


@dataclass(frozen=True, slots=True)
class Reproduction:
    """Everything that the report shows."""

    folder: Path
    scale: Scale
    seed: int
    claims: list[Verdict]
    """Of the paper."""
    pooled: Mapping[str, Outcome]
    """Claim about the robot -> its outcome on the trials of all replicates together."""
    runs: list[tuple[Plan, Report]]
    offline: list[OfflineReport]
    sensitivity: Counts | None
    """The study of sensitivity; ``None`` where nothing was moved."""
    behaviours: list[Played]
    """Episodes in each env."""
    own_claims: list[Verdict]
    """Our own claims, about behaviours."""
    failures: Mapping[str, Sequence[Failure]]
    """Failures of the studies."""
    description: Mapping[str, Any]
    readings: list[readings.Chapter]
    """The readings of the paper that were taken, and the outcomes of claims under the others."""
    onboard: Counts | None = None
    """The claims in the robot's own arithmetic, where it was shown."""
    read_off: Mapping[str, Counts] = field(default_factory=dict)
    """The studies whose points are clips of off-line experiments that were run."""

    @property
    def failed(self) -> bool:
        """Return whether any of its trials, clips and episodes failed, for all models or for one."""
        lists = [
            *(report.failures for _, report in self.runs),
            *(report.failures for report in self.offline),
            *(played.failures for played in self.behaviours),
            *self.failures.values(),
        ]
        return any(lists)


def models_shown(given: Sequence[str] | None, only: bool) -> list[str]:
    """Return the models that ``--model`` and ``--only`` ask for.

    Raises `UsageError` without the one that the claims are about.
    """
    names = shown_models((MODEL, *BESIDE), given, only)
    if MODEL not in names:
        raise UsageError(f"--only: the claims are about {MODEL}: give --model {MODEL} too")
    return names


def reproduce(
    folder: Path, scale: Scale, seed: int, models: Sequence[str], resources: Resources, extra: Sequence[str] = (),
    robot_only: bool = False, only: bool = False, pictures: Pictures | None = None,
) -> Reproduction:  # fmt: skip
    """Run what is missing of it all into ``folder``, then judge. Goes on where an earlier call stopped.

    Parameters
    ----------
    folder
        A new one, or one that holds a part of this reproduction.
    scale, seed
        How much to run, and the first seed.
    models
        See the experiments' frames beside the DSNN, on which the claims are judged.
    resources
        Workers, or a cluster.
    extra
        Experiments, names or files, that are run and shown too.
    robot_only
        Whether to leave out clips and behaviours.
    only
        Whether to leave out the looming detectors; the claim about them is then not judged.
    pictures
        One for each replicate, behind the objects of clips and on the arena's wall; not in the envs of behaviours.
    """
    whole = planned(scale, seed, models, extra, robot_only, only, pictures)
    if not resources.quiet:
        _announce(whole, folder, resources)
    with ExitStack() as locks:
        with resources.pool() as pool:
            begin_whole(folder, REPRODUCTION)
            done = [_run(run_plan, folder, pool, resources, locks) for run_plan in whole.plans]
            shows = [
                offline.run(
                    run_plan,
                    folder / run_plan.experiment.name,
                    pool,
                    resources,
                    recordings=run_plan.experiment.recorded,
                )
                for run_plan in whole.offline
            ]
            played = [_play(run_plan, folder, pool, resources) for run_plan in whole.loops]
            again, lost = _study(whole.others, REPLICATES, "other replicates", folder, pool, resources)
            moved, move_failures = _study(whole.moves, SENSITIVITY, SENSITIVITY, folder, pool, resources)
            clips_moved, clip_failures = _study(
                whole.clip_moves, SENSITIVITY_CLIPS, SENSITIVITY_CLIPS, folder, pool, resources
            )
        runs = [
            (run_plan, conclude(run_plan, run, run.failures())) for run_plan, run in zip(whole.plans, done, strict=True)
        ]
    first = replicate(
        [spec for run_plan in whole.paper() for spec in run_plan.specs()],
        [row for _, report in runs for row in report.rows],
    )
    every = [first, *(again.replicates(Point(), EVERY_MODEL) if again else ())]
    behaviours = closed_loop_claims.judge(closed_loop_claims.episodes(played)) if played else []
    read_off = {
        name: Counts(points_of_run(study_registry.find(name), report.plan), report.rows)
        for report in shows
        for name in [report.plan.experiment.name]
        if name in READ_OFF
    }
    verdicts = claims.verdicts(every, shows)
    chapters = readings.chapters(
        readings.Evidence({claim.id: claim for claim in verdicts}, every, shows, _moves(moved, clips_moved), scale.name)
    )
    onboard = _onboard(whole, every, moved) if scale.onboard and moved else None
    result = Reproduction(
        folder, scale, seed, verdicts, claims.pooled(every), runs, shows, moved, played, behaviours,
        {REPLICATES: lost, SENSITIVITY: move_failures, SENSITIVITY_CLIPS: clip_failures},
        describe(whole.plans[0]), chapters, onboard, read_off,
    )  # fmt: skip
    files = Files(folder)
    files.write_json("design.json", design(whole))
    files.write_json("claims.json", stored.document(result.claims))
    files.write_json("pooled.json", {claim: stored.plain(outcome) for claim, outcome in result.pooled.items()})
    files.write_json("readings.json", result.readings)
    for counts in (*read_off.values(), *filter(None, (moved, clips_moved, onboard))):
        files.write_json(f"{counts.plan.study.name}.json", counts.described())
    if behaviours:
        files.write_json("behaviours.json", stored.document(behaviours))
    return result


def _announce(whole: Planned, folder: Path, resources: Resources) -> None:
    clips = sum(len(run_plan.trials) for run_plan in whole.offline) + (
        len(whole.clip_moves.specs) if whole.clip_moves else 0
    )
    episodes = sum(len(run_plan.specs()) for run_plan in whole.loops)
    beside = f"; {clips} clips, {episodes} episodes" if clips or episodes else ""
    amount = f"{whole.amount()}{beside}, {resources.where()}, into {folder}"
    error_console.print(amount, soft_wrap=True, markup=False)


def _run(plan: Plan, folder: Path, pool: Workers, resources: Resources, locks: ExitStack) -> RunFolder:
    """Run an experiment's trials. Its folder stays locked until all is judged."""
    batch = robot_run.batch(plan, robot_run.Keep())
    run = batch.open(folder / plan.experiment.name, resources)
    locks.callback(run.close)
    batch.fill(run, pool, resources)
    return run


def _play(run_plan: BehaviourPlan, folder: Path, pool: Workers, resources: Resources) -> Played:
    """The episodes in one env, without recordings, and their figure."""
    short = run_plan.settings[0].env.partition("/")[2].partition("-")[0].lower()
    done = closed_loop_run.run(run_plan, folder / f"behave-{short}", pool, resources)
    closed_loop_figure.write(done)
    return done


def _moves(*studies: Counts | None) -> dict[str, dict[str, Outcome]]:
    """Return what was moved of the network in float, or of the apparatus -> claim -> its outcome."""
    moved: dict[str, dict[str, Outcome]] = {}
    for counts in filter(None, studies):
        for cell in counts.cells:
            if cell.model == MODEL:
                moved.setdefault(cell.point.values[0][1], {})[cell.claim] = cell.outcomes[0]
    return moved


def _onboard(whole: Planned, every: Sequence[Replicate], moved: Counts) -> Counts:
    """The claims in the robot's own arithmetic, on the reproduction's own replicates.

    It watched replicate 0 beside the moves of the network, whose seed is the same.
    """
    defaults = Point((("moved", DEFAULTS),))
    study = replace(
        ONBOARD, models=tuple(form.label for form in FORMATS[:2]), repeats=whole.scale.repeats,
        replicates=len(every),
    )  # fmt: skip
    given = {(Point(), model): [moved.replicate(defaults, model, 0), *every[1:]] for model in (MODEL, BEST.label)}
    return Counts(study_run.planned(study, whole.seed), given=given)


def _study(
    plan: StudyPlan | None, place: str, name: str, folder: Path, pool: Workers, resources: Resources
) -> tuple[Counts | None, list[Failure]]:
    """Run a study in a folder of its own inside that of the reproduction. Returns its counts, and what failed."""
    if plan is None:
        return None, []
    batch = study_run.batch(plan, name)
    with closing(batch.open(folder / place, resources)) as run:
        failures = batch.fill(run, pool, resources)
        return Counts(plan, run.rows(), failures), failures
