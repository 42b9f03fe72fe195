"""Frames of a scene at rest, and the settings without noise that many tests of the eye share."""

import dataclasses

import numpy as np

from colias_sim import CameraConfig, Frame, Pose, SceneConfig, Simulation
from colias_sim.scene import timestep

LENS = CameraConfig().forward_cm / 100
STILL = SceneConfig(light_sd=0, turn_wall=False)
PLAIN = SceneConfig(arena="plain", light_sd=0, turn_wall=False)
AWAY = Pose(-0.3, 0.0, 0.0)
QUIET = CameraConfig(shot_noise=0.0, read_noise=0.0)
ROLLING = dataclasses.replace(
    QUIET, fps=5.0, row_time_us=1e6 * timestep(5.0), row_bands=72, exposure_ms=0.0, supersample=4
)
"""A row a physics step: no moment is rounded. At 30 fps moments are whole steps too, so a row may be 0.9 ms off."""


def frames(camera: CameraConfig, scene: SceneConfig = STILL, stimulus: Pose = AWAY, count: int = 1) -> list[Frame]:
    """The first frames that the eye takes of a stimulus that stands still."""
    with Simulation(camera=camera, scene=scene) as sim:
        rng = np.random.default_rng(0)
        sim.reset({"stimulus": stimulus}, rng)
        return [sim.step(rng) for _ in range(count)]


def crossing(sim: Simulation, start: Pose, speed: float, count: int) -> list[Frame]:
    """Frames of a stimulus that drives ahead from ``start`` at ``speed`` m/s."""
    rng = np.random.default_rng(0)
    sim.reset({"stimulus": start}, rng)
    robot = sim.robots["stimulus"]
    robot.drive(robot.wheels_for(speed, 0.0))
    return [sim.step(rng) for _ in range(count)]


def view(camera: CameraConfig, scene: SceneConfig = STILL, stimulus: Pose = AWAY) -> np.ndarray:
    """The luma of the first frame, as floats (R, C)."""
    return frames(camera, scene, stimulus)[0].luma.astype(float)
