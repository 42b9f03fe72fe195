"""Domain randomisation: what the argument ``randomise`` varies between episodes beyond the defaults."""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import dataclass

import mujoco
import numpy as np

from colias_sim.config import SceneConfig
from colias_sim.simulation import Simulation

WIDEST_LIGHT = 0.3
"""Largest change of the lamps, as a share of their light."""
WIDEST_SHELL = 0.4
"""Largest increase of the shells' reflectance."""
WIDEST_MOTOR = 0.05
"""Largest change of each wheel's speed, as a share."""
WIDEST_TILT = math.radians(3.0)
"""Largest tilt of the camera in pitch and in yaw, in radians."""


@dataclass(frozen=True, slots=True)
class Randomised:
    """The values that one episode was given: factors on the lamps' light and on the wheels' speeds (left, right)."""

    light: float
    wheel_gains: tuple[float, float]


class Randomisation:
    """Applies domain randomisation to a simulation, anew for each episode.

    Parameters
    ----------
    sim
        The simulation; its shells' materials and the observer's camera are changed.
    observer
        Name of the robot whose camera is tilted.
    shells
        Names of the robots whose shells vary.
    strength
        0 for none, 1 for the widest ranges.
    """

    def __init__(self, sim: Simulation, observer: str, shells: Collection[str], strength: float) -> None:
        self._strength = strength
        self._materials = [sim.model.material(f"{name}/shell") for name in shells]
        self._eye_quat = sim.model.camera(f"{observer}/eye").quat
        self._straight_quat = self._eye_quat.copy()

    def apply(self, rng: np.random.Generator) -> Randomised:
        """Draw the values of an episode, and set shells and camera by them.

        All values are drawn whatever the strength is, so the strength does not change the draws that follow.

        Parameters
        ----------
        rng
            The generator of the episode.

        Returns
        -------
        Randomised
            What the caller has to apply: light and wheel gains.
        """
        wide = self._strength
        light, shell, left, right, pitch, yaw = rng.uniform(-1.0, 1.0, 6).tolist()
        gains = 1.0 + wide * WIDEST_MOTOR * left, 1.0 + wide * WIDEST_MOTOR * right
        grey = SceneConfig().shell_grey + wide * WIDEST_SHELL * (shell + 1.0) / 2
        for material in self._materials:
            material.rgba[:3] = grey
        tilt = np.zeros(4)
        mujoco.mju_euler2Quat(tilt, np.array([pitch, yaw, 0.0]) * wide * WIDEST_TILT, "xyz")
        mujoco.mju_mulQuat(self._eye_quat, self._straight_quat, tilt)
        return Randomised(float(1.0 + wide * WIDEST_LIGHT * light), gains)
