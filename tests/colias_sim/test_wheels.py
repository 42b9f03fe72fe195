"""Wheels as the robot has them: powers, trim, dead band, slots."""

import dataclasses
import math

import numpy as np
import pytest

from colias_sim import OpenLoop, Pose, RobotConfig, Route, Schedule, Simulation
from colias_sim.motors import Motors

COLIAS4 = RobotConfig.preset("colias4")
STEPS = RobotConfig(power_step_cm_s=0.06)
QUEUE = RobotConfig(command_slot_ms=100.0, serial_ms=2.1)


def alone(robot: RobotConfig) -> Simulation:
    sim = Simulation(robot, robots={"one": "colias"}, seeing=False)
    sim.reset({"one": Pose(0.0, 0.0, 0.0)}, np.random.default_rng(0))
    return sim


def test_speeds_are_whole_steps():
    """What is realised is the nearest multiple of a step, up to 255 of them, in the direction wanted."""
    step, sim = STEPS.power_step_cm_s / 100, alone(STEPS)
    for wanted in (*np.linspace(-0.153, 0.153, 401), 0.2):
        sim.robots["one"].drive((wanted, wanted))
        for side in ("left", "right"):
            real = float(sim.data.actuator(f"one/{side}").ctrl[0]) * STEPS.wheel_radius_cm / 100
            assert real / step == pytest.approx(round(real / step), abs=1e-6)
            assert abs(real - min(wanted, 255 * step)) <= step / 2 + 1e-12
    assert STEPS.power_step_cm_s / 2.0 == pytest.approx(0.03), "some 3 % at 2 cm/s"


def test_a_command_waits_for_a_slot():
    """A command that is sent at t begins with the first slot after t and its time on the line."""
    slot, serial = QUEUE.command_slot_ms, QUEUE.serial_ms
    for sent in (0.0, 33.0, 66.0, 97.8, 98.0, 100.0, 150.0, 197.0, 199.0, 733.0):
        begins = next(k * slot for k in range(100) if k * slot > sent + serial)
        sim = alone(QUEUE)
        one, control = sim.robots["one"], sim.data.actuator("one/left").ctrl
        sim.data.time = sent / 1000
        one.drive((0.05, 0.05))
        for now in np.arange(math.floor(sent), sent + 250.0):
            if now >= sent:
                sim.data.time = now / 1000
                one.tick()
                assert (float(control[0]) > 0) == (now >= begins), (sent, now)


def test_weak_powers_do_not_turn_a_wheel():
    motors = Motors(COLIAS4)
    for power in range(-40, 41):
        turning = abs(power) >= COLIAS4.dead_band
        left, right = motors.speeds(power, power)
        assert (left != 0, right != 0) == (turning, turning), power
        assert not turning or math.copysign(1, right) == math.copysign(1, power)


# The queue.


def test_commands_with_durations_follow_one_another_and_then_the_wheels_stop():
    sim = alone(QUEUE)
    one, control = sim.robots["one"], sim.data.actuator("one/left").ctrl
    for speed, slots in ((0.05, 2), (0.02, 1), (0.08, 3)):
        one.queue((speed, speed), slots)
    seen = []
    for now in range(0, 1000, 50):
        sim.data.time = now / 1000
        one.tick()
        seen.append(round(float(control[0]) * one.config.wheel_radius_cm, 6))
    assert seen == [0.0] * 2 + [5.0] * 4 + [2.0] * 2 + [8.0] * 6 + [0.0] * 6
    with pytest.raises(ValueError, match="no queue"):
        alone(RobotConfig()).robots["one"].queue((0.1, 0.1), 1)


