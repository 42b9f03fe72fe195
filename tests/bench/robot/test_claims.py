"""The judges on made-up trials: what holds, what fails, and what cannot be judged."""

import pytest

from experiments.bench.sources.judge import judge as outcome
from experiments.bench.stats.claim import claims_on

CLAIMS = claims_on("robot")


def rows(spikes_by, column, direction="rightward", achieved=1.0, **fixed):
    return [
        {"motion": "translation", "direction": direction, "speed_cm_s": 6.0, "distance_cm": 8.0, "peak_hs": 0.5,
         "trough_hs": -0.01, "path_error_mm": 0.1, "shell_grey": None, "wall_contrast": None,
         "observer_speed_cm_s": 0.0, "observer_turn_deg_s": 0.0, "angle_deg": None, "mean_hs_near_axis": 0.4,
         **fixed, column: float(level), "spikes": count, "spikes_in_window": count, "spikes_in_inner_window": count}
        | {"achieved_speed_cm_s": (float(level) if column == "speed_cm_s" else 6.0) * achieved}
        for level, counts in spikes_by.items()
        for count in counts
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("means", "verdict"),
    [
        ((0, 40, 60, 45), "holds"),
        ((0, 40, 60, 60), "fails"),  # not fewer at 10
        ((0, 40, 60, 70), "fails"),
        ((5, 5, 60, 45), "fails"),  # does not rise from 2 to 4
        ((0, 60, 50, 45), "fails"),  # the peak is at 4
    ],
)
def test_c15(means, verdict):
    trials = rows(dict(zip((2, 4, 6, 10), ([m] * 4 for m in means), strict=True)), "speed_cm_s")
    assert outcome("C15", trials, 0.2).verdict == verdict


@pytest.mark.parametrize(
    ("means", "verdict"),
    [((60, 40, 30), "holds"), ((60, 40, 31), "fails"), ((60, 61, 0), "fails"), ((0, 0, 0), "fails")],
)
def test_c16(means, verdict):
    trials = rows(dict(zip((5, 10, 15), ([m] * 4 for m in means), strict=True)), "distance_cm")
    assert outcome("C16", trials, 0.2).verdict == verdict


def test_c14_needs_both_directions_and_every_trial():
    right = rows({6: [9] * 5}, "speed_cm_s")
    left = rows({6: [9] * 5}, "speed_cm_s", "leftward", peak_hs=0.0, trough_hs=-0.4)
    assert outcome("C14", right + left, 0.2).verdict == "holds"
    assert outcome("C14", right, 0.2).verdict == "not shown"
    assert outcome("C14", right + rows({6: [9]}, "speed_cm_s", "leftward", trough_hs=-0.19), 0.2).verdict == "fails"
    assert outcome("C14", right + rows({6: [9]}, "speed_cm_s", peak_hs=0.19), 0.2).verdict == "fails"
    both_ways = rows({6: [9] * 5}, "speed_cm_s", "leftward", peak_hs=0.8, trough_hs=-0.9)
    assert outcome("C14", right + both_ways, 0.2).verdict == "fails", "it passes the threshold of either direction"


@pytest.mark.parametrize("claim", CLAIMS)
def test_no_trials_no_verdict(claim):
    assert outcome(claim, [], 0.2).verdict == "not shown"
    assert outcome(claim, rows({3: [1]}, "speed_cm_s", "leftward"), 0.2).verdict in ("not shown", "fails")


def test_trials_that_were_not_what_they_say_are_not_judged():
    spikes = dict(zip((2, 4, 6, 10), ([m] * 4 for m in (0, 40, 60, 45)), strict=True))
    slow = outcome("C15", rows(spikes, "speed_cm_s", achieved=0.97), 0.2)
    assert (slow.verdict, slow.n) == ("not shown", 16)
    assert "16 of 16 trials were off the commanded speed, by up to 3%" in slow.measured
    astray = outcome("C15", rows(spikes, "speed_cm_s", path_error_mm=1.5), 0.2)
    assert astray.verdict == "not shown" and "up to 1.5 mm" in astray.measured
    elsewhere = rows(spikes, "speed_cm_s") + depth("approach", {0: [1]}, path_error_mm=1.5)
    assert outcome("C15", elsewhere, 0.2).verdict == "holds", "another motion's flaw is not this claim's"


def test_trials_driven_open_loop_are_judged_by_what_they_did():
    spikes = dict(zip((2, 4, 6, 10), ([m] * 4 for m in (0, 40, 60, 45)), strict=True))
    off = {"achieved": 0.97, "path_error_mm": 4.0}
    assert outcome("C15", rows(spikes, "speed_cm_s", drive="feedback", **off), 0.2).verdict == "not shown"
    assert outcome("C15", rows(spikes, "speed_cm_s", drive="open", **off), 0.2).verdict == "holds"
    nowhere = [row | {"achieved_speed_cm_s": float("nan")} for row in rows(spikes, "speed_cm_s", drive="open")]
    lost = outcome("C15", nowhere, 0.2)
    assert lost.verdict == "not shown" and "16 of 16 trials have no measured speed" in lost.measured


def test_conditions_of_the_other_direction_do_not_count():
    trials = rows(dict(zip((2, 4, 6, 10), ([m] for m in (0, 40, 60, 45)), strict=True)), "speed_cm_s", "leftward")
    assert outcome("C15", trials, 0.2).verdict == "not shown"


def depth(motion, spikes_by_angle, **changed):
    return rows(spikes_by_angle, "angle_deg", "straight", motion=motion, **changed)


def test_c13_counts_every_spike():
    silent = depth("approach", {0: [0] * 5}) + depth("recession", {0: [0] * 5})
    assert outcome("C13", silent, 0.2).verdict == "holds"
    assert outcome("C13", silent + depth("recession", {0: [1]}), 0.2).verdict == "fails"
    assert outcome("C13", depth("approach", {0: [0]}), 0.2).verdict == "not shown"
    assert outcome("C13", depth("approach", {0: [3]}), 0.2).verdict == "fails", "one motion is enough to fail"


@pytest.mark.parametrize(
    ("means", "fewest", "sides"),
    [
        ((11, 8, 0, 2, 8), "holds", True),
        ((11, 8, 3, 2, 8), "fails", True),  # fewer at 15 than ahead
        ((11, 8, 0, 0, 8), "fails", True),  # as few at 15 as ahead
        ((8, 11, 0, 2, 8), "fails", True),  # more at -15 than at -30
        ((8, 2, 0, 8, 11), "holds", False),
    ],
)
def test_c17_to_c20(means, fewest, sides):
    counts = dict(zip((-30, -15, 0, 15, 30), ([m] * 4 for m in means), strict=True))
    assert outcome("C17", depth("approach", counts), 0.2).verdict == fewest
    assert outcome("C18", depth("approach", counts), 0.2).verdict == ("holds" if sides else "fails")
    assert outcome("C19", depth("recession", counts), 0.2).verdict == fewest
    assert outcome("C20", depth("recession", counts), 0.2).verdict == ("fails" if sides else "holds")
    assert outcome("C17", depth("recession", counts), 0.2).verdict == "not shown"


def test_other_experiments_trials_do_not_count():
    spikes = dict(zip((2, 4, 6, 10), ([m] * 4 for m in (0, 40, 60, 45)), strict=True))
    mixed = rows(spikes, "speed_cm_s") + rows({6: [0] * 9}, "speed_cm_s", observer_turn_deg_s=5.0)
    assert outcome("C15", mixed, 0.2).verdict == "holds"
