"""Trials whose stimulus drives by time alone: what ends them, what is told of them, and what they are not held to."""

import dataclasses
import math

import pytest

from colias_sim import Robot, RobotConfig
from experiments.declare.conditions import Condition
from experiments.judge.judge import flaws
from experiments.show.course import nominal
from tests.experiments.show.test_trial import trial_of
from tests.helpers.played import Played

COLIAS4 = RobotConfig.preset("colias4")
CROSSING = Condition("translation", "rightward", 10.0, 8.0)


def driven(robot: RobotConfig) -> Played:
    return Played(trial_of(CROSSING, robot=robot))


def rows(result: Played) -> list[dict]:
    return [{**row, "wall_s": 0.0} for row in result.record.rows]


@pytest.fixture(scope="module")
def crossing() -> Played:
    return driven(COLIAS4)


def test_by_default_commands_reach_the_wheels_as_they_are(monkeypatch):
    """A trial of the default robot is one in which nothing stands between command and wheel, to the bit."""
    usual = driven(RobotConfig())

    def direct(self, wheels):
        for side, speed in zip(("left", "right"), wheels, strict=True):
            self._data.actuator(f"{self.name}/{side}").ctrl[:] = speed / (self.config.wheel_radius_cm / 100)

    monkeypatch.setattr(Robot, "drive", direct)
    bare = driven(RobotConfig())
    assert rows(usual) == rows(bare)
    assert usual.record.frames.equals(bare.record.frames)


def test_it_stops_by_time_whatever_it_reached(crossing):
    """After up to a slot of waiting, and whole slots of driving; the same again."""
    stimulus = nominal(CROSSING, crossing.trial.settings)["stimulus"]
    slots = math.ceil((stimulus.route.length / 0.10 + 0.10 / (2 * stimulus.acceleration)) / 0.1)
    assert crossing.columns.time_s[-1] == pytest.approx((1 + slots) * 0.1, abs=1e-6)
    assert rows(driven(COLIAS4)) == rows(crossing)
    assert abs(crossing.columns.stimulus_bearing_deg[[0, -1]]).min() > 35.0


def test_its_speed_and_drift_are_those_of_its_powers(crossing):
    """167 powers on the right, 167 - 3 + 3.29 on the left: a circle to the right of radius track / 2 (sum) / (gap)."""
    right, left = 167 * 0.06, (167 - 3 + 3.29) * 0.06
    assert crossing.achieved_speed_cm_s == pytest.approx((left + right) / 2 * (1 - 0.0074), rel=1e-3)
    x, y = crossing.columns.stimulus_x_cm, crossing.columns.stimulus_y_cm
    way = math.hypot(x[-1] - x[0], y[-1] - y[0])
    radius = 3.2 / 2 * (left + right) / (right - left)
    assert crossing.drift_mm == pytest.approx(10 * way**2 / 2 / radius, rel=0.05)
    assert crossing.path_error_mm > 1.0


def test_one_that_drifts_off_its_path_ends_and_counts():
    """Untrimmed motors turn it about before it has crossed."""
    lost = driven(dataclasses.replace(COLIAS4, motor_inequality=50.0))
    (row,) = rows(lost)
    assert lost.columns.time_s[-1] < 5.0 and abs(lost.drift_mm) > 20.0
    assert row["achieved_speed_cm_s"] < 9.9 and row["spikes"] >= 0
    assert row["drive"] == "open" and flaws([row]) == "", "no tolerance voids it"


def test_open_loop_and_powers_are_switched_apart():
    """With feedback coarse wheels keep to speed and path; without it perfect wheels lag behind, as the servo does."""
    steered = driven(dataclasses.replace(COLIAS4, open_loop=False))
    assert flaws(rows(steered)) == "" and rows(steered)[0]["drive"] == "feedback"
    blind = driven(RobotConfig(open_loop=True))
    assert blind.path_error_mm < 0.01
    assert blind.achieved_speed_cm_s == pytest.approx(10.0 * (1 - 0.0074), rel=1e-3)
