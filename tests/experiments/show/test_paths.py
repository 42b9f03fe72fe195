"""Paths of one's own: what they do in trials, and what is refused before any."""

import math

import numpy as np
import pytest

from colias_sim import CameraConfig
from experiments import Condition, Experiment, Leg, Trajectory, UsageError
from experiments.declare.experiment import Listed
from tests.experiments.show.test_trial import trial_of
from tests.helpers import plans
from tests.helpers.played import Played

QUIET = CameraConfig(shot_noise=0.0, read_noise=0.0, exposure_ms=0.0)


def result_of(condition, *, maps=False, **changes):
    return Played(trial_of(condition, pose_sd_mm=0.0, heading_sd_deg=0.0, **changes), maps=maps)


def planned(*conditions, assignments=()):
    return plans.planned(Experiment("mine", "", Listed(conditions), "motion", 1), ("dsnn",), assignments, 1)


def crossing(speed=4.0, to=20.0, length=20.0, **place):
    return Trajectory([Leg(length, speed, to)], **{"x_cm": 8.0, "y_cm": 10.0, "heading_deg": -90.0, **place})


def slalom(t):
    return 9.0 + 1.5 * math.sin(2.0 * t), 8.0 - 4.0 * t


def test_the_legs_of_a_path_are_the_stretches_of_its_route():
    """In m, s and rad, after a run-up; that a robot drives them so is a law of test_drive.py."""
    legs = [Leg(20, 4, 20), Leg(turn_deg=60, seconds=0.5), Leg(6, 6, turn_deg=30)]
    run_up, ahead, corner, arc = Trajectory(legs, 8.0, 10.0, -90.0).stimulus_route(1.0).stretches
    assert run_up.speed == run_up.end_speed == pytest.approx(0.04) and run_up.length > 0.0
    assert (ahead.length, ahead.speed, ahead.end_speed) == pytest.approx((0.2, 0.04, 0.2))
    assert (corner.seconds, corner.rate) == pytest.approx((0.5, math.radians(120)))
    assert (arc.length, arc.speed, arc.end_speed, arc.turn) == pytest.approx((0.06, 0.06, 0.06, math.radians(30)))


def test_a_mirrored_path_has_left_and_right_exchanged():
    path = Trajectory([Leg(6, 6), Leg(turn_deg=60, seconds=0.5), Leg(6, 6)], x_cm=8.0, y_cm=9.0, heading_deg=-120.0)
    assert [Condition.along("zig-zag", p).direction for p in (path, path.mirrored())] == ["rightward", "leftward"]
    for way in (0.02, 0.08, 0.12):
        one, other = (p.stimulus_route(1.0).point(way) for p in (path, path.mirrored()))
        assert (other.x, other.y) == pytest.approx((one.x, -one.y))


@pytest.mark.parametrize(("x_cm", "heading_deg"), [(16.0, 180.0), (6.0, 0.0)], ids=["approach", "recession"])
def test_a_path_s_distance_is_that_of_its_nearest_place(x_cm, heading_deg):
    assert Condition.along("mine", Trajectory([Leg(10, 5)], x_cm, 0.0, heading_deg)).distance_cm == 6.0


def test_a_function_of_time_is_followed():
    """The stimulus comes through the places of the function, in its time."""
    path = Trajectory.of_time(slalom, seconds=4)
    result = result_of(Condition.along("slalom", path))
    times = np.linspace(0.0, 4.0, 2001)
    places = np.array([slalom(t) for t in times])
    x, y = result.columns.stimulus_x_cm - CameraConfig().forward_cm, result.columns.stimulus_y_cm
    away = np.hypot(x[:, None] - places[:, 0], y[:, None] - places[:, 1])
    on_path = (y < 7.5) & (y > -7.9)
    assert away[on_path].min(axis=1).max() < 0.08
    late = result.columns.time_s[on_path] - times[away[on_path].argmin(axis=1)]
    assert np.ptp(late) < 0.05
    assert path.length_cm == pytest.approx(np.hypot(*np.diff(places, axis=0).T).sum(), rel=1e-3)


def test_observer_and_movers_take_their_paths():
    """An observer that turns 20 degrees in an arc while a mover crosses behind the stimulus, seen darker there."""
    seer = Trajectory([Leg(4, 2, turn_deg=20)])
    mover = crossing(5, 5, x_cm=20.0)
    with_mover, without = (
        result_of(Condition.along("pair", crossing(6, 6), observer=seer, movers=movers), maps=True, camera=QUIET)
        for movers in ((mover,), ())
    )
    columns = with_mover.columns
    turn = math.radians(20)
    end = (4 / turn * math.sin(turn), 4 / turn * (1 - math.cos(turn)))
    assert columns.observer_heading_deg[-1] == pytest.approx(20.0, abs=0.5)
    assert (columns.observer_x_cm[-1], columns.observer_y_cm[-1]) == pytest.approx(end, abs=0.1)
    pictures = [result.media.images[""][0].astype(int) for result in (with_mover, without)]
    condition = with_mover.trial.condition
    assert (condition.observer_speed_cm_s, condition.observer_turn_deg_s) == (2.0, 10.0)
    assert (pictures[0] - pictures[1]).min() < -20, "the mover is in the picture"


ARC, SPOT = Leg(0.5, 6, turn_deg=180), Leg(turn_deg=90, seconds=0.05)
REFUSED = {
    "beyond the arena": (crossing(6, 6, length=60), "45"),
    "faster than the wheels": (Trajectory([Leg(20, 6), Leg(2, 40)], 8, 10, -90), r"33\.25"),
    "turning faster": (Trajectory([Leg(5, 6), SPOT, Leg(5, 6)], 8, 6, -90), "wheel"),
    "a bend too narrow": (Trajectory([ARC], 10, 2, -90), "wheel"),
    "a function too fast": (Trajectory.of_time(lambda t: (9, 8 - 40 * t), 0.4), "wheel"),
    "never in view": (crossing(6, 6, x_cm=-15.0), "35"),
    "into the observer": (Trajectory([Leg(15, 6)], 16, 0, 180), "touch"),
    "below the dead band": (crossing(0.5, 0.5), "stand"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_no_robot_can_do_is_refused_before_any_trial(name):
    path, words = REFUSED[name]
    assignments = ["robot.preset=colias4"] if "dead band" in name else []
    with pytest.raises(UsageError, match=words):
        planned(Condition.along("mine", path), assignments=assignments)
