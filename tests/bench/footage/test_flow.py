"""The two grades of footage: what they tell of networks that follow, oppose or ignore the flow."""

import numpy as np
import pytest

from experiments.bench.footage.flow import LEVEL, Grades
from experiments.bench.footage.watch import LEAST_FRAMES

RATE, SECONDS, T = 30.0, 40, 0.16


def flow() -> np.ndarray:
    """Flow that turns every two seconds, px per frame."""
    return np.sign(np.sin(np.pi * np.arange(RATE * SECONDS) / 60 + 0.01))


def noise(seed: int) -> np.ndarray:
    return np.random.default_rng(seed).standard_normal(int(RATE * SECONDS))


def test_a_weak_network_that_follows_is_told_from_one_that_does_not():
    """Both stay below the threshold, so that no claim about spikes tells them apart."""
    follows = Grades.of(flow(), 0.05 * flow(), T, RATE)
    ignores = Grades.of(flow(), 0.03 * noise(1), T, RATE)
    assert follows.passed == ignores.passed == 0
    assert follows.r == pytest.approx(1.0) and follows.told == follows.level == len(flow())
    assert ignores.r_interval[0] < 0 < ignores.r_interval[1]
    assert ignores.told_interval[0] < 0.5 < ignores.told_interval[1]


def test_a_network_of_the_other_sign_has_the_opposite_grade():
    with_it, against = (Grades.of(flow(), sign * (0.05 * flow() + 0.02 * noise(2)), T, RATE) for sign in (1, -1))
    assert with_it.r == pytest.approx(-against.r)
    assert with_it.told + against.told == with_it.level == against.level


def test_smoothing_takes_away_what_is_faster_than_motion():
    hs = 0.05 * flow() + 0.1 * noise(3)
    assert Grades.of(flow(), hs, T, RATE).r > 1.5 * np.corrcoef(flow(), hs)[0, 1]


@pytest.mark.parametrize(("frames", "passed"), [(LEAST_FRAMES - 1, 0), (LEAST_FRAMES, 7)])
def test_a_second_passes_the_threshold_by_enough_of_its_frames(frames, passed):
    hs = np.zeros_like(flow())
    for second in range(7):
        hs[second * int(RATE) : second * int(RATE) + frames] = -2 * T  # leftward counts as rightward does
    grades = Grades.of(flow(), hs, T, RATE)
    assert (grades.passed, grades.seconds) == (passed, SECONDS)
    assert grades.passed_interval[0] <= passed / SECONDS <= grades.passed_interval[1]


def test_the_interval_of_the_sign_is_of_seconds_not_of_frames():
    """All frames of one second agree: that is one piece of evidence, not thirty."""
    hs = np.where(np.arange(len(flow())) < RATE, 2 * LEVEL, 0.0) * flow()
    grades = Grades.of(flow(), hs, T, RATE)
    assert grades.told == grades.level == RATE and grades.told_interval[0] < 0.05


def test_a_silent_network_has_no_sign():
    grades = Grades.of(flow(), np.zeros_like(flow()), T, RATE)
    assert grades.level == 0 and grades.r == 0 and "no frame has |HS| over 0.02" in grades.lines()[0]


def test_what_cannot_be_graded():
    gap = 0.05 * flow()
    gap[5] = np.nan
    assert Grades.of(flow(), gap, T, RATE) is None
    assert Grades.of(flow()[:59], flow()[:59], T, RATE) is None
