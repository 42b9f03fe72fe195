"""The claims of the models' own papers: show their clips to the models, and judge them at every seed."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from experiments.bench import offline
from experiments.bench.offline import OfflinePlan
from experiments.bench.reproduction.models.clips import GROUPS, RANDOM
from experiments.bench.run.errors import UsageError
from experiments.bench.run.models import look_up
from experiments.bench.run.runs import Resources
from experiments.bench.run.workers import Workers
from experiments.bench.sources.clips import OfflineExperiment
from experiments.bench.stats import clips as clips_claims
from experiments.bench.stats import stored
from experiments.bench.stats.clips import ClipClaim
from experiments.bench.stats.verdict import Outcome, Verdict
from experiments.bench.store.files import Files
from experiments.bench.store.rows import Failure
from experiments.claims.models import ModelClaim, clip_claim, model_claims

EVERY = "all"
REPLICATES = 5
"""Seeds of the clips in which anything is random."""


@dataclass(frozen=True, slots=True)
class Asked:
    """A claim, judged for one model as it was asked for."""

    claim: ModelClaim
    asked: str
    """The model's name, with settings where it was given some."""
    label: str
    than: str

    @property
    def random(self) -> bool:
        """Return whether any of its clips differs with the seed."""
        return bool(set(self.claim.groups) & set(RANDOM))

    def judged(self) -> ClipClaim:
        """The claim with its judge."""
        return clip_claim(self.claim, self.label, self.than)


def asked(models: Sequence[str]) -> list[Asked]:
    """The claims of the models named; ``all`` are all that have some.

    Raises `UsageError` for a model whose paper has no claim here, or that there is not.
    """
    names = [name for model in models for name in (model_claims() if model == EVERY else (model,))]
    questions: list[Asked] = []
    for name in dict.fromkeys(names):
        base, _, settings = name.partition(":")
        if base not in model_claims():
            known = ", ".join(model_claims())
            raise UsageError(
                f"--model {name}: no claims of its own paper are written down; they are of {known}, {EVERY}"
            )
        questions += [
            Asked(claim, name, _with(claim.model, settings), _with(claim.than, settings))
            for claim in model_claims()[base]
        ]
    return questions


def _with(label: str, settings: str) -> str:
    """A model's label with more settings."""
    if not label or not settings:
        return label
    return f"{label}{',' if ':' in label else ':'}{settings}"


def run(folder: Path, models: Sequence[str], seed: int, resources: Resources) -> tuple[list[Verdict], list[Failure]]:
    """Show the models what their claims are about, judge, and write ``model_claims.json``.

    Parameters
    ----------
    folder
        A new one, or one that holds a part of this run.
    models
        Registered names, with settings or without, or ``all``.
    seed
        Of the first replicate.
    resources
        Workers, or a cluster.

    Returns
    -------
    list of Verdict, list of Failure
        A verdict for each claim and model, and the clips that failed.

    Raises
    ------
    UsageError
        A model has no claims, or the folder holds something else.
    """
    wanted = asked(models)
    plans = _plans(wanted, seed)
    with resources.pool() as pool:
        folder.mkdir(parents=True, exist_ok=True)
        done = {name: _shown(plan, folder / name, pool, resources) for name, plan in plans.items()}
    rows = {name: table for name, (table, _) in done.items()}
    thresholds = {label: limit for plan in plans.values() for label, limit in plan.thresholds.items()}
    verdicts = [_verdict(question, rows.get("even", []), rows.get("gratings", []), thresholds) for question in wanted]
    Files(folder).write_json("model_claims.json", stored.document(verdicts))
    return verdicts, [failure for _, failures in done.values() for failure in failures]


def _plans(wanted: Sequence[Asked], seed: int) -> dict[str, OfflinePlan]:
    """The clips that are the same at every seed, and those that are not."""
    labels = tuple(dict.fromkeys(label for question in wanted for label in (question.label, question.than) if label))
    look_up(labels, "offline")  # an unknown parameter is named before anything runs
    groups = dict.fromkeys(group for question in wanted for group in question.claim.groups)
    plans = {}
    for name, repeats, with_gratings in (("even", 1, False), ("gratings", REPLICATES, True)):
        clips = tuple(clip for group in groups if (group in RANDOM) == with_gratings for clip in GROUPS[group])
        if clips:
            summary = "clips of the models' own claims"
            experiment = OfflineExperiment(name, summary, clips, labels, repeats=repeats, recorded=False)
            plans[name] = offline.plan(experiment, (), (), None, seed)
    return plans


def _shown(
    plan: OfflinePlan, out: Path, pool: Workers, resources: Resources
) -> tuple[list[dict[str, Any]], list[Failure]]:
    batch = offline.batch(plan, frames=False)
    with closing(batch.open(out, resources)) as folder:
        failures = batch.fill(folder, pool, resources)
        return folder.rows(), failures


def _verdict(
    question: Asked, even: list[dict[str, Any]], gratings: list[dict[str, Any]], thresholds: dict[str, float | None]
) -> Verdict:
    """Judge a claim with the gratings of each seed. What has none of them is judged once: nothing in it is random."""
    claim = question.judged()
    outcomes = []
    for repeat in range(REPLICATES if question.random else 1):
        rows = [*even, *(row for row in gratings if row["repeat"] == repeat)]
        if question.claim.check == "not shown":
            outcomes.append(Outcome.unjudged(question.claim.why))
        else:
            outcomes.append(clips_claims.judge(claim, rows, thresholds))
    return claim.verdict(*outcomes, random=question.random, model=question.asked, experiment="clips")
