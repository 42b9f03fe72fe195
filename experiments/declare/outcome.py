"""Outcome of a claim in one replicate, and the reasons why it cannot be judged.

A claim is a list of checks, each a reading held against a bound; the weakest decides.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal, get_args

from experiments.base.errors import UsageError, check_known, short

Needs = Literal["above", "at least", "below", "at most", "within"]
"""Where a reading has to lie: on which side of its bound, or between two of them, ends included."""
Quantity = Literal["spikes", "potential"]
"""What claims compare: means of counts, spikes a trial, or peak potentials."""
MARGIN: Mapping[Quantity, float] = {"spikes": 1.0, "potential": 0.002}
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


Reason = Literal["judge failed", "not shown", "silent model", "unknown constants"]
"""Why a claim cannot be judged in a replicate.

``judge failed``: a user's own judge raised an error, or returned no outcome. ``not shown``: trials, clips, models or
columns that it needs are missing, too few or flawed. ``silent model``: it is kept, but by a model that does not
answer the crossings that the paper has it answer, so that a network that is always silent would keep it too.
``unknown constants``: what it says of the DSNN holds; the rest hangs on constants of another model that are not known,
whichever way it comes out with those assumed.
"""


REASONS: Mapping[Reason, str] = {
    "judge failed": "its judge went wrong",
    "not shown": "what it needs was not shown",
    "silent model": "the model keeps it, but does not answer the paper's own crossings either",
    "unknown constants": "what it says of the DSNN holds, and another model's constants are not known",
}  # fmt: skip
"""Reason -> what it means."""


MOST_LISTED = 6
"""Checks that are told one by one of a claim that has many."""


LEAST_ANSWERED = 0.5
"""Share of the translations of one kind that a model answers, below which it counts as silent there."""


Judged = Literal["holds", "fails", "judge failed", "not shown", "silent model", "unknown constants"]
"""The outcome of a claim in one replicate: it holds, it fails, or the `Reason` why it cannot be judged."""


def together(verdicts: Collection[str]) -> Judged:
    """Return the outcome of a claim from those of its parts: models, say, or clips and trials with the robot.

    Parameters
    ----------
    verdicts
        What each part came to, in any order.

    Returns
    -------
    Judged
        ``fails`` if any part fails; else, where any part cannot be judged, the first of their reasons in the order of
        `Reason`; else ``holds``.
    """
    return "fails" if "fails" in verdicts else next((reason for reason in REASONS if reason in verdicts), "holds")


@dataclass(frozen=True, slots=True)
class Outcome:
    """Outcome of a claim in one replicate, as its judge finds it.

    Parameters
    ----------
    verdict
        ``holds``, ``fails``, or the reason why it cannot be judged: see `experiments.declare.outcome.Reason`.
    measured
        The measured numbers, in words.
    effect
        The test and its effect size; empty where there is none.
    n
        Number of trials or clips; 0 stands for all that the judge was given.
    decided
        The number that decided, and its bound, as `decide` tells it.
    fewest
        Number of trials of the condition that has the fewest; 0: it is counted in what the judge was given.
    broken
        For a claim about every single trial: how many of the ``n`` trials break it; otherwise ``None``.
    trouble
        What went wrong in a user's own judge; empty if nothing did.
    checks
        Everything that was asked, each with its reading, its bound and its slack; empty where nothing could be.
    equal
        The outcome where the models that it compares with are on equal terms (`Claim.equal_terms`); ``None`` of a
        claim without, and where these were not shown.

    Raises
    ------
    ValueError
        ``verdict`` is none of these.
    """

    verdict: Judged
    measured: str
    effect: str = ""
    n: int = 0
    decided: str = ""
    fewest: int = 0
    broken: int | None = None
    trouble: str = ""
    checks: tuple[Check, ...] = ()
    equal: Outcome | None = None

    def __post_init__(self) -> None:
        check_known("verdict", self.verdict, get_args(Judged))

    @classmethod
    def of(cls, checks: Iterable[Check], measured: str = "", effect: str = "", n: int = 0, fewest: int = 0) -> Outcome:
        """Return the outcome of checks: the claim holds if all pass, and the weakest decides.

        Parameters
        ----------
        checks
            One or more.
        measured, effect, n, fewest
            As of an `Outcome`; left out, ``measured`` is what the checks say, the weakest first.

        Returns
        -------
        Outcome
            ``holds`` or ``fails``, with the weakest check in ``decided``.

        Raises
        ------
        UsageError
            There are no checks, or something else is among them.
        """
        listed = tuple(checks)
        holds, decided = decide(listed)
        texts = measured or _listed(listed)
        return cls("holds" if holds else "fails", texts, effect, n, decided, fewest, checks=listed)

    @classmethod
    def unjudged(cls, why: str, *, reason: Reason = "not shown", n: int = 0) -> Outcome:
        """Return the outcome of a claim that cannot be judged.

        Parameters
        ----------
        why
            Why, in words.
        reason
            The same in one of the words of `experiments.declare.outcome.REASONS`.
        n
            As of an `Outcome`.

        Returns
        -------
        Outcome
            The reason, with ``why`` in ``measured``.
        """
        return cls(reason, why, n=n)

    @classmethod
    def together(cls, parts: Mapping[str, Outcome]) -> Outcome:
        """Return the outcome of a claim about several models or kinds: see `together`.

        Parameters
        ----------
        parts
            What each part is called -> its outcome; one or more.

        Returns
        -------
        Outcome
            Their verdict together. Its texts name each part; ``decided`` is of the parts that decided.
        """
        verdict = together([part.verdict for part in parts.values()])
        equal = {name: part.equal for name, part in parts.items() if part.equal}
        return cls(
            verdict,
            "; ".join(f"{name} {part.verdict}: {part.measured}" for name, part in parts.items()),
            "; ".join(f"{name}: {part.effect}" for name, part in parts.items() if part.effect),
            sum(part.n for part in parts.values()),
            "; ".join(f"{name}: {part.decided}" for name, part in parts.items()
                      if part.verdict == verdict and part.decided),
            min(part.fewest for part in parts.values()),
            trouble=next((part.trouble for part in parts.values() if part.trouble), ""),
            checks=tuple(check for part in parts.values() for check in part.checks),
            equal=cls.together(equal) if len(equal) == len(parts) else None,
        )  # fmt: skip

    def settled(self) -> Outcome:
        """Return the outcome with the constants that were assumed.

        Returns
        -------
        Outcome
            The verdict of all its checks, where unknown constants left it unjudged; otherwise the same.
        """
        if self.verdict != "unknown constants":
            return self
        holds, decided = decide(self.checks)
        return replace(self, verdict="holds" if holds else "fails", decided=decided)

    @property
    def judged(self) -> bool:
        """Return whether the claim holds or fails."""
        return self.verdict in ("holds", "fails")

    @property
    def deciding(self) -> str:
        """Return what decided, in words; of a claim that could not be judged, why."""
        return self.decided or self.measured.partition("; measured:")[0]

    def withheld(self, why: str) -> Outcome:
        """Withhold the verdict.

        Parameters
        ----------
        why
            The reason, in words.

        Returns
        -------
        Outcome
            The same, ``not shown``; ``measured`` begins with the reason.
        """
        equal = self.equal.withheld(why) if self.equal else None
        return replace(self, verdict="not shown", measured=f"{why}; measured: {self.measured}", decided="", equal=equal)

    def noting(self, note: str) -> Outcome:
        """Return the outcome with a note after the measured numbers.

        Parameters
        ----------
        note
            The note; an empty one adds nothing.

        Returns
        -------
        Outcome
            The outcome with it.
        """
        return replace(self, measured="; ".join(filter(None, (self.measured, note))))

    def against_silence(self, answers: Mapping[str, Sequence[bool]], what: str) -> Outcome:
        """Return the outcome of a claim that a silent network would keep, held against the answers to translation.

        Parameters
        ----------
        answers
            Which translations -> whether the model answers each of them past its threshold.
        what
            What shows a translation: ``trial`` or ``clip``.

        Returns
        -------
        Outcome
            ``silent model`` where the claim holds, and of some of these the model answers less than half. Without
            translations it holds unchecked.
        """
        if self.verdict not in ("holds", "unknown constants"):
            return self
        answered = {name: listed for name, listed in answers.items() if listed}
        if not answered:
            return replace(self, measured=f"{self.measured}; not checked against translation (no {what} shows one)")
        silent = [f"{sum(listed)} of {len(listed)} {what}s of {name} answered"
                  for name, listed in answered.items() if sum(listed) < LEAST_ANSWERED * len(listed)]  # fmt: skip
        return self.silent(", ".join(silent)) if silent else self

    def silent(self, why: str) -> Outcome:
        """Return the outcome of a model that satisfies the claim by never responding.

        Parameters
        ----------
        why
            What the model does not respond to, in words.

        Returns
        -------
        Outcome
            The same, ``silent model``; ``measured`` begins with ``why``.
        """
        return replace(self, verdict="silent model", measured=f"{why}; measured: {self.measured}", decided=why)


def _listed(checks: Sequence[Check]) -> str:
    """What the checks say; of many how many pass, and the first of those in the order in which they decide."""
    if len(checks) <= MOST_LISTED:
        return "; ".join(check.says for check in checks)
    first = sorted(checks, key=strength)[:MOST_LISTED]
    passing = sum(check.passes for check in checks)
    return f"{passing} of {len(checks)} checks pass; the weakest: {'; '.join(check.says for check in first)}"
