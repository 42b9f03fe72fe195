"""Outcome of a claim in one replicate, and the reasons why it cannot be judged."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Literal, get_args

from experiments.base.errors import check_known
from experiments.declare.checks import Check, decide, strength

Reason = Literal["judge failed", "not shown", "silent model", "unknown constants"]
"""Why a claim cannot be judged in a replicate.

``judge failed``: a user's own judge raised an error, or returned no outcome. ``not shown``: trials, clips, models or
columns that it needs are missing, too few or flawed. ``silent model``: it is kept, but by a model that does not
answer the crossings that the paper has it answer, so that a network that is always silent would keep it too.
``unknown constants``: what it says of the DSNN holds; the rest hangs on constants of another model that are not known,
whichever way it comes out with those assumed.
"""


REASONS: Mapping[Reason, str] = MappingProxyType({
    "judge failed": "its judge went wrong",
    "not shown": "what it needs was not shown",
    "silent model": "the model keeps it, but does not answer the paper's own crossings either",
    "unknown constants": "what it says of the DSNN holds, and another model's constants are not known",
})  # fmt: skip
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
