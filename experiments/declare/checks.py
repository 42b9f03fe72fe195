"""A claim is a list of checks, each a reading held against a bound; the weakest decides."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, Literal, get_args

from experiments.base.errors import UsageError, short

Needs = Literal["above", "at least", "below", "at most", "within"]
"""Where a reading has to lie: on which side of its bound, or between two of them, ends included."""
Quantity = Literal["spikes", "potential"]
"""What claims compare: means of counts, spikes a trial, or peak potentials."""
MARGIN: Mapping[Quantity, float] = MappingProxyType({"spikes": 1.0, "potential": 0.002})
"""The smallest difference that "more", "rises", "falls", "fewer", "highest" and "lowest" may rest on.

1 spike a trial between means of counts; 0.002 between peak potentials, about 1 % of T. Stated before any claim was
judged by it; no claim has a margin of its own.
"""


@dataclass(frozen=True, slots=True)
class Check:
    """One thing that a claim asks for: a reading, and the bound that it has to keep.

    Parameters
    ----------
    says
        The reading in words, with its number.
    reading
        What was measured. A NaN never passes.
    bound
        What it is held against; two numbers, the lower first, of a reading that has to lie ``within`` them.
    needs
        Where the reading has to lie: ``above`` or ``below`` the bound, ``at least`` or ``at most`` as much, ``within``.
    unit
        Of reading and bound.
    scale
        What a slack is divided by before the weakest of several checks is chosen, where these differ in their units.
    asks
        The bound in words; left out, these are made from the other fields.

    Raises
    ------
    UsageError
        ``needs`` is none of the five, or does not fit the bound. It is a ``ValueError``.

    Examples
    --------
    >>> from experiments import Check
    >>> check = Check("61.1 spikes at 6 cm/s", 61.1, 45.8, unit="spikes")
    >>> check.passes, round(check.slack, 1), check.text
    (True, 15.3, '61.1 spikes at 6 cm/s (needs above 45.8 spikes)')
    """

    says: str
    reading: float
    bound: float | tuple[float, float]
    needs: Needs = "above"
    unit: str = ""
    scale: float = 1.0
    asks: str = ""

    def __post_init__(self) -> None:
        if self.needs not in get_args(Needs):
            raise UsageError(f"check {short(self.says)}: needs must be one of {', '.join(get_args(Needs))}")
        if isinstance(self.bound, tuple) != (self.needs == "within"):
            raise UsageError(f"check {short(self.says)}: two bounds are for 'within', and one is for the others")

    @property
    def slack(self) -> float:
        """Return how far inside its bound the reading lies, in the reading's unit; below 0 where it lies outside."""
        if isinstance(self.bound, tuple):
            return min(self.reading - self.bound[0], self.bound[1] - self.reading)
        return self.reading - self.bound if self.needs in ("above", "at least") else self.bound - self.reading

    @property
    def passes(self) -> bool:
        """Return whether the reading keeps its bound."""
        return self.slack > 0.0 or (self.slack == 0.0 and self.needs not in ("above", "below"))

    @property
    def text(self) -> str:
        """The reading and its bound, in words."""
        return f"{self.says} (needs {self.bound_text})"

    @property
    def bound_text(self) -> str:
        """The bound in words, with its unit."""
        unit = f" {self.unit}" if self.unit else ""
        if self.asks:
            return self.asks
        if isinstance(self.bound, tuple):
            return f"{self.bound[0]:g} to {self.bound[1]:g}{unit}"
        return f"{self.needs} {self.bound:g}{unit}"


def exceeds(says: str, value: float, other: float, than: str, quantity: Quantity, *, scale: float = 1.0) -> Check:
    """Return the check that a mean count, or a potential, is more than another, by `MARGIN` or farther.

    Parameters
    ----------
    says
        The larger one in words, with its number.
    value, other
        Both; the reading of the check is their difference.
    than
        What the other one is, in words.
    quantity
        What both are.
    scale
        As of a `Check`.

    Examples
    --------
    >>> check = exceeds("0.3 spikes at 15 degrees", 0.3, 0.0, "at 0", "spikes")
    >>> check.passes, check.text
    (False, '0.3 spikes at 15 degrees, +0.3 against 0.0 at 0 (needs +1 or more)')
    """
    difference = round(float(value) - float(other), _PLACES)
    signed, plain = _FORM[quantity]
    text = f"{says}, {difference:{signed}} against {other:{plain}} {than}"
    return Check(text, difference, MARGIN[quantity], "at least", unit=_UNIT[quantity], scale=scale,
                 asks=f"{MARGIN[quantity]:+g} or more")  # fmt: skip


_UNIT: Mapping[Quantity, str] = {"spikes": "spikes", "potential": ""}
_FORM: Mapping[Quantity, tuple[str, str]] = {"spikes": ("+.1f", ".1f"), "potential": ("+.4f", ".4f")}
_PLACES = 9
"""Decimal places of a difference: means of counts that differ by 1 do so by a last bit less in floating point."""


def weakest(checks: Iterable[Check]) -> Check:
    """Return the check that decides: the worst that fails, or else the nearest to its bound, slack over scale.

    Parameters
    ----------
    checks
        At least one; of several that are as weak the first.

    Raises
    ------
    UsageError
        There are no checks, or something else is among them. It is a ``ValueError``.
    """
    listed = list(checks) if isinstance(checks, Iterable) else []
    if not listed or not all(isinstance(check, Check) for check in listed):
        raise UsageError(f"a judge must return one experiments.Check or more, got {short(checks)}")
    return min(listed, key=strength)


def strength(check: Check) -> tuple[bool, float]:
    """Return the key by which checks are ordered, the one that decides first; a NaN is the last of those that fail."""
    slack = check.slack / check.scale
    return check.passes, math.inf if math.isnan(slack) else slack


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
        What the weakest says: see `weakest`.

    Raises
    ------
    UsageError
        There are no checks, or something else is among them. It is a ``ValueError``.

    Examples
    --------
    >>> from experiments import Check, decide
    >>> decide([Check("3 spikes", 3, 2), Check("8 spikes", 8, 2)])
    (True, '3 spikes (needs above 2)')
    """
    check = weakest(checks)
    return check.passes, check.text


def is_number(value: Any) -> bool:
    """Return whether a table's value is a finite number; ``None``, NaN and infinities are not."""
    return value is not None and math.isfinite(value)


def unreadable(rows: Iterable[Mapping[str, Any]], columns: Sequence[str]) -> str:
    """Return how many of the rows lack a number in which of the ``columns``, in words; empty if none does."""
    listed = list(rows)
    counts = {name: sum(not is_number(row[name]) for row in listed) for name in columns}
    return "; ".join(f"{count} of {len(listed)} have no number in {name}" for name, count in counts.items() if count)
