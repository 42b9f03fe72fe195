"""What the figure must show: every repeat, every condition apart from every other."""

import pyarrow as pa
import pytest
from matplotlib.collections import PathCollection

from experiments.bench.robot.figure import figure


def drawn(conditions, varies="speed_cm_s", repeats=3):
    rows = [
        {"trial": i, "motion": "translation", "direction": direction, "speed_cm_s": speed, "distance_cm": distance,
         "angle_deg": None, "far_cm": None, "shell_grey": None, "wall_contrast": None, "acceleration_cm_s2": 100.0,
         "observer_speed_cm_s": 0.0, "observer_turn_deg_s": 0.0, "model": "dsnn", "spikes": i}
        for i, (direction, speed, distance) in enumerate(conditions * repeats)
    ]  # fmt: skip
    frames = pa.table(
        {
            "trial": [row["trial"] for row in rows for _ in range(4)],
            "model": ["dsnn"] * 4 * len(rows),
            "hs": [0.1] * 4 * len(rows),
            "stimulus_bearing_deg": [20.0, 5.0, -5.0, -20.0] * len(rows),
        }
    )
    return figure(rows, frames, varies, "title", 0.2).axes


def series(axes):
    return [line.get_label() for line in axes.get_lines() if not line.get_label().startswith("_")]


def test_every_repeat_is_a_dot_and_a_trace():
    counts, traces = drawn([("rightward", speed, 8.0) for speed in (2.0, 4.0, 6.0)])
    dots = [c for c in counts.collections if isinstance(c, PathCollection)]
    assert sum(len(c.get_offsets()) for c in dots) == 9
    assert sum(len(line.get_xdata()) == 4 for line in traces.get_lines()) == 9


def test_conditions_beside_the_varied_one_stay_apart():
    """Two directions at two distances: four means at each speed, never one of all."""
    kinds = [(way, speed, far) for way in ("rightward", "leftward") for speed in (2.0, 4.0) for far in (5.0, 10.0)]
    counts, _ = drawn(kinds)
    assert series(counts) == ["rightward, 5 cm", "rightward, 10 cm", "leftward, 5 cm", "leftward, 10 cm"]
    means = [line for line in counts.get_lines() if line.get_label() in series(counts)]
    assert len({line.get_linestyle() for line in means}) == 4
    assert len({tuple(line.get_xdata()) for line in means}) == 4


@pytest.mark.parametrize("count", [3, 6, 7, 12])
def test_no_two_levels_share_a_colour(count):
    counts, _ = drawn([("rightward", float(speed), 8.0) for speed in range(1, count + 1)])
    dots = [c for c in counts.collections if isinstance(c, PathCollection)]
    assert len({tuple(c.get_facecolor()[0]) for c in dots}) == count


def test_a_single_trial_has_no_error_bar():
    counts, _ = drawn([("rightward", 2.0, 8.0), ("rightward", 4.0, 8.0)], repeats=1)
    assert not counts.containers
