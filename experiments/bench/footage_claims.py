"""Claim C12 on any footage, with dense optical flow in place of the ground truth that footage lacks.

"The sign of HS follows the direction of the dominant translation; VS stays below HS" holds, as laid down before any
footage was looked at, when all of this does:

- HS correlates with the mean horizontal Farneback flow by more than 0.5, the 95 % interval above 0;
- of the frames with abs(HS) over the threshold, at least 90 % have the sign of that flow;
- the mean abs(VS) is below the mean abs(HS).

HS is compared with the flow into the same frame, without a lag, and frames too close to call in the flow count as
they fall. Intervals are percentiles of a moving-block bootstrap: neighbouring frames are alike, so blocks of about a
second are drawn, not frames. Without frames over the threshold, or with less than two blocks, C12 is untested.
"""

from __future__ import annotations

from array import array
from collections.abc import Callable, Sequence

import cv2
import numpy as np
import numpy.typing as npt

from dsnn import Response
from experiments.bench.claims import Outcome
from experiments.bench.footage import Image, Picture
from experiments.bench.statistics import RESAMPLES, SEED
from experiments.bench.streams import stream

LEAST_CORRELATION, LEAST_AGREEMENT, BLOCK_S = 0.5, 0.9, 1.0
Floats = npt.NDArray[np.float64]


def mean_flow(before: Image, now: Image) -> float:
    """Mean horizontal flow between two luma images (R, C), px per frame, rightward positive (Farneback 2003)."""
    flow = cv2.calcOpticalFlowFarneback(
        before, now, np.empty((*now.shape, 2), np.float32),
        pyr_scale=0.5, levels=3, winsize=15, iterations=3, poly_n=5, poly_sigma=1.2, flags=0,
    )  # fmt: skip
    return float(flow[..., 0].mean())


class FlowJudge:
    """Follows footage with dense flow beside the models and judges C12 at the end; 8 bytes a frame, 16 more a model."""

    note = ""

    def __init__(self, thresholds: Sequence[float | None]) -> None:
        self._thresholds = thresholds
        self._before: Image | None = None
        self._until_s = 0.0
        self._flow = array("d")
        self._hs, self._vs = ([array("d") for _ in thresholds] for _ in range(2))

    def add(self, picture: Picture, answers: Sequence[Response]) -> None:
        """Take a frame and the models' answers to it; the first frame has no flow, and does not count."""
        if self._before is not None:
            self._flow.append(mean_flow(self._before, picture.luma))
            for answer, hs, vs in zip(answers, self._hs, self._vs, strict=True):
                hs.append(answer.hs)
                vs.append(answer.vs)
        self._before, self._until_s = picture.luma, picture.time_s

    def outcomes(self) -> list[Outcome]:
        """C12 for each model, in their order."""
        rate = len(self._flow) / self._until_s if self._until_s else 1.0
        flow = np.asarray(self._flow)
        return [
            Outcome("untested", "this model has no HS spikes")
            if threshold is None
            else judge(flow, np.asarray(hs), np.asarray(vs), threshold, rate)
            for hs, vs, threshold in zip(self._hs, self._vs, self._thresholds, strict=True)
        ]


def judge(flow: Floats, hs: Floats, vs: Floats, threshold: float, rate: float) -> Outcome:
    """C12 from columns of T frames: mean horizontal flow, both potentials; ``rate`` in frames per second."""
    over = np.abs(hs) > threshold
    block, count = max(round(rate * BLOCK_S), 1), len(hs)
    if count < 2 * block:
        return Outcome("untested", f"needs at least {2 * BLOCK_S:g} s of footage", n=count)
    if not over.any():
        return Outcome("untested", f"|HS| never passes T = {threshold:g}: it peaks at {np.abs(hs).max():.2f}", n=count)
    # Every figure of C12 is made of sums over frames, so a resample is a sum of sums over blocks.
    agrees = over & (np.sign(flow) == np.sign(hs))
    terms = np.column_stack(
        [np.ones(count), flow, hs, flow**2, hs**2, flow * hs, over, agrees, np.abs(hs), np.abs(vs)]
    )  # fmt: skip
    whole, resamples = terms.sum(axis=0), _resampled(terms, block)
    said, good = [], []
    for name, figure, holds in _FIGURES:
        value, (low, high) = float(figure(whole)), np.nanpercentile(figure(resamples), [2.5, 97.5])
        said.append(f"{name} {value:.2f} [{low:.2f}, {high:.2f}]")
        good.append(holds(value, float(low)))
    spread = f"{over.sum()} of {count} frames over T = {threshold:g}"
    effect = f"95 % intervals by moving-block bootstrap, blocks of {block} frames"
    return Outcome("holds" if all(good) else "fails", f"{'; '.join(said)} ({spread})", effect, count)


def _resampled(terms: Floats, block: int) -> Floats:
    """Sums (`RESAMPLES`, columns) of as many blocks of consecutive frames, drawn anywhere, as fill the footage."""
    running = np.vstack([np.zeros(terms.shape[1]), np.cumsum(terms, axis=0)])
    blocks = running[block:] - running[:-block]
    rng, draws = stream("bootstrap.blocks", SEED), round(len(terms) / block)
    return np.stack([blocks[rng.integers(len(blocks), size=draws)].sum(axis=0) for _ in range(RESAMPLES)])


def _correlation(sums: Floats) -> Floats:
    n, x, y, xx, yy, xy = (sums[..., i] for i in range(6))
    spread = np.sqrt(np.maximum(n * xx - x * x, 0.0) * np.maximum(n * yy - y * y, 0.0))
    return np.asarray(np.divide(n * xy - x * y, spread, out=np.zeros_like(spread), where=spread > 0))


def _agreement(sums: Floats) -> Floats:
    """Share of the frames over the threshold; NaN in a resample that drew none of them."""
    over = sums[..., 6]
    return np.divide(sums[..., 7], over, out=np.full_like(over, np.nan), where=over > 0)


_FIGURES: tuple[tuple[str, Callable[[Floats], Floats], Callable[[float, float], bool]], ...] = (
    ("correlation of HS with the flow", _correlation, lambda value, low: value > LEAST_CORRELATION and low > 0.0),
    ("same sign over T", _agreement, lambda value, low: value >= LEAST_AGREEMENT),
    ("mean |VS| / |HS|", lambda sums: sums[..., 9] / sums[..., 8], lambda value, low: value < 1.0),
)
"""What is measured, how from the sums, and whether its value and lower bound are what the claim needs."""