def test_the_last_command_of_a_slot_counts_and_a_reset_forgets_it():
    sim = alone(QUEUE)
    one, control = sim.robots["one"], sim.data.actuator("one/left").ctrl
    one.queue((0.01, 0.01), 50)
    for now, speed in ((0.0, 0.05), (0.05, 0.02), (0.09, 0.08)):
        sim.data.time = now
        one.drive((speed, speed))
    sim.data.time = 0.1
    one.tick()
    assert float(control[0]) * one.config.wheel_radius_cm == pytest.approx(8.0)
    one.drive((0.03, 0.03))
    sim.reset({"one": Pose(0.0, 0.0, 0.0)}, np.random.default_rng(0))
    for _ in range(30):
        sim.advance()
    assert math.hypot(*one.velocity) < 1e-6


def test_eased_wheels_settle_on_steps_in_their_slot_the_same_after_every_reset():
    """As envs drive: a command in every interval, with limited acceleration."""

    def driven(sim):
        sim.reset({"one": Pose(0.0, 0.0, 0.0)}, np.random.default_rng(0))
        one, control, rows = sim.robots["one"], sim.data.actuator("one/right").ctrl, []

        def ease(dt):
            one.ease((0.101, 0.101), dt)
            rows.append((sim.data.time, float(control[0]) * one.config.wheel_radius_cm / 100))

        for _ in range(12):
            sim.advance(ease)
        return rows

    with alone(COLIAS4) as sim:
        first, second = driven(sim), driven(sim)
    assert first == second
    assert all(speed == 0.0 for time, speed in first if time < 0.0999)
    begun = [speed for time, speed in first if time > 0.0999]
    assert begun == pytest.approx([2 / 60, 4 / 60, 6 / 60, *[168 * 0.0006] * (len(begun) - 3)])


def test_the_spread_of_the_motors_is_drawn_from_the_seed():
    spread = dataclasses.replace(COLIAS4, motor_inequality_sd=0.5)

    def left(seed, robot=spread):
        sim = alone(robot)
        rng = np.random.default_rng(seed)
        sim.reset({"one": Pose(0.0, 0.0, 0.0)}, rng)
        return sim.robots["one"].realised((0.06, 0.06))[0], rng.random()

    assert left(1) == left(1) != left(2)
    assert left(1, COLIAS4)[1] == left(1, RobotConfig())[1], "without a spread nothing is drawn"
    motors, rng = Motors(spread), np.random.default_rng(0)
    drawn = []
    for _ in range(4000):
        motors.draw(rng)
        drawn.append(motors.speeds(97, 100)[0] / 0.0006 - 97)
    assert np.mean(drawn) == pytest.approx(3.29, abs=0.03) and np.std(drawn) == pytest.approx(0.5, rel=0.05)


# Open loop.


@pytest.mark.parametrize("stop", [True, False])
def test_the_commands_of_a_profile_cover_its_length(stop):
    line = Route.line(Pose(0.0, 0.0, 0.0), 0.15, 0.06, wait=0.3, rest=0.0 if stop else None)
    profile = Schedule(line, 0.17)
    drive = OpenLoop(alone(COLIAS4).robots["one"], profile)
    commands = [(left, slots) for (left, _), slots in drive.commands()]
    way = sum(speed * slots * 0.1 for speed, slots in commands)
    assert way == pytest.approx(0.15, abs=1e-7) if stop else 0.15 <= way < 0.15 + 0.1 * 0.06
    assert profile.covered(profile.seconds) == pytest.approx(0.15)
    assert all(left == right for (left, right), _ in drive.commands())
    assert commands[0] == (0.0, 3) and max(speed for speed, _ in commands) == pytest.approx(0.06)
    ramp = 0.06 / 0.17
    assert profile.seconds == pytest.approx(0.3 + 0.15 / 0.06 + ramp / (1 if stop else 2))
    assert profile.mean(0.3, 0.3 + ramp) == pytest.approx((0.03, 0.0))


def test_presets_are_named():
    assert RobotConfig.preset("default") == RobotConfig() != COLIAS4
    assert COLIAS4.max_speed_cm_s == pytest.approx(255 * COLIAS4.power_step_cm_s)
    assert Motors(COLIAS4).powers(0.048, 0.048) == (77, 80), "straight ahead in the public firmware"
    assert Motors(COLIAS4).powers(0.018, 0.018) == (27, 30), "slowly ahead"
