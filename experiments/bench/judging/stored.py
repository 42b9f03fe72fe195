"""Verdicts in a file: ``claims.json``, ``behaviours.json`` and ``model_claims.json`` have this one form.

An object with ``version`` and ``claims``. Each claim has ``id``, ``says``, ``source``, ``model``, ``experiment`` and
``trouble`` as a `Verdict` has them, and

- ``word``: ``holds``, ``fails``, ``sometimes``, or empty where too few replicates could be judged for a word;
- ``count``: the numbers ``holds`` and ``fails`` of replicates, ``unjudged`` (reason -> number), and ``random``, which
  is false where nothing differs between replicates;
- ``interval``: the two ends of the exact 95 % interval of the share of judged replicates in which it holds, or null;
- ``outcome``: what was found in the first replicate, as an `Outcome` has it;
- ``equal_terms``: the count where the models that it compares with are on equal terms, or null. ``equal`` in
  ``outcome`` is the outcome there. Files from before have neither;
- ``decisions``: for each replicate its ``verdict`` and ``check``, the one that decided there, or null. Files from
  before do not have it.

Files of version 1, a bare list with ``verdict``, are read too. Those of release 0.1 count ``seeds``, later ones
``replicates``. Release 0.2 calls ``fewest`` in ``outcome`` ``each``.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping, Sequence
from numbers import Real
from typing import Any, cast

from experiments.bench.judging.checks import Check
from experiments.bench.judging.count import Count, Reason, count
from experiments.bench.judging.verdict import Decision, Judged, Outcome, Verdict

VERSION = 2
_FORMER: Mapping[str, Judged] = {
    "untested": "not shown",
    "vacuous": "silent model",
    "untestable": "unknown constants",
}
"""Word of version 1 -> the reason that it is today."""
_OF_REPLICATES: Mapping[str, Judged] = {"held": "holds", "failed": "fails", **_FORMER}
"""Field of version 1, after ``replicates_`` -> what it counts."""


def document(verdicts: Sequence[Verdict]) -> dict[str, Any]:
    """Return what a file of verdicts holds."""
    return {"version": VERSION, "claims": [_entry(verdict) for verdict in verdicts]}


def verdicts(content: Any) -> list[Verdict]:
    """Return the verdicts that a file holds, of this version or the one before.

    Parameters
    ----------
    content
        What the file's JSON is.

    Raises
    ------
    ValueError
        It is no file of verdicts, or one of a later version.
    """
    if isinstance(content, list):
        return [_former(_object(row)) for row in content]
    whole = _object(content)
    if whole.get("version") != VERSION or not isinstance(whole.get("claims"), list):
        raise ValueError(f"version={whole.get('version')!r}: legal is {VERSION}, with a list of claims")
    return [_verdict(_object(row)) for row in whole["claims"]]


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
    try:
        equal = row.get("equal_terms")
        return Verdict(
            row["id"], row["says"], row["source"], _outcome(row["outcome"]), Count(**row["count"]), row["model"],
            row["experiment"], row["trouble"], Count(**equal) if equal else None,
            tuple(decision(entry) for entry in row.get("decisions", ())),
        )  # fmt: skip
    except (KeyError, TypeError, AttributeError, IndexError) as error:
        raise ValueError(f"claim {row.get('id')}: a field lacks or is not of its kind ({error})") from None


def decision(entry: Mapping[str, Any]) -> Decision:
    """Return what decided a claim in one replicate, from what a file holds of it."""
    return Decision(entry["verdict"], _check(entry["check"]) if entry["check"] else None)


def _outcome(entry: Mapping[str, Any]) -> Outcome:
    fields = dict(entry)
    if "each" in fields:
        fields["fewest"] = fields.pop("each")
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


def _former(row: Mapping[str, Any]) -> Verdict:
    """A verdict of version 1: one of replicate 0, with numbers of replicates that are null where there was one run."""
    try:
        word = row["verdict"]
        verdict = _FORMER.get(word, word)
        trouble = str(row.get("trouble") or "")
        outcome = Outcome(
            verdict, str(row["measured"]), str(row.get("effect") or ""), int(row.get("n") or 0),
            str(row.get("decided") or ""), trouble=trouble,
        )  # fmt: skip
        counted = count([verdict])
        if row.get("replicates") is not None:
            numbers = {now: int(row.get(f"replicates_{name}") or 0) for name, now in _OF_REPLICATES.items()}
            held, failed = numbers.pop("holds"), numbers.pop("fails")
            random = row.get("standing") != "deterministic"
            counted = Count(held, failed, cast(Mapping[Reason, int], numbers), random)
        elif row.get("seeds") is not None:
            held, unshown = int(row["seeds_holding"]), int(row.get("seeds_untested") or 0)
            counted = Count(held, int(row["seeds"]) - held - unshown, {"not shown": unshown} if unshown else {})
        model, experiment = str(row.get("model") or ""), str(row.get("experiment") or "")
        texts = str(row["id"]), str(row["says"]), str(row["source"])
        return Verdict(*texts, outcome, counted, model, experiment, trouble)
    except (KeyError, TypeError) as error:
        raise ValueError(f"claim {row.get('id')}: a field lacks or is not of its kind ({error})") from None


def _object(value: Any) -> Mapping[str, Any]:
    if not isinstance(value, dict):
        raise ValueError("no object, nor a list of objects")
    return value
