"""A claim: its words and its judge; and the claims that ship, by id.

The words of those that ship are in `WORDS`. Their judges are modules beside it, one for each kind of trial, which is
imported when a claim on such trials is asked for.
"""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Iterable, Mapping, Set
from dataclasses import dataclass, field, replace
from functools import cache
from pathlib import Path
from typing import Any, Literal, TypeVar

from experiments.base.errors import check_name, check_unique, short
from experiments.base.user_code import traced
from experiments.declare.outcome import Check, Outcome

WORDS = Path(__file__).parents[1] / "paper" / "claims" / "claims.toml"
"""The words of the claims that ship."""
LOOMING_DETECTORS = ("lgmd1", "lgmd2")
"""The models that claims about looming are about."""
DSNN = "dsnn"
POTENTIALS = ("peak_hs", "trough_hs", "peak_vs", "trough_vs")
EACH_TRIAL, MEANS = 5, 4
"""Trials of each condition, below which a claim is not judged.

A claim about every trial takes 5: if half of all trials broke it, five in a row would keep it once in 32 times. A
claim that means of conditions differ takes 4: four against four are the fewest of which a two-sided rank test can
reach p < 0.05 (2 of 70 arrangements).
"""
PAPER, BEHAVIOURS = "C", "B"
"""The letters of the ids: claims of the paper, and ours about behaviours."""


@dataclass(frozen=True, kw_only=True)
class Claim:
    """A claim: its words, its judge, and the trials that it is about.

    An experiment declares it in ``claims=``, beside ids of the paper's. A claim ``on`` trials with the robot is judged
    once for each model, or once for all the ``models`` that it compares; one on clips is judged at each seed.

    Parameters
    ----------
    id
        Its name in tables: up to 60 letters, digits, ``.``, ``-`` and ``_``. The ids of claims that ship are taken.
    judge
        From the rows of ``trials.parquet`` that it is about, and a spiking threshold, to its checks or an `Outcome`. A
        row is a whole trial or clip, a mapping by column: a judge gets no time course. A claim that names ``models``
        gets the rows of all of them, told apart by the column ``model``, and the DSNN's threshold, or without the DSNN
        that of its first model by name. Where a judge raises, the claim is not judged.
    says, source, title
        Its words, where they are from, and the claim in a few words.
    on
        What it is judged on: ``robot``, ``clips``, ``footage`` or ``behaviours``. The last two are for claims that
        ship.
    models
        The labels of the models that it compares; without one of them it is not judged. Left out, it is about each
        model by itself; of clips about the DSNN alone.
    conditions
        Column -> the values that its words name; other trials do not count. Without any, all do. Of clips every
        combination is needed, and ``shade`` is no column: it is ``dark`` or ``light``, the clip's ``grey`` against its
        ``background_mean``.
    reads
        The columns that it is judged by. A row without a number in one leaves it unjudged. Left out, ``spikes``; of
        clips the peaks and troughs of HS and VS.
    silent_passes
        Whether a model that never responds would satisfy it. It is not judged for a model that responds to no
        translation either, as far as the run has any.
    of_each
        Whether it is about every single trial or clip: then one that breaks it refutes it, however few there are.
    least
        Trials of each condition, with the robot, below which it is not judged; otherwise 5 of a claim ``of_each``, and
        4.
    about
        The kind of model it is about, with the robot: one that declares a ``direction``, or a ``looming`` detector.
    equal_terms
        Label of a model that it compares with -> that of the same model with its gain matched. With these in place of
        those it is judged a second time.
    pools
        The experiments whose trials of a replicate it is judged on together; none: the one that answers for it.
    of_potentials
        Whether it is about potentials alone: then a model without a spiking threshold is judged too, by one of 0.
    alone
        The condition that clips without an object have to meet, where it is about such clips too.
    least_greys
        How many grey levels of the object it needs.

    Raises
    ------
    ValueError
        It has no words, its id is taken, or a value is not legal.

    Examples
    --------
    >>> from experiments import Check, Claim
    >>> def faster(rows, threshold):
    ...     slow, fast = ([row["spikes"] for row in rows if row["speed_cm_s"] == speed] for speed in (4, 6))
    ...     means = [sum(spikes) / len(spikes) for spikes in (slow, fast)]
    ...     return [Check(f"{means[1]:.1f} spikes at 6 cm/s", means[1], means[0], unit="spikes")]
    >>> claim = Claim(id="faster-fires-more", says="more spikes at 6 cm/s than at 4", judge=faster)
    """

    id: str
    judge: Callable[..., Outcome | Iterable[Check]]
    says: str = ""
    source: str = ""
    title: str = ""
    on: Literal["robot", "clips", "footage", "behaviours"] = "robot"
    models: Set[str] = frozenset()
    conditions: Mapping[str, tuple[Any, ...]] = field(default_factory=dict)
    reads: tuple[str, ...] = ()
    silent_passes: bool = False
    of_each: bool = False
    least: int = 0
    about: Literal["direction", "looming"] = "direction"
    equal_terms: Mapping[str, str] = field(default_factory=dict)
    pools: tuple[str, ...] = ()
    of_potentials: bool = False
    alone: str = ""
    least_greys: int = 0

    def __post_init__(self) -> None:
        check_name("claim", self.id)
        if not callable(self.judge):
            raise ValueError(f"claim {self.id}: the judge must be a function, got {short(self.judge)}")
        if not self.own and self.judge.__module__.partition(".")[0] != __name__.partition(".")[0]:
            raise ValueError(f"claim {self.id}: a claim that ships has this id; give yours another")
        if not self.says:
            raise ValueError(f"claim {self.id}: it needs words, as says='...'")
        if isinstance(self.models, str):
            raise ValueError(f"claim {self.id}: models must be a set of labels, got {short(self.models)}")
        for name, values in self.conditions.items():
            if not isinstance(values, tuple):
                raise ValueError(f"claim {self.id}: conditions['{name}'] must be a tuple, got {short(values)}")
        clips = self.on == "clips"
        object.__setattr__(self, "models", frozenset(self.models or ({DSNN} if clips else ())))
        object.__setattr__(self, "reads", self.reads or (POTENTIALS if clips else ("spikes",)))
        object.__setattr__(self, "least", self.least or (EACH_TRIAL if self.of_each else MEANS))

    @property
    def spiking(self) -> str:
        """The model whose spiking threshold the judge of a claim with ``models`` receives."""
        return DSNN if DSNN in self.models else min(self.models)

    @property
    def own(self) -> bool:
        """Return whether it is a user's own, and none of those that ship."""
        return self.id not in claim_ids()

    def as_json(self) -> dict[str, str]:
        """Return what files have of it.

        Returns
        -------
        dict
            Its id, its words (``says``), and where they are from (``source``).
        """
        return {"id": self.id, "says": self.says, "source": self.source}

    def settled(self) -> Claim:
        """Return the claim with the constants of the models that it compares with taken as known: those shown.

        Returns
        -------
        Claim
            It has no equal terms.
        """

        def judge(*given: Any) -> Outcome:
            return _outcome(self.judge(*given)).settled()

        return replace(self, judge=judge, equal_terms={})

    def evaluate(self, trials: Any, *more: Any) -> Outcome:
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
        except (Exception, SystemExit) as error:
            why = f"its judge raised {type(error).__name__}"
            outcome = replace(Outcome.unjudged(why, reason="judge failed"), trouble=traced(error))
        return outcome if outcome.n else replace(outcome, n=len(trials))


