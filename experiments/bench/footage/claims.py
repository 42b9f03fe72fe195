"""Claim C12 on any footage, with dense optical flow in place of the ground truth that footage lacks.

"The sign of HS follows the direction of the dominant translation; VS stays below HS" holds, as laid down before any
footage was looked at, when all of this does:

- HS correlates with the mean horizontal Farneback flow by more than 0.5, the 95 % interval above 0;
- of the frames with abs(HS) over the threshold, at least 90 % have the sign of that flow;
- the mean abs(VS) is below the mean abs(HS).

HS is compared with the flow into the same frame, without a lag, and frames too close to call in the flow count as
they fall. Neighbouring frames are alike, so what counts is seconds, not frames. The intervals of the correlation and
of the ratio are percentiles of a moving-block bootstrap of blocks of a second; that of the share is Clopper and
Pearson's, with one trial for each separate second that has frames over the threshold (Korn and Graubard 1998). With
fewer than `LEAST_SECONDS` of these C12 is not judged: by chance four signs agree once in 16 times, and five once in
32.

The paper's own words are stronger: "the HS system is highly activated", and VS "mainly remains at much lower level,
below the spiking threshold". They are judged beside the claim, by `stronger`:

- HS passes the threshold in at least `LEAST_SECONDS` separate seconds, in `LEAST_FRAMES` frames or more of each;
- of all frames of these seconds, at least 95 % have abs(VS) below the threshold. Silent footage thus adds nothing.

Where HS passes in fewer seconds, the words fail if the flow shows translation in `LEAST_SECONDS` seconds or more, and
are not judged otherwise. A second shows translation if its mean flow is over `LEAST_FLOW`: over a second, what sways
back and forth cancels.
"""

from __future__ import annotations

from array import array
from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
import numpy.typing as npt

from dsnn import Response
from experiments.bench.footage.video import Image, Picture
from experiments.bench.footage.watch import LEAST_FRAMES
from experiments.bench.judging.statistics import SEED, proportion_interval
from experiments.bench.judging.verdict import Check, Outcome, decide
from experiments.bench.streams import stream

CLAIM = "C12"
LEAST_CORRELATION, LEAST_AGREEMENT, BLOCK_S = 0.5, 0.9, 1.0
LEAST_SECONDS = 5
"""Separate seconds of footage in which HS passes the threshold."""
LEAST_BELOW = 0.95
"""Of the frames of these seconds, the share with abs(VS) below the threshold: "mainly"."""
LEAST_FLOW = 0.05
"""Mean horizontal flow over a second and the frame, px a frame: a fortieth of the picture going at 2 px a frame."""
RESAMPLES = 2000
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

    def outcomes(self) -> list[Readings]:
        """C12 for each model, in their order."""
        rate = len(self._flow) / self._until_s if self._until_s else 1.0
        flow = np.asarray(self._flow)
        return [
            Readings.without("this model has no HS spikes")
            if threshold is None
            else Readings.without("this model went wrong before the end", len(hs))
            if lost
            else Readings.of(flow, np.asarray(hs), np.asarray(vs), threshold, rate)
            for hs, vs, threshold, lost in zip(self._hs, self._vs, self._thresholds, self._lost, strict=True)
        ]


@dataclass(frozen=True, slots=True)
class Readings:
    """C12 as it is worded in ``claims.toml``, and in the paper's stronger words."""

    claim: Outcome
    stronger: Outcome

    @classmethod
    def of(cls, flow: Floats, hs: Floats, vs: Floats, threshold: float, rate: float) -> Readings:
        """Both, from columns of T frames; see `judge`."""
        return cls(judge(flow, hs, vs, threshold, rate), stronger(flow, hs, vs, threshold, rate))

    @classmethod
    def without(cls, why: str, n: int = 0) -> Readings:
        """Neither, and why."""
        return cls(Outcome.unjudged(why, n=n), Outcome.unjudged(why, n=n))


