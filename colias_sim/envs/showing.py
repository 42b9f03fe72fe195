"""What ``render()`` of an env shows: pictures of the scene, or MuJoCo's own viewer on the screen."""

from __future__ import annotations

import atexit
import threading
import weakref
from typing import Any

import mujoco
import numpy as np
import numpy.typing as npt

from colias_sim import gl
from colias_sim.envs.options import EnvOptions
from colias_sim.offscreen import Offscreen
from colias_sim.scene import OWN_BODY_GROUP
from colias_sim.simulation import Simulation

Picture = npt.NDArray[np.uint8]
DRAWN = (0, OWN_BODY_GROUP)


class Shower:
    """Shows a simulation as ``options.render_mode`` asks. Raises `colias_sim.gl.GLUnavailable` where it cannot.

    The viewer's window opens with the first episode.
    """

    def __init__(self, sim: Simulation, options: EnvOptions) -> None:
        self._sim, self._mode = sim, options.render_mode
        self._kept: list[Picture] = []
        self._viewer: Any = None
        self._shut: Any = None
        self._offscreen: Offscreen | None = None
        if self._mode == "human":
            gl.require_screen()
            return
        self._eye = _eye(sim.model, options.render_view)
        self._option = mujoco.MjvOption()
        for group in range(mujoco.mjNGROUP):
            self._option.geomgroup[group] = group in DRAWN
        self._option.geomgroup[OWN_BODY_GROUP] = options.render_view != "observer"
        self._offscreen = Offscreen(sim.model, options.render_height, options.render_width)

    def begin(self) -> None:
        """After a reset."""
        self._kept.clear()
        self.step()

    def step(self) -> None:
        """After a step."""
        if self._mode == "rgb_array_list":
            self._kept.append(self._draw())
        elif self._mode == "human":
            self._sync()

    def picture(self) -> Picture | list[Picture] | None:
        """What ``render()`` returns: (H, W, 3) uint8, or a list of those since the last call, or nothing."""
        if self._mode == "rgb_array":
            return self._draw()
        if self._mode == "rgb_array_list":
            kept, self._kept = self._kept, []
            return kept
        return None

    def close(self) -> None:
        """Free the context, or close the window."""
        if self._offscreen is not None:
            self._offscreen.close()
        if self._shut is not None:
            self._shut()
            atexit.unregister(self._shut)

    def _draw(self) -> Picture:
        assert self._offscreen is not None
        mujoco.mj_kinematics(self._sim.model, self._sim.data)
        mujoco.mj_camlight(self._sim.model, self._sim.data)
        return np.flipud(self._offscreen.render(self._sim.data, self._eye, self._option)).copy()

    def _sync(self) -> None:
        if self._viewer is None:
            import mujoco.viewer

            before = set(threading.enumerate())
            self._viewer = mujoco.viewer.launch_passive(
                self._sim.model, self._sim.data, show_left_ui=False, show_right_ui=False
            )
            # At exit too, and before GLFW ends: a thread of the viewer's left then is a segmentation fault.
            self._shut = weakref.finalize(self, _shut, self._viewer, set(threading.enumerate()) - before)
            self._shut.atexit = False
            atexit.register(self._shut)
        self._viewer.sync()


def _shut(viewer: Any, threads: set[threading.Thread]) -> None:
    """Close the window and wait until its threads are gone."""
    viewer.close()
    for thread in threads:
        thread.join(timeout=5.0)


def _eye(model: mujoco.MjModel, view: str) -> mujoco.MjvCamera:
    eye = mujoco.MjvCamera()
    if view == "observer":
        eye.type, eye.fixedcamid = mujoco.mjtCamera.mjCAMERA_FIXED.value, model.camera("observer/eye").id
        return eye
    eye.type = mujoco.mjtCamera.mjCAMERA_FREE.value
    eye.lookat[:] = 0.0, 0.0, 0.0
    eye.azimuth, eye.elevation, eye.distance = (90.0, -90.0, 1.3) if view == "top" else (90.0, -50.0, 1.15)
    return eye
