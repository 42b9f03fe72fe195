"""Verdicts in a file: ``claims.json``, ``behaviours.json`` and ``model_claims.json`` have this one form.

An object with ``claims``, of which each has ``id``, ``title``, ``says``, ``source``, ``model``,
``experiment`` and ``trouble`` as a `Verdict` has them, and

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

from pydantic import TypeAdapter

from experiments.judge.verdict import Verdict

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
