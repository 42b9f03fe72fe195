"""Laws of tuning curves, on responses made up by formulas."""

import math

import numpy as np
import polars as pl
import pytest

from experiments.judge import curves

TURNS = 22.5 * np.arange(16)
X, OCTAVES = [1.0 + i for i in range(11)], [1.0, 2.0, 4.0, 8.0, 16.0]
DENSE = 0.5 * np.arange(720)


@pytest.mark.parametrize(
    ("shape", "dsi"),
    [
        (lambda a: np.cos(np.radians(a - 90)), math.pi / 4),
        (lambda a: (a == 90.0).astype(float), 1.0),
        (lambda a: 0.3 + 0 * a, 0.0),
        (lambda a: np.abs(np.cos(np.radians(a))), 0.0),
    ],
    ids=["a cosine", "one direction", "all alike", "an axis"],
)
def test_the_index_of_known_shapes(shape, dsi):
    index, turn = curves.selectivity(DENSE, shape(DENSE))
    assert index == pytest.approx(dsi, abs=1e-4)
    assert dsi == 0.0 or turn == pytest.approx(90.0)


def test_selectivity_has_no_scale_and_turns_and_mirrors_with_the_response():
    responses = np.random.default_rng(0).uniform(-1, 1, 16)
    index, turn = curves.selectivity(TURNS, responses)
    for changed, expected in (
        (7 * responses, turn),
        (np.roll(responses, 4), turn + 90.0),
        (np.roll(responses[::-1], 1), -turn),
    ):
        index_changed, turn_changed = curves.selectivity(TURNS, changed)
        assert index_changed == pytest.approx(index)
        assert abs((turn_changed - expected + 180.0) % 360.0 - 180.0) < 1e-9
    assert curves.selectivity(TURNS, -np.abs(responses)) is None and curves.selectivity([], []) is None


@pytest.mark.parametrize("place", range(11))
@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e3])
def test_a_curve_with_one_peak_prefers_it_at_any_scale(place, scale):
    responses = scale * np.exp(-(((np.arange(11) - place) / 3) ** 2))
    best = curves.preferred(X, responses)
    assert best == (X[place], X[place]) and curves.undefined_peak(responses) == ""
    assert curves.inside(X, best) == (0 < place < 10)
    assert curves.range_text(X, best) == {0: "≤1", 10: "≥11"}.get(place, f"{X[place]:g}")


def test_plateaus_and_silence():
    assert curves.range_text(OCTAVES, curves.preferred(OCTAVES, [0.1, 0.9, 0.899, 0.2, 0.1])) == "2..4"
    assert curves.range_text(X, curves.preferred(X, [1.0] * 11)) == "flat"
    assert curves.preferred(OCTAVES, [0.0, -1.0, 0.0, 0.0, 0.0]) is None and curves.preferred([], []) is None


def test_noise_prefers_nothing():
    rng = np.random.default_rng(1)
    defined = sum(curves.undefined_peak(rng.normal(size=10)) == "" for _ in range(40))
    assert defined <= 6, "of noise one in twenty passes: more than 6 of 40 have a chance of 1 in 200"
    assert curves.undefined_peak([0.1, 0.9, 0.2, 0.8, 0.0, 0.9, 0.1, 0.7, 0.3])
    ramp = np.arange(5.0)
    assert curves.undefined_peak(np.add.outer(ramp, ramp)) == curves.undefined_peak([1.0, math.nan, 2.0]) == ""


def test_a_direction_is_defined_where_its_interval_is_narrower_than_the_step():
    assert curves.undefined_direction([350.0, 2.0, 355.0, 5.0, 358.0], 22.5) == "", "angles go round"
    assert curves.undefined_direction([310.0, 350.0, 347.0, 343.0, 320.0], 22.5)
    assert curves.undefined_direction([40.0], 22.5) == "", "one phase says nothing of noise"
    assert curves.direction_noise([358.0, 0.0, 2.0]) == pytest.approx(4.3027 * 2 / math.sqrt(3), rel=1e-3), "Student's"
    rng = np.random.default_rng(0)
    samples = rng.normal(90.0, 8.0, (400, 5))
    covered = np.mean([abs(turns.mean() - 90.0) <= curves.direction_noise(turns) for turns in samples])
    assert 0.92 <= covered <= 0.98


