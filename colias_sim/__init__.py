"""The simulated bench: Colias robots, their cameras and arenas in MuJoCo. Knows no vision model."""

from colias_sim import gl

gl.choose_backend()  # before anything below imports mujoco

# ruff: noqa: E402
from colias_sim.camera import Camera, Frame
from colias_sim.config import CameraConfig, RobotConfig, SceneConfig
from colias_sim.envs.registry import register_envs
from colias_sim.gl import GLUnavailable
from colias_sim.path import Line, PathFollower
from colias_sim.robot import Pose, Robot, WheelSpeeds, bearing
from colias_sim.simulation import Simulation

register_envs()

__all__ = [
    "Camera",
    "CameraConfig",
    "Frame",
    "GLUnavailable",
    "Line",
    "PathFollower",
    "Pose",
    "Robot",
    "RobotConfig",
    "SceneConfig",
    "Simulation",
    "WheelSpeeds",
    "bearing",
]
