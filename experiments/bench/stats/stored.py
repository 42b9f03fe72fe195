"""Verdicts in a file: ``claims.json``, ``behaviours.json`` and ``model_claims.json`` have this one form.

An object with ``version`` and ``claims``. Each claim has ``id``, ``says``, ``source``, ``model``, ``experiment`` and
``trouble`` as a `Verdict` has them, and

- ``word``: ``holds``, ``fails``, ``sometimes``, or empty where too few replicates could be judged for a word;
- ``count``: the numbers ``holds`` and ``fails`` of replicates, ``unjudged`` (reason -> number), and ``random``, which
  is false where nothing differs between replicates;
- ``interval``: the two ends of the exact 95 % interval of the share of judged replicates in which it holds, or null;
- ``outcome``: what was found in the first replicate, as an `Outcome` has it;
- ``equal_terms``: the count where the models that it compares with are on equal terms, or null. ``equal`` in
  ``outcome`` is the outcome there;
- ``decisions``: for each replicate its ``verdict`` and ``check``, the one that decided there, or null.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping, Sequence
from numbers import Real
from typing import Any

from experiments.bench.stats.checks import Check
from experiments.bench.stats.count import Count
from experiments.bench.stats.verdict import Decision, Outcome, Verdict

VERSION = 2


def document(verdicts: Sequence[Verdict]) -> dict[str, Any]:
    """Return what a file of verdicts holds."""
    return {"version": VERSION, "claims": [_entry(verdict) for verdict in verdicts]}


def verdicts(content: Mapping[str, Any]) -> list[Verdict]:
    """Return the verdicts that a file's JSON holds."""
    return [_verdict(row) for row in content["claims"]]


def outcome_entry(outcome: Outcome) -> dict[str, Any]:
    """Return an outcome as a file has it; JSON has no number for one that is not finite, which stands as a text."""
    entry = {field.name: getattr(outcome, field.name) for field in dataclasses.fields(outcome)}
    entry |= {"equal": outcome_entry(outcome.equal) if outcome.equal else None}
    return entry | {"checks": [_check_entry(check) for check in outcome.checks]}


def decision_entry(decision: Decision) -> dict[str, Any]:
    """Return what decided a claim in one replicate as a file has it."""
    return {"verdict": decision.verdict, "check": _check_entry(decision.check) if decision.check else None}


def _check_entry(check: Check) -> dict[str, Any]:
    return {name: _number(value) for name, value in dataclasses.asdict(check).items()}


def _number(value: Any) -> Any:
    if isinstance(value, tuple):
        return [_number(part) for part in value]
    if isinstance(value, Real) and not isinstance(value, int):
        return float(value) if math.isfinite(value) else str(float(value))
    return value


def _entry(verdict: Verdict) -> dict[str, Any]:
    return {
        "id": verdict.id, "says": verdict.says, "source": verdict.source, "model": verdict.model,
        "experiment": verdict.experiment, "word": verdict.count.word, "count": dataclasses.asdict(verdict.count),
        "interval": verdict.count.interval, "outcome": outcome_entry(verdict.outcome), "trouble": verdict.trouble,
        "equal_terms": dataclasses.asdict(verdict.equal) if verdict.equal else None,
        "decisions": list(map(decision_entry, verdict.decisions)),
    }  # fmt: skip


def _verdict(row: Mapping[str, Any]) -> Verdict:
    equal = row["equal_terms"]
    return Verdict(
        row["id"], row["says"], row["source"], _outcome(row["outcome"]), Count(**row["count"]), row["model"],
        row["experiment"], row["trouble"], Count(**equal) if equal else None,
        tuple(decision(entry) for entry in row["decisions"]),
    )  # fmt: skip


def decision(entry: Mapping[str, Any]) -> Decision:
    """Return what decided a claim in one replicate, from what a file holds of it."""
    return Decision(entry["verdict"], _check(entry["check"]) if entry["check"] else None)


def _outcome(entry: Mapping[str, Any]) -> Outcome:
    fields = dict(entry)
    checks = tuple(_check(check) for check in fields.pop("checks"))
    equal = fields.pop("equal", None)
    return Outcome(**fields, checks=checks, equal=_outcome(equal) if equal else None)


def _check(entry: Mapping[str, Any]) -> Check:
    bound = entry["bound"]
    numbers = {
        "reading": float(entry["reading"]),
        "bound": (float(bound[0]), float(bound[1])) if isinstance(bound, list) else float(bound),
        "scale": float(entry["scale"]),
    }
    fields: dict[str, Any] = {**entry, **numbers}
    return Check(**fields)
