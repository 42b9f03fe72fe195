"""The verdict on a claim over all its replicates: the count of those in which it held, and the one word that follows.

A replicate is the paper's own design, run once at one seed. In each a claim holds, fails, or cannot be judged. What
differs between replicates is the seed: placement, light, wall, noise. The word is about these, and not about the world.

``claims.json``, ``behaviours.json`` and ``model_claims.json`` have one form: an object with ``claims``. Each has
``id``, ``title``, ``says``, ``source``, ``model``, ``experiment`` and ``trouble`` as a `Verdict` has them, and

- ``word``: ``holds``, ``fails``, ``sometimes``, or empty where too few replicates could be judged for a word;
- ``count``: the numbers ``holds`` and ``fails`` of replicates, ``unjudged`` (reason -> number), and ``random``, which
  is false where nothing differs between replicates;
- ``interval``: the two ends of the exact 95 % interval of the share of judged replicates in which it holds, or null;
- ``outcome``: what was found in the first replicate, as an `Outcome` has it;
- ``equal_terms``: the count where the models that it compares with are on equal terms, or null. ``equal`` in
  ``outcome`` is the outcome there;
- ``decisions``: for each replicate its ``verdict`` and ``check``, the one that decided there, or null.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, fields, is_dataclass
from numbers import Real
from typing import Any, Literal

from pydantic import TypeAdapter

from experiments.declare.claim import Claim
from experiments.declare.outcome import REASONS, Check, Judged, Outcome, Reason, weakest
from experiments.judge.tests import proportion_interval

Word = Literal["holds", "fails", "sometimes", ""]
"""A claim's word over its replicates; empty where too few could be judged for a word."""
State = Literal["holds", "sometimes", "fails", "counted", "unjudged"]
"""A word; or ``counted``, where too few could be judged for one; or ``unjudged``, where none could."""


LEAST_JUDGED = 20
"""Replicates that could be judged, below which there is no word, just the count."""
HOLDS_FROM, FAILS_TO = 0.8, 0.2
"""A claim holds where the lower end of the interval is at least the first, and fails where the upper end is at most the
second."""


