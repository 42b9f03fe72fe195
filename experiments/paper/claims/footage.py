"""The paper's claim about real footage, C12. Its words are in ``claims.toml``.

Footage has no ground truth: dense optical flow takes its place. The claim holds, as laid down before any footage was
looked at, when all of this does:

- HS correlates with the mean horizontal Farneback flow by more than 0.5, the 95 % interval above 0;
- of the frames with abs(HS) over the threshold, at least 90 % have the sign of that flow;
- the mean abs(VS) is below the mean abs(HS).

HS is compared with the flow into the same frame, without a lag, and frames too close to call in the flow count as
they fall. Neighbouring frames are alike, so what counts is seconds, not frames. The intervals of the correlation and
of the ratio are percentiles of a moving-block bootstrap of blocks of a second; that of the share is Clopper and
Pearson's, with one trial for each separate second that has frames over the threshold (Korn and Graubard 1998). With
fewer than `LEAST_SECONDS` of these C12 cannot be judged: by chance four signs agree once in 16 times, five once in 32.

The paper's own words are stronger: "the HS system is highly activated", and VS "mainly remains at much lower level,
below the spiking threshold". They are judged too, by `stronger`:

- HS passes the threshold in at least `LEAST_SECONDS` separate seconds, in `LEAST_FRAMES` frames or more of each;
- of all frames of these seconds, at least 95 % have abs(VS) below the threshold. Silent footage thus adds nothing.

Where HS passes in fewer seconds, the words fail if the flow shows translation in `LEAST_SECONDS` seconds or more, and
cannot be judged otherwise. A second shows translation if its mean flow is over `LEAST_FLOW`: over a second, what sways
back and forth cancels.
"""

from collections.abc import Sequence

import numpy as np
import polars as pl

from experiments.declare.claim import Claim, shipped as claim
from experiments.declare.outcome import Check, Outcome
from experiments.judge.motion import (
    LEAST_FRAMES,
    LEAST_SECONDS,
    block_frames,
    columns,
    correlation,
    frame_rate,
    moments,
    resampled,
    separate,
)
from experiments.judge.tests import Floats, proportion_interval
from experiments.judge.verdict import Verdict, verdict_of
from experiments.kinds.registry import claims_on
from experiments.settings.models import ConfiguredModel

CLAIM = "C12"
STRONGER = "Real footage in the paper's stronger words: HS passes T, VS stays below T"
LEAST_CORRELATION, LEAST_AGREEMENT = 0.5, 0.9
LEAST_BELOW = 0.95
"""Share of the frames of these seconds with abs(VS) below the threshold: "mainly"."""
LEAST_FLOW = 0.05
"""Mean horizontal flow over a second and the frame, px a frame: a fortieth of the picture going at 2 px a frame."""


def stronger(flow: Floats, hs: Floats, vs: Floats, threshold: float, rate: float) -> Outcome:
    """Judge the paper's stronger words about real footage, from the same columns as `c12`."""
    block, count = block_frames(rate), len(hs)
    over = np.abs(hs) > threshold
    seconds = [slice(start, start + block) for start in separate(np.flatnonzero(over), block)]
    least = min(LEAST_FRAMES, block)  # below 3 frames/s, all of a second's
    passed = [second for second in seconds if over[second].sum() >= least]
    whole = len(flow) // block
    moving = int((np.abs(flow[: whole * block].reshape(whole, block).mean(axis=1)) > LEAST_FLOW).sum())
    text = f"HS over T = {threshold:g} in {least} frames or more of {len(passed)} separate seconds"
    asks, scale = f"{LEAST_SECONDS} or more", float(LEAST_SECONDS)
    many = Check(text, float(len(passed)), scale, "at least", unit="seconds", scale=scale, asks=asks)
    translating = f"the flow has translation in {moving} of {whole} seconds"
    if len(passed) < LEAST_SECONDS:
        if moving < LEAST_SECONDS:
            return Outcome.unjudged(f"{many.text}; {translating}", n=count)
        return Outcome.of([many], f"{text}; {translating}", n=count)
    frames = np.concatenate([np.abs(vs[second]) for second in passed])
    share = float((frames < threshold).mean())
    below = f"|VS| below T in {share:.1%} of the {len(frames)} frames of these seconds"
    mainly = Check(below, share, LEAST_BELOW, "at least", scale=LEAST_BELOW, asks=f"{LEAST_BELOW:.0%} or more")
    return Outcome.of([many, mainly], f"{text}; {below}; {translating}", "", count, len(passed))


