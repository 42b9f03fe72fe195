"""The verdict on a claim over all its replicates."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from numbers import Real
from typing import Any

from pydantic import TypeAdapter

from experiments.declare.claim import Claim
from experiments.declare.outcome import Check, Judged, Outcome, weakest
from experiments.judge.count import Count, count


@dataclass(frozen=True, slots=True)
class Verdict:
    """Verdict on a claim over all its replicates.

    Attributes
    ----------
    id, says, source
        The claim, its words, and where they are from.
    outcome
        What was found in the first replicate: its numbers are those that are reported with the count.
    count
        In how many replicates it held; a single run is one replicate.
    model
        The model it is about; empty where the claim itself names its models.
    experiment
        The experiments, or the env, whose trials answer for it; empty where nothing here judges it.
    trouble
        What went wrong in a user's own judge, in any replicate; empty if nothing did.
    equal
        In how many replicates it held with the models that it compares with on equal terms; ``None`` of a claim that
        compares with none, or where these were not shown.
    decisions
        What it came to in each replicate, the first one first, and the weakest check there, if anything was asked.
    title
        The claim in a few words, or empty.
    """

    id: str
    says: str
    source: str
    outcome: Outcome
    count: Count
    model: str = ""
    experiment: str = ""
    trouble: str = ""
    equal: Count | None = None
    decisions: tuple[tuple[Judged, Check | None], ...] = ()
    title: str = ""

    @property
    def numbers(self) -> tuple[str, str]:
        """The number that decided in the first replicate, and what the claim needs there; both empty without one."""
        check = self.decisions[0][1] if self.decisions else None
        return (check.says, check.bound_text) if check else ("", "")


def verdict_of(
    claim: Claim, outcomes: Sequence[Outcome], *, random: bool = True, model: str = "", experiment: str = ""
) -> Verdict:
    """Return the verdict on a claim over its replicates: the first outcome, and the count of all.

    Parameters
    ----------
    claim
        The claim.
    outcomes
        One of each replicate, the first one first.
    random
        Whether anything differs between replicates.
    model, experiment
        As of a `Verdict`.

    Returns
    -------
    Verdict
        The verdict.
    """
    again = [outcome.equal.verdict if outcome.equal else "not shown" for outcome in outcomes]
    return Verdict(
        claim.id, claim.says, claim.source, outcomes[0], count([one.verdict for one in outcomes], random=random),
        model, experiment, trouble=next((one.trouble for one in outcomes if one.trouble), ""),
        equal=count(again, random=random) if any(one.equal for one in outcomes) else None,
        decisions=tuple((one.verdict, weakest(one.checks) if one.checks else None) for one in outcomes),
        title=claim.title,
    )  # fmt: skip


_READ = TypeAdapter(Verdict)


def document(verdicts: Sequence[Verdict]) -> dict[str, Any]:
    """Return what a file of verdicts holds."""
    return {"claims": [_entry(verdict) for verdict in verdicts]}


def _entry(verdict: Verdict) -> dict[str, Any]:
    fields, count = plain(verdict), verdict.count
    decisions = [{"verdict": came_to, "check": plain(check)} for came_to, check in verdict.decisions]
    more = {"equal_terms": fields.pop("equal"), "word": count.word, "interval": count.interval}
    return {**fields, **more, "decisions": decisions}


def plain(value: Any) -> Any:
    """Return a record as JSON has it; a number that is not finite, for which JSON has none, stands as a text."""
    if dataclasses.is_dataclass(value):
        return {field.name: plain(getattr(value, field.name)) for field in dataclasses.fields(value)}
    if isinstance(value, tuple):
        return [plain(part) for part in value]
    if isinstance(value, Real) and not isinstance(value, int):
        return float(value) if math.isfinite(value) else str(float(value))
    return value


def verdicts(content: Mapping[str, Any]) -> list[Verdict]:
    """Return the verdicts that a file's JSON holds."""
    rows = (
        {**row, "equal": row["equal_terms"], "decisions": [(one["verdict"], one["check"]) for one in row["decisions"]]}
        for row in content["claims"]
    )
    return [_READ.validate_python(row) for row in rows]
