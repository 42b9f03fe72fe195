"""The settings of one episode of an env: those of its arguments, changed by what is drawn."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

from colias_sim.config import CameraConfig, RobotConfig, SceneConfig


@dataclass(frozen=True, slots=True)
class EpisodeSettings:
    """Decisions of the factors for one episode.

    Parameters
    ----------
    camera, robot
        The observer's camera and body. Of the robot only mass and motor gain may differ from the env's argument.
    light
        A factor on the light of the lamps.
    shell_grey
        Reflectance of the other robots' shells.
    wall_contrast
        A factor on the contrast of the wall's texture.
    wheel_gains
        Factors on the commanded speeds of the observer's left and right wheel.
    tilt
        Pitch and yaw of the camera off its usual direction, in radians.
    shift
        How far ahead and to the left of its usual start the observer begins, in metres.
    latency
        Time from an action to the command to the wheels, in seconds.
    """

    camera: CameraConfig
    robot: RobotConfig
    light: float = 1.0
    shell_grey: float = dataclasses.field(default_factory=lambda: SceneConfig().shell_grey)
    wall_contrast: float = 1.0
    wheel_gains: tuple[float, float] = (1.0, 1.0)
    tilt: tuple[float, float] = (0.0, 0.0)
    shift: tuple[float, float] = (0.0, 0.0)
    latency: float = 0.0
