"""A claim is a list of checks, each with its distance from its bound; the weakest decides."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass


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


def decide(checks: Sequence[Check]) -> tuple[bool, str]:
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
    ValueError
        There are no checks.

    Examples
    --------
    >>> from experiments import Check, decide
    >>> decide([Check("3 spikes (needs more than 2)", 1.0), Check("8 spikes (needs more than 2)", 6.0)])
    (True, '3 spikes (needs more than 2)')
    """
    weakest = min(checks, key=lambda check: (check.passes, -math.inf if math.isnan(check.slack) else check.slack))
    return all(check.passes for check in checks), weakest.said
