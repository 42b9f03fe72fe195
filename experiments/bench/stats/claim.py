"""A claim: its words and its judge; and a reading of the paper that claims were used to choose."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from experiments.bench.run.errors import check_name, short
from experiments.bench.run.user_code import traced
from experiments.bench.stats.checks import weakest
from experiments.bench.stats.claim_files import PACKAGE, claim_ids
from experiments.bench.stats.verdict import Outcome, Verdict
from scenes.hints import closest


@dataclass(frozen=True, slots=True, kw_only=True)
class Reading:
    """A reading of the paper that was taken where it leaves room.

    Parameters
    ----------
    id
        Its name, with underscores between words.
    says
        The paper's words.
    taken, others
        The reading taken, and the others, one or more.
    note
        What a reader has to know of them.
    claims
        Ids of the claims that it was chosen for; empty: all of them together.
    used
        Whether it was chosen because these claims favoured it. Otherwise they tell the readings apart.
    """

    id: str
    says: str
    taken: str
    others: tuple[str, ...]
    note: str
    claims: tuple[str, ...] = ()
    used: bool = True

    @property
    def name(self) -> str:
        """The id in words, with spaces for underscores."""
        return self.id.replace("_", " ")

    @property
    def of_all(self) -> bool:
        """Return whether it was chosen for all claims together."""
        return not self.claims


@dataclass(frozen=True, kw_only=True)
class Claim:
    """A claim: its words and its judge. Each wing has a kind of its own, which says what its judge gets.

    Parameters
    ----------
    id
        Its name in tables: up to 60 letters, digits, ``.``, ``-`` and ``_``. The ids of claims that ship are taken.
    judge
        From the rows that it is about to an `Outcome`.
    says, source
        Its words, and where they are from.
    title
        The same in a few words.
    cause
        In one line why it fails, or holds in some replicates only.
    eye
        Of a claim about the robot: in one line what the robot's own eye and wheels make of it.
    tried
        What was tried to make it hold, or what limits it.
    mechanism
        The experiment whose figure shows why it comes out as it does, and what that figure draws.
    silent_passes
        Whether a model that never answers anything would keep it.
    implied
        Why the model's equations imply it, whatever it is shown; empty where they do not.
    equal_terms
        Label of a model that it compares with -> that of the same model on equal terms. With these in place of those
        it is judged a second time, and that stands beside: see `experiments.bench.clips.equal_terms`.

    Raises
    ------
    ValueError
        It has no words or no judge, its id is taken, or a value is not legal.
    """

    id: str
    judge: Callable[..., Outcome]
    says: str = ""
    source: str = ""
    title: str = ""
    cause: str = ""
    eye: str = ""
    tried: str = ""
    mechanism: tuple[str, str] = ("", "")
    silent_passes: bool = False
    implied: str = ""
    equal_terms: Mapping[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        check_name("claim", self.id)
        if not callable(self.judge):
            raise ValueError(f"claim {self.id}: judge={short(self.judge)}: legal is a function")
        for name in ("says", "source", "title", "cause", "eye", "tried", "implied"):
            if not isinstance(getattr(self, name), str):
                raise ValueError(f"claim {self.id}: {name}={short(getattr(self, name))}: legal is a text")
        pair = self.mechanism
        if not isinstance(pair, tuple) or len(pair) != 2 or not all(isinstance(text, str) for text in pair):
            legal = "legal is a pair of an experiment's name and what its figure draws"
            raise ValueError(f"claim {self.id}: mechanism={short(pair)}: {legal}")
        if not self.own and not str(getattr(self.judge, "__module__", "")).startswith(f"{PACKAGE}."):
            raise ValueError(f"claim {self.id}: one of the paper's claims has that id; give yours another")
        if not self.says:
            raise ValueError(f"claim {self.id}: says='': a claim of your own needs words")

    @property
    def own(self) -> bool:
        """Return whether it is none of those that ship, in `experiments.claims`."""
        return self.id not in claim_ids()

    def on_equal_terms(self, rows: Sequence[Any]) -> list[Any]:
        """Return the rows that it is judged on a second time; none where no model was shown on equal terms.

        Parameters
        ----------
        rows
            Rows of a run's table.

        Returns
        -------
        list
            The same rows, those of the models on equal terms under the labels of the ones that they stand for.
        """
        labels = {equal: label for label, equal in self.equal_terms.items()}
        if not labels or not labels.keys() <= {row["model"] for row in rows}:
            return []
        plain = (row for row in rows if row["model"] not in {*labels, *labels.values()})
        return [*plain, *({**row, "model": labels[row["model"]]} for row in rows if row["model"] in labels)]

    def described(self) -> dict[str, str]:
        """Describe the claim as ``run.json`` does.

        Returns
        -------
        dict of str to str
            ``id``, ``says`` and ``source``.
        """
        return {"id": self.id, "says": self.says, "source": self.source}

    def ask(self, rows: Sequence[Any], *more: Any) -> Outcome:
        """Ask the judge.

        A user's own judge that raises, or answers no `Outcome`, leaves the claim unjudged: the tables count.

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
        if not rows:  # every trial of the model failed: a judge need not expect that
            return Outcome.unjudged("nothing to judge it on was shown")
        copies = [dict(row) for row in rows]  # what a judge changes is its own
        try:
            answer = self.judge(copies, *more)
            if not isinstance(answer, Outcome):
                trouble = f"its judge answered {short(answer)}, expected an Outcome"
                return _broken(trouble, len(rows), trouble)
            if answer.checks:
                weakest(answer.checks)  # nothing but checks is among them
            texts = str(answer.measured), str(answer.effect)
            n, decided, fewest = int(answer.n) or len(rows), str(answer.decided), int(answer.fewest)
            return Outcome(answer.verdict, *texts, n, decided, fewest, answer.broken, checks=answer.checks)
        except Exception as error:
            if isinstance(error, KeyError) and (near := closest(str(error.args[0]), map(str, rows[0]))):
                error.add_note(f"nearest column: {near}")
            return _broken(f"its judge raised {type(error).__name__}", len(rows), traced(error))

    def verdict(self, *outcomes: Outcome, random: bool = True, model: str = "", experiment: str = "") -> Verdict:
        """Return the verdict of outcomes.

        Parameters
        ----------
        *outcomes
            One of each replicate, the first one first.
        random
            Whether anything differs between replicates.
        model, experiment
            As of a `Verdict`.

        Returns
        -------
        Verdict
            The first outcome, and the count of all.
        """
        words = (self.id, self.says, self.source)
        return Verdict.of(words, outcomes, random=random, model=model, experiment=experiment)


def _broken(why: str, rows: int, trouble: str) -> Outcome:
    return replace(Outcome.unjudged(why, reason="judge failed", n=rows), trouble=trouble)
