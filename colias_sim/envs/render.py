"""Rendering of an env for people: pictures of the scene, or MuJoCo's own viewer on the screen."""

from __future__ import annotations

import atexit
import threading
import weakref
from typing import Any

import cv2
import mujoco
import numpy as np
import numpy.typing as npt

from colias_sim.envs.options import EnvOptions
from colias_sim.envs.views import FRAME, LEAST_INSET_WIDTH, SCALE_M, View, dress, follow, framed, scale_of, views
from colias_sim.envs.world import OBSERVER
from colias_sim.gl import GLUnavailable, has_screen
from colias_sim.offscreen import Offscreen
from colias_sim.scene import OWN_BODY_GROUP
from colias_sim.simulation import Simulation

Picture = npt.NDArray[np.uint8]
SCALE_GREY = 245
"""Grey level of the scale."""
DRAWN = (0, OWN_BODY_GROUP)
"""The groups of geoms that are drawn."""


class Renderer:
    """Shows a simulation as ``options.render_mode`` asks. The viewer's window opens with the first episode.

    Parameters
    ----------
    sim
        The simulation to show.
    options
        The env's options; ``render_mode`` is not ``None``.

    Raises
    ------
    colias_sim.GLUnavailable
        Where nothing can render, and in mode ``human`` where there is no screen.
    """

    def __init__(self, sim: Simulation, options: EnvOptions) -> None:
        self._sim, self._mode = sim, options.render_mode
        self._viewer: Any = None
        self._shut: Any = None
        self._offscreen: Offscreen | None = None
        if self._mode == "human":
            if not has_screen():
                raise GLUnavailable("no screen to open a window on (DISPLAY is not set): use render_mode='rgb_array'")
            return
        self._views = views(sim.model, options.render_view, options.render_width, options.render_height)
        self._scale = scale_of(self._views[0]) if self._views[0].people else None
        self._options = {people: _drawn(own_body=people) for people in (False, True)}
        self._floor = sim.model.geom("floor").id
        self._offscreen = Offscreen(sim.model, options.render_height, options.render_width)

    def begin(self) -> None:
        """Notice that an episode has begun: call after a reset."""
        self.step()

    def step(self) -> None:
        """Notice a step: call after each."""
        if self._mode == "human":
            self._sync()

    def picture(self) -> Picture | None:
        """Return the return value of ``render()``.

        Returns
        -------
        ndarray or None
            For ``rgb_array`` a picture, (H, W, 3) uint8; otherwise ``None``.
        """
        return self._draw() if self._mode == "rgb_array" else None

    def retexture(self, texture: int) -> None:
        """Notice that the model's texture of this index has changed."""
        if self._offscreen is not None:
            self._offscreen.retexture(texture)
        if self._viewer is not None:
            self._viewer.update_texture(texture)

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
        for view in self._views:
            self._draw_view(view)
        picture = np.flipud(framed(self._offscreen.read_all(), self._views[1:])).copy()
        if self._scale is not None and picture.shape[1] >= LEAST_INSET_WIDTH:
            _draw_scale(picture, self._scale)
        return picture

    def _draw_view(self, view: View) -> None:
        assert self._offscreen is not None
        poses = {name: robot.pose for name, robot in self._sim.everyone.items()}
        follow(view, poses[OBSERVER])

        def dressed(scene: mujoco.MjvScene) -> None:
            dress(scene, self._floor, poses, self._sim.robots)

        option = self._options[view.people]
        self._offscreen.draw_into(view.rect, self._sim.data, view.eye, option, dressed if view.people else None)

    def _sync(self) -> None:
        if self._viewer is None:
            import mujoco.viewer

            before = set(threading.enumerate())
            self._viewer = mujoco.viewer.launch_passive(
                self._sim.model, self._sim.data, show_left_ui=False, show_right_ui=False
            )
            # Also at exit, before GLFW ends: a viewer's thread that is alive after that is a segmentation fault.
            self._shut = weakref.finalize(self, _shut, self._viewer, set(threading.enumerate()) - before)
            self._shut.atexit = False
            atexit.register(self._shut)
        self._viewer.sync()


def _shut(viewer: Any, threads: set[threading.Thread]) -> None:
    """Close the window and wait until its threads are gone."""
    viewer.close()
    for thread in threads:
        thread.join(timeout=5.0)


def _draw_scale(picture: Picture, scale: tuple[float, float, float]) -> None:
    """Draw the scale and its length into a picture (H, W, 3): its left and right end, and its row, px."""
    left, right, row = map(round, scale)
    text, font, size = f"{100 * SCALE_M:g} cm", cv2.FONT_HERSHEY_SIMPLEX, picture.shape[1] / 1000
    base = max(row - 6, 0)
    for grey, extra in ((FRAME, 2), (SCALE_GREY, 0)):  # an outline, so that it is seen before any ground
        tint = (grey, grey, grey)
        cv2.rectangle(
            picture, (left - extra // 2, row - 2 - extra // 2), (right + extra // 2, row + extra // 2), tint, -1
        )
        cv2.putText(picture, text, (left, base), font, size, tint, 1 + extra, cv2.LINE_AA)


def _drawn(own_body: bool) -> mujoco.MjvOption:
    """Draw the groups of `DRAWN`, the observer's own body only on demand: its lens stands in front of all of it."""
    option = mujoco.MjvOption()
    for group in range(mujoco.mjNGROUP):
        option.geomgroup[group] = group in DRAWN
    option.geomgroup[OWN_BODY_GROUP] = own_body
    return option
