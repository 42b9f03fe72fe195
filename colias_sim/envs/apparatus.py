"""Apply the settings of an episode to a simulation that was compiled once."""

from __future__ import annotations

import copy
import math
from collections.abc import Callable, Collection

import mujoco
import numpy as np

from colias_sim.config import CameraConfig, RobotConfig
from colias_sim.envs.randomise import Values
from colias_sim.scene import base_mass, contrasted, set_motor_gain, texels
from colias_sim.simulation import Simulation

WALL = "wall"
"""Name of the wall's texture."""


class Apparatus:
    """The properties that may differ between the episodes of one simulation.

    Parameters
    ----------
    sim
        The simulation. Its camera has the settings that need the most memory of all episodes.
    observer
        Name of the robot that the agent drives.
    shells
        Names of the robots whose shells vary.
    robot
        The robot that the model was compiled with.
    """

    def __init__(self, sim: Simulation, observer: str, shells: Collection[str], robot: RobotConfig) -> None:
        self._observer, self._shells = observer, shells
        self._bind(sim)
        self._straight_quat = self._eye_quat.copy()
        self._robot, self._contrast = robot, 1.0
        self._plain_wall = self._wall.copy()

    def _bind(self, sim: Simulation) -> None:
        """Find what varies in a simulation."""
        self._sim = sim
        self._materials = [sim.model.material(f"{name}/shell") for name in self._shells]
        self._eye_quat = sim.model.camera(f"{self._observer}/eye").quat
        self._wall = texels(sim.model, WALL)

    def copy(self, sim: Simulation) -> Apparatus:
        """Make a twin of it for a copy of the simulation."""
        twin = copy.copy(self)
        twin._bind(sim)
        return twin

    def set(self, camera: CameraConfig, robot: RobotConfig, values: Values, retexture: Callable[[int], None]) -> None:
        """Set everything except light, wheel gains, start and latency. Call it before the simulation's reset.

        Parameters
        ----------
        camera, robot
            The settings of the observer's camera and body. Only the robot's mass and motor gain may vary.
        values
            Factor -> its values, of all factors of `USUAL`.
        retexture
            Called with the index of a changed texture, to update copies of it.
        """
        (contrast,), (pitch, yaw) = values["wall"], values["tilt"]
        for material in self._materials:
            material.rgba[:3] = values["shell"]
        tilt = np.zeros(4)
        mujoco.mju_euler2Quat(tilt, np.array([math.radians(pitch), math.radians(yaw), 0.0]), "xyz")
        mujoco.mju_mulQuat(self._eye_quat, self._straight_quat, tilt)
        self._set_robot(robot)
        if contrast != self._contrast:
            self._contrast = contrast
            self._wall[:] = contrasted(self._plain_wall, contrast)
            retexture(self._sim.model.tex(WALL).id)
        if self._sim.seeing:
            self._sim.camera(self._observer).tune(camera)

    def _set_robot(self, robot: RobotConfig) -> None:
        """Set mass and motor gain, and what MuJoCo derives from them."""
        if robot == self._robot:
            return
        self._robot, model = robot, self._sim.model
        model.body(f"{self._observer}/base").mass[:] = base_mass(robot, model, self._observer)
        set_motor_gain(model, self._observer, robot.motor_gain)
        mujoco.mj_setConst(model, self._sim.data)
        # The solver's tolerance is relative to this, which MuJoCo only computes when it compiles.
        model.stat.meaninertia = np.add.accumulate(model.dof_M0)[-1] / model.nv
