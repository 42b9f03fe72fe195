"""The plan of a reproduction: its scale, its trials, clips and episodes, and the content of ``design.json``."""

from __future__ import annotations

import dataclasses
import hashlib
import json
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from experiments import OFFLINE
from experiments.bench import offline, registry
from experiments.bench.closed_loop import claims as closed_loop_claims
from experiments.bench.closed_loop.run import BehaviourPlan
from experiments.bench.engine.pictures import Pictures
from experiments.bench.footage import claims as footage_claims
from experiments.bench.offline import OfflinePlan
from experiments.bench.reproduction.replicates import SHOWN, models_in
from experiments.bench.run.errors import UsageError
from experiments.bench.sources import robot_claims
from experiments.bench.sources.clips import OfflineExperiment
from experiments.bench.sources.robot_claims import EACH_TRIAL, PATH_TOLERANCE_MM, SPEED_TOLERANCE
from experiments.bench.stats import clips as clips_claims
from experiments.bench.stats.claim import PAPER, claim_ids, words
from experiments.bench.stats.clips import LEAST_GREYS
from experiments.bench.stats.count import LEAST_JUDGED
from experiments.bench.store import provenance
from experiments.bench.store.description import THRESHOLDS, plain
from experiments.bench.studies import run as study_run
from experiments.bench.studies.plan import StudyPlan
from experiments.bench.studies.replicates import MODEL, asked_models
from experiments.bench.studies.study import WHOLE, Study
from experiments.bench.trials import Plan, describe, plan
from experiments.studies.onboard import BEST, series_of
from experiments.studies.sensitivity import STUDY as SENSITIVE
from experiments.studies.sensitivity_clips import STUDY as SENSITIVE_ON_CLIPS


@dataclass(frozen=True, slots=True)
class Scale:
    """The scale of a reproduction: how much of each part is run.

    Parameters
    ----------
    replicates
        Of the experiments with the robot, the headline among them; 1 or more. Replicate r has the seed of the run
        plus r.
    repeats
        Trials of each condition in a replicate. Fewer than a claim's ``least`` leave it unjudged.
    moves
        Whether to run one replicate with each thing moved that the studies of sensitivity name, and clips so too.
    offline_replicates
        Of the off-line experiments in which anything is random. Of the others one says all.
    episodes
        Of each behaviour.
    steps
        Frames of an episode at most; otherwise the env's own number.
    offline
        The off-line experiments to run.
    onboard
        Whether the network in the robot's own arithmetic watches the other replicates too.
    """

    replicates: int
    repeats: int
    moves: bool
    offline_replicates: int
    episodes: int
    steps: int | None = None
    offline: tuple[str, ...] = OFFLINE
    onboard: bool = False

    @property
    def name(self) -> str:
        """Return what a replicate with the robot is called: one with fewer repeats than the paper's is a short one."""
        return "replicate" if self.whole else "short replicate"

    @property
    def whole(self) -> bool:
        """Return whether its replicates with the robot have as many repeats as the paper's."""
        return self.repeats >= WHOLE


SHORT = (
    "clean", "blocked", "clutter-depth", "clutter-translation", "edges", "apparent", "background-alone",
)  # fmt: skip
"""The off-line experiments without grids of long clips."""
REPLICATES, SENSITIVITY, SENSITIVITY_CLIPS = "replicates", "sensitivity", "sensitivity-clips"
BESIDE = ("dsn2017",)
"""The models shown beside the DSNN unless others are named."""
ENOUGH = EACH_TRIAL
"""Repeats at which every claim of the robot is judged."""
QUICK = Scale(2, ENOUGH, moves=False, offline_replicates=1, episodes=1, steps=150, offline=SHORT)
USUAL = Scale(5, WHOLE, moves=True, offline_replicates=5, episodes=20, steps=900)
FULL = Scale(40, WHOLE, moves=True, offline_replicates=LEAST_JUDGED, episodes=60, onboard=True)
"""Off-line, as few replicates as a word may rest on: one costs a minute and a half of processor time."""


@dataclass(frozen=True, slots=True)
class Planned:
    """All that a reproduction runs, checked."""

    scale: Scale
    seed: int
    plans: list[Plan]
    """The paper's experiments with the robot, then those of the user."""
    offline: list[OfflinePlan]
    loops: list[BehaviourPlan]
    others: StudyPlan | None
    """Replicates 1, 2, ... of the paper's experiments; replicate 0 is ``plans``."""
    moves: StudyPlan | None
    """The study of sensitivity."""
    clip_moves: StudyPlan | None
    """The same of clips."""

    def paper(self) -> list[Plan]:
        """Return the plans of the paper's experiments: replicate 0."""
        return self.plans[: len(registry.paper_experiments())]

    def amount(self) -> str:
        """Say how many trials with the robot there are, by what they are for."""
        paper, every = (sum(len(run_plan.specs()) for run_plan in plans) for plans in (self.paper(), self.plans))
        again, moved = (len(study_plan.specs) if study_plan else 0 for study_plan in (self.others, self.moves))
        others = f", {every - paper} of other experiments" if every > paper else ""
        more = self.scale.replicates - 1
        parts = f"{paper} in replicate 0, {again} in {more} more, {moved} with something moved{others}"
        return f"{every + again + moved} trials with the robot ({parts})"


