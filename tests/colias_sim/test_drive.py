"""The robot's drive: commanded against achieved speed, and the path, over the whole working range."""

import math

import mujoco
import numpy as np
import pytest

from colias_sim import (
    CameraConfig,
    PathFollower,
    Pose,
    Robot,
    RobotConfig,
    Route,
    SceneConfig,
    Schedule,
    Stretch,
    Tracker,
    scene,
)

COMMAND_STEPS = scene.steps_per_command(30.0)
START = Pose(0.1, 0.15, -math.pi / 2)


def bench(config: RobotConfig | None = None) -> tuple[mujoco.MjModel, mujoco.MjData, Robot]:
    config = config or RobotConfig()
    model = scene.compile_model(SceneConfig(), config, CameraConfig(), {"stimulus": "colias_black"})
    data = mujoco.MjData(model)
    return model, data, Robot(model, data, "stimulus", config)


def followed(route: Route, start: Pose | None = None, config: RobotConfig | None = None) -> np.ndarray:
    """Drive a route to its end; rows of time, distance along, offset, height, and the place."""
    model, data, robot = bench(config)
    robot.place(start or route.start)
    follower, tracker = PathFollower(robot, route), Tracker(route)
    rows = []
    while not follower.over and data.time < 20:
        robot.drive(follower.wheels(COMMAND_STEPS * model.opt.timestep))
        mujoco.mj_step(model, data, COMMAND_STEPS)
        follower.look()
        tracker.see(robot.pose)
        rows.append((data.time, tracker.along, tracker.offset, robot.height, robot.pose.x, robot.pose.y))
    return np.array(rows)


@pytest.mark.parametrize("speed", [0.02, 0.06, 0.1, 0.2, 0.3])
@pytest.mark.parametrize("wheel_radius_cm", [1.0, 1.3])
def test_achieved_speed_and_path(speed, wheel_radius_cm):
    """Within 2 % at every moment after the run-up, within 1 mm of the line, without bobbing."""
    rows = followed(Route.line(START, 0.25, speed), config=RobotConfig(wheel_radius_cm=wheel_radius_cm))
    crossing = rows[rows[:, 1] >= PathFollower.run_up(speed)]
    now = np.diff(crossing[:, 1]) / np.diff(crossing[:, 0])
    assert np.abs(now / speed - 1).max() < 0.02
    assert np.abs(crossing[:, 2]).max() < 1e-3
    assert np.ptp(crossing[:, 3]) < 1e-4


def test_the_follower_steers_back_to_the_line():
    """Set down 2 mm off and 2 degrees askew, it returns as a critically damped system does, in distance travelled."""
    beside = Pose(START.x + 0.002, START.y, START.heading + math.radians(2))
    rows = followed(Route.line(START, 0.25, 0.06), beside)
    rate, travelled = PathFollower.HEADING_GAIN / 2, rows[:, 1]
    expected = (0.002 + (math.radians(2) + rate * 0.002) * travelled) * np.exp(-rate * travelled)
    np.testing.assert_allclose(rows[:, 2], expected, atol=1e-4)
    assert abs(rows[-1, 2]) < 2e-4
    assert math.radians(3.5) / (math.e * rate) < 1e-3, "3.5 sd of a trial's heading stay within its tolerance"


@pytest.mark.parametrize(("speed", "turn"), [(0.1, 0.0), (0.05, 2.0), (0.0, 3.0), (-0.1, 0.0), (0.1, -1.5)])
def test_kinematics_hold_in_physics(speed, turn):
    """The wheel speeds for a forward speed and turning rate produce them."""
    model, data, robot = bench()
    robot.place(Pose(0.0, 0.0, 0.3))
    robot.drive(robot.wheels_for(speed, turn))
    mujoco.mj_step(model, data, 200)
    before, start = robot.pose, data.time
    mujoco.mj_step(model, data, 200)
    after, elapsed = robot.pose, data.time - start
    turned = math.remainder(after.heading - before.heading, 2 * math.pi)
    assert turned / elapsed == pytest.approx(turn, abs=0.05 + 0.03 * abs(turn))
    arc = math.copysign(math.hypot(after.x - before.x, after.y - before.y), speed)
    chord = 2 * speed / turn * math.sin(turn * elapsed / 2) if turn else speed * elapsed
    assert arc == pytest.approx(chord, abs=1e-3)


