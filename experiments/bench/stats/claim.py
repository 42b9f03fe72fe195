"""A claim: its words and its judge; and the claims that ship, by id.

The words of those that ship are in ``experiments/claims/claims.toml``. Their judges are in the modules beside it: each
kind of claim names its own, which is imported when a claim of that kind is asked for.
"""

from __future__ import annotations

import dataclasses
import importlib
import tomllib
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from functools import cache
from importlib import resources
from typing import Any, ClassVar, TypeVar

from experiments.bench.run.errors import check_name, short
from experiments.bench.run.user_code import traced
from experiments.bench.stats.verdict import Outcome, Verdict, Words

PACKAGE = "experiments.claims"
PAPER, BEHAVIOURS = "C", "B"
"""The letters of the ids: claims of the paper, and ours about behaviours."""


@dataclass(frozen=True, kw_only=True)
class Claim(Words):
    """A claim: its words and its judge. Each kind of trial has a kind of claim, which says what its judge receives.

    Parameters
    ----------
    id
        Its name in tables: up to 60 letters, digits, ``.``, ``-`` and ``_``. The ids of claims that ship are taken.
    judge
        From the trials that it is about to its checks, or to an `Outcome`.
    silent_passes
        Whether a model that never responds would satisfy it.
    equal_terms
        Label of a model that it compares with -> that of the same model with its gain matched. With these in place of
        those it is judged a second time.
    title, says, source, cause, tried, eye, implied, of_dsnn, mechanism
        As of `Words`.

    Raises
    ------
    ValueError
        It has no words, or its id is taken.
    """

    module: ClassVar[str] = ""
    """The module of `PACKAGE` that has the judges of this kind."""

    judge: Callable[..., Outcome | Iterable[Any]]
    silent_passes: bool = False
    equal_terms: Mapping[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        check_name("claim", self.id)
        if not callable(self.judge):
            raise ValueError(f"claim {self.id}: the judge must be a function, got {short(self.judge)}")
        if not self.own and not self.judge.__module__.startswith(f"{PACKAGE}."):
            raise ValueError(f"claim {self.id}: a claim that ships has this id; give yours another")
        if not self.says:
            raise ValueError(f"claim {self.id}: it needs words, as says='...'")

    @property
    def own(self) -> bool:
        """Return whether it is a user's own, and none of those that ship."""
        return self.id not in claim_ids()

    def on_equal_terms(self, rows: Iterable[Mapping[str, Any]]) -> list[Mapping[str, Any]]:
        """Return the rows that it is judged on a second time; none where no model was shown on equal terms.

        Parameters
        ----------
        rows
            Rows of a run's table.

        Returns
        -------
        list
            The same rows, those of the models on equal terms under the labels of the models that they stand for.
        """
        rows = list(rows)
        labels = {equal: label for label, equal in self.equal_terms.items()}
        if not labels or not labels.keys() <= {row["model"] for row in rows}:
            return []
        plain = (row for row in rows if row["model"] not in {*labels, *labels.values()})
        return [*plain, *({**row, "model": labels[row["model"]]} for row in rows if row["model"] in labels)]

    def described(self) -> dict[str, str]:
        """Describe the claim as a run does.

        Returns
        -------
        dict of str to str
            ``id``, ``says`` and ``source``.
        """
        return {"id": self.id, "says": self.says, "source": self.source}

    def ask(self, trials: Any, *more: Any) -> Outcome:
        """Ask the judge. A user's judge that raises leaves the claim unjudged: the tables count.

        Parameters
        ----------
        trials, *more
            The trials that the claim is about, and what the judge receives beside them.

        Returns
        -------
        Outcome
            What the judge finds.
        """
        if not self.own:
            return _outcome(self.judge(trials, *more))
        if not len(trials):  # every trial of the model failed: a judge need not expect that
            return Outcome.unjudged("nothing to judge it on was shown")
        try:
            outcome = _outcome(self.judge(trials, *more))
        except Exception as error:
            why = f"its judge raised {type(error).__name__}"
            outcome = dataclasses.replace(Outcome.unjudged(why, reason="judge failed"), trouble=traced(error))
        return outcome if outcome.n else dataclasses.replace(outcome, n=len(trials))


def _outcome(answer: Any) -> Outcome:
    if not isinstance(answer, Outcome | list | tuple):
        raise TypeError(f"a judge must return a list of checks or an Outcome, got {short(answer)}")
    return answer if isinstance(answer, Outcome) else Outcome.of(answer)


Kind = TypeVar("Kind", bound=Claim)
Judge = TypeVar("Judge", bound=Callable[..., Any])
_SHIPPED: dict[str, dict[str, Claim]] = {}
"""Module of `PACKAGE` -> id -> claim, of the modules imported so far."""


def shipped(kind: type[Claim], claim: str, **fields: Any) -> Callable[[Judge], Judge]:
    """Return a decorator that declares a claim that ships: the function is its judge, ``claims.toml`` has its words.

    Parameters
    ----------
    kind
        The kind of claim.
    claim
        Its id.
    **fields
        What the kind needs beside words and judge.
    """

    def declare(judge: Judge) -> Judge:
        declaration = kind(judge=judge, **vars(words(claim)), **fields)
        _SHIPPED.setdefault(kind.module, {})[claim] = declaration
        return judge

    return declare


@cache
def texts() -> Mapping[str, Any]:
    """Return the tables of ``claims.toml``; line breaks inside a text are spaces."""
    return dict(_joined(tomllib.loads(resources.files(PACKAGE).joinpath("claims.toml").read_text("utf-8"))))


def _joined(value: Any) -> Any:
    return {k: _joined(v) for k, v in value.items()} if isinstance(value, dict) else " ".join(value.split())


def claim_ids(letter: str = "") -> tuple[str, ...]:
    """Return the ids of the claims that ship, in order, the paper's first; of one ``letter`` those alone."""
    return tuple(name for name in texts() if name.startswith(letter) and name not in ("mechanisms", "papers"))


@cache
def words(claim: str) -> Words:
    """Return the words of a claim that ships, by its id."""
    table = dict(texts()[claim])
    name = table.pop("mechanism", "")
    return Words(id=claim, **table, mechanism=(name, texts()["mechanisms"].get(name, "")))


def title_of(verdict: Verdict) -> str:
    """Return a claim in a few words: its title, or the words of a user's own that has none."""
    return words(verdict.id).title if verdict.id in claim_ids() else verdict.title or verdict.says


def of_kind(kind: type[Kind]) -> Mapping[str, Kind]:
    """Return id -> claim, of those that ship and are of one kind, in the order of their ids."""
    importlib.import_module(f"{PACKAGE}.{kind.module}")
    declared: Mapping[str, Any] = _SHIPPED[kind.module]
    return {claim: declared[claim] for claim in claim_ids() if claim in declared}


def find_claim(claim: Claim | str, kind: type[Kind]) -> Kind:
    """Return a claim of one kind by its id; one of a user's own stands for itself.

    Raises
    ------
    KeyError
        No claim that ships has that id and is of that kind.
    TypeError
        A claim of one's own is of another kind.
    """
    if isinstance(claim, kind):
        return claim
    if isinstance(claim, Claim):
        raise TypeError(f"claim {claim.id} must be a {kind.__name__} here, got a {type(claim).__name__}")
    return of_kind(kind)[claim]


def check_claims(experiment: str, claims: Any) -> None:
    """Raise ``ValueError`` for claims that no experiment can declare: a tuple of ids, and of claims of one's own."""
    if not isinstance(claims, tuple) or not all(isinstance(claim, str | Claim) for claim in claims):
        must = "claims must be a tuple of ids and of claims of your own; a comma makes one: (X,)"
        raise ValueError(f"experiment {experiment}: {must}, got {short(claims)}")
    own = [claim for claim in claims if isinstance(claim, Claim)]
    ids = [claim.id for claim in own]
    for claim in own:
        if not claim.own:
            raise ValueError(f"experiment {experiment}: claim {claim.id} is the paper's: declare it by its id alone")
        if ids.count(claim.id) > 1:
            raise ValueError(f"experiment {experiment}: two claims are called '{claim.id}'")
