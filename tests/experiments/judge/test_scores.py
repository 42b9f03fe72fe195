"""Scores of episodes and their intervals against tables and SciPy; what the claims need."""

import math

import numpy as np
import polars as pl
import pytest
from scipy import stats

from experiments.declare.behaviour import AVOIDANCE, FIXATION, OPTOMOTOR
from experiments.judge.scores import free_distance, mean, mean_difference, rate, rate_ratio, scores, summary, verdicts
from experiments.kinds.registry import claims_on
from experiments.paper.claims.behaviours import LGMD_EPISODES
from experiments.paper.page import FULL, QUICK, USUAL
from tests.helpers.episodes import STILL, gaze, judged, outcomes, rows

CLAIMS = claims_on("behaviours").values()

# --- scores -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("hits", "low", "high"), [(0, 0.0, 3.689), (1, 0.0253, 5.572), (10, 4.795, 18.39)])
def test_rates_have_garwoods_intervals(hits, low, high):
    """The table of Garwood 1936."""
    score = rate(rows(hits, 20 - hits, metres=0.05), "driven_m")
    assert (score.value, score.low, score.high) == pytest.approx((hits, low, high), rel=1e-3)


def test_free_distance_is_the_rates_reciprocal():
    played = rows(4, 6, metres=2.0)
    per_metre, free = rate(played, "driven_m"), free_distance(played)
    assert (free.value, free.low, free.high) == pytest.approx((5.0, 1 / per_metre.high, 1 / per_metre.low))
    assert free_distance(rows(0, 3)).value == math.inf


def test_the_ratio_of_rates_is_exact():
    """Equal counts over stretches of 1:4 are a ratio of 4; the interval of a half is symmetric in the logarithm."""
    score = rate_ratio(rows(10, metres=1.0), rows(10, metres=4.0))
    assert score.value == pytest.approx(4.0)
    assert score.low * score.high == pytest.approx(16.0)
    assert score.low < 4.0 < score.high
    assert rate_ratio(rows(9), rows(0, 9)).value == math.inf and rate_ratio(rows(9), rows(0, 9)).low > 1.0
    assert math.isnan(rate_ratio(rows(0, 5), rows(0, 5)).value)
    odd = rows(2, 2, metres=math.nan)
    assert math.isnan(rate(odd, "driven_m").low) and math.isnan(rate_ratio(odd, rows(2, 2)).low)


def test_what_differs_between_worlds_cancels_in_a_difference_at_equal_seeds():
    worlds = np.random.default_rng(0).normal(0, 100, 20)
    first, second = (rows(0, 20).with_columns(reward=pl.Series(worlds + more)) for more in (3.0, 0.0))
    score = mean_difference(first, second.reverse(), "reward")
    assert (score.value, score.low, score.high, score.n) == pytest.approx((3.0, 3.0, 3.0, 20))
    assert mean_difference(first[:5], second[5:], "reward") is None


def test_scores_are_those_of_the_env():
    assert set(scores(rows(1, 1), AVOIDANCE)) == {"collisions/min", "collisions/m", "free distance (m)", "return"}
    assert scores(rows(0, 4, in_view=0.5), FIXATION)["time on target"].value == 0.5
    assert mean(rows(1), "in_view") is None


def test_no_interval_of_a_share_goes_beyond_all_and_none_of_a_distance_below_0():
    """Student's interval of four episodes at 1, 1, 1 and 0.8 would end at 1.11."""
    shares = rows(0, 4).with_columns(in_view=pl.Series([1.0, 1.0, 1.0, 0.8]), off_axis_deg=pl.Series([0.0, 0, 0, 1.0]))
    on_target, off_axis = mean(shares, "in_view"), mean(shares, "off_axis_deg")
    assert on_target.low < on_target.value < on_target.high == 1.0
    assert 0.0 == off_axis.low < off_axis.value < off_axis.high
    other = shares.with_columns(in_view=0.0)
    assert mean_difference(shares, other, "in_view").high > 1.0  # of a difference nothing is cut


def test_a_summary_compares_collisions_with_those_of_the_reference():
    played = pl.concat([rows(12, 8, name="a"), rows(2, 18, metres=4.0, name="hybrid"), rows(0, 20, name="b")])
    table = summary(played, AVOIDANCE, "hybrid")
    values = {(row["behaviour"], row["measure"]): row for row in table.iter_rows(named=True)}
    assert values["a", "without collision"]["value"] == 0.4
    assert values["b", "without collision"]["ci_low"] == pytest.approx(0.025 ** (1 / 20)), "Clopper and Pearson's"
    ratio = rate_ratio(played.filter(model="a"), played.filter(model="hybrid"))
    row = values["a", "collisions/m, times hybrid"]
    assert (row["value"], row["ci_low"], row["ci_high"]) == (ratio.value, ratio.low, ratio.high)
    assert not [name for behaviour, name in values if behaviour == "hybrid" and "hybrid" in name]
    assert not [name for name in summary(gaze()[0], OPTOMOTOR, "still")["measure"] if "collision" in name]


