"""Summary of an off-line run: its claims at every seed, and its figure."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from experiments import OFFLINE
from experiments.bench.clips import figure as clips_figure
from experiments.bench.clips.claims import ClipClaim, find, judge
from experiments.bench.clips.plan import OfflinePlan
from experiments.bench.figures import plotting
from experiments.bench.stats import stored
from experiments.bench.stats.verdict import Outcome, Verdict
from experiments.bench.store.rows import Failure, mixture
from experiments.bench.store.run_folder import RunFolder


@dataclass(frozen=True, slots=True)
class OfflineReport:
    """Summary of an off-line run: a row a clip and model, the verdicts, and what failed."""

    plan: OfflinePlan
    folder: Path
    rows: list[dict[str, Any]]
    verdicts: list[Verdict]
    failures: list[Failure]


def conclude(plan: OfflinePlan, folder: RunFolder, failures: Sequence[Failure]) -> OfflineReport:
    """Write verdicts and figure of the clips in ``folder``."""
    rows = folder.rows()
    judged = verdicts(plan, rows)
    folder.write_json("claims.json", stored.document(judged))
    if rows:
        first = [row for row in rows if row["repeat"] == 0]
        title = clips_figure.title(plan.experiment.name, plan.seed, plan.changed())
        drawn = clips_figure.draw(plan.experiment.figure, first, folder.frames(), plan.thresholds, title)
        plotting.save(drawn, folder.folder)
    return OfflineReport(plan, folder.folder, rows, judged, list(failures))


def is_random(plan: OfflinePlan) -> bool:
    """Return whether the clips of an off-line run may differ with the seed, as those before a scene do."""
    declared = plan.experiment
    if declared.repeats > 1 or declared.name not in OFFLINE:
        return True
    first, second = (next(iter(declared.clips[0].build(seed))).luma for seed in (0, 1))
    return not np.array_equal(first, second)


def verdicts(
    plan: OfflinePlan, rows: Sequence[Mapping[str, Any]], all_rows: Sequence[Mapping[str, Any]] | None = None
) -> list[Verdict]:
    """Judge the claims of an off-line run, each at every seed. A seed is a replicate.

    Parameters
    ----------
    plan
        The run's plan.
    rows
        The run's rows.
    all_rows
        The same models' rows in other runs too: see `experiments.bench.clips.claims.judge`.
    """
    return [_verdict(find(claim), plan, rows, all_rows or rows) for claim in plan.experiment.claims]


def _verdict(
    claim: ClipClaim, plan: OfflinePlan, rows: Sequence[Mapping[str, Any]], all_rows: Sequence[Mapping[str, Any]]
) -> Verdict:
    outcomes: list[Outcome] = []
    for repeat in range(plan.repeats):
        of_seed = [row for row in rows if row["repeat"] == repeat]
        whole = len({row["trial"] for row in of_seed}) == len(plan.experiment.clips)
        lost = Outcome.unjudged("some of its clips failed")
        outcomes.append(judge(claim, of_seed, plan.thresholds, all_rows) if whole else lost)
    outcomes[0] = outcomes[0].noting([mixture(rows)])
    return claim.verdict(*outcomes, random=is_random(plan), experiment=plan.experiment.name)
