"""Frames of a scene at rest, and the settings without noise that many tests of the eye share."""

import dataclasses

import mujoco
import numpy as np

from colias_sim import CameraConfig, Frame, Pose, SceneConfig, Simulation
from colias_sim.offscreen import Offscreen
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


def owners(model: mujoco.MjModel, geoms: np.ndarray) -> np.ndarray:
    """The names of the robots, and of the arena's bodies, that geoms belong to; -1 belongs to none, an empty text."""
    names = [model.body(model.body_rootid[body]).name.partition("/")[0] for body in model.geom_bodyid]
    return np.array([*names, ""])[geoms]


def drawn(sim: Simulation, name: str) -> np.ndarray:
    """The geom that each pixel (72, 99) of a robot's eye shows, by a render in flat colours; -1 is nothing."""
    eye, geoms = mujoco.MjvCamera(), {0: -1}
    eye.type, eye.fixedcamid = mujoco.mjtCamera.mjCAMERA_FIXED.value, sim.model.camera(f"{name}/eye").id
    offscreen = Offscreen(sim.model, 72, 99)

    def number(scene: mujoco.MjvScene) -> None:
        scene.flags[mujoco.mjtRndFlag.mjRND_SEGMENT] = scene.flags[mujoco.mjtRndFlag.mjRND_IDCOLOR] = 1
        geoms.update({geom.segid + 1: geom.objid for geom in scene.geoms[: scene.ngeom]})

    offscreen.draw_into((0, 0, 99, 72), sim.data, eye, number)
    numbers = offscreen.read_all()[::-1].astype(int) @ (1, 256, 65536)
    offscreen.close()
    return np.vectorize(geoms.get)(numbers)
