"""The judges of real footage (C12) and of the paper's stronger words about it, and the grades beside them."""

import numpy as np
import polars as pl
import pytest

from experiments.judge.motion import LEAST_FRAMES, LEAST_SECONDS, LEVEL, grades
from experiments.paper.claims.footage import c12, stronger
from experiments.show.video import mean_flow
from tests.helpers.footage import street

T_SP, RATE, SECONDS = 0.16, 30.0, 40


def film(frames=794, moving=((0, 794),)):
    """Flow and an HS that follows it over T in the ``moving`` stretches of frames, and a small VS."""
    rng = np.random.default_rng(0)
    flow = np.where(np.arange(frames) // 60 % 2, 1.0, -1.0)
    hs = np.zeros(frames)
    for start, end in moving:
        hs[start:end] = 0.3 * flow[start:end]
    return flow, hs + 1e-3 * rng.standard_normal(frames), 0.001 * rng.standard_normal(frames), T_SP, RATE


def test_c12_holds_fails_or_is_not_judged():
    flow, hs, vs, *rest = film()
    assert c12(flow, hs, vs, *rest).verdict == "holds"
    assert c12(-flow, hs, vs, *rest).verdict == "fails"
    assert c12(flow, hs, 2 * hs, *rest).decided.startswith("mean |VS| / |HS| 2.00")
    wrong = flow * np.where(np.arange(794) % 8 == 0, -1, 1)  # the sign of one frame in eight: still correlated
    assert c12(wrong, hs, vs, *rest).verdict == "fails"
    assert c12(flow, hs / 10, vs, *rest).verdict == "not shown"


def test_a_few_frames_over_the_threshold_do_not_decide_c12():
    """2 of 794 agree, which by chance alone is as likely as not to be so."""
    for moving, seconds in ([((400, 402),), 1], [((10, 20), (300, 310)), 2], [((0, 119),), 4], [(), 0]):
        outcome = c12(*film(moving=moving))
        assert outcome.verdict == "not shown"
        assert f"at least {LEAST_SECONDS} separate seconds of footage (has {seconds})" in outcome.measured


def test_intervals_are_those_of_seconds_not_of_frames():
    outcome = c12(*film(moving=[(start, start + 3) for start in range(0, 600, 60)]))
    low, high = outcome.measured.split("same sign over T 1.00 [")[1].split("]")[0].split(", ")
    assert (float(low), float(high)) == (pytest.approx(0.025 ** (1 / 10), abs=0.006), 1.0)
    rng = np.random.default_rng(2)
    flow, hs = (np.repeat(rng.standard_normal(40), 30) for _ in range(2))
    outcome = c12(flow, hs, np.zeros(1200), T_SP, RATE)
    low, high = (float(part) for part in outcome.measured.split("[")[1].split("]")[0].split(","))
    assert high - low > 2 / np.sqrt(40)  # 1200 frames taken as independent would give 0.11
    assert low < np.corrcoef(flow, hs)[0, 1] < high


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
        (busy(5, vs=0.15), "holds"),  # VS near T, and below it
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
    assert stronger(*footage).verdict == verdict


def test_flow_is_rightward_positive():
    frames = [frame.luma for frame in street()][48:50]
    assert mean_flow(*frames) > 0.01
    assert mean_flow(*(frame[:, ::-1].copy() for frame in frames)) < -0.01


FLOW = np.sign(np.sin(np.pi * np.arange(RATE * SECONDS) / 60 + 0.01))
"""Flow that turns every two seconds, px per frame."""


def noise(seed: int) -> np.ndarray:
    return np.random.default_rng(seed).standard_normal(len(FLOW))


def graded(hs: np.ndarray, flow: np.ndarray = FLOW) -> dict:
    """Grades of columns, before which there is a first frame that has no flow."""
    columns = {"flow": [None, *flow], "hs": [9.0, *hs], "vs": [0.0] * (len(hs) + 1)}
    return grades(pl.DataFrame({**columns, "time_s": np.arange(len(hs) + 1) / RATE}), T_SP)


def test_a_weak_network_that_follows_is_told_from_one_that_does_not():
    """Both stay below the threshold, so that no claim about spikes tells them apart."""
    follows, ignores = graded(0.05 * FLOW), graded(0.03 * noise(1))
    assert follows["passing_s"] == ignores["passing_s"] == 0
    assert follows["flow_r"] == pytest.approx(1.0) and follows["right_sign"] == 1.0
    assert ignores["flow_r_low"] < 0 < ignores["flow_r_high"]
    assert ignores["right_sign_low"] < 0.5 < ignores["right_sign_high"]


@pytest.mark.parametrize(("frames", "passed"), [(LEAST_FRAMES - 1, 0), (LEAST_FRAMES, 7)])
def test_a_second_passes_the_threshold_by_enough_of_its_frames(frames, passed):
    hs = np.zeros_like(FLOW)
    for second in range(7):
        hs[second * int(RATE) : second * int(RATE) + frames] = -2 * T_SP  # leftward counts as rightward does
    row = graded(hs)
    assert row["passing_s"] == passed / SECONDS and row["passing_s_low"] <= passed / SECONDS <= row["passing_s_high"]


def test_the_interval_of_the_sign_is_of_seconds_and_what_cannot_be_graded_is_null():
    """All frames of one second agree: that is one piece of evidence, not thirty."""
    row = graded(np.where(np.arange(len(FLOW)) < RATE, 2 * LEVEL, 0.0) * FLOW)
    assert row["right_sign"] == 1.0 and row["right_sign_low"] < 0.05
    silent = graded(np.zeros_like(FLOW))
    assert silent["flow_r"] == 0 and silent["right_sign"] is None
    assert set(graded(FLOW[:59], FLOW[:59]).values()) == {None}


def test_a_network_of_the_other_sign_has_the_opposite_grade():
    with_it, against = (graded(sign * (0.05 * FLOW + 0.02 * noise(2))) for sign in (1, -1))
    assert with_it["flow_r"] == pytest.approx(-against["flow_r"])
    assert with_it["right_sign"] + against["right_sign"] == pytest.approx(1.0)