@dataclass(frozen=True, slots=True)
class Count:
    """Numbers of replicates in which a claim held, failed, or could not be judged.

    Parameters
    ----------
    holds, fails
        Numbers of replicates, 0 or more.
    unjudged
        Reason -> number of replicates that could not be judged for it; without reasons of none.
    random
        Whether anything differs between replicates. Where nothing does, one says all.

    Examples
    --------
    >>> count = Count(38, 2)
    >>> count.word, str(count)
    ('holds', '38 of 40')
    >>> Count(4, 1, {"not shown": 1}).word
    ''
    """

    holds: int
    fails: int = 0
    unjudged: Mapping[Reason, int] = field(default_factory=dict)
    random: bool = True

    def __post_init__(self) -> None:
        there: dict[Reason, int] = {name: self.unjudged[name] for name in REASONS if self.unjudged.get(name)}
        object.__setattr__(self, "unjudged", there)

    @property
    def judged(self) -> int:
        """The number of replicates that could be judged."""
        return self.holds + self.fails

    @property
    def replicates(self) -> int:
        """The number of all replicates."""
        return self.judged + sum(self.unjudged.values())

    @property
    def interval(self) -> tuple[float, float] | None:
        """The exact 95 % interval of the share of judged replicates in which the claim holds (Clopper and Pearson).

        ``None`` where none was judged, or where nothing is random.
        """
        return proportion_interval(self.holds, self.judged) if self.judged and self.random else None

    @property
    def half(self) -> Count | None:
        """The count of what a claim says of the DSNN alone; ``None`` where it hangs on no unknown constants.

        Where that fails the claim fails; where it holds the claim cannot be judged.
        """
        held = self.unjudged.get("unknown constants", 0)
        others: dict[Reason, int] = {**self.unjudged, "unknown constants": 0}
        return Count(held, self.fails, others, self.random) if held and not self.holds else None

    @property
    def word(self) -> Word:
        """Return the verdict on the count.

        Where nothing is random: ``holds`` or ``fails``. Otherwise, from `LEAST_JUDGED` judged replicates up: ``holds``
        where the lower end of the interval is at least `HOLDS_FROM`, ``fails`` where its upper end is at most
        `FAILS_TO`, else ``sometimes``. Below, or where none was judged, there is no word. A claim that hangs on unknown
        constants fails where its `half` does, and has no other word: the replicates in which that half holds would
        leave the count, and those that are left all fail.
        """
        if self.half is not None:
            return "fails" if self.half.word == "fails" else ""
        if self.judged and not self.random:
            return "fails" if self.fails else "holds"
        if self.judged < LEAST_JUDGED:
            return ""
        low, high = proportion_interval(self.holds, self.judged)
        return "holds" if low >= HOLDS_FROM else "fails" if high <= FAILS_TO else "sometimes"

    @property
    def state(self) -> State:
        """The word; or whether it lacks one for too few replicates, or for none that could be judged."""
        return self.word or ("counted" if self.judged and self.half is None else "unjudged")

    @property
    def label(self) -> str:
        """The word; without one ``4 of 5``, or ``not judged``."""
        return self.word or (f"{self.holds} of {self.judged}" if self.state == "counted" else "not judged")

    def sentence(self) -> str:
        """Say in how many replicates the claim held, and why others could not be judged.

        Examples
        --------
        >>> Count(17, 2, {"not shown": 1}).sentence()
        'holds in 17 of 19 replicates; not judged in 1: what it needs was not shown'
        >>> Count(1, random=False).sentence()
        'holds; nothing in it is random'
        """
        reasons = [f"not judged in {number}: {REASONS[reason]}" for reason, number in self.unjudged.items()]
        if self.half is not None:
            constants = "another model's constants are not known"
            return f"not judged, as {constants}; the DSNN's half {self.half.sentence()}"
        if not self.judged:
            whole = "not judged" if self.replicates == 1 else f"not judged in any of {self.replicates} replicates"
            return "; ".join([whole, *(REASONS[reason] for reason in self.unjudged)])
        if self.random and self.replicates > 1:
            first = f"{'holds' if self.holds else 'fails'} in {self.holds or self.fails} of {self.judged} replicate"
            first += "s" * (self.judged != 1)
        else:
            first = f"{'fails' if self.fails else 'holds'}{'' if self.random else '; nothing in it is random'}"
        return "; ".join([first, *reasons])

    def __str__(self) -> str:
        """Say in how many of the judged replicates it held, and what of others: ``17 of 19 (silent model in 1)``."""
        reasons = ", ".join(f"{reason} in {number}" for reason, number in self.unjudged.items())
        if self.half is not None:
            return f"not judged: unknown constants; the DSNN's half {self.half}"
        if not self.judged:
            return f"not judged: {reasons}"
        return f"{self.holds} of {self.judged}" + (f" ({reasons})" if reasons else "")


def count(outcomes: Iterable[str], *, random: bool = True) -> Count:
    """Count what a claim came to in each replicate.

    Parameters
    ----------
    outcomes
        ``holds``, ``fails`` or one of `Reason` for each replicate, one or more.
    random
        As of `Count`.
    """
    found: Counter[Any] = Counter(outcomes)
    return Count(found.pop("holds", 0), found.pop("fails", 0), found, random)


def count_columns(counted: Count) -> dict[str, Any]:
    """Return a count as columns: ``holds``, ``fails``, each reason, all replicates, the interval and the verdict."""
    low, high = counted.interval or (None, None)
    reasons = {str(reason): counted.unjudged.get(reason, 0) for reason in REASONS}
    return {"holds": counted.holds, "fails": counted.fails, **reasons, "replicates": counted.replicates, "low": low,
            "high": high, "word": counted.word}  # fmt: skip


