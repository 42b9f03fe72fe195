"""How a judge decides: a claim is a list of checks, each with its distance from its bound; the weakest decides."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal


@dataclass(frozen=True, slots=True)
class Check:
    """One thing that a claim asks for.

    ``said`` has the measured number and its bound. ``slack`` is how far inside its bound the number lies, below 0
    where it lies outside; on the bound itself a check passes unless it is ``strict``. A NaN never passes.
    """

    said: str
    slack: float
    strict: bool = True

    @property
    def passes(self) -> bool:
        """Whether the number is inside its bound."""
        return self.slack > 0.0 or (self.slack == 0.0 and not self.strict)


def decide(checks: Sequence[Check]) -> tuple[bool, str]:
    """Whether all of at least one check pass, and what the weakest says: the worst that fails, or the nearest to."""
    weakest = min(checks, key=lambda check: (check.passes, -math.inf if math.isnan(check.slack) else check.slack))
    return all(check.passes for check in checks), weakest.said


@dataclass(frozen=True, slots=True)
class Outcome:
    """What a judge finds: what ``n`` trials measured, the test with its effect size, and the number that decided.

    ``each`` is the number of trials of the condition that has the fewest.
    """

    verdict: Literal["holds", "fails", "untested"]
    measured: str
    effect: str = ""
    n: int = 0
    decided: str = ""
    each: int = 0

    def untested(self, why: str) -> Outcome:
        """The same without a verdict, and why."""
        return replace(self, verdict="untested", measured=f"{why}; measured: {self.measured}", decided="")


def is_number(value: Any) -> bool:
    """Whether a table's value is a finite number; ``None``, NaN and infinities are not."""
    return value is not None and math.isfinite(value)


def unreadable(rows: Iterable[Mapping[str, Any]], columns: Sequence[str]) -> str:
    """How many of the rows lack a number in which of the ``columns``, in words; empty if none does."""
    listed = list(rows)
    counts = {name: sum(not is_number(row[name]) for row in listed) for name in columns}
    return "; ".join(f"{count} of {len(listed)} have no number in {name}" for name, count in counts.items() if count)
