"""Several robots that see: each as if it alone did, with its own settings and noise."""

import numpy as np
import pytest

from colias_sim import CameraConfig, Pose, Simulation
from tests.colias_sim.views import QUIET, STILL

ROBOTS = {"a": "colias", "b": "colias_black", "c": "colias", "d": "colias_black"}
PLACES = Pose(0.0, 0.0, 0.0), Pose(0.15, 0.05, -2.8), Pose(-0.1, 0.2, -1.0), Pose(0.1, -0.15, 2.0)
OWN = CameraConfig.preset("ov7670")
EYES = {"a": CameraConfig(), "b": OWN, "c": CameraConfig(width=50, hfov_deg=90.0), "d": OWN}


def noise(names, seed=0):
    """Generators of each robot's own."""
    return {name: np.random.default_rng(seed + ord(name)) for name in names}


def begun(sim, names="abcd"):
    """Let all drive in arcs, from places in the order of their names."""
    sim.reset(dict(zip(names, PLACES, strict=True)), np.random.default_rng(0))
    for number, name in enumerate(names):
        sim.robots[name].drive((0.06, 0.05 + 0.01 * number))
    return sim


def test_a_robot_sees_the_same_whoever_else_sees():
    """Any camera beside it, whose exposures stop the physics at other moments; and as ``eye_of`` of one that sees."""
    generators = noise(EYES)
    with Simulation(robots=ROBOTS, eyes=EYES, fence=True, truth=True, scene=STILL) as sim:
        begun(sim)
        together = [sim.step_all(generators) for _ in range(5)][-1]
        truths = {name: sim.truth(robot=name).flow for name in EYES}
    for name, camera in EYES.items():
        with Simulation(None, camera, STILL, ROBOTS, name, fence=True, truth=True) as sim:
            begun(sim)
            alone = noise(name)[name]
            frame = [sim.step(alone) for _ in range(5)][-1]
            np.testing.assert_array_equal(together[name].luma, frame.luma)
            np.testing.assert_array_equal(truths[name], sim.truth().flow)


@pytest.mark.parametrize("count", [1, 20])
def test_exchanged_robots_see_exchanged_frames(count):
    """Whichever name stands at a place, and in whatever order the scene has them."""
    frames = []
    for names in ("abcd", "cadb"):
        with Simulation(robots=dict.fromkeys("abcd", "colias_black"), camera=QUIET, eyes=[*"abcd"], scene=STILL) as sim:
            begun(sim, names)
            taken = [sim.step_all(noise("abcd")) for _ in range(count)][-1]
            frames.append(np.array([taken[name].luma for name in names], int))
    # Contacts are solved in another order, which is a matter of the last bit of a pose.
    apart = np.abs(frames[0] - frames[1])
    assert (apart > 0).mean() < 0.002 and apart.max() <= (0 if count == 1 else 3)


def test_a_restored_simulation_has_every_camera_as_it_was():
    """Exposures, loops and truths of unlike cameras, and of two that share a framebuffer, in another and in a copy."""
    eyes = EYES | {"c": EYES["a"]}

    def ahead(sim, seed):
        generators = noise(eyes, seed)
        return [
            (name, frame.luma.tobytes(), frame.exposure_ms, frame.age_ms, sim.truth(2, name).flow.tobytes())
            for _ in range(3) for name, frame in sim.step_all(generators).items()
        ]  # fmt: skip

    made = {"robots": ROBOTS, "truth": True}
    with Simulation(eyes=eyes, **made) as sim, Simulation(eyes=eyes, **made) as new:
        ahead(begun(sim), 0)
        state, twin = sim.get_state(), sim.copy()
        assert twin.cameras["a"].offscreen is twin.cameras["c"].offscreen
        expected = ahead(sim, 9)
        new.set_state(state)
        assert ahead(new, 9) == ahead(twin, 9) == expected
        with Simulation(eyes=EYES, **made) as other, pytest.raises(ValueError, match="must be"):
            other.set_state(state)
