"""One offscreen picture of a MuJoCo scene, over the backend this package chose.

MuJoCo's own ``Renderer`` uses the backend that was named when mujoco was first imported, which may be before this
package was; and it flips and copies each picture. This one does neither, and can share its OpenGL context.
"""

from __future__ import annotations

import hashlib
import importlib
import weakref
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Any

import mujoco
import numpy as np
import numpy.typing as npt

from colias_sim import gl

MAX_GEOMS = 1000
UPLOADED = ("tex_data", "mesh_vert", "mesh_normal", "mesh_face", "mesh_texcoord")
"""What an `mujoco.MjrContext` copies of a model, as far as this package's scenes have it; poses and lights it does not.
"""


class Offscreen:
    """A framebuffer of (rows, columns) and an OpenGL context, its own unless made under `shared_contexts`.

    For one thread. Raises `colias_sim.gl.GLUnavailable` where nothing can render.
    """

    def __init__(self, model: mujoco.MjModel, rows: int, columns: int) -> None:
        self._surface: _Surface | None = _surface(model, rows, columns)
        self._scene = mujoco.MjvScene(model, MAX_GEOMS)
        self._rect = mujoco.MjrRect(0, 0, columns, rows)
        self._model = model
        self._pixels = np.empty((rows, columns, 3), np.uint8)

    def render(self, data: mujoco.MjData, camera: mujoco.MjvCamera, option: mujoco.MjvOption) -> npt.NDArray[np.uint8]:
        """The view of a camera, fixed in the scene or free: RGB (rows, columns, 3), *bottom row first*.

        The array is overwritten by the next call.
        """
        if self._surface is None:
            raise RuntimeError("this camera is closed: make a new Simulation")
        everything = mujoco.mjtCatBit.mjCAT_ALL.value
        mujoco.mjv_updateScene(self._model, data, option, None, camera, everything, self._scene)
        self._surface.context.make_current()
        mujoco.mjr_render(self._rect, self._scene, self._surface.mjr)
        mujoco.mjr_readPixels(self._pixels, None, self._rect, self._surface.mjr)
        return self._pixels

    def close(self) -> None:
        """Free framebuffer and context if nobody shares them, as dropping the last reference does; again, nothing."""
        self._surface = None


@contextmanager
def shared_contexts() -> Iterator[None]:
    """Within, whatever draws equal textures and meshes at one size shares one OpenGL context.

    Changing contexts between worlds that take turns costs as much as a tenth of a frame. All of them belong to the
    thread that made them.
    """
    token = _sharing.set(weakref.WeakValueDictionary())
    try:
        yield
    finally:
        _sharing.reset(token)


class _Surface:
    """A framebuffer and its context, freed with the last reference."""

    def __init__(self, model: mujoco.MjModel, rows: int, columns: int) -> None:
        model.vis.global_.offwidth, model.vis.global_.offheight = columns, rows  # read by MjrContext alone
        backend = importlib.import_module(f"mujoco.{gl.require_backend()}")
        try:
            self.context = backend.GLContext(columns, rows)
            self.context.make_current()
            self.mjr = mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_50.value)
        except mujoco.FatalError as error:
            raise gl.GLUnavailable(f"OpenGL cannot draw {columns}x{rows} pixels: {error}") from None
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN.value, self.mjr)
        weakref.finalize(self, _free, self.context, self.mjr).atexit = False  # by then MuJoCo has closed the display


_Surfaces = weakref.WeakValueDictionary[tuple[Any, ...], _Surface]
_sharing: ContextVar[_Surfaces | None] = ContextVar("_sharing", default=None)


def _surface(model: mujoco.MjModel, rows: int, columns: int) -> _Surface:
    """A new surface, or the one that this scope already has for the same."""
    surfaces = _sharing.get()
    if surfaces is None:
        return _Surface(model, rows, columns)
    contents = hashlib.blake2b()
    for name in UPLOADED:
        contents.update(np.ascontiguousarray(getattr(model, name)).tobytes())
    key = rows, columns, model.vis.quality.offsamples, contents.digest()
    found = surfaces.get(key)
    if found is None:
        surfaces[key] = found = _Surface(model, rows, columns)
    return found


def _free(context: Any, mjr: mujoco.MjrContext) -> None:
    """Free both with their own context current: the framebuffer's names may mean another's in any other."""
    context.make_current()
    mjr.free()
    context.free()