def test_wheels_saturate_together():
    _, _, robot = bench()
    left, right = robot.wheels_for(0.35, 5.0)
    assert max(abs(left), abs(right)) == pytest.approx(0.35)
    assert (right - left) / (left + right) == pytest.approx(5.0 * 0.032 / 2 / 0.35)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_an_arc_is_a_part_of_a_circle(side):
    """A quarter of a circle of 10 cm about a centre on that side; a pose 1 cm outside it is 1 cm to the other side."""
    arc, start = Stretch(0.05 * math.pi, 0.1, 0.1, side / 0.1), Pose(0.0, 0.0, 0.0)
    assert arc.turn == pytest.approx(side * math.pi / 2)
    end = arc.point(start, arc.length)
    assert (end.x, end.y, end.heading) == pytest.approx((0.1, side * 0.1, side * math.pi / 2))
    beside = Pose(0.11 * math.sin(0.5), side * (0.1 - 0.11 * math.cos(0.5)), 0.0)
    assert arc.measured(start, beside) == pytest.approx((0.05, -side * 0.01))


def test_achieved_speed_is_commanded_speed_while_it_accelerates():
    """From 4 to 20 cm/s with 10 cm/s2 after a run-up: v^2 = v0^2 + 2 a s within 4 %, then braked to rest."""
    begin, length = 0.02, (0.2**2 - 0.04**2) / (2 * 0.1)
    route = Route(START, (Stretch(begin, 0.04, 0.04), Stretch(length, 0.04, 0.2), Stretch()))
    rows = followed(route)
    now, along = np.diff(rows[:, 1]) / np.diff(rows[:, 0]), (rows[1:, 1] + rows[:-1, 1]) / 2
    braking = PathFollower.braking(0.2)
    chosen = (along > begin + 0.01) & (along < begin + length - braking)
    asked = np.sqrt(0.04**2 + 2 * 0.1 * (along[chosen] - begin))
    assert chosen.sum() > 30 and np.abs(now[chosen] / asked - 1).max() < 0.04
    assert np.abs(rows[:, 2]).max() < 1e-4 and rows[-1, 1] == pytest.approx(route.length, abs=2e-3)


def test_a_zig_zag_is_driven_corner_by_corner_and_its_mirror_image_mirrored():
    """Three legs of 5 cm with corners of 60 degrees on the spot, and an arc: within 1 mm all along."""

    def route(side):
        corner, leg = Stretch(seconds=0.5, rate=side * math.radians(120)), Stretch(0.05, 0.06, 0.06)
        back = Stretch(seconds=0.5, rate=-side * math.radians(120))
        return Route(Pose(0.0, 0.0, 0.0), (leg, corner, leg, back, Stretch(0.05, 0.06, 0.06, side * 10), Stretch()))

    one, other = followed(route(1.0)), followed(route(-1.0))
    assert np.abs(one[:, 2]).max() < 1e-3
    half = math.radians(60)
    end = (0.05 + 0.05 * math.cos(half) + math.sin(0.5) / 10, 0.05 * math.sin(half) + (1 - math.cos(0.5)) / 10)
    assert one[-1, 4:] == pytest.approx(end, abs=2e-3)
    count = min(len(one), len(other))
    np.testing.assert_allclose(one[:count, 4:], other[:count, 4:] * (1, -1), atol=3e-4)


def test_a_schedule_is_what_constant_acceleration_gives():
    """Up to 6 cm/s with 17 cm/s2, a step down to 3 cm/s, to rest: times and distances by v^2 = 2 a s."""
    speed, low, up = 0.06, 0.03, 0.17
    line = Route(Pose(0, 0, 0), (Stretch(0.1, speed, speed), Stretch(0.05, low, low), Stretch(seconds=0.3)))
    schedule = Schedule(line, up)
    ramp, down = speed**2 / 2 / up, (speed**2 - low**2) / 2 / up
    seconds = speed / up + (0.1 - ramp - down) / speed + (speed - low) / up
    assert schedule.covered(seconds) == pytest.approx(0.1)
    seconds += (0.05 - low**2 / 2 / up) / low + low / up
    assert schedule.covered(seconds) == pytest.approx(0.15)
    assert schedule.seconds == pytest.approx(seconds + 0.3)


def test_the_mean_speed_over_parts_is_their_length_over_their_time():
    line = Route(Pose(0, 0, 0), (Stretch(0.1, 0.03, 0.03), Stretch(0.1, 0.09, 0.09)))
    parts = [(0.02, 0.04), (0.15, 0.19)]
    assert Schedule(line, 10.0).speed_over(parts) == pytest.approx(0.06 / (0.02 / 0.03 + 0.04 / 0.09))


@pytest.mark.parametrize("fps", [5.0, 24.0, 30.0, 60.0, 120.0])
def test_a_frame_divides_into_whole_commands_and_short_steps(fps):
    assert scene.steps_per_frame(fps) == scene.commands_per_frame(fps) * scene.steps_per_command(fps)
    assert scene.timestep(fps) <= scene.LONGEST_STEP
    assert scene.timestep(fps) * scene.steps_per_frame(fps) * fps == pytest.approx(1.0)
    assert 40 <= fps * scene.commands_per_frame(fps) <= 120
