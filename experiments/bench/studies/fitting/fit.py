"""What a fit is: a study, a box of parameters in place of its grid, and how much of it is searched and judged anew."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

from experiments.bench.engine.errors import UsageError
from experiments.bench.engine.settings import MOST_JOBS
from experiments.bench.studies.study import Study

Sampler = Literal["tpe", "random"]
"""``tpe``: Optuna's tree-structured Parzen estimator; ``random``: every value alike."""
TOGETHER = 2
"""Settings of the renderings in a batch, where both they and the network are searched."""
NEXT_BEST = 10
"""Settings that are judged anew beside the winner."""


@dataclass(frozen=True, slots=True)
class Fit:
    """A search for the parameters under which all claims of a study hold.

    Parameters
    ----------
    study
        Claims, experiments, one model, what holds at every point, and the replicates that each setting is searched
        by. It has no axes.
    over
        The box: ``KEY=A..B``, ``KEY=V1,V2`` or ``KEY`` texts, one for each parameter. ``KEY`` alone is its whole legal
        range. A range of positive numbers whose ends are 100 times apart is searched by its logarithm.
    trials
        Settings that are searched, rounded up to whole batches of twice ``share``.
    share
        Settings of the network that are shown the frames of one rendering.
    sample
        Settings of the space-filling sample, each with a rendering of its own.
    held_out
        Replicates in which the winner and the ten next best are judged anew.
    sampler
        What chooses the settings.

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

    def __post_init__(self) -> None:
        if isinstance(self.over, str):
            raise UsageError(f"fit {self.study.name}: over={self.over!r}: legal is a tuple")
        object.__setattr__(self, "over", tuple(self.over))
        for option, value, least, most in (
            ("--trials", self.trials, 1, MOST_JOBS), ("--share", self.share, 1, 1000),
            ("--sample", self.sample, 1, MOST_JOBS), ("--held-out", self.held_out, 1, 1000),
        ):  # fmt: skip
            if not isinstance(value, int) or not least <= value <= most:
                raise UsageError(f"{option} {value}: legal is a whole number from {least} to {most}")
        if self.sampler not in get_args(Sampler):
            raise UsageError(f"--sampler {self.sampler}: legal is {', '.join(get_args(Sampler))}")
        if self.study.axes or self.study.over or self.study.measures or self.study.as_run:
            raise UsageError(f"fit {self.study.name}: its study has axes or measures; a fit has claims and a box")
        if len(self.study.models) != 1:
            raise UsageError(f"fit {self.study.name}: models={self.study.models}: a fit is of one model")