def count_of(columns: Mapping[str, Any]) -> Count:
    """Return the count whose columns these are (`count_columns`): one that was judged and has no interval is of all."""
    judged = columns["holds"] + columns["fails"]
    reasons = {reason: columns[reason] for reason in REASONS if columns.get(reason)}
    return Count(columns["holds"], columns["fails"], reasons, not judged or columns["low"] is not None)


@dataclass(frozen=True, slots=True)
class Verdict:
    """Verdict on a claim over all its replicates.

    Attributes
    ----------
    id, says, source
        The claim, its words, and where they are from.
    outcome
        What was found in the first replicate: its numbers are those that are reported with the count.
    count
        In how many replicates it held; a single run is one replicate.
    model
        The model it is about; empty where the claim itself names its models.
    experiment
        The experiments, or the env, whose trials answer for it; empty where nothing here judges it.
    trouble
        What went wrong in a user's own judge, in any replicate; empty if nothing did.
    equal
        In how many replicates it held with the models that it compares with on equal terms; ``None`` of a claim that
        compares with none, or where these were not shown.
    decisions
        What it came to in each replicate, the first one first, and the weakest check there, if anything was asked.
    title
        The claim in a few words, or empty.
    """

    id: str
    says: str
    source: str
    outcome: Outcome
    count: Count
    model: str = ""
    experiment: str = ""
    trouble: str = ""
    equal: Count | None = None
    decisions: tuple[tuple[Judged, Check | None], ...] = ()
    title: str = ""

    @property
    def numbers(self) -> tuple[str, str]:
        """The number that decided in the first replicate, and what the claim needs there; both empty without one."""
        check = self.decisions[0][1] if self.decisions else None
        return (check.says, check.bound_text) if check else ("", "")


def verdict_of(
    claim: Claim, outcomes: Sequence[Outcome], *, random: bool = True, model: str = "", experiment: str = ""
) -> Verdict:
    """Return the verdict on a claim over its replicates: the first outcome, and the count of all.

    Parameters
    ----------
    claim
        The claim.
    outcomes
        One of each replicate, the first one first.
    random
        Whether anything differs between replicates.
    model, experiment
        As of a `Verdict`.

    Returns
    -------
    Verdict
        The verdict.
    """
    again = [outcome.equal.verdict if outcome.equal else "not shown" for outcome in outcomes]
    return Verdict(
        claim.id, claim.says, claim.source, outcomes[0], count([one.verdict for one in outcomes], random=random),
        model, experiment, trouble=next((one.trouble for one in outcomes if one.trouble), ""),
        equal=count(again, random=random) if any(one.equal for one in outcomes) else None,
        decisions=tuple((one.verdict, weakest(one.checks) if one.checks else None) for one in outcomes),
        title=claim.title,
    )  # fmt: skip


_READ = TypeAdapter(Verdict)


def document(verdicts: Sequence[Verdict]) -> dict[str, Any]:
    """Return what a file of verdicts holds."""
    return {"claims": [_entry(verdict) for verdict in verdicts]}


def _entry(verdict: Verdict) -> dict[str, Any]:
    fields, count = plain(verdict), verdict.count
    decisions = [{"verdict": came_to, "check": plain(check)} for came_to, check in verdict.decisions]
    more = {"equal_terms": fields.pop("equal"), "word": count.word, "interval": count.interval}
    return {**fields, **more, "decisions": decisions}


def plain(value: Any) -> Any:
    """Return a record as JSON has it; a number that is not finite, for which JSON has none, stands as a text."""
    if is_dataclass(value):
        return {field.name: plain(getattr(value, field.name)) for field in fields(value)}
    if isinstance(value, tuple):
        return [plain(part) for part in value]
    if isinstance(value, Real) and not isinstance(value, int):
        return float(value) if math.isfinite(value) else str(float(value))
    return value


def verdicts(content: Mapping[str, Any]) -> list[Verdict]:
    """Return the verdicts that a file's JSON holds."""
    rows = (
        {**row, "equal": row["equal_terms"], "decisions": [(one["verdict"], one["check"]) for one in row["decisions"]]}
        for row in content["claims"]
    )
    return [_READ.validate_python(row) for row in rows]