# --- claims -----------------------------------------------------------------------------------------------------------


def words(hybrid, lgmd, straight):
    return {claim: one.verdict for claim, one in judged(hybrid=hybrid, lgmd=lgmd, straight=straight).items()}


def test_claims_hold_where_their_whole_interval_does():
    good = rows(1, 19, metres=4.0), rows(12, 8, metres=3.0), rows(20, metres=0.4)
    assert words(*good) == {"B1": "holds", "B2": "holds"}
    near = rows(10, 10, metres=3.0)  # rarer, but not for sure
    blind = rows(10, 10, metres=1.0)
    beside = judged(hybrid=near, lgmd=near, **{"lgmd-hybrid": blind})["B2"].measured
    assert str(rate_ratio(blind, near)) in beside and rate_ratio(blind, near).value == pytest.approx(3.0)
    assert words(near, rows(12, 8, metres=3.0), rows(20, metres=0.4))["B2"] == "fails"
    assert words(near, near, rows(20, metres=1.0))["B1"] == "fails"


def test_both_sides_of_a_comparison_need_twenty_seeds():
    claim = judged(hybrid=rows(1, 19, metres=4.0), straight=rows(3, metres=0.1))["B1"]
    assert claim.verdict == "not shown" and "(has 20 of hybrid, 3 of straight)" in claim.measured
    nobody = judged(hybrid=rows(0, 20), straight=rows(0, 20))["B1"]
    assert nobody.verdict == "not shown" and "no episode collided" in nobody.measured


def test_a_claim_is_judged_where_its_behaviours_were_to_play():
    hybrid = rows(1, 19, name="hybrid")
    assert not verdicts(CLAIMS, AVOIDANCE, ["hybrid"], hybrid)
    (lost,) = verdicts(CLAIMS, AVOIDANCE, ["hybrid", "straight"], hybrid)  # whose episodes failed
    assert (lost.id, lost.outcome.verdict) == ("B1", "not shown")


def test_episodes_without_the_measure_do_not_count():
    """Of 20 seeds one was disturbed: one gain is no mean of twenty."""
    steering, *others = gaze()
    steering = steering.with_columns(optomotor_gain=pl.when(pl.col("seed") == 0).then(0.9))
    claim = outcomes([steering, *others])["B3"]
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
    found = outcomes(gaze(**values))
    assert {claim for claim in ("B3", "B4") if found[claim].verdict == "holds"} == held
    assert all(found[claim].verdict == "fails" for claim in {"B3", "B4"} - held)
    assert outcomes(gaze(reward=math.nan))["B3"].verdict == "not shown"


@pytest.mark.parametrize("shift", [1, 20])
def test_it_is_compared_at_equal_seeds(shift):
    steering, still, *_ = gaze()
    assert outcomes([steering, still.with_columns(pl.col("seed") + shift)])["B3"].verdict == "not shown"


def test_the_end_of_the_interval_that_is_nearest_its_bound_decides():
    held, missed = outcomes(gaze(optomotor_gain=0.51))["B3"], outcomes(gaze(in_view=0.7))["B4"]
    assert held.verdict == "holds" and "0.51 (needs above 0.5)" in held.decided
    assert missed.verdict == "fails" and "0.7 (needs above 0.8)" in missed.decided


def test_b2_says_where_it_is_underpowered():
    enough = LGMD_EPISODES
    few = {"hybrid": rows(1, 19, metres=4.0, seconds=60.0), "lgmd": rows(12, 8, metres=3.0, seconds=60.0)}
    assert f"underpowered: 20 of {enough} episodes" in judged(**few)["B2"].decided
    many = {"hybrid": rows(1, enough - 1, seconds=60.0), "lgmd": rows(12, enough - 12, seconds=60.0)}
    assert "underpowered" not in judged(**many)["B2"].decided
    half = {name: side.with_columns(seconds=30.0) for name, side in many.items()}
    assert f"underpowered: {enough} of {enough} episodes, of 30 s in place of 60" in judged(**half)["B2"].decided


def test_a_full_reproduction_has_the_episodes_that_b2_takes():
    assert FULL.episodes >= LGMD_EPISODES > USUAL.episodes > QUICK.episodes
    assert FULL.steps is None, "whole episodes, as the pilot's"


def test_b2_takes_the_first_number_of_episodes_with_a_power_of_80_percent():
    """Summed over pairs of Poisson counts at the pilot's rates, by the exact binomial test that is the interval's."""
    share = 394.73 / (394.73 + 543.05)  # of LGMD's collisions, were the rates equal

    def power(episodes):
        often, seldom = stats.poisson(50 * episodes / 120), stats.poisson(14 * episodes / 120)
        return sum(
            seldom.pmf(fewer) * often.pmf(more)
            for fewer in range(25)
            for more in range(60)
            if stats.binom.sf(more - 1, more + fewer, share) < 0.025
        )

    assert power(LGMD_EPISODES - 1) < 0.8 <= power(LGMD_EPISODES)
