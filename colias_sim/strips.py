"""The rows of a picture rendered band by band, each at its own moment: a rolling shutter."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import mujoco
import numpy as np
import numpy.typing as npt

from colias_sim.config import CameraConfig
from colias_sim.exposure import Render
from colias_sim.offscreen import Offscreen

Floats = npt.NDArray[np.float32]
_MOST_SLOTS = 4


@dataclass(frozen=True, slots=True)
class _Drawn:
    """A band that OpenGL has drawn, and nobody has read."""

    render: Render
    slot: int


class Strips:
    """Draws bands of rows, and reads several of them together, as OpenGL waits for each reading.

    A band is drawn into the first slot of the framebuffer where nothing unread lies in its rows. Where there is none,
    everything is read first.

    Parameters
    ----------
    offscreen
        Framebuffer with ``slots`` slots.
    config
        The camera's settings.
    slots
        Number of slots.
    """

    def __init__(self, offscreen: Offscreen, config: CameraConfig, slots: int) -> None:
        self._offscreen, self._slots = offscreen, slots
        self._height, self._width, self._scale = config.height, config.width, config.supersample
        self._drawn: list[_Drawn] = []

    @staticmethod
    def slots(config: CameraConfig) -> int:
        """Tell how many slots spare readings: one for each sample of an exposure, and one for the next frame's."""
        return min(config.exposure_samples + 1, _MOST_SLOTS)

    def draw(
        self, data: mujoco.MjData, camera: mujoco.MjvCamera, option: mujoco.MjvOption, render: Render,
        light: Floats, ahead: Floats,
    ) -> None:  # fmt: skip
        """Draw a band of the present scene. ``light`` and ``ahead`` are those of `collect`, in case it is due."""
        taken = {
            strip.slot for strip in self._drawn if strip.render.top < render.bottom and render.top < strip.render.bottom
        }
        slot = next((slot for slot in range(self._slots) if slot not in taken), None)
        if slot is None:
            self.collect(light, ahead)
            slot = 0
        self._offscreen.draw(data, camera, option, self._rows(render.top, render.bottom), slot)
        self._drawn.append(_Drawn(render, slot))

    def collect(self, light: Floats, ahead: Floats) -> None:
        """Read what was drawn, and add it to the exposures.

        Parameters
        ----------
        light, ahead
            The exposure of the frame under way and that of the next, (R, C).
        """
        drawn, self._drawn = self._drawn, []
        for slot in sorted({strip.slot for strip in drawn}):
            inside = [strip.render for strip in drawn if strip.slot == slot]
            top, bottom = min(strip.top for strip in inside), max(strip.bottom for strip in inside)
            grey = self._read(top, bottom, slot)
            for render in inside:
                target = ahead if render.ahead else light
                target[render.top : render.bottom] += render.parts * grey[render.top - top : render.bottom - top]

    def _read(self, top: int, bottom: int, slot: int) -> Floats:
        """Return rows of a slot as grey levels, first row uppermost."""
        rgb = self._offscreen.read(self._rows(top, bottom), slot)
        grey = cv2.flip(cv2.cvtColor(rgb, cv2.COLOR_RGB2GRAY), 0).astype(np.float32)
        if grey.shape == (bottom - top, self._width):
            return grey
        return np.asarray(cv2.resize(grey, (self._width, bottom - top), interpolation=cv2.INTER_AREA), np.float32)

    def _rows(self, top: int, bottom: int) -> range:
        """Return rows of the framebuffer, counted from below."""
        return range((self._height - bottom) * self._scale, (self._height - top) * self._scale)
