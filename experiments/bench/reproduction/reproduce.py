"""Which of the paper's claims hold: its experiments, the studies of replicates and sensitivity, the verdicts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import ExitStack, closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from experiments.bench.clips import run as clips_run
from experiments.bench.clips.constants import comparing
from experiments.bench.clips.summary import OfflineReport
from experiments.bench.closed_loop import claims as closed_loop_claims
from experiments.bench.closed_loop import figure as closed_loop_figure
from experiments.bench.closed_loop import run as closed_loop_run
from experiments.bench.closed_loop.run import BehaviourPlan, Played
from experiments.bench.engine.batch import Resources
from experiments.bench.engine.errors import UsageError
from experiments.bench.engine.models import shown_models
from experiments.bench.engine.pool import Pool
from experiments.bench.engine.terminal import error_console
from experiments.bench.judging import stored
from experiments.bench.judging.verdict import Outcome, Verdict
from experiments.bench.reproduction import claims, mechanisms, readings, replicates, robustness
from experiments.bench.reproduction.onboard.formats import BEST, FORMATS
from experiments.bench.reproduction.onboard.rows import FILE, Onboard, tabled
from experiments.bench.reproduction.plan import BESIDE, REPLICATES, SENSITIVITY, Planned, Scale, design, planned
from experiments.bench.reproduction.replicates import Replicate
from experiments.bench.robot import run as robot_run
from experiments.bench.robot.plan import Plan, describe
from experiments.bench.robot.summary import Report, conclude
from experiments.bench.store.files import Files
from experiments.bench.store.kinds import REPRODUCTION
from experiments.bench.store.places import inside
from experiments.bench.store.record import begin_whole
from experiments.bench.store.rows import Failure
from experiments.bench.store.run_folder import RunFolder


@dataclass(frozen=True, slots=True)
class Reproduction:
    """Everything that the report shows."""

    folder: Path
    scale: Scale
    seed: int
    claims: list[Verdict]
    """Of the paper."""
    pooled: Mapping[str, Outcome]
    """Claim about the robot -> what it comes to on the trials of all replicates together."""
    runs: list[tuple[Plan, Report]]
    offline: list[OfflineReport]
    sensitivity: Mapping[str, Mapping[str, Outcome]]
    """What was moved -> claim -> its outcome; the defaults first. Empty where nothing was moved."""
    behaviours: list[Played]
    """Episodes in each env."""
    own_claims: list[Verdict]
    """Our own claims, about behaviours."""
    failures: Mapping[str, Sequence[Failure]]
    """Failures of the two studies."""
    description: Mapping[str, Any]
    readings: list[readings.Chapter]
    """The readings of the paper that were taken, and what claims come to under the others."""
    onboard: Onboard | None = None
    """The claims in the robot's own arithmetic, where it was shown."""

    @property
    def failed(self) -> bool:
        """Whether any of its trials, clips and episodes failed, for all models or for one."""
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
    names = shown_models((robustness.MODEL, *BESIDE), given, only)
    if robustness.MODEL not in names:
        raise UsageError(f"--only: the claims are about {robustness.MODEL}: give --model {robustness.MODEL} too")
    return names


