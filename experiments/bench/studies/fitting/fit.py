"""Declaration of a fit: a study, a box in place of its grid, goals, and how much is searched and judged anew."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

from experiments.bench.run.errors import UsageError
from experiments.bench.run.settings import MOST_JOBS
from experiments.bench.study import Study, make_tuples

Sampler = Literal["tpe", "random"]
"""``tpe``: Optuna's tree-structured Parzen estimator; ``random``: every value alike."""
SLACK, KEPT = "slack", "kept"
"""Goals of claims, made large: the least slack over claims and replicates, or the number of claims kept."""
OF_CLAIMS = (SLACK, KEPT)
LEADERBOARD, TUNING = "leaderboard", "tuning"
"""Boards in place of experiments: the clips and trials of the leaderboard, whose scores are made large, or tuning
curves."""
BOARDS = (LEADERBOARD, TUNING)
TOGETHER = 2
"""Settings of the renderings in a batch, where both they and the network are searched."""
NEXT_BEST = 10
"""Settings that are judged anew beside the winner."""


@dataclass(frozen=True, slots=True)
class Goal:
    """A number that a fit makes as large, or as small, as it can.

    Parameters
    ----------
    name
        `SLACK` or `KEPT` of claims, a measure of the study, or a column of the leaderboard or of tuning curves.
    least
        Whether it is made small.
    """

    name: str
    least: bool = False

    @property
    def of_claims(self) -> bool:
        """True if it is a goal of claims, `SLACK` or `KEPT`, and not a measure."""
        return self.name in OF_CLAIMS

    def signed(self, value: float) -> float:
        """Return a value as one that is the better the larger it is."""
        return -value if self.least else value


@dataclass(frozen=True, slots=True)
class Fit:
    """A search for the parameters under which all claims of a study hold, or measures are largest.

    Parameters
    ----------
    study
        Claims or measures, experiments, one model, what holds at every point, and the replicates that each setting is
        searched by. It has no axes. Its experiments may be ``("leaderboard",)`` or ``("tuning",)`` alone.
    over
        The box: ``KEY=A..B``, ``KEY=V1,V2`` or ``KEY`` texts, one for each parameter, or for several of one value with
        ``+`` between their keys. ``KEY`` alone is its whole legal range. A range of positive numbers whose ends are 100
        times apart is searched by its logarithm.
    trials
        Settings that are searched, rounded up to whole batches of twice ``share``.
    share
        Settings of the network that are shown the frames of one rendering.
    sample
        Settings of the space-filling sample, each with a rendering of its own.
    held_out
        Replicates in which the winner and the ten next best are judged anew.
    sampler
        The sampler that chooses the settings.
    search_repeats
        Trials of each condition in a replicate of search and sample; ``None``: those of the study, which the judging
        anew always has. Fewer make a search quicker, and its slack rougher.
    maximise, minimise
        The goals, made large, and small: ``slack`` or ``kept`` of claims, the study's measures, columns of the
        leaderboard's table or of ``preferences.csv``. Several give a front: the settings that none betters in all.

    Raises
    ------
    UsageError
        A number is not legal, or the study has axes or several models.

    Examples
    --------
    >>> from experiments import Fit, Study
    >>> speed = Study("threshold", "C15 at some threshold", claims=("C15",), replicates=1)
    >>> Fit(speed, over=("dsnn.t_sp=0.05..0.3",), trials=60).sample
    64
    """

    study: Study
    over: tuple[str, ...]
    trials: int = 400
    share: int = 10
    sample: int = 64
    held_out: int = 20
    sampler: Sampler = "tpe"
    search_repeats: int | None = None
    maximise: tuple[str, ...] = (SLACK,)
    minimise: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        make_tuples(self, f"fit {self.study.name}", ("over", "maximise", "minimise"))
        for option, value, least, most in (
            ("--trials", self.trials, 1, MOST_JOBS), ("--share", self.share, 1, 1000),
            ("--sample", self.sample, 1, MOST_JOBS), ("--held-out", self.held_out, 1, 1000),
            ("--repeats", 1 if self.search_repeats is None else self.search_repeats, 1, MOST_JOBS),
        ):  # fmt: skip
            if not isinstance(value, int) or not least <= value <= most:
                raise UsageError(f"{option} must be between {least} and {most}, got {value}")
        if self.sampler not in get_args(Sampler):
            raise UsageError(f"--sampler {self.sampler}: legal is {', '.join(get_args(Sampler))}")
        if self.study.axes or self.study.over or self.study.measures or self.study.as_run:
            raise UsageError(f"fit {self.study.name}: its study has axes or measures; a fit has claims or --maximise,"
                             " and a box")  # fmt: skip
        if len(self.study.models) != 1:
            raise UsageError(f"fit {self.study.name}: models={self.study.models}: a fit is of one model")
        names = [*self.maximise, *self.minimise]
        if not names or len(set(names)) < len(names):
            raise UsageError(f"--maximise {','.join(names) or '(nothing)'}: legal is one name or more, each once")
        if self.board and len(self.study.experiments) > 1:
            raise UsageError(f"{self.board}: it is fitted to alone, without {', '.join(self.study.experiments)}")
        if any(goal.of_claims for goal in self.goals) and len(names) > 1:
            raise UsageError(f"--maximise {','.join(names)}: slack and kept are about all claims; each is a goal alone")
        if self.of_claims and self.board:
            raise UsageError(f"{self.board}: it has no claims; name what to make large by --maximise")
        if self.study.claims and not self.of_claims:
            raise UsageError(f"--claims: {names[0]} is no number of claims; leave out --claims, or --maximise")
        if self.minimise and self.of_claims:
            raise UsageError(f"--minimise {names[0]}: it is made large, by --maximise")

    @property
    def of_claims(self) -> bool:
        """True if the goal is one of claims, and not a measure."""
        return self.goals[0].of_claims

    @property
    def goals(self) -> tuple[Goal, ...]:
        """The goals in order: those made large, then those made small."""
        return (*map(Goal, self.maximise), *(Goal(name, least=True) for name in self.minimise))

    @property
    def board(self) -> str:
        """The one of `BOARDS` that the fit is to; empty where it is to a study."""
        return next((name for name in self.study.experiments if name in BOARDS), "")
