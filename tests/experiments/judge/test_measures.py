"""Measures against tables made by hand."""

import pytest

from experiments.judge.sweep import MEASURES, measured

POTENTIAL, COUNT, PEAK = (MEASURES[name].of for name in ("peak-speed-potential", "peak-speed-count", "peak-hs"))
SPEEDS = (2.0, 6.0, 15.0, 30.0)


def rows_of(potentials, counts=(0, 0, 0, 0)):
    """Two trials of a rightward crossing at each speed, whose means these are."""
    return [
        {
            "motion": "translation", "direction": "rightward", "speed_cm_s": speed, "achieved_speed_cm_s": speed,
            "path_error_mm": 0.0, "trial": 100 * place + repeat, "spikes": counts[place] + repeat,
            "mean_hs_near_axis": potentials[place] + spread,
        }
        for place, speed in enumerate(SPEEDS)
        for repeat, spread in enumerate((-0.01, 0.01))
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("potentials", "value"),
    [
        ((0.1, 0.5, 0.8, 0.7), 15.0),
        ((0.1, 0.5, 0.7, 0.8), 30.0),
        ((0.9, 0.5, 0.8, 0.7), 2.0),
        ((0.1, 0.8, 0.8, 0.7), 6.0),  # of equal ones the lowest speed
    ],
)
def test_the_peak_of_the_potential_is_where_its_mean_is_largest(potentials, value):
    assert POTENTIAL(rows_of(potentials))["value"] == value
    assert POTENTIAL(rows_of(potentials)[::-1])["value"] == value, "in any order of the rows"


def test_the_count_has_a_peak_of_its_own():
    rows = rows_of((0.1, 0.5, 0.8, 0.7), (0, 60, 30, 15))
    assert COUNT(rows)["value"] == 6.0
    one = max(rows, key=lambda row: row["spikes"])  # a single trial with many spikes is not the mean
    more = {**one, "speed_cm_s": 2.0, "achieved_speed_cm_s": 2.0, "trial": 999}
    assert COUNT([*rows, more])["value"] == 6.0


def test_a_mean_of_spikes_is_of_its_own_condition_and_has_no_end_below_none():
    rows = [
        {"speed_cm_s": speed, "spikes": n} for speed, counts in ((2.0, (0, 0, 3)), (4.0, (7, 8, 9))) for n in counts
    ]
    found = measured("spikes: speed_cm_s=2", {"speed_cm_s": 2.0}, rows)
    assert found == {"value": 1.0, "n": 3, "ci_low": 0.0, "ci_high": pytest.approx(1.0 + 4.303, abs=1e-3)}, "Student's"


def test_agreement_with_the_truth_is_a_mean_within_its_bounds_and_its_slope_a_line():
    """Gains of 0.5 - 0.01 times the speed; a trial without a number does not count."""
    rows = [
        {"speed_cm_s": speed, "true_gain": 0.5 - 0.01 * speed, "true_hs_flow_r": r, "true_sign": 1.0}
        for speed, r in zip(SPEEDS, (0.2, 0.9, 1.0, 0.7), strict=True)
    ]
    lost = {"speed_cm_s": 50.0, "true_gain": None, "true_hs_flow_r": None, "true_sign": None}
    slope, r, sign = (measured(f"true-{name}", {}, [*rows, lost]) for name in ("gain-slope", "r", "sign"))
    assert slope["value"] == pytest.approx(-0.01) and measured("true-gain-slope", {}, rows[:1])["value"] is None
    assert r["value"] == pytest.approx(0.7) and -1.0 <= r["ci_low"] < r["ci_high"] <= 1.0
    assert (sign["value"], sign["ci_low"], sign["ci_high"]) == (1.0, 1.0, 1.0)
    assert measured("true-r", {}, [lost])["value"] is None


def test_what_has_no_peak_has_no_value():
    rows = rows_of((0.1, 0.5, 0.8, 0.7))
    assert COUNT([{**row, "spikes": 0} for row in rows])["value"] is None
    assert POTENTIAL(rows_of((-0.1, -0.5, -0.8, -0.7)))["value"] is None
    off = [{**row, "achieved_speed_cm_s": 1.5 * row["speed_cm_s"]} for row in rows]
    assert POTENTIAL(off)["value"] is None


def test_the_lowest_peak_is_of_crossings_of_an_object():
    row = {"motion": "rightward", "object": "present", "clip": "a", "seed": 0, "trough_hs": 0.0, "peak_vs": 0.0,
           "trough_vs": 0.0}  # fmt: skip
    rows = [{**row, "peak_hs": 0.3}, {**row, "clip": "b", "peak_hs": 0.2}]
    assert PEAK([*rows, {**row, "object": "absent", "peak_hs": 0.01}])["value"] == 0.2
