"""A claim is a list of checks, each with its distance from its bound; the weakest decides."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from numbers import Real

from experiments.bench.engine.errors import UsageError, short


@dataclass(frozen=True, slots=True)
class Check:
    """One thing that a claim asks for.

    Parameters
    ----------
    said
        The measured number and its bound, in words.
    slack
        How far inside its bound the number lies; below 0 where it lies outside. A NaN never passes.
    strict
        Whether a number on the bound itself fails.

    Examples
    --------
    >>> from experiments import Check
    >>> Check("61.1 spikes at 6 cm/s (needs more than at 10: 45.8)", 61.1 - 45.8).passes
    True
    """

    said: str
    slack: float
    strict: bool = True

    @property
    def passes(self) -> bool:
        """Whether the number is inside its bound."""
        return self.slack > 0.0 or (self.slack == 0.0 and not self.strict)


def decide(checks: Iterable[Check]) -> tuple[bool, str]:
    """Decide a claim by its checks: it holds if all of them pass.

    Parameters
    ----------
    checks
        At least one.

    Returns
    -------
    holds : bool
        Whether all pass.
    decided : str
        What the weakest says: the worst that fails, or else the nearest to its bound.

    Raises
    ------
    UsageError
        There are no checks, something else is among them, or a slack is no number. It is a ``ValueError``.

    Examples
    --------
    >>> from experiments import Check, decide
    >>> decide([Check("3 spikes (needs more than 2)", 1.0), Check("8 spikes (needs more than 2)", 6.0)])
    (True, '3 spikes (needs more than 2)')
    """
    listed = list(checks) if isinstance(checks, Iterable) else []
    if not listed or not all(isinstance(check, Check) for check in listed):
        raise UsageError(f"decide({short(checks)}): legal is at least one experiments.Check")
    for check in listed:
        if not isinstance(check.slack, Real):
            raise UsageError(f"decide: check {check.said!r}: slack={short(check.slack)}: legal is a number")
    weakest = min(listed, key=lambda check: (check.passes, -math.inf if math.isnan(check.slack) else check.slack))
    return all(check.passes for check in listed), weakest.said
