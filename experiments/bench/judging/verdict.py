"""What a judge finds, what becomes of a claim, and a claim itself: its words and its judge."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal, get_args

from experiments.bench.engine import interrupts
from experiments.bench.engine.errors import check_name, short
from experiments.bench.engine.user_code import apart, blamed
from experiments.bench.judging.checks import Check as Check
from experiments.bench.judging.checks import decide as decide
from experiments.bench.judging.texts import claim_texts

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

    def __post_init__(self) -> None:
        if self.verdict not in get_args(Judged):
            raise ValueError(f"outcome: verdict={short(self.verdict)}: legal is {', '.join(get_args(Judged))}")

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
        why = f"silent in all {of} {what}s of translation too"
        return replace(self, verdict="vacuous", measured=f"{why}; measured: {self.measured}", decided=why)


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


@dataclass(frozen=True, kw_only=True)
class Claim:
    """A claim: its words, which one of the paper's has in ``claims.toml``, and its judge; the wings' say more of them.

    Raises
    ------
    ValueError
        A claim that is not the paper's lacks words, has the id of one of the paper's, or has no judge.
    """

    id: str
    judge: Callable[..., Outcome]
    says: str = ""
    source: str = ""
    silent_passes: bool = False

    def __post_init__(self) -> None:
        check_name("claim", self.id)
        if not callable(self.judge):
            raise ValueError(f"claim {self.id}: judge={short(self.judge)}: legal is a function")
        for name in ("says", "source"):
            if not isinstance(getattr(self, name), str):
                raise ValueError(f"claim {self.id}: {name}={short(getattr(self, name))}: legal is a text")
        if self.says and not self.own:
            raise ValueError(f"claim {self.id}: one of the paper's claims has that id; give yours another")
        if not self.says and self.own:
            raise ValueError(f"claim {self.id}: says='': a claim of your own needs words")
        if not self.own:
            says, source = claim_texts()[self.id]
            object.__setattr__(self, "says", says)
            object.__setattr__(self, "source", source)

    @property
    def own(self) -> bool:
        """Whether it is none of the paper's."""
        return self.id not in claim_texts()

    def described(self) -> dict[str, str]:
        """Describe the claim as ``experiment.json`` does.

        Returns
        -------
        dict of str to str
            ``id``, ``says`` and ``source``.
        """
        return {"id": self.id, "says": self.says, "source": self.source}

    def ask(self, rows: Sequence[Any], *more: Any) -> Outcome:
        """Ask the judge.

        A user's own judge that raises, or answers no `Outcome`, leaves the claim untested: the tables count.

        Parameters
        ----------
        rows, *more
            Rows of a run's table, and what the judge gets beside them.

        Returns
        -------
        Outcome
            What the judge finds.
        """
        if not self.own:
            return self.judge(rows, *more)
        copies = [dict(row) for row in rows]  # what a judge changes is its own
        try:
            answer = apart(lambda: self.judge(copies, *more))
            if not isinstance(answer, Outcome):
                return _broken(f"its judge answered {short(answer)}, expected an Outcome", len(rows))
            texts = str(answer.measured), str(answer.effect)
            return Outcome(
                answer.verdict, *texts, int(answer.n) or len(rows), str(answer.decided), int(answer.each), answer.broken
            )  # fmt: skip
        except BaseException as error:  # SystemExit too: sys.exit in a judge ends the judge
            interrupts.pass_on(error)
            return _broken(f"its judge failed: {blamed(error, rows)}", len(rows))

    def verdict(self, found: Outcome, **more: Any) -> Verdict:
        """Make a verdict of an outcome.

        Parameters
        ----------
        found
            The outcome.
        **more
            Further fields of the verdict.

        Returns
        -------
        Verdict
            The verdict.
        """
        return Verdict(
            self.id, self.says, self.source, found.verdict, found.measured, found.effect, found.n, found.decided,
            **{"trouble": found.trouble, **more},
        )  # fmt: skip


def _broken(trouble: str, rows: int) -> Outcome:
    return Outcome("untested", trouble, n=rows, trouble=trouble)
