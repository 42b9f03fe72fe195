"""The simulated testbed: Colias robots, their cameras and arenas in MuJoCo, and Gymnasium envs on these.

This package knows no vision model.
"""

from importlib.metadata import PackageNotFoundError, version

from colias_sim.gl import choose_backend

choose_backend()  # before anything below imports mujoco

# ruff: noqa: E402
from colias_sim.camera import Camera, Frame
from colias_sim.config import CameraConfig, RobotConfig, SceneConfig
from colias_sim.envs.registry import register_envs
from colias_sim.gl import GLUnavailable
from colias_sim.path import Line, OpenLoop, PathFollower, SpeedProfile
from colias_sim.robot import Parked, Pose, Robot, WheelSpeeds, bearing
from colias_sim.simulation import Simulation

try:
    __version__ = version("colias-sim")
except PackageNotFoundError:  # run from a folder of sources that was never installed
    __version__ = "0+unknown"

register_envs()

__all__ = [
    "Camera",
    "CameraConfig",
    "Frame",
    "GLUnavailable",
    "Line",
    "OpenLoop",
    "Parked",
    "PathFollower",
    "Pose",
    "Robot",
    "RobotConfig",
    "SceneConfig",
    "Simulation",
    "SpeedProfile",
    "WheelSpeeds",
    "__version__",
    "bearing",
    "register_envs",
]