def _outcome(answer: Any) -> Outcome:
    if not isinstance(answer, Outcome | list | tuple):
        raise TypeError(f"a judge must return a list of checks or an Outcome, got {short(answer)}")
    return answer if isinstance(answer, Outcome) else Outcome.of(answer)


Judge = TypeVar("Judge", bound=Callable[..., Any])
SHIPPED: dict[str, dict[str, Claim]] = {}
"""What claims are judged on -> id -> claim, of the modules of judges that are imported so far."""


def shipped(claim: str, **fields: Any) -> Callable[[Judge], Judge]:
    """Return a decorator that declares a claim that ships: the function is its judge, ``claims.toml`` has its words.

    What it is judged on is the name of the judge's module.

    Parameters
    ----------
    claim
        Its id.
    **fields
        What a `Claim` needs beside words and judge.
    """

    def declare(judge: Judge) -> Judge:
        on, words = judge.__module__.rpartition(".")[2], texts()[claim]
        declared: Any = {name: words.get(name, "") for name in ("says", "source", "title")} | {"on": on, **fields}
        SHIPPED.setdefault(on, {})[claim] = Claim(id=claim, judge=judge, **declared)
        return judge

    return declare


@cache
def texts() -> Mapping[str, Any]:
    """Return the tables of ``claims.toml``, which says what is in them; line breaks inside a text are spaces."""
    return dict(_joined(tomllib.loads(WORDS.read_text("utf-8"))))


def _joined(value: Any) -> Any:
    return {k: _joined(v) for k, v in value.items()} if isinstance(value, dict) else " ".join(value.split())


def claim_ids(letter: str = "") -> tuple[str, ...]:
    """Return the ids of the claims that ship, in order, the paper's first; of one ``letter`` those alone."""
    return tuple(name for name in texts() if name.startswith(letter) and name not in ("mechanisms", "papers"))


def check_claims(experiment: str, claims: Any) -> None:
    """Raise ``ValueError`` for claims that no experiment can declare: a tuple of ids, and of claims of one's own."""
    if not isinstance(claims, tuple) or not all(isinstance(claim, str | Claim) for claim in claims):
        must = "claims must be a tuple of ids and of claims of your own; a comma makes one: (X,)"
        raise ValueError(f"experiment {experiment}: {must}, got {short(claims)}")
    check_unique(f"experiment {experiment}: two claims", [claim.id for claim in claims if isinstance(claim, Claim)])
