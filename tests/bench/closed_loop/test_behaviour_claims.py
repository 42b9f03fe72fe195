"""Claims about behaviours: how many seeds they take, of whom, and what decided."""

import math

import pytest

from experiments.behaviours import OPTOMOTOR
from experiments.bench.closed_loop.scores import rate, rate_ratio
from tests.helpers.episodes import STILL, gaze, judged, outcomes, rows


def test_both_sides_of_a_comparison_need_twenty_seeds():
    claim = judged(hybrid=rows(1, 19, metres=4.0), straight=rows(3, metres=0.1))["B1"]
    assert claim.verdict == "not shown" and "(has 20 of hybrid, 3 of straight)" in claim.measured


def test_episodes_without_the_measure_do_not_count():
    """Of 20 seeds one was disturbed: one gain is no mean of twenty."""
    played = gaze()
    steering = played[OPTOMOTOR]["optomotor-pi"]
    played[OPTOMOTOR]["optomotor-pi"] = [
        row | {"optomotor_gain": 0.9 if row["seed"] == 0 else None} for row in steering
    ]
    claim = outcomes(played)["B3"]
    assert claim.verdict == "not shown" and "(has 1 of optomotor-pi, 1 of still)" in claim.measured


@pytest.mark.parametrize(("values", "held"), [
    ({}, {"B3", "B4"}),
    ({"optomotor_gain": 0.5}, {"B4"}),
    ({"in_view": 0.79}, {"B3"}),
    ({"rms_slip_deg_s": STILL["rms_slip_deg_s"]}, {"B4"}),  # no less than the still robot
    ({"rms_off_axis_deg": STILL["rms_off_axis_deg"]}, {"B3"}),
    ({"reward": STILL["reward"]}, set()),
])  # fmt: skip
def test_a_reflex_has_its_level_and_is_better_than_a_still_robot(values, held):
    claim_outcomes = outcomes(gaze(**values))
    assert {claim for claim in ("B3", "B4") if claim_outcomes[claim].verdict == "holds"} == held
    assert all(claim_outcomes[claim].verdict == "fails" for claim in {"B3", "B4"} - held)


def test_it_is_compared_at_equal_seeds():
    played = gaze()
    for shift in (1, 20):
        played[OPTOMOTOR]["still"] = [row | {"seed": row["seed"] + shift} for row in rows(0, 20, **STILL)]
        assert outcomes(played)["B3"].verdict == "not shown"
    del played[OPTOMOTOR]["still"]
    assert outcomes(played)["B3"].verdict == "not shown"


def test_a_measure_that_is_no_number_is_not_judged():
    assert outcomes(gaze(reward=math.nan))["B3"].verdict == "not shown"
    nobody = judged(hybrid=rows(0, 20), straight=rows(0, 20))["B1"]
    assert nobody.verdict == "not shown" and "no episode collided" in nobody.measured


@pytest.mark.parametrize("order", [1, -1])
def test_a_stretch_that_is_no_number_has_no_rate(order):
    odd = rows(2, 2, metres=math.nan)
    assert math.isnan(rate(odd, "driven_m").value) and math.isnan(rate(odd, "driven_m").low)
    ratio = rate_ratio(*(odd, rows(2, 2))[::order])
    assert math.isnan(ratio.value) and math.isnan(ratio.low)


def test_the_end_of_the_interval_that_decided_is_said():
    held = outcomes(gaze(optomotor_gain=0.51))["B3"]
    decided = "optomotor gain: lower end of the 95 % interval 0.51 (needs above 0.5)"
    assert (held.verdict, held.decided) == ("holds", decided)
    missed = outcomes(gaze(in_view=0.7))["B4"]
    decided = "time on target: lower end of the 95 % interval 0.7 (needs above 0.8)"
    assert (missed.verdict, missed.decided) == ("fails", decided)
