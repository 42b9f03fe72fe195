"""Summary of an off-line run: its claims at every seed, and its figure."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from experiments.bench.clips import figure as clips_figure
from experiments.bench.clips.claims import ClipClaim, find, judge
from experiments.bench.clips.plan import OfflinePlan
from experiments.bench.figures import plotting
from experiments.bench.judging.replicates import counted
from experiments.bench.judging.verdict import Outcome, Verdict
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


def conclude(made: OfflinePlan, folder: RunFolder, failures: Sequence[Failure]) -> OfflineReport:
    """Write verdicts and figure of the clips in ``folder``."""
    rows = folder.rows()
    judged = verdicts(made, rows)
    folder.write_json("claims.json", judged)
    if rows:
        shown = [row for row in rows if row["repeat"] == 0]
        title = clips_figure.title(made.experiment.name, made.seed, made.changed())
        drawn = clips_figure.draw(made.experiment.figure, shown, folder.frames(), made.thresholds, title)
        plotting.save(drawn, folder.folder)
    return OfflineReport(made, folder.folder, rows, judged, list(failures))


def verdicts(
    made: OfflinePlan, rows: Sequence[Mapping[str, Any]], shown: Sequence[Mapping[str, Any]] | None = None,
    *, random: bool = True,
) -> list[Verdict]:  # fmt: skip
    """Judge the claims of an off-line run, each at every seed. A seed is a replicate, the first one replicate 0.

    Parameters
    ----------
    made
        The run's plan.
    rows
        The run's rows.
    shown
        The same models' rows in other runs too: see `experiments.bench.clips.claims.judge`.
    random
        Whether anything in the clips is random, so that seeds differ.
    """
    return [_verdict(find(claim), made, rows, shown or rows, random) for claim in made.experiment.claims]


def _verdict(
    claim: ClipClaim, made: OfflinePlan, rows: Sequence[Mapping[str, Any]], shown: Sequence[Mapping[str, Any]],
    random: bool,
) -> Verdict:  # fmt: skip
    by_seed: list[Outcome] = []
    for repeat in range(made.repeats):
        own = [row for row in rows if row["repeat"] == repeat]
        whole = len({row["trial"] for row in own}) == len(made.experiment.clips)
        lost = Outcome("untested", "some of its clips failed")
        by_seed.append(judge(claim, own, made.thresholds, shown) if whole else lost)
    first, mixed = by_seed[0], mixture(rows)
    admitted = replace(first, measured="; ".join([first.measured, *([mixed] if mixed else [])]))
    count = counted([outcome.verdict for outcome in by_seed], random=random)
    trouble = next((outcome.trouble for outcome in by_seed if outcome.trouble), "")
    return claim.verdict(admitted, experiment=made.experiment.name, trouble=trouble, **count.fields())
