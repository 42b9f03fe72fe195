"""What a judge finds, and what becomes of a claim."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Literal, get_args

from experiments.bench.engine.errors import short
from experiments.bench.judging.checks import Check as Check
from experiments.bench.judging.checks import decide as decide
from experiments.bench.judging.count import Reason

Judged = Literal["holds", "fails", "vacuous", "untestable", "untested"]
"""What a claim comes to.

``vacuous``: the claim is kept, but by a model that answers nothing, which a silent network would keep too.
``untestable``: what the claim says of the DSNN holds; what it says of another model does not, but that model's own
constants are not known, and with others than those assumed it may.
"""

WORST_FIRST: tuple[Judged, ...] = ("fails", "untested", "untestable", "vacuous")


def together(verdicts: Collection[Judged]) -> Judged:
    """What several verdicts come to together: ``holds`` if all do, else the first that is there of `WORST_FIRST`."""
    return next((word for word in WORST_FIRST if word in verdicts), "holds")


_UNJUDGED: Mapping[Reason, Judged] = {
    "not shown": "untested",
    "silent model": "vacuous",
    "unknown constants": "untestable",
}


@dataclass(frozen=True, slots=True)
class Outcome:
    """What a judge finds.

    Parameters
    ----------
    verdict
        ``holds``, ``fails``, ``untestable`` or ``untested``; ``vacuous`` is found by the bench.
    measured
        The measured numbers, in words.
    effect
        The test and its effect size; empty where there is none.
    n
        Number of trials or clips; 0 stands for all that the judge was given.
    decided
        The number that decided, and its bound, as `decide` tells it.
    each
        Number of trials of the condition that has the fewest; 0: it is counted in what the judge was given.
    broken
        Of a claim about every single trial: how many of the ``n`` trials break it. ``None`` of any other claim.
    trouble
        What went wrong in a user's own judge; empty if nothing did.
    checks
        Everything that was asked, each with its reading, its bound and its slack; empty where nothing could be.

    Raises
    ------
    ValueError
        ``verdict`` is none of the five.
    """

    verdict: Judged
    measured: str
    effect: str = ""
    n: int = 0
    decided: str = ""
    each: int = 0
    broken: int | None = None
    trouble: str = ""
    checks: tuple[Check, ...] = ()

    def __post_init__(self) -> None:
        if self.verdict not in get_args(Judged):
            raise ValueError(f"outcome: verdict={short(self.verdict)}: legal is {', '.join(get_args(Judged))}")

    @classmethod
    def of(
        cls, checks: Iterable[Check], measured: str = "", effect: str = "", n: int = 0, each: int = 0
    ) -> Outcome:  # fmt: skip
        """Return what checks come to: the claim holds if all pass, and the weakest decides.

        Parameters
        ----------
        checks
            One or more.
        measured, effect, n, each
            As of an `Outcome`.

        Raises
        ------
        UsageError
            There are no checks, or something else is among them.
        """
        listed = tuple(checks)
        holds, decided = decide(listed)
        return cls("holds" if holds else "fails", measured, effect, n, decided, each, checks=listed)

    @classmethod
    def unjudged(
        cls, why: str, *, reason: Reason = "not shown", effect: str = "", n: int = 0, each: int = 0,
        checks: Iterable[Check] = (),
    ) -> Outcome:  # fmt: skip
        """Return the outcome of a claim that cannot be judged.

        Parameters
        ----------
        why
            Why, in words.
        reason
            The same in one of the words of `experiments.bench.judging.count.REASONS`.
        effect, n, each, checks
            As of an `Outcome`.
        """
        return cls(_UNJUDGED[reason], why, effect, n, each=each, checks=tuple(checks))

    def untested(self, why: str) -> Outcome:
        """Withhold the verdict.

        Parameters
        ----------
        why
            The reason, in words.

        Returns
        -------
        Outcome
            The same, ``untested``; ``measured`` has the reason.
        """
        return replace(self, verdict="untested", measured=f"{why}; measured: {self.measured}", decided="")

    def against_silence(self, answering: int, of: int, what: str) -> Outcome:
        """The outcome of a claim that a silent network would keep, held against the model's answers to translation.

        Parameters
        ----------
        answering, of
            How many of how many translations the model answers past its threshold.
        what
            What shows a translation: ``trial`` or ``clip``.

        Returns
        -------
        Outcome
            ``vacuous`` where the claim holds and no translation is answered. Without translations it holds unchecked.
        """
        if self.verdict != "holds" or answering:
            return self
        if not of:
            return replace(self, measured=f"{self.measured}; not checked against translation (no {what} shows one)")
        return self.silent(f"silent in all {of} {what}s of translation too")

    def silent(self, why: str) -> Outcome:
        """Return the same of a model that keeps the claim by never answering; ``why`` says what it does not answer."""
        return replace(
            self, verdict=_UNJUDGED["silent model"], measured=f"{why}; measured: {self.measured}", decided=why
        )


@dataclass(frozen=True, slots=True)
class Verdict:
    """What became of a claim.

    Attributes
    ----------
    id, says, source
        The claim, its words, and where they are from.
    verdict
        ``holds``, ``fails``, ``vacuous``, ``untestable`` or ``untested``. Of a claim with replicates it is that of
        replicate 0.
    measured
        The numbers it was judged by.
    effect
        The test and its effect size; empty where there is none.
    n
        Number of trials, clips or episodes.
    decided
        The number that decided, and its bound: of a claim that fails the worst that misses its bound, of one that
        holds the nearest to it. Empty where the claim is untested.
    model
        The model it is about; empty where the claim itself names its models.
    experiment
        The experiment, or the env, whose trials answer for it.
    replicates, replicates_held, replicates_failed, replicates_vacuous, replicates_untestable, replicates_untested
        In how many replicates it was to be judged, and in how many of them it came to each verdict. ``None`` where
        replicates were not counted.
    standing, held, overall
        What these numbers come to: in a word, in words, and in one of the words of ``verdict``, ``fragile`` or
        ``mixed``. Empty where replicates were not counted; ``overall`` of a claim that nothing judges is ``untested``.
    interval
        The exact 95 % interval of the share of replicates in which it holds, or why there is none.
    rate
        Of a claim about every single trial: the share of the trials of all replicates that break it.
    pooled
        The same claim on the trials of all replicates together.
    tried
        What was tried to make it hold, or what limits it. Told where it fails, or does not hold in all replicates.
    used_to_choose
        The readings of the paper that were chosen because this claim favoured them.
    mechanism
        Where it is shown why the claim comes out as it does: the experiment, what its figure draws, and its numbers.
    other_reading
        What the claim comes to under the readings of the paper that were not taken, beside those taken.
    assumed
        Of a claim that compares models: what is assumed of the other one, and with which of its constants it holds.
    provenance
        Where the trials come from: ``measured``, say, of a real robot's; empty where they are simulated.
    trouble
        What went wrong in a user's own judge, in any replicate; empty if nothing did.

    Raises
    ------
    ValueError
        Verdict and counts contradict each other: replicate 0 is one of the replicates.
    """

    id: str
    says: str
    source: str
    verdict: Judged
    measured: str
    effect: str = ""
    n: int = 0
    decided: str = ""
    model: str = ""
    experiment: str = ""
    replicates: int | None = None
    replicates_held: int | None = None
    replicates_failed: int | None = None
    replicates_vacuous: int | None = None
    replicates_untestable: int | None = None
    replicates_untested: int | None = None
    standing: str = ""
    held: str = ""
    overall: str = ""
    interval: str = ""
    rate: str = ""
    pooled: str = ""
    tried: str = ""
    used_to_choose: str = ""
    mechanism: str = ""
    other_reading: str = ""
    assumed: str = ""
    provenance: str = ""
    trouble: str = ""

    @property
    def word(self) -> str:
        """The verdict that tiles and tables show: that of all replicates, or of the only one."""
        return self.overall or self.verdict

    def __post_init__(self) -> None:
        if self.replicates is None:
            return
        counts = {
            "holds": self.replicates_held, "fails": self.replicates_failed, "vacuous": self.replicates_vacuous,
            "untestable": self.replicates_untestable, "untested": self.replicates_untested,
        }  # fmt: skip
        if None in counts.values() or sum(n or 0 for n in counts.values()) != self.replicates:
            raise ValueError(f"claim {self.id}: {counts} do not add up to {self.replicates} replicates")
        if not counts[self.verdict]:
            raise ValueError(f"claim {self.id}: {self.verdict} in replicate 0, and in 0 of {self.replicates}")
