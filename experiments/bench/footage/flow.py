"""Statistics of how well HS follows the horizontal flow of footage.

Columns have a row for each frame. Neighbouring frames are alike. Seconds are therefore counted, and intervals come from
blocks of a second.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
import numpy.typing as npt

from experiments.bench.footage.film import Image
from experiments.bench.footage.watch import LEAST_FRAMES
from experiments.bench.run.streams import stream
from experiments.bench.stats.tests import SEED, proportion_interval

BLOCK_S = 1.0
RESAMPLES = 2000
SMOOTHING_S = 0.5
"""Width of the moving mean that is taken of flow and HS, before they are correlated for `Grades`."""
LEVEL = 0.02
"""|HS| from which on `Grades` reads a direction; an eighth of the off-line threshold."""
Floats = npt.NDArray[np.float64]


def mean_flow(before: Image, now: Image) -> float:
    """Mean horizontal flow between two luma images (R, C), px per frame, rightward positive (Farneback 2003)."""
    flow = cv2.calcOpticalFlowFarneback(
        before, now, np.empty((*now.shape, 2), np.float32),
        pyr_scale=0.5, levels=3, winsize=15, iterations=3, poly_n=5, poly_sigma=1.2, flags=0,
    )  # fmt: skip
    return float(flow[..., 0].mean())


def block_frames(rate: float) -> int:
    """Return how many frames a block of a second has; ``rate`` is in frames per second."""
    return max(round(rate * BLOCK_S), 1)


def separate(frames: npt.NDArray[np.intp], block: int) -> list[int]:
    """Return where stretches of ``block`` frames begin, none overlapping, that hold all of the ``frames``."""
    starts: list[int] = []
    for frame in frames.tolist():
        if not starts or frame >= starts[-1] + block:
            starts.append(frame)
    return starts


def resampled(terms: Floats, block: int) -> Floats:
    """Return sums (`RESAMPLES`, columns) of as many blocks of frames, drawn anywhere, as fill the footage."""
    running = np.vstack([np.zeros(terms.shape[1]), np.cumsum(terms, axis=0)])
    blocks = running[block:] - running[:-block]
    rng, draws = stream("bootstrap.blocks", SEED), round(len(terms) / block)
    return np.stack([blocks[rng.integers(len(blocks), size=draws)].sum(axis=0) for _ in range(RESAMPLES)])


def moments(x: Floats, y: Floats) -> Floats:
    """Return the terms (T, 6) whose sums a correlation is made of: n, x, y, x squared, y squared, x times y."""
    return np.column_stack([np.ones(len(x)), x, y, x**2, y**2, x * y])


def correlation(sums: Floats) -> Floats:
    """Return Pearson's correlation from sums (..., 6 or more) of `moments`; 0 where a column does not vary."""
    n, x, y, xx, yy, xy = (sums[..., i] for i in range(6))
    spread = np.sqrt(np.maximum(n * xx - x * x, 0.0) * np.maximum(n * yy - y * y, 0.0))
    return np.asarray(np.divide(n * xy - x * y, spread, out=np.zeros_like(spread), where=spread > 0))


def undefined(*columns: Floats) -> str:
    """Return how many frames lack a number in flow, HS or VS, in words; empty if none does."""
    count = int((~np.isfinite(columns).all(axis=0)).sum())
    return f"{count} of {len(columns[0])} frames have no number in flow, HS or VS" if count else ""


@dataclass(frozen=True, slots=True)
class Grades:
    """Two grades of a model on footage, each a number with its 95 % interval: direction told, threshold passed.

    A claim about footage holds or fails. A network whose HS follows the motion and stays below its threshold fails it
    as one does that follows nothing; these numbers tell the two apart.

    Parameters
    ----------
    r, r_interval
        Correlation of HS with the mean horizontal flow, after a moving mean of `SMOOTHING_S`. Its interval is that of
        a moving-block bootstrap.
    told, level, told_interval
        In how many of the ``level`` frames with |HS| over `LEVEL` HS has the sign of the flow. The interval of the
        share has one trial for each separate second of these.
    passed, seconds, passed_interval
        In how many of the footage's whole ``seconds`` |HS| is over the model's threshold in `LEAST_FRAMES` frames or
        more, and the exact interval of the share.
    """

    r: float
    r_interval: tuple[float, float]
    told: int
    level: int
    told_interval: tuple[float, float]
    passed: int
    seconds: int
    passed_interval: tuple[float, float]

    @classmethod
    def of(cls, flow: Floats, hs: Floats, threshold: float, rate: float) -> Grades | None:
        """Grade columns of T frames; ``rate`` is in frames per second.

        Returns
        -------
        Grades or None
            None of less than two seconds, and where a frame lacks a number.
        """
        block = block_frames(rate)
        seconds = len(hs) // block
        if seconds < 2 or undefined(flow, hs):
            return None
        smooth = np.full(max(round(rate * SMOOTHING_S), 1), 1.0)
        terms = moments(*(np.convolve(column, smooth / len(smooth), "valid") for column in (flow, hs)))
        low, high = np.percentile(correlation(resampled(terms, block)), [2.5, 97.5])
        level = np.abs(hs) > LEVEL
        told, trials = int((level & (np.sign(flow) == np.sign(hs))).sum()), len(separate(np.flatnonzero(level), block))
        share = told / level.sum() if trials else 0.0
        over = (np.abs(hs[: seconds * block]) > threshold).reshape(seconds, block).sum(axis=1)
        passed = int((over >= min(LEAST_FRAMES, block)).sum())
        return cls(
            r=float(correlation(terms.sum(axis=0))), r_interval=(float(low), float(high)),
            told=told, level=int(level.sum()),
            told_interval=proportion_interval(share * trials, trials) if trials else (0.0, 1.0),
            passed=passed, seconds=seconds, passed_interval=proportion_interval(passed, seconds),
        )  # fmt: skip

    def lines(self) -> tuple[str, str]:
        """Return the two grades in words, a line each."""
        r = f"HS follows the flow by r = {self.r:.2f} [{self.r_interval[0]:.2f}, {self.r_interval[1]:.2f}]"
        low, high = self.told_interval
        sign = (
            f"the right sign in {self.told / self.level:.0%} [{low:.0%}, {high:.0%}] of the {self.level} frames with "
            f"|HS| over {LEVEL:g}"
            if self.level
            else f"no frame has |HS| over {LEVEL:g}"
        )
        low, high = self.passed_interval
        return (
            f"direction told: {r} (both smoothed over {SMOOTHING_S:g} s); {sign}",
            f"threshold passed: in {self.passed} of {self.seconds} seconds, {self.passed / self.seconds:.0%} "
            f"[{low:.0%}, {high:.0%}]",
        )
