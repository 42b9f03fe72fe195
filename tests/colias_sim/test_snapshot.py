"""States of simulations: physics, light, wall, motors and exposure go on to the bit; what a trial changes is listed."""

import copy

import mujoco
import numpy as np
import pytest

from colias_sim import CameraConfig, Pose, RobotConfig, Simulation
from colias_sim.snapshot import SCENE

POSES = {"observer": Pose(0.0, 0.0, 0.3), "other": Pose(0.2, 0.1, 0.0), "parked": Pose(-0.2, 0.1, 1.0)}
ROBOTS = {"observer": "colias", "other": "colias_black", "parked": "colias_parked"}
EYES = {
    "own": CameraConfig(),
    "rolling": CameraConfig.preset("ov7670"),
    "jumpy": CameraConfig(row_time_us=300.0, jitter_ms=1.0, drop_probability=0.3),
}


def made(eye="own"):
    robot = RobotConfig(command_slot_ms=100.0, serial_ms=5.0, power_step_cm_s=0.06, motor_inequality_sd=2.0)
    return Simulation(robot=robot, camera=EYES[eye], robots=ROBOTS, truth=True)


def ahead(simulation, rng, count=12):
    """Frames and poses while both robots queue commands; every third frame is not looked at."""
    told = []
    for index in range(count):
        for name in ("observer", "other"):
            if index % 2 == 0:
                simulation.robots[name].queue((0.05 + 0.01 * index, 0.08), 1)
        simulation.robots["other"].twist(1e-4 * index)
        simulation.turn_wall(simulation.wall_turn + 0.05)
        if index % 3 == 2:
            simulation.advance(look=False)
        else:
            frame = simulation.step(rng)
            truth = simulation.truth(1 + index % 5)
            pixels = truth.flow.tobytes(), truth.depth_m.tobytes(), truth.robot.tobytes(), truth.interval_ms.tobytes()
            told.append((frame.luma.tobytes(), frame.time, frame.exposure_ms, frame.age_ms, pixels))
        told.append(repr(simulation.poses))
    return told


@pytest.mark.parametrize("eye", EYES)
def test_a_restored_simulation_goes_on_to_the_bit(eye):
    """In another one, in a copy, and after another trial with other light; generators are the caller's."""
    with made(eye) as simulation, made(eye) as other:
        rng = np.random.default_rng(4)
        simulation.reset(POSES, rng, light=0.8)
        ahead(simulation, rng, 7)
        state, twin, bits = simulation.get_state(), simulation.copy(), copy.deepcopy(rng)
        expected = ahead(simulation, rng)
        simulation.reset(POSES | {"observer": Pose(0.1, 0.2, 0.0)}, rng, light=0.0)
        for restored in (other, simulation):
            restored.set_state(state)
            assert restored.get_state() == state
            assert ahead(restored, copy.deepcopy(bits)) == expected
        assert ahead(twin, copy.deepcopy(bits)) == expected
        twin.close()
        assert simulation.step(rng).luma.shape == (72, 99)


def test_what_a_trial_changes_of_the_model_is_listed():
    """Every array of the compiled scene is compared before and after a trial with a turned wall and other light."""
    with Simulation(robots=ROBOTS, seeing=False) as simulation:
        names = [name for name in dir(simulation.model) if isinstance(getattr(simulation.model, name), np.ndarray)]
        before = {name: getattr(simulation.model, name).copy() for name in names}
        simulation.reset(POSES, np.random.default_rng(0), light=0.5)
        simulation.turn_wall(1.0)
        for _ in range(3):
            simulation.advance()
        changed = {name for name in names if not np.array_equal(before[name], getattr(simulation.model, name))}
        assert changed == set(SCENE)


def test_a_foreign_state_changes_nothing():
    """Of other settings, of a scene of another structure, and one cut short."""
    with made() as simulation, Simulation(robots=ROBOTS, seeing=False) as other:
        simulation.reset(POSES, np.random.default_rng(0))
        state = simulation.get_state()
        for wrong in (other.get_state(), state[:-1], state[:30], b"colias-state"):
            with pytest.raises(ValueError, match="must be"):
                simulation.set_state(wrong)
            assert simulation.get_state() == state


def test_what_was_touched_before_is_not_touched_after_a_restore():
    """MuJoCo keeps the contacts of its last step, which are no part of the state."""
    with Simulation(fence=True, seeing=False) as simulation:
        simulation.reset({"stimulus": Pose(0.3, 0.0, 0.0)}, np.random.default_rng(0))
        state, hull = simulation.get_state(), simulation.model.geom("observer/hull").id
        simulation.reset({"observer": Pose(0.427, 0.0, 0.0)}, np.random.default_rng(0))
        simulation.robots["observer"].drive((0.2, 0.2))
        for _ in range(15):
            simulation.advance()
        assert hull in simulation.data.contact.geom
        simulation.set_state(state)
        assert hull not in simulation.data.contact.geom
        xpos = simulation.data.body("observer/base").xpos.copy()
        mujoco.mj_kinematics(simulation.model, simulation.data)
        assert (simulation.data.body("observer/base").xpos == xpos).all()
