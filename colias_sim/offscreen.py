"""One offscreen picture of a MuJoCo scene, over the backend this package chose.

MuJoCo's own ``Renderer`` uses the backend that was named when mujoco was first imported, which may be before this
package was; and it flips and copies each picture. This one does neither.
"""

from __future__ import annotations

import importlib
import weakref
from typing import Any

import mujoco
import numpy as np
import numpy.typing as npt

from colias_sim import gl

MAX_GEOMS = 1000


class Offscreen:
    """A framebuffer of (rows, columns) and the OpenGL context that owns it; for one thread.

    Raises `colias_sim.gl.GLUnavailable` where nothing can render.
    """

    def __init__(self, model: mujoco.MjModel, rows: int, columns: int) -> None:
        model.vis.global_.offwidth, model.vis.global_.offheight = columns, rows  # read by MjrContext alone
        backend = importlib.import_module(f"mujoco.{gl.require_backend()}")
        try:
            self._context = backend.GLContext(columns, rows)
            self._context.make_current()
            self._mjr = mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_50.value)
        except mujoco.FatalError as error:
            raise gl.GLUnavailable(f"OpenGL cannot draw {columns}x{rows} pixels: {error}") from None
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN.value, self._mjr)
        self._scene = mujoco.MjvScene(model, MAX_GEOMS)
        self._rect = mujoco.MjrRect(0, 0, columns, rows)
        self._model = model
        self._pixels = np.empty((rows, columns, 3), np.uint8)
        self._free = weakref.finalize(self, _free, self._context, self._mjr)
        self._free.atexit = False  # by then MuJoCo has closed the display under it

    def render(self, data: mujoco.MjData, camera: mujoco.MjvCamera, option: mujoco.MjvOption) -> npt.NDArray[np.uint8]:
        """The view of a camera, fixed in the scene or free: RGB (rows, columns, 3), *bottom row first*.

        The array is overwritten by the next call.
        """
        if not self._free.alive:
            raise RuntimeError("this camera is closed: make a new Simulation")
        everything = mujoco.mjtCatBit.mjCAT_ALL.value
        mujoco.mjv_updateScene(self._model, data, option, None, camera, everything, self._scene)
        self._context.make_current()
        mujoco.mjr_render(self._rect, self._scene, self._mjr)
        mujoco.mjr_readPixels(self._pixels, None, self._rect, self._mjr)
        return self._pixels

    def close(self) -> None:
        """Free framebuffer and context, as dropping the last reference does; a second call does nothing."""
        self._free()


def _free(context: Any, mjr: mujoco.MjrContext) -> None:
    """Free both with their own context current: the framebuffer's names may mean another's in any other."""
    context.make_current()
    mjr.free()
    context.free()