def reproduce(
    folder: Path, scale: Scale, seed: int, models: Sequence[str], resources: Resources, extra: Sequence[str] = (),
    robot_only: bool = False, only: bool = False,
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
    """
    made = planned(scale, seed, models, extra, robot_only, only)
    if not resources.quiet:
        _announce(made, folder, resources)
    with ExitStack() as locks:
        with resources.pool() as pool:
            begin_whole(folder, REPRODUCTION)
            done = [_run(each, folder, pool, resources, locks) for each in made.plans]
            shows = [
                clips_run.run(
                    each, inside(folder, each.experiment.name), pool, resources, record=each.experiment.recorded
                )
                for each in made.offline
            ]
            played = [_play(each, folder, pool, resources) for each in made.loops]
            kept = (robustness.MODEL, BEST.label)
            rows, lost = _study(
                REPLICATES,
                "other replicates",
                made.others,
                made,
                folder,
                pool,
                resources,
                kept if scale.onboard else (),
            )
            moved, move_failures = _study(SENSITIVITY, SENSITIVITY, made.moves, made, folder, pool, resources, kept)
        runs = [(each, conclude(each, run, run.failures())) for each, run in zip(made.plans, done, strict=True)]
    first = replicates.replicate(
        [spec for each in made.paper() for spec in each.specs()], [row for _, report in runs for row in report.rows]
    )
    every = [first, *replicates.studied(made.others, rows)]
    own = closed_loop_claims.judge(closed_loop_claims.episodes(played)) if played else []
    survived = replicates.survival(made.moves, moved, first) if made.moves else {}
    verdicts = claims.verdicts(every, shows)
    chapters = readings.chapters(
        readings.Evidence({claim.id: claim for claim in verdicts}, every, shows, survived, scale.name)
    )
    onboard = _onboard(made, every, moved) if scale.onboard and made.moves else None
    result = Reproduction(
        folder, scale, seed, verdicts, claims.pooled(every), runs, shows, survived, played, own,
        {REPLICATES: lost, SENSITIVITY: move_failures}, describe(made.plans[0]), chapters, onboard,
    )  # fmt: skip
    files = Files(folder)
    files.write_json("design.json", design(made))
    files.write_json("claims.json", stored.document(result.claims))
    files.write_json("pooled.json", {claim: stored.outcome_entry(outcome) for claim, outcome in result.pooled.items()})
    files.write_json("readings.json", result.readings)
    chosen = {claim: found for claim in comparing() if (found := mechanisms.constants(claim, shows))}
    if chosen:
        files.write_json("constants.json", chosen)
    if result.sensitivity:
        files.write_json("sensitivity.json", result.sensitivity)
    if own:
        files.write_json("behaviours.json", stored.document(own))
    if onboard:
        files.write_json(FILE, onboard)
    return result


def _announce(made: Planned, folder: Path, resources: Resources) -> None:
    clips, episodes = (
        sum(len(each.showings) for each in made.offline), sum(len(each.specs()) for each in made.loops)
    )  # fmt: skip
    beside = f"; {clips} clips, {episodes} episodes" if clips or episodes else ""
    said = f"{made.amount()}{beside}, {resources.where()}, into {folder}"
    error_console.print(said, soft_wrap=True, markup=False)


def _run(plan: Plan, folder: Path, pool: Pool, resources: Resources, locks: ExitStack) -> RunFolder:
    """Run an experiment's trials. Its folder stays locked until all is judged."""
    batch = robot_run.batch(plan, robot_run.Keep())
    run = batch.open(inside(folder, plan.experiment.name), resources)
    locks.callback(run.close)
    batch.fill(run, pool, resources)
    return run


def _play(each: BehaviourPlan, folder: Path, pool: Pool, resources: Resources) -> Played:
    """The episodes in one env, without recordings, and their figure."""
    short = each.settings[0].env.partition("/")[2].partition("-")[0].lower()
    done = closed_loop_run.run(each, inside(folder, f"behave-{short}"), pool, resources)
    closed_loop_figure.write(done)
    return done


def _onboard(made: Planned, every: Sequence[Replicate], moved: Sequence[Mapping[str, Any]]) -> Onboard:
    """The claims in the robot's own arithmetic. It watched replicate 0 beside the moves of the network."""
    first = replicates.studied(made.moves, moved)[0]
    return tabled([first, *every[1:]], made.scale.repeats, made.seed, formats=FORMATS[:2])


def _study(
    place: str, name: str, cases: Sequence[robustness.Case], made: Planned, folder: Path, pool: Pool,
    resources: Resources, kept: Sequence[str],
) -> tuple[list[dict[str, Any]], list[Failure]]:  # fmt: skip
    """The rows of a study's trials, with the series of the models ``kept`` and no frames, and what failed."""
    if not cases:
        return [], []
    batch = robustness.batch(name, cases, made.plans[0], kept)
    with closing(batch.open(inside(folder, place), resources)) as run:
        failures = batch.fill(run, pool, resources)
        return run.rows(), failures
