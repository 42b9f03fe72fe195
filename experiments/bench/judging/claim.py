"""A claim: its words and its judge."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

from experiments.bench.engine import interrupts
from experiments.bench.engine.errors import check_name, short
from experiments.bench.engine.user_code import apart, blamed
from experiments.bench.judging.texts import claim_texts
from experiments.bench.judging.verdict import Outcome, Verdict


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
            n, decided, fewest = int(answer.n) or len(rows), str(answer.decided), int(answer.each)
            return Outcome(answer.verdict, *texts, n, decided, fewest, answer.broken, checks=answer.checks)
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
    return replace(Outcome.unjudged(trouble, n=rows), trouble=trouble)
