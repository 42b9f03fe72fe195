"""What the verdicts of a claim in several replicates come to. One place decides, and says it in words.

A replicate is the paper's own design, run once at one seed: every condition, ten trials of each. A claim is judged
anew in each replicate, and what is reported is in how many of them it held.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

from experiments.bench.judging.overall import Overall

LEAST_FOR_STANDING = 20
"""Replicates below which a claim is neither robust nor fragile: what is known is told as "so far"."""
ROBUST_SHARE = 0.9
"""Of the replicates, the share in which a robust claim holds: 18 of 20."""

Standing = Literal["robust", "fragile", "never held", "so far", "deterministic", "untestable", "unjudged"]

UNKNOWN = "another model's constants are not known"
"""Why a claim is untestable."""


@dataclass(frozen=True, slots=True)
class Replicates:
    """In how many replicates a claim came to each verdict.

    Parameters
    ----------
    held, failed, vacuous, untested
        Number of replicates, 0 or more. They add up to one or more.
    random
        Whether replicates differ. Where nothing is random, one says all.
    name
        What a replicate is called where it is not a whole one.
    untestable
        As the first four.

    Raises
    ------
    ValueError
        A number is negative, or there is no replicate.
    """

    held: int
    failed: int = 0
    vacuous: int = 0
    untested: int = 0
    random: bool = True
    name: str = "replicate"
    untestable: int = 0

    def __post_init__(self) -> None:
        for what in ("held", "failed", "vacuous", "untested", "untestable"):
            if getattr(self, what) < 0:
                raise ValueError(f"replicates: {what}={getattr(self, what)}: legal is 0 or more")
        if not self.of:
            raise ValueError("replicates: none at all: legal is one or more")

    @property
    def of(self) -> int:
        """The number of replicates in all."""
        return self.held + self.failed + self.vacuous + self.untested + self.untestable

    @property
    def standing(self) -> Standing:
        """What the counts come to.

        ``unjudged`` where the claim could be judged in none; ``untestable`` where it was in some, and did not hold in
        90 % of all; ``deterministic`` where nothing is random, ``so far`` below 20 replicates; from there ``robust``
        if it held in 18 of 20 (90 %) or more, ``never held`` in none, and ``fragile``
        otherwise. A replicate in which the claim was vacuous or could not be judged counts as one in which it did not
        hold.
        """
        if self.untested == self.of:
            return "unjudged"
        most = self.held >= ROBUST_SHARE * self.of
        if self.untestable and not most:
            return "untestable"
        if not self.random:
            return "deterministic"
        if self.of < LEAST_FOR_STANDING:
            return "so far"
        return "robust" if most else "fragile" if self.held else "never held"

    @property
    def overall(self) -> Overall:
        """What the counts come to in one word: see `experiments.bench.judging.overall.MEANINGS`.

        A claim that held in at least 90 % of 20 replicates or more, or in all of fewer, holds. One that held in none
        fails if it failed in any.
        """
        if self.standing == "unjudged":
            return "untested"
        if self.standing == "untestable":
            return "untestable"
        many = self.of >= LEAST_FOR_STANDING
        if self.held == self.of or (many and self.held >= ROBUST_SHARE * self.of):
            return "holds"
        if self.held:
            return "fragile" if many else "mixed"
        return "fails" if self.failed else "vacuous"

    def __str__(self) -> str:
        """The standing as a sentence that says what held: ``held in 17 of 20 replicates: fragile``."""
        if self.standing == "unjudged":
            return f"could not be judged in any of {self._counted()}"
        if self.standing == "untestable":
            rest = self.of - self.untestable
            also = f"; held in {self.held} of the other {rest}" if rest else ""
            return f"untestable in {self.untestable} of {self._counted()}: {UNKNOWN}{also}"
        parts = [f"held in {self.held} of {self._counted()}"]
        if self.standing == "deterministic":
            parts.append("; nothing in it is random")
        elif self.standing == "so far":
            parts.append(" so far")
        else:
            parts.append(f": {self.standing if self.held else 'it never held'}")
        others = {"vacuous": self.vacuous, "untestable": self.untestable, "not judged": self.untested}
        parts += [f"; {word} in {number}" for word, number in others.items() if number]
        return "".join(parts)

    def _counted(self) -> str:
        return f"{self.of} {self.name}{'s' * (self.of != 1)}"

    def fields(self) -> dict[str, Any]:
        """The fields of an `experiments.bench.judging.verdict.Verdict` that tell of replicates."""
        return {
            "replicates": self.of, "replicates_held": self.held, "replicates_failed": self.failed,
            "replicates_vacuous": self.vacuous, "replicates_untestable": self.untestable,
            "replicates_untested": self.untested, "standing": self.standing, "held": str(self),
            "overall": self.overall,
        }  # fmt: skip


def counted(verdicts: Sequence[str], *, random: bool = True, name: str = "replicate") -> Replicates:
    """Count the verdicts of a claim, one of each replicate.

    Parameters
    ----------
    verdicts
        ``holds``, ``fails``, ``vacuous``, ``untestable`` or ``untested``, one or more.
    random, name
        As of `Replicates`.
    """
    held, failed, vacuous, untested = map(verdicts.count, ("holds", "fails", "vacuous", "untested"))
    return Replicates(held, failed, vacuous, untested, random, name, verdicts.count("untestable"))
