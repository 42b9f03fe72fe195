"""The simulated testbed: Colias robots, cameras and arenas in MuJoCo, and Gymnasium envs built on them.

This package is independent of any vision model.
"""

from importlib.metadata import PackageNotFoundError, version
from typing import TYPE_CHECKING

import lazy_loader

from colias_sim.gl import choose_backend

choose_backend()  # before anything below imports mujoco

# ruff: noqa: E402
from colias_sim.config import CameraConfig, EventConfig, RobotConfig, SceneConfig
from colias_sim.envs import register_envs, swarm_env
from colias_sim.gl import GLUnavailable
from colias_sim.path import OpenLoop, PathFollower, Route, Schedule, Stretch, Tracker
from colias_sim.pose import Pose, bearing
from colias_sim.robot import ParkedRobot, Robot

try:
    __version__ = version("colias-sim")
    """The version of colias-sim that is installed."""
except PackageNotFoundError:  # run from a folder of sources that was never installed
    __version__ = "0+unknown"

register_envs()

__all__ = [
    "Camera",
    "CameraConfig",
    "EventCamera",
    "EventConfig",
    "Frame",
    "GLUnavailable",
    "OpenLoop",
    "ParkedRobot",
    "PathFollower",
    "Pose",
    "Robot",
    "RobotConfig",
    "Route",
    "SceneConfig",
    "Schedule",
    "Simulation",
    "Stretch",
    "Tracker",
    "Truth",
    "__version__",
    "bearing",
    "register_envs",
    "swarm_env",
]

# The names whose modules import MuJoCo are looked up when they are first asked for, so that listing the envs, or
# setting up trials, does without it. Type checkers read the imports; a `__getattr__` that they saw would make any name
# one of this package's.
if TYPE_CHECKING:
    from colias_sim.camera import Camera, Frame
    from colias_sim.event_camera import EventCamera
    from colias_sim.simulation import Simulation
    from colias_sim.truth import Truth
else:
    _LATER = {"camera": "Camera Frame", "event_camera": "EventCamera", "simulation": "Simulation", "truth": "Truth"}
    _NAMES = {module: names.split() for module, names in _LATER.items()}
    __getattr__, _, _ = lazy_loader.attach(__name__, submod_attrs=_NAMES)

    def __dir__() -> list[str]:
        """List every public name, imported already or not."""
        return sorted({*globals(), *__all__})