def planned(
    scale: Scale, seed: int, models: Sequence[str] = BESIDE, extra: Sequence[str] = (), robot_only: bool = False,
    only: bool = False, pictures: Pictures | None = None,
) -> Planned:  # fmt: skip
    """Return what `experiments.bench.reproduction.reproduce.reproduce` runs; `UsageError` for what cannot be run."""
    labels = [MODEL, *(name for name in models if name != MODEL)]
    plans = [
        plan(registry.load(name), labels if only else _models(name, labels), (), scale.repeats, seed, pictures)
        for name in (*registry.paper_experiments(), *SHOWN, *extra)
    ]
    _check_names(plans)
    return Planned(
        scale, seed, plans,
        offline=[_offline_plan(name, scale, seed, pictures) for name in scale.offline if not robot_only],
        loops=[] if robot_only else closed_loop_claims.plans(scale.episodes, seed, scale.steps),
        others=replicates_plan(
            scale.replicates - 1, scale.repeats, seed + 1, labels if only else None, onboard=scale.onboard,
            pictures=pictures and dataclasses.replace(pictures, first=1),
        ) if scale.replicates > 1 else None,
        moves=study_run.planned(
            dataclasses.replace(SENSITIVE, repeats=scale.repeats), seed, pictures=pictures
        ) if scale.moves else None,
        clip_moves=study_run.planned(
            SENSITIVE_ON_CLIPS, seed, pictures=pictures
        ) if scale.moves and not robot_only else None,
    )  # fmt: skip


def replicates_plan(
    replicates: int, repeats: int, seed: int, among: Sequence[str] | None = None, *, onboard: bool = False,
    pictures: Pictures | None = None,
) -> StudyPlan:  # fmt: skip
    """Return the plan of replicates of the paper's experiments with the robot: a study without a grid.

    Parameters
    ----------
    replicates, repeats, seed
        How many replicates, trials of each condition in one, and the seed of the first.
    among
        Models to be shown; ``None``: all that the claims are about.
    onboard
        Whether the network in the robot's own arithmetic watches too, and its potentials are kept.
    pictures
        The wall of the arena has one of them in each replicate.
    """
    study = Study(
        REPLICATES,
        "the paper's experiments at several seeds",
        claims=tuple(registry.answering()),
        experiments=registry.paper_experiments(),
        models=(MODEL,),
        repeats=repeats,
        replicates=replicates,
        probe=series_of((MODEL, BEST.label)) if onboard else None,
    )
    return study_run.planned(study, seed, models_in(among, (BEST.label,) if onboard else ()), pictures)


def design(whole: Planned) -> dict[str, Any]:
    """Return what ``design.json`` holds: scale and seed, the versions, and a digest of all that decides the numbers.

    The digest is of every experiment, parameter, seed and number of repeats, and of the claims' words and bounds; not
    of versions and code. Two reproductions with one digest should differ in no number.
    """
    clips, loops = (clip_plan.describe() for clip_plan in whole.offline), (loop.describe() for loop in whole.loops)
    runs, computes = [*map(describe, whole.plans), *clips, *loops], (*provenance.KEYS, "form", THRESHOLDS, "kind")
    studies = whole.others, whole.moves, whole.clip_moves
    parts = {
        "runs": [{name: value for name, value in run.items() if name not in computes} for run in runs],
        "studies": [(study_plan.study.name, study_plan.specs) for study_plan in studies if study_plan],
        "claims": {claim: (words(claim).says, words(claim).source) for claim in claim_ids(PAPER)},
        "least": [{claim.id: claim.least for claim in robot_claims.paper_claims().values()},
                  {claim.id: claim.conditions for claim in clips_claims.paper_claims().values()},
                  LEAST_GREYS, footage_claims.LEAST_SECONDS, closed_loop_claims.LEAST_SEEDS],
        "bounds": [SPEED_TOLERANCE, PATH_TOLERANCE_MM],
    }  # fmt: skip
    text = json.dumps(parts, default=plain)  # without indents: C writes that, twenty times as fast
    digest = hashlib.sha256(text.encode()).hexdigest()
    return {
        "seed": whole.seed,
        "scale": dataclasses.asdict(whole.scale),
        "digest": digest,
        "versions": provenance.versions(),
    }


def _models(experiment: str, labels: Sequence[str]) -> list[str]:
    """The models of one experiment: its own, those of all, and where a claim is about them the looming detectors.

    An experiment that shows variants of the DSNN, or that is shown for its mechanism, shows its own alone.
    """
    declared = registry.load(experiment)
    models = declared.models
    if len(models) > 1 or experiment in SHOWN:
        return list(models)
    return list(dict.fromkeys([*models, *labels, *asked_models(declared)]))


def _offline_plan(name: str, scale: Scale, seed: int, pictures: Pictures | None) -> OfflinePlan:
    experiment = registry.find(name)
    assert isinstance(experiment, OfflineExperiment)
    # Where one repeat says it all, nothing in the clips is random.
    repeats = scale.offline_replicates if experiment.repeats > 1 else None
    return offline.plan(experiment, (), (), repeats, seed, pictures=pictures)


def _check_names(plans: Sequence[Plan]) -> None:
    """Every experiment has a folder of its own."""
    names = [run_plan.experiment.name for run_plan in plans]
    for name in names:
        if names.count(name) > 1 or name in (REPLICATES, SENSITIVITY, SENSITIVITY_CLIPS, *OFFLINE):
            raise UsageError(f"--experiment {name}: that name is taken in a reproduction; give it another")
