"""Claims about behaviours: how many seeds they take, of whom, and what decided."""

import math

import pytest

from experiments.bench.closed_loop.scores import rate, rate_ratio
from tests.helpers.episodes import judged, rows


def test_both_sides_of_a_comparison_need_twenty_seeds():
    claim = judged(hybrid=rows(1, 19, metres=4.0), straight=rows(3, metres=0.1))["B1"]
    assert claim.verdict == "not shown" and "(has 20 of hybrid, 3 of straight)" in claim.measured


def test_episodes_without_the_measure_do_not_count():
    """Of 20 seeds one was disturbed: one gain is no mean of twenty."""
    known = rows(0, 20, optomotor_gain=0.9)
    few = [row | {"optomotor_gain": 0.9 if row["seed"] == 0 else None} for row in known]
    claim = judged(optomotor=few)["B3"]
    assert claim.verdict == "not shown" and "(has 1 of optomotor)" in claim.measured and claim.n == 1
    assert judged(optomotor=known)["B3"].verdict == "holds"


def test_a_measure_that_is_no_number_is_not_judged():
    gains = [row | {"optomotor_gain": math.nan if row["seed"] == 7 else 0.9} for row in rows(0, 20)]
    assert judged(optomotor=gains)["B3"].verdict == "not shown"
    nobody = judged(hybrid=rows(0, 20), straight=rows(0, 20))["B1"]
    assert nobody.verdict == "not shown" and "no episode collided" in nobody.measured


@pytest.mark.parametrize("order", [1, -1])
def test_a_stretch_that_is_no_number_has_no_rate(order):
    odd = rows(2, 2, metres=math.nan)
    assert math.isnan(rate(odd, "driven_m").value) and math.isnan(rate(odd, "driven_m").low)
    ratio = rate_ratio(*(odd, rows(2, 2))[::order])
    assert math.isnan(ratio.value) and math.isnan(ratio.low)


def test_the_end_of_the_interval_that_decided_is_said():
    held = judged(optomotor=rows(0, 20, optomotor_gain=0.9))["B3"]
    assert (held.verdict, held.decided) == ("holds", "lower end of the 95 % interval 0.9 (needs above 0.5)")
    missed = judged(fixation=rows(0, 20, in_view=0.7))["B4"]
    assert (missed.verdict, missed.decided) == ("fails", "lower end of the 95 % interval 0.7 (needs above 0.8)")
