"""How a judge decides: a claim is a list of checks, each with its distance from its bound; the weakest decides."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from importlib.resources import files
from typing import Any, Literal, get_args

from experiments.bench.core.errors import check_name, explained, short

Judged = Literal["holds", "fails", "untested"]


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
    bool, str
        Whether all pass, and what the weakest says: the worst that fails, or else the nearest to its bound.

    Examples
    --------
    >>> decide([Check("3 spikes (needs more than 2)", 1.0), Check("8 spikes (needs more than 2)", 6.0)])
    (True, '3 spikes (needs more than 2)')
    """
    weakest = min(checks, key=lambda check: (check.passes, -math.inf if math.isnan(check.slack) else check.slack))
    return all(check.passes for check in checks), weakest.said


@dataclass(frozen=True, slots=True)
class Outcome:
    """What a judge finds.

    Parameters
    ----------
    verdict
        ``holds``, ``fails`` or ``untested``.
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

    Raises
    ------
    ValueError
        ``verdict`` is none of the three.
    """

    verdict: Judged
    measured: str
    effect: str = ""
    n: int = 0
    decided: str = ""
    each: int = 0

    def __post_init__(self) -> None:
        if self.verdict not in get_args(Judged):
            raise ValueError(f"outcome: verdict={short(self.verdict)}: legal is {', '.join(get_args(Judged))}")

    def untested(self, why: str) -> Outcome:
        """The same without a verdict, and why."""
        return replace(self, verdict="untested", measured=f"{why}; measured: {self.measured}", decided="")


@dataclass(frozen=True, slots=True)
class Verdict:
    """What became of a claim.

    Attributes
    ----------
    id, says, source
        The claim, its words, and where they are from.
    verdict
        ``holds``, ``fails`` or ``untested``.
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
    seeds, seeds_holding, seeds_untested
        At how many seeds it was to be judged, at how many it holds, and at how many it could not be judged. ``None``
        where it was judged at one seed alone.
    pooled
        The same claim on the trials of all seeds together.
    tried
        What was tried to make it hold, or what limits it. Told where it fails, or holds at few seeds.
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
    seeds_holding: int | None = None
    seeds: int | None = None
    seeds_untested: int | None = None
    pooled: str = ""
    tried: str = ""


@dataclass(frozen=True, kw_only=True)
class Claim:
    """A claim: its words, and the function that judges it.

    Parameters
    ----------
    id
        Its name, as experiments declare it.
    judge
        Finds an `Outcome` from the rows of a run's table. The wings say with what arguments.
    says, source
        Its words, and where they are from. One of the paper's claims has none here: they are in ``claims.toml``.

    Raises
    ------
    ValueError
        A claim that is not the paper's lacks words, has the id of one of the paper's, or has no judge.
    """

    id: str
    judge: Callable[..., Outcome]
    says: str = ""
    source: str = ""

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
        """Return what ``experiment.json`` says of it: its id, its words and where they are from."""
        return {"id": self.id, "says": self.says, "source": self.source}

    def ask(self, rows: Sequence[Any], *more: Any) -> Outcome:
        """Return what the judge finds in ``rows``.

        A judge of a user's own that raises, or that answers something else than an `Outcome`, leaves the claim
        untested: the trials were run, and their tables count. Numbers that it left at 0 are counted here.
        """
        if not self.own:
            return self.judge(rows, *more)
        try:
            found = self.judge(rows, *more)
        except Exception as error:
            return Outcome("untested", f"its judge failed: {explained(error)}", n=len(rows))
        if not isinstance(found, Outcome):
            return Outcome("untested", f"its judge answered {short(found)}, expected an Outcome", n=len(rows))
        said, effect, decided = str(found.measured), str(found.effect), str(found.decided)
        return Outcome(found.verdict, said, effect, int(found.n) or len(rows), decided, int(found.each))

    def verdict(self, found: Outcome, **more: Any) -> Verdict:
        """Return the verdict that an outcome is; ``more`` are further fields of it."""
        return Verdict(
            self.id, self.says, self.source, found.verdict, found.measured, found.effect, found.n, found.decided, **more
        )  # fmt: skip


def check_claims(experiment: str, claims: Any) -> None:
    """Raise ``ValueError`` for claims that no experiment can declare: a tuple of ids, and of claims of one's own."""
    where = f"experiment {experiment}: claims={short(claims)}"
    if not isinstance(claims, tuple) or not all(isinstance(claim, str | Claim) for claim in claims):
        raise ValueError(f"{where}: legal is a tuple of names, and of claims of your own")
    for claim in claims:
        if isinstance(claim, Claim) and not claim.own:
            raise ValueError(f"experiment {experiment}: claim {claim.id} is the paper's: declare it by its id alone")
    ids = [claim.id for claim in claims if isinstance(claim, Claim)]
    twice = next((each for each in ids if ids.count(each) > 1), None)
    if twice is not None:
        raise ValueError(f"experiment {experiment}: two claims are called '{twice}'")


def is_number(value: Any) -> bool:
    """Whether a table's value is a finite number; ``None``, NaN and infinities are not."""
    return value is not None and math.isfinite(value)


def unreadable(rows: Iterable[Mapping[str, Any]], columns: Sequence[str]) -> str:
    """How many of the rows lack a number in which of the ``columns``, in words; empty if none does."""
    listed = list(rows)
    counts = {name: sum(not is_number(row[name]) for row in listed) for name in columns}
    return "; ".join(f"{count} of {len(listed)} have no number in {name}" for name, count in counts.items() if count)


@cache
def claim_texts() -> Mapping[str, tuple[str, str]]:
    """Claim id -> (what the paper says, the label of its figure), in order of number."""
    table = tomllib.loads(files("experiments.bench.core").joinpath("claims.toml").read_text(encoding="utf-8"))
    parts = [part for room in table.values() for part in room.values()]
    texts = {claim["id"]: (claim["says"], part["source"]) for part in parts for claim in part["claims"]}
    return dict(sorted(texts.items(), key=lambda item: int(item[0][1:])))


@cache
def tried() -> Mapping[str, str]:
    """Claim id -> what was tried to make it hold, or limits it, from ``tried.toml``."""
    return tomllib.loads(files("experiments.bench.core").joinpath("tried.toml").read_text(encoding="utf-8"))
