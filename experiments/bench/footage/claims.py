"""Claims on any footage: what the models answer is followed beside dense optical flow, and judged at the end."""

from __future__ import annotations

from array import array
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from dsnn import Response
from experiments.bench.footage.film import Image
from experiments.bench.footage.flow import Floats, Grades, mean_flow
from experiments.bench.footage.video import Picture
from experiments.bench.stats.claim import Claim, find_claim
from experiments.bench.stats.verdict import Outcome

CLAIM = "C12"
LEAST_SECONDS = 5
"""Separate seconds of footage in which HS passes the threshold, below which C12 cannot be judged."""
FlowColumns = Callable[[Floats, Floats, Floats, float, float], Outcome]
"""Judge of columns of T frames (mean horizontal flow, HS, VS), a threshold and frames per second."""


@dataclass(frozen=True, kw_only=True)
class FootageClaim(Claim):
    """A claim about footage, of which dense optical flow says what moves.

    Parameters
    ----------
    judge
        Judges the claim as it is worded.
    stronger
        Judges the paper's own words, where these are stronger.
    """

    module: ClassVar[str] = "footage"

    judge: FlowColumns
    stronger: FlowColumns


class FlowJudge:
    """Follows footage with dense flow beside the models, for C12: 8 bytes a frame, 16 more a model."""

    note = ""

    def __init__(self, thresholds: Sequence[float | None]) -> None:
        self._thresholds = thresholds
        self._before: Image | None = None
        self._until_s = 0.0
        self._flow = array("d")
        self._hs, self._vs = ([array("d") for _ in thresholds] for _ in range(2))
        self._lost = [False for _ in thresholds]

    def add(self, picture: Picture, answers: Sequence[Response | None]) -> None:
        """Take a frame and the models' answers to it; the first frame has no flow, and does not count."""
        self._lost = [lost or answer is None for lost, answer in zip(self._lost, answers, strict=True)]
        if self._before is not None:
            self._flow.append(mean_flow(self._before, picture.luma))
            for answer, hs, vs in zip(answers, self._hs, self._vs, strict=True):
                if answer is not None:
                    hs.append(answer.hs)
                    vs.append(answer.vs)
        self._before, self._until_s = picture.luma, picture.time_s

    def outcomes(self) -> list[FootageOutcomes]:
        """Return the outcomes of C12 for each model, in their order."""
        rate = len(self._flow) / self._until_s if self._until_s else 1.0
        flow = np.asarray(self._flow)
        return [
            FootageOutcomes.without("this model has no HS spikes")
            if threshold is None
            else FootageOutcomes.without("this model went wrong before the end", len(hs))
            if lost
            else FootageOutcomes.of(flow, np.asarray(hs), np.asarray(vs), threshold, rate)
            for hs, vs, threshold, lost in zip(self._hs, self._vs, self._thresholds, self._lost, strict=True)
        ]


@dataclass(frozen=True, slots=True)
class FootageOutcomes:
    """Outcomes of C12, as its file words it and in the paper's stronger words, and two grades beside them."""

    claim: Outcome
    stronger: Outcome
    grades: Grades | None = None
    """None where the footage cannot be graded."""

    @classmethod
    def of(cls, flow: Floats, hs: Floats, vs: Floats, threshold: float, rate: float) -> FootageOutcomes:
        """Judge both, on columns of T frames; ``rate`` is in frames per second."""
        claim, columns = find_claim(CLAIM, FootageClaim), (flow, hs, vs, threshold, rate)
        return cls(claim.judge(*columns), claim.stronger(*columns), Grades.of(flow, hs, threshold, rate))

    @classmethod
    def without(cls, why: str, n: int = 0) -> FootageOutcomes:
        """Judge neither, and say why."""
        return cls(Outcome.unjudged(why, n=n), Outcome.unjudged(why, n=n))
