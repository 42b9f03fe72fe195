"""The result of any fit: the fields that a fit to claims and a fit to measures share, and their words."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Generic, TypeVar

from experiments.bench.store.rows import Failure
from experiments.bench.studies.fitting.box import Box, Setting
from experiments.bench.studies.fitting.fit import Fit
from experiments.bench.studies.fitting.scores import Reading, Score

Scored = TypeVar("Scored", Score, Reading)
"""Result of one setting: slacks of claims, or measures."""


@dataclass(frozen=True)
class FitResult(Generic[Scored]):
    """The result of a fit: settings searched, the best of them judged anew, and a sample of the box."""

    fit: Fit
    """The fit that was asked for."""
    box: Box
    """The parameters that are free, and their ranges."""
    seed: int
    """Seed of the whole run."""
    searched: tuple[Scored, ...]
    """Every setting that was searched, in order, with its slacks or measures."""
    best: tuple[int, ...]
    """Numbers of the winner and of the next best among these; of several goals those of the front."""
    anew: tuple[Scored, ...]
    """The same settings at seeds that the search never saw. A fit to measures has the model as it is after them."""
    sample: tuple[Scored, ...]
    """The settings that fill the box evenly."""
    looks: int
    """Number of times that settings were judged at those seeds, this one included."""
    importance: dict[str, dict[str, float]]
    """Claim or measure -> parameter -> its share of what varies; empty is all claims together, or the first goal."""
    failures: tuple[Failure, ...]
    """Everything that failed."""

    @property
    def winner(self) -> Scored:
        """The best setting as the search saw it; of several goals the best in the first."""
        return self.searched[self.best[0]]

    def searched_words(self) -> str:
        """Return what was searched, and how often its winner was judged.

        Returns
        -------
        str
            One line: the number of settings, the ranges, the replicates and the looks.
        """
        ranges = "; ".join(f"{part}{f' {part.unit}' if part.unit else ''}" for part in self.box.ranges)
        replicates = self.fit.study.replicates
        return (f"searched: {len(self.searched)} settings of {ranges}, in {replicates}"
                f" replicate{'s' * (replicates != 1)} each;"
                f" looked at the seeds of the judging anew {self.looks} time{'s' * (self.looks != 1)}")  # fmt: skip


def setting_words(setting: Setting) -> str:
    """Return a setting in words."""
    return ", ".join(f"{key}={value}" for key, value in setting.items())


def lost(before: float, after: float) -> float:
    """Return how much of a value is lost from before to after; 0 where they differ by rounding alone."""
    return 0.0 if math.isclose(before, after, rel_tol=1e-12) else before - after
