"""Render a MuJoCo scene offscreen, with the OpenGL backend that this package chose.

MuJoCo's own ``Renderer`` uses the backend that was set when mujoco was first imported, possibly before this package. It
also flips and copies each picture, which `Offscreen` does not.
"""

from __future__ import annotations

import copy
import weakref
from collections.abc import Callable
from contextlib import AbstractContextManager, ExitStack
from typing import Any

import mujoco
import numpy as np
import numpy.typing as npt

from colias_sim import gl
from colias_sim.scene import groups_of, hidden

MAX_GEOMS = 1000


class Offscreen:
    """A framebuffer with its OpenGL context, for one thread at a time.

    The view of a robot's eye is drawn without the robot itself.

    Parameters
    ----------
    model
        The compiled scene.
    rows, columns
        Size of the pictures.
    slots
        Number of pictures that fit into the framebuffer; `draw` can draw into each.
    bright
        Whether light may exceed a material's white, up to the saturation of a pixel. Otherwise OpenGL clips the light
        on a surface before it multiplies it with the surface's texture.

    Raises
    ------
    colias_sim.GLUnavailable
        No OpenGL backend works.
    """

    def __init__(self, model: mujoco.MjModel, rows: int, columns: int, *, slots: int = 1, bright: bool = False) -> None:
        self._surface: _Surface | None = _Surface(model, rows * slots, columns)
        self._textures: dict[int, object] = {}  # changed texture -> a mark of the change
        self._rect = mujoco.MjrRect(0, 0, columns, rows)
        self._bright, self._option = bright, mujoco.MjvOption()
        self._bind(model)

    def _bind(self, model: mujoco.MjModel) -> None:
        """Draw this model."""
        self._use, self._model = ExitStack(), model
        self._scene = mujoco.MjvScene(model, MAX_GEOMS)
        eyes = [eye for eye in map(model.camera, range(model.ncam)) if eye.name.endswith("/eye")]
        self._own = {eye.id: groups_of(model, eye.name.removesuffix("/eye")) for eye in eyes}
        self._nothing = model.geom_group[:0]
        self._pixels = np.empty((self._rect.height, self._rect.width, 3), np.uint8)

    def copy(self, model: mujoco.MjModel) -> Offscreen:
        """Make a twin that draws a copy of the model into the same framebuffer, each picture as a whole."""
        twin = copy.copy(self)
        twin._bind(model)
        return twin

    def render(self, data: mujoco.MjData, camera: mujoco.MjvCamera) -> npt.NDArray[np.uint8]:
        """Render the view of a camera.

        Parameters
        ----------
        data
            State of the scene.
        camera
            A camera of the scene, or a free one.

        Returns
        -------
        ndarray
            RGB, (rows, columns, 3) uint8, *bottom row first*. The next call overwrites this array.

        Raises
        ------
        RuntimeError
            After `close`.
        """
        return self._read(self._pixels, self._rect, self._drawn(self._rect, data, camera))

    def draw(self, data: mujoco.MjData, camera: mujoco.MjvCamera, rows: range, slot: int = 0) -> None:
        """Draw some rows of a picture into a slot of the framebuffer, for `read`.

        Drawing rows one by one and reading them together costs less than rendering them: OpenGL waits only in `read`.

        Parameters
        ----------
        data, camera
            As for `render`.
        rows
            Consecutive rows of the picture, counted from the *bottom*.
        slot
            Index of the slot.
        """
        self._drawn(self._part(rows, slot), data, camera, rows)

    def read(self, rows: range, slot: int = 0) -> npt.NDArray[np.uint8]:
        """Read rows that `draw` has drawn.

        Returns
        -------
        ndarray
            RGB, (len(rows), columns, 3) uint8, bottom row first. The next call overwrites this array.
        """
        return self._read(self._pixels[: len(rows)], self._part(rows, slot), self._current())

    def draw_into(
        self, rect: tuple[int, int, int, int], data: mujoco.MjData, camera: mujoco.MjvCamera,
        dress: Callable[[mujoco.MjvScene], None] | None = None,
    ) -> None:  # fmt: skip
        """Draw the whole view of a camera into a rectangle of the picture, for `read_all`.

        Parameters
        ----------
        rect
            Left, bottom, width and height of the rectangle, in pixels.
        data, camera
            As for `render`.
        dress
            Called with the scene before it is drawn, to add geoms.
        """
        self._drawn(mujoco.MjrRect(*rect), data, camera, dress=dress)

    def read_all(self) -> npt.NDArray[np.uint8]:
        """Read the whole picture, in the form that `render` returns."""
        return self._read(self._pixels, self._rect, self._current())

    def _part(self, rows: range, slot: int) -> mujoco.MjrRect:
        return mujoco.MjrRect(0, slot * self._rect.height + rows.start, self._rect.width, len(rows))

    def _drawn(
        self, rect: mujoco.MjrRect, data: mujoco.MjData, camera: mujoco.MjvCamera,
        rows: range | None = None, dress: Callable[[mujoco.MjvScene], None] | None = None,
    ) -> _Surface:  # fmt: skip
        """Draw into a rectangle of the framebuffer: the whole view, or some rows of it."""
        everything = mujoco.mjtCatBit.mjCAT_ALL.value
        with hidden(self._own.get(camera.fixedcamid, self._nothing)):
            mujoco.mjv_updateScene(self._model, data, self._option, None, camera, everything, self._scene)
        if rows is not None:
            for eye in self._scene.camera:
                low, share = eye.frustum_bottom, (eye.frustum_top - eye.frustum_bottom) / self._rect.height
                eye.frustum_bottom, eye.frustum_top = low + share * rows.start, low + share * rows.stop
        if dress is not None:
            dress(self._scene)
        surface = self._current()
        if self._bright:
            gl.clip_light(False)
        mujoco.mjr_render(rect, self._scene, surface.mjr)
        return surface

    def _read(self, pixels: npt.NDArray[np.uint8], rect: mujoco.MjrRect, surface: _Surface) -> npt.NDArray[np.uint8]:
        with self._use:
            mujoco.mjr_readPixels(pixels, None, rect, surface.mjr)
            if self._bright:
                gl.clip_light(True)
        return pixels

    def in_use(self) -> AbstractContextManager[Any]:
        """Keep the context current in this thread, which saves time at each picture. No other thread can use it."""
        if self._surface is None:
            raise RuntimeError("this camera is closed: make a new Simulation")
        current: AbstractContextManager[Any] = self._surface.context.as_current()
        return current

    def _current(self) -> _Surface:
        """Make the context current in this thread, until ``_use`` is closed."""
        self._use.enter_context(self.in_use())
        surface = self._surface
        assert surface is not None
        for texture in {*self._textures, *surface.textures}:
            if surface.textures.get(texture) is not self._textures.get(texture):
                mujoco.mjr_uploadTexture(self._model, surface.mjr, texture)
                surface.textures[texture] = self._textures.get(texture)
        return surface

    def retexture(self, texture: int) -> None:
        """Upload a texture of the model that has changed, before the next picture.

        Parameters
        ----------
        texture
            Index of the texture.
        """
        self._textures = {**self._textures, texture: object()}

    def close(self) -> None:
        """Free framebuffer and context."""
        self._surface = None


class _Surface:
    """A framebuffer and its context, which are freed with the last reference."""

    def __init__(self, model: mujoco.MjModel, rows: int, columns: int) -> None:
        self.textures: dict[int, object] = {}
        """Which of the changes of each texture it has: twins draw in turns."""
        model.vis.global_.offwidth, model.vis.global_.offheight = columns, rows  # read by MjrContext alone
        self.context = gl.context(columns, rows)
        with self.context.as_current():
            try:
                self.mjr = mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_50.value)
            except mujoco.FatalError as error:
                raise gl.unavailable(f"{columns}x{rows} pixels: {error}") from None
            mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN.value, self.mjr)
        weakref.finalize(self, _free, self.context, self.mjr).atexit = False  # by then MuJoCo has closed the display


def _free(context: Any, mjr: mujoco.MjrContext) -> None:
    """Free both with their own context current, because another context may use the same names."""
    with context.as_current():
        mjr.free()
    context.free()
