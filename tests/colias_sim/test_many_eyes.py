"""Several robots that see: each as if it alone did, with its own settings and noise."""

import dataclasses

import numpy as np
import pytest

from colias_sim import CameraConfig, Pose, Simulation
from tests.colias_sim.views import QUIET, STILL

ROBOTS = {"a": "colias", "b": "colias_black", "c": "colias", "d": "colias_black"}
STARTS = {
    "a": Pose(0.0, 0.0, 0.0), "b": Pose(0.15, 0.05, -2.8), "c": Pose(-0.1, 0.2, -1.0), "d": Pose(0.1, -0.15, 2.0),
}  # fmt: skip
EYES = {
    "a": CameraConfig(), "b": CameraConfig.preset("ov7670"), "c": CameraConfig(width=50, hfov_deg=90.0),
    "d": CameraConfig.preset("ov7670"),
}  # fmt: skip


def seen(eyes, frames=5, robots=ROBOTS, starts=STARTS, look=None, truth=False):
    """What each robot sees while all drive in arcs; the noise of a robot follows from its name."""
    with Simulation(robots=robots, eyes=eyes, fence=True, truth=truth, scene=STILL) as sim:
        sim.reset(starts, np.random.default_rng(0))
        for name, robot in sim.robots.items():
            robot.drive((0.06, 0.05 + 0.01 * (ord(name) - ord("a"))))
        noise = {name: np.random.default_rng(ord(name)) for name in eyes}
        for i in range(frames):
            taken = sim.step_all(noise if look is None else {name: noise[name] for name in look[i]})
        truths = {name: sim.truth(robot=name) for name in eyes} if truth else {}
        return {name: frame.luma for name, frame in taken.items()}, truths


def test_a_robot_sees_the_same_whoever_else_sees():
    """Any camera beside it, whose exposures stop the physics at other moments; and the same where it is the trial's."""
    together, truths = seen(EYES, truth=True)
    for name, camera in EYES.items():
        (alone,), own = seen({name: camera}, truth=True)[0].values(), seen({name: camera}, truth=True)[1][name]
        np.testing.assert_array_equal(together[name], alone)
        np.testing.assert_array_equal(truths[name].flow, own.flow)
    with Simulation(camera=EYES["b"], robots=ROBOTS, eye_of="b", fence=True, scene=STILL) as sim:
        sim.reset(STARTS, np.random.default_rng(0))
        for name, robot in sim.robots.items():
            robot.drive((0.06, 0.05 + 0.01 * (ord(name) - ord("a"))))
        noise = np.random.default_rng(ord("b"))
        for _ in range(5):
            frame = sim.step(noise)
    # The optics of the others' bodies differ in nothing that this robot sees.
    np.testing.assert_array_equal(frame.luma, together["b"])


def test_a_robot_that_does_not_look_for_a_while_sees_the_same_afterwards():
    """Its noise is the one drawn for the frames that it took."""
    quiet = {name: dataclasses.replace(eye, shot_noise=0.0, read_noise=0.0) for name, eye in EYES.items()}
    del quiet["b"], quiet["d"]  # an exposure loop pauses with its frames
    both = seen(quiet)[0]
    late = seen(quiet, look=["a", "a", "ac", "c", "ac"])[0]
    for name in quiet:
        np.testing.assert_array_equal(both[name], late[name])


def test_exchanged_robots_see_exchanged_frames():
    """Whichever name stands at a place, and in whatever order the scene has them."""
    robots = dict.fromkeys("abcd", "colias_black")
    eyes = dict.fromkeys(robots, QUIET)
    for count in (0, 20):
        frames = {}
        for turn in range(2):
            names = ("a", "b", "c", "d") if turn == 0 else ("c", "a", "d", "b")
            with Simulation(robots=robots, eyes=eyes, fence=True, scene=STILL) as sim:
                sim.reset(dict(zip(names, STARTS.values(), strict=True)), np.random.default_rng(0))
                for i, name in enumerate(names):
                    sim.robots[name].drive((0.02 * i, 0.03))
                noise = dict.fromkeys(names, np.random.default_rng(0))
                for _ in range(count + 1):
                    taken = sim.step_all(noise)
                frames[turn] = [taken[name].luma.astype(int) for name in names]
        for one, other in zip(*frames.values(), strict=True):
            # Contacts are solved in another order, which is a matter of the last bit of a pose.
            assert (one != other).mean() < 0.002 and np.abs(one - other).max() <= (3 if count else 0)


def test_a_restored_simulation_has_every_camera_as_it_was():
    """Exposures, loops and truths of unlike cameras, and of two that share a framebuffer, in another and in a copy."""
    eyes = EYES | {"c": EYES["a"]}

    def ahead(sim, seed):
        frames = [sim.step_all({name: np.random.default_rng(seed + i) for i, name in enumerate(eyes)}) for _ in "123"]
        return [
            (name, frame.luma.tobytes(), frame.exposure_ms, frame.age_ms, sim.truth(2, name).flow.tobytes())
            for taken in frames for name, frame in taken.items()
        ]  # fmt: skip

    with (
        Simulation(robots=ROBOTS, eyes=eyes, truth=True) as sim,
        Simulation(robots=ROBOTS, eyes=eyes, truth=True) as new,
    ):
        sim.reset(STARTS, np.random.default_rng(0), light=0.7)
        for name, robot in sim.robots.items():
            robot.drive((0.06, 0.05 + 0.01 * (ord(name) - ord("a"))))
        ahead(sim, 0)
        state, twin = sim.get_state(), sim.copy()
        assert twin.cameras["a"].offscreen is twin.cameras["c"].offscreen
        expected = ahead(sim, 9)
        new.set_state(state)
        assert ahead(new, 9) == ahead(twin, 9) == expected
        with Simulation(robots=ROBOTS, eyes=EYES, truth=True) as other, pytest.raises(ValueError, match="must be"):
            other.set_state(state)


@pytest.mark.parametrize(
    ("eyes", "words"),
    [
        (("a", "z"), "must be one of a, b, c, d, got z"),
        ({"a": CameraConfig(), "b": CameraConfig(fps=60.0)}, "one frame rate.* got a 30, b 60"),
    ],
)
def test_eyes_that_cannot_be_are_refused(eyes, words):
    with pytest.raises(ValueError, match=words):
        Simulation(robots=ROBOTS, eyes=eyes)