@claim("C12")
def c12(flow: Floats, hs: Floats, vs: Floats, threshold: float, rate: float) -> Outcome:
    """Judge columns of T frames: mean horizontal flow, both potentials; ``rate`` is in frames per second."""
    block, count = block_frames(rate), len(hs)
    over = np.abs(hs) > threshold
    seconds = len(separate(np.flatnonzero(over), block))
    spread = f"{over.sum()} of {count} frames, in {seconds} separate seconds, over T = {threshold:g}"
    if seconds < LEAST_SECONDS:
        peak = f"; |HS| peaks at {np.abs(hs).max():.2f}" if count else ""
        why = f"needs |HS| over T in at least {LEAST_SECONDS} separate seconds of footage (has {seconds})"
        return Outcome.unjudged(f"{why}: {spread}{peak}", n=count)
    # Every figure of C12 is made of sums over frames, so a resample is a sum of sums over blocks.
    agrees = over & (np.sign(flow) == np.sign(hs))
    terms = np.column_stack([moments(flow, hs), over, agrees, np.abs(hs), np.abs(vs)])
    whole, resamples = terms.sum(axis=0), resampled(terms, block)
    related, ratio = float(correlation(whole)), float(_ratio(whole))
    least, most = np.percentile(correlation(resamples), [2.5, 97.5])
    share = float(agrees.sum() / over.sum())
    low, high = proportion_interval(share * seconds, seconds)
    below, above = np.nanpercentile(_ratio(resamples), [2.5, 97.5])
    follows = f"correlation of HS with the flow {related:.2f} [{least:.2f}, {most:.2f}]"
    agreement = f"same sign over T {share:.2f} [{low:.2f}, {high:.2f}]"
    shares = f"mean |VS| / |HS| {ratio:.2f} [{below:.2f}, {above:.2f}]"
    checks = [
        Check(follows, related, LEAST_CORRELATION),
        Check(follows, float(least), 0.0, asks="an interval above 0"),
        Check(agreement, share, LEAST_AGREEMENT, "at least", asks=f"{LEAST_AGREEMENT:g} or more"),
        Check(shares, ratio, 1.0, "below"),
    ]
    effect = f"95 % intervals: of the sign by separate seconds, else by bootstrap of blocks of {block} frames"
    return Outcome.of(checks, f"{follows}; {agreement}; {shares} ({spread})", effect, count, seconds)


def _ratio(sums: Floats) -> Floats:
    """Return mean abs(VS) over mean abs(HS); NaN in a resample of frames in which HS is 0 throughout."""
    hs, vs = sums[..., 8], sums[..., 9]
    return np.asarray(np.divide(vs, hs, out=np.full_like(vs, np.nan), where=hs > 0))


def verdicts(frames: pl.DataFrame, models: Sequence[ConfiguredModel], experiment: str) -> list[Verdict]:
    """Judge C12 of each model that has rows, and the paper's stronger words. Nothing in a film is random."""
    asked = claims_on("footage")[CLAIM]
    second = Claim(id=f"{CLAIM}s", judge=stronger, says=STRONGER, source=asked.source, title=STRONGER, on="footage")
    judged = []
    for model in models:
        rows, threshold = frames.filter(pl.col("model") == model.label), model.thresholds.get("hs")
        for one in (asked, second) if len(rows) else ():
            if threshold is None:
                outcome = Outcome.unjudged("this model has no HS spikes")
            else:
                outcome = one.evaluate(*columns(rows), threshold, frame_rate(rows))
            judged.append(verdict_of(one, [outcome], random=False, model=model.label, experiment=experiment))
    return judged