def judge(flow: Floats, hs: Floats, vs: Floats, threshold: float, rate: float) -> Outcome:
    """C12 from columns of T frames: mean horizontal flow, both potentials; ``rate`` in frames per second."""
    block, count = max(round(rate * BLOCK_S), 1), len(hs)
    lacking = _lacking(flow, hs, vs)
    if lacking:
        return Outcome.unjudged(lacking, n=count)
    over = np.abs(hs) > threshold
    seconds = len(_separate(np.flatnonzero(over), block))
    spread = f"{over.sum()} of {count} frames, in {seconds} separate seconds, over T = {threshold:g}"
    if seconds < LEAST_SECONDS:
        peak = f"; |HS| peaks at {np.abs(hs).max():.2f}" if count else ""
        why = f"needs |HS| over T in at least {LEAST_SECONDS} separate seconds of footage (has {seconds})"
        return Outcome.unjudged(f"{why}: {spread}{peak}", n=count)
    # Every figure of C12 is made of sums over frames, so a resample is a sum of sums over blocks.
    agrees = over & (np.sign(flow) == np.sign(hs))
    terms = np.column_stack(
        [np.ones(count), flow, hs, flow**2, hs**2, flow * hs, over, agrees, np.abs(hs), np.abs(vs)]
    )  # fmt: skip
    whole, resamples = terms.sum(axis=0), _resampled(terms, block)
    related, ratio = float(_correlation(whole)), float(_ratio(whole))
    least, most = np.percentile(_correlation(resamples), [2.5, 97.5])
    share = float(agrees.sum() / over.sum())
    bounds = {
        f"correlation of HS with the flow {related:.2f} [{least:.2f}, {most:.2f}]": [
            (f"above {LEAST_CORRELATION:g}", related - LEAST_CORRELATION),
            ("an interval above 0", float(least)),
        ],
        "same sign over T {:.2f} [{:.2f}, {:.2f}]".format(share, *proportion_interval(share * seconds, seconds)): [
            (f"{LEAST_AGREEMENT:g} or more", share - LEAST_AGREEMENT)
        ],
        "mean |VS| / |HS| {:.2f} [{:.2f}, {:.2f}]".format(ratio, *np.nanpercentile(_ratio(resamples), [2.5, 97.5])): [
            ("below 1", 1.0 - ratio)
        ],
    }
    checks = [
        Check(f"{said} (needs {needs})", slack, strict="or more" not in needs)
        for said, needed in bounds.items()
        for needs, slack in needed
    ]
    holds, decided = decide(checks)
    effect = f"95 % intervals: of the sign by separate seconds, else by bootstrap of blocks of {block} frames"
    return Outcome("holds" if holds else "fails", f"{'; '.join(bounds)} ({spread})", effect, count, decided, seconds)


def stronger(flow: Floats, hs: Floats, vs: Floats, threshold: float, rate: float) -> Outcome:
    """The paper's stronger words about real footage, from the same columns as `judge`."""
    block, count = max(round(rate * BLOCK_S), 1), len(hs)
    lacking = _lacking(flow, hs, vs)
    if lacking:
        return Outcome.unjudged(lacking, n=count)
    over = np.abs(hs) > threshold
    seconds = [slice(start, start + block) for start in _separate(np.flatnonzero(over), block)]
    passed = [second for second in seconds if over[second].sum() >= LEAST_FRAMES]
    whole = len(flow) // block
    moving = int((np.abs(flow[: whole * block].reshape(whole, block).mean(axis=1)) > LEAST_FLOW).sum())
    said = f"HS over T = {threshold:g} in {LEAST_FRAMES} frames or more of {len(passed)} separate seconds"
    needs = f"{said} (needs {LEAST_SECONDS} or more)"
    shown = f"the flow has translation in {moving} of {whole} seconds"
    if len(passed) < LEAST_SECONDS:
        if moving < LEAST_SECONDS:
            return Outcome.unjudged(f"{needs}; {shown}", n=count)
        return Outcome("fails", f"{said}; {shown}", n=count, decided=needs)
    frames = np.concatenate([np.abs(vs[second]) for second in passed])
    share = float((frames < threshold).mean())
    below = f"|VS| below T in {share:.1%} of the {len(frames)} frames of these seconds"
    holds, decided = decide(
        [
            Check(needs, len(passed) / LEAST_SECONDS - 1.0, strict=False),
            Check(f"{below} (needs {LEAST_BELOW:.0%} or more)", (share - LEAST_BELOW) / LEAST_BELOW, strict=False),
        ]
    )
    return Outcome("holds" if holds else "fails", f"{said}; {below}; {shown}", "", count, decided, len(passed))


def _lacking(flow: Floats, hs: Floats, vs: Floats) -> str:
    """How many frames lack a number, in words; empty if none does."""
    without = int((~np.isfinite([flow, hs, vs]).all(axis=0)).sum())
    return f"{without} of {len(hs)} frames have no number in flow, HS or VS" if without else ""


def _separate(frames: npt.NDArray[np.intp], block: int) -> list[int]:
    """Where ``block`` frames long stretches begin, none overlapping, that hold all of the ``frames`` in order."""
    found: list[int] = []
    for frame in frames.tolist():
        if not found or frame >= found[-1] + block:
            found.append(frame)
    return found


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


def _ratio(sums: Floats) -> Floats:
    """Mean abs(VS) over mean abs(HS); NaN in a resample of frames in which HS is 0 throughout."""
    hs, vs = sums[..., 8], sums[..., 9]
    return np.asarray(np.divide(vs, hs, out=np.full_like(vs, np.nan), where=hs > 0))