def test_half_contrast_is_between_points_on_a_log_axis():
    assert curves.half_contrast([0.01, 0.1, 1.0], [0.0, 0.25, 0.75]) == pytest.approx(0.1 * 10**0.25)
    assert curves.half_contrast([0.1, 1.0], [0.9, 1.0]) is None, "it is lower than what was shown"
    assert curves.half_contrast([0.1, 1.0], [0.0, 0.0]) is None and curves.half_contrast([], []) is None


@pytest.mark.parametrize(("slope", "best"), [(0.0, lambda x: 4.0 + 0 * x), (1.0, lambda x: 40.0 * x)])
def test_the_slope_tells_temporal_frequency_from_speed(slope, best):
    x = np.array([1 / 40, 1 / 20, 1 / 10, 1 / 5])
    assert curves.speed_slope(x, best(x)) == pytest.approx(slope)
    assert curves.speed_slope(x, np.where(x > 0.06, math.nan, best(x))) is None


def test_a_column_of_a_map_prefers_only_a_maximum_inside():
    columns = [[0, 0.5, 1, 0.5, 0.1], [0.9, 0.5, 0.4, 0.3, 0.1], [0, 0.01, 0.02, 0.01, 0], [0.5, 1, 1, 0.2, 0.1],
               [0.5, 1, 1, 1, math.nan]]  # fmt: skip
    best = curves.best_rows(OCTAVES, np.array(columns, float).T)
    np.testing.assert_allclose(best, [4.0, math.nan, math.nan, math.sqrt(8), math.nan])


def test_a_map_has_holes_where_points_are_missing():
    points = pl.DataFrame({"x": [1.0, 2.0, 2.0], "y": [4.0, 3.0, 4.0], "response": [4.0, 6.0, 8.0]})
    np.testing.assert_array_equal(curves.grid(points.reverse())[2], [[math.nan, 6.0], [4.0, 8.0]])


def test_a_response_is_steady_and_along_the_motion():
    series = {"hs": np.arange(10.0), "vs": np.arange(10.0), "looming": np.array([0.9, *[0.5] * 4, 0.75, *[0.5] * 4]),
              "looming_spikes": np.array([0, 0, 0, 1, 1, 0, 0, 0, 0, 0])}  # fmt: skip
    moving = np.arange(2, 8)
    along, against, across = (curves.response(series, moving, turn, ("hs", "vs")) for turn in (45.0, 225.0, 135.0))
    assert along["hs"] == 6.0 and along["response"] == pytest.approx(math.hypot(6.0, 6.0))
    assert against["response"] == -along["response"] and across["response"] == pytest.approx(0.0)
    contact_s = np.linspace(0.8, -0.1, 10)
    looming = curves.response(series, moving, 0.0, ("hs", "looming"), approach=True, contact_s=contact_s)
    assert (looming["response"], looming["spikes"]) == (0.25, 2) and looming["contact_s"] == pytest.approx(0.5)


def test_an_ideal_detector_points_along_the_motion_and_a_mirrored_one_against_it():
    for sign, error in ((1.0, 0.0), (-1.0, 180.0)):
        ideal = {"hs": sign * np.cos(np.radians(TURNS)), "vs": sign * np.sin(np.radians(TURNS))}
        assert curves.pointing_error(pl.DataFrame({"direction_deg": TURNS, **ideal})) == pytest.approx(error)
    assert curves.pointing_error(pl.DataFrame({"direction_deg": TURNS, "hs": 0 * TURNS, "vs": 0 * TURNS})) is None
