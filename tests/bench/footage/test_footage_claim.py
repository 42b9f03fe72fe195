"""The judges of real footage (C12), and of the paper's stronger words about it."""

import numpy as np
import pytest

from experiments.bench.footage import claims as footage_claims
from experiments.bench.footage.watch import LEAST_FRAMES
from experiments.bench.stats.claim import find_claim
from experiments.claims.footage import LEAST_FLOW

C12 = find_claim(footage_claims.CLAIM, footage_claims.FootageClaim)
T_SP = 0.16


def film(frames=794, moving=((0, 794),), rate=30.0):
    """Flow and an HS that follows it over T in the ``moving`` stretches of frames, and a small VS."""
    rng = np.random.default_rng(0)
    flow = np.where(np.arange(frames) // 60 % 2, 1.0, -1.0)
    hs = np.zeros(frames)
    for start, end in moving:
        hs[start:end] = 0.3 * flow[start:end]
    return flow, hs + 1e-3 * rng.standard_normal(frames), 0.001 * rng.standard_normal(frames), T_SP, rate


def test_a_few_frames_over_the_threshold_do_not_decide_c12():
    """2 of 794 agree, which by chance alone is as likely as not to be so."""
    for moving, seconds in ([((400, 402),), 1], [((10, 20), (300, 310)), 2], [((0, 119),), 4], [(), 0]):
        outcome = C12.judge(*film(moving=moving))
        assert outcome.verdict == "not shown" and outcome.decided == ""
        assert (
            f"at least {footage_claims.LEAST_SECONDS} separate seconds of footage (has {seconds})" in outcome.measured
        )
        assert f"{sum(b - a for a, b in moving)} of 794 frames" in outcome.measured


def test_a_share_of_all_is_no_certainty():
    outcome = C12.judge(*film(moving=[(start, start + 3) for start in range(0, 600, 60)]))
    low, high = outcome.measured.split("same sign over T 1.00 [")[1].split("]")[0].split(", ")
    assert (float(low), float(high)) == (pytest.approx(0.025 ** (1 / 10), abs=0.006), 1.0)
    assert "in 10 separate seconds" in outcome.measured


def test_c12_says_what_decided():
    holds = C12.judge(*film())
    assert holds.verdict == "holds" and "(needs " in holds.decided
    flow, hs, _, *rest = film()
    fails = C12.judge(flow, hs, 2 * hs, *rest)
    assert fails.verdict == "fails" and fails.decided.startswith("mean |VS| / |HS| 2.00")
    assert fails.decided.endswith("(needs below 1)")


@pytest.mark.parametrize("which", [0, 1, 2])
def test_footage_with_an_answer_that_is_no_number_is_not_judged(which):
    columns = list(film())
    columns[which] = columns[which].copy()
    columns[which][5] = np.nan
    outcome = C12.judge(*columns)
    assert outcome.verdict == "not shown" and "1 of 794 frames have no number" in outcome.measured


def test_long_silence_has_an_interval():
    """Resamples of silent stretches alone have no ratio; they raise nothing."""
    flow, hs, vs, *rest = film(frames=3000, moving=[(i, i + 2) for i in range(0, 300, 40)])
    hs[300:] = vs[300:] = 0.0
    assert C12.judge(flow, hs, vs, *rest).verdict in ("holds", "fails")


# The paper's stronger words about footage.


def busy(seconds, frames=LEAST_FRAMES, vs=0.0, flow=0.0, whole=12, rate=30):
    """HS over T in the first ``frames`` frames of so many seconds, a VS in them, and an even flow throughout."""
    hs, across = np.zeros(whole * rate), np.zeros(whole * rate)
    for second in range(seconds):
        hs[second * rate : second * rate + frames] = 0.3
        across[second * rate : (second + 1) * rate] = vs
    return np.full(whole * rate, float(flow)), hs, across, T_SP, float(rate)


@pytest.mark.parametrize(
    ("footage", "verdict"),
    [
        (busy(5), "holds"),
        (busy(5, vs=-0.3), "fails"),  # VS over T throughout
        (busy(4), "not shown"),  # too little over T, and too little to see
        (busy(4, flow=0.2), "fails"),  # too little over T, though the flow has translation in every second
        (busy(4, flow=-0.2), "fails"),
        (busy(4, flow=0.04), "not shown"),
        (busy(12, frames=LEAST_FRAMES - 1, flow=0.2), "fails"),  # flashes of two frames are no motion
        (busy(0, whole=0), "not shown"),
    ],
)
def test_the_paper_s_stronger_words(footage, verdict):
    outcome = C12.stronger(*footage)
    assert outcome.verdict == verdict
    assert bool(outcome.decided) == (verdict != "not shown")


def test_at_a_bound_nothing_is_over_it():
    """HS that equals T does not pass it, and a flow of `LEAST_FLOW` is no translation."""
    flow, hs, *rest = busy(12)
    assert C12.stronger(flow, np.where(hs > 0, T_SP, 0.0), *rest).verdict == "not shown"
    for least, verdict in ((LEAST_FLOW, "not shown"), (np.nextafter(LEAST_FLOW, 1), "fails")):
        even = np.full(1, least)  # a block of one frame: a mean over several might be rounded
        assert C12.stronger(np.repeat(even, 12), np.zeros(12), np.zeros(12), T_SP, 1.0).verdict == verdict


@pytest.mark.parametrize(("over", "verdict"), [(7, "holds"), (8, "fails")])
def test_vs_may_pass_in_one_frame_of_twenty(over, verdict):
    """Of the 150 frames of the seconds with HS over T; quiet footage beside them does not count."""
    for whole in (6, 60):
        flow, hs, vs, *rest = busy(5, whole=whole)
        vs[:over] = 0.2
        outcome = C12.stronger(flow, hs, vs, *rest)
        assert outcome.verdict == verdict and "of the 150 frames" in outcome.measured


def test_a_sway_is_no_translation():
    flow = np.sin(2 * np.pi * np.arange(360) / 30)
    _, hs, vs, *rest = busy(0)
    assert C12.stronger(flow, hs, vs, *rest).verdict == "not shown"


@pytest.mark.parametrize("which", [0, 1, 2])
def test_the_stronger_words_need_numbers_too(which):
    columns = list(busy(5))
    columns[which][5] = np.nan
    assert C12.stronger(*columns).verdict == "not shown"
