"""The camera's sensor: add up renders of the scene, as grey levels, over an exposure."""

from __future__ import annotations

import cv2
import mujoco
import numpy as np
import numpy.typing as npt

from colias_sim.config import CameraConfig
from colias_sim.exposure import Render
from colias_sim.offscreen import Offscreen

Floats = npt.NDArray[np.float32]
_MOST_SLOTS = 4


class Sensor:
    """Adds up the renders of one frame, and with a rolling shutter also the next frame's.

    Parameters
    ----------
    eye
        The scene's camera to render.
    offscreen
        Framebuffer, with the slots of `slots_of`.
    config
        The camera's settings.
    """

    def __init__(self, eye: mujoco.MjvCamera, offscreen: Offscreen, config: CameraConfig) -> None:
        self._eye, self._offscreen = eye, offscreen
        self._grey = np.empty(render_shape(config), np.uint8)
        self._light = np.zeros((config.height, config.width), np.float32)
        self._ahead = np.zeros_like(self._light)
        self._exposures = 0
        self._strips = Strips(offscreen, config, slots_of(config)) if _has_bands(config) else None

    @property
    def bands(self) -> bool:
        """Whether it renders bands of rows, for a rolling shutter."""
        return self._strips is not None

    def restart(self) -> None:
        """Discard everything, the light of the next frame too."""
        self.discard()
        self._ahead[:] = 0.0

    def expose(self, data: mujoco.MjData, render: Render) -> None:
        """Render the present scene, and add it to the current exposure."""
        if render.bottom:
            assert self._strips is not None, "only a rolling shutter renders bands of rows"
            self._strips.draw(data, self._eye, render, self._light, self._ahead)
            return
        self._render(data)
        if self._grey.shape != self._light.shape:
            self._light += render.parts * self._shrunk()
        else:
            for _ in range(render.parts):
                cv2.accumulate(self._grey, self._light)
        self._exposures += render.parts

    def collect(self) -> None:
        """Read the pixels that OpenGL has drawn since the last call."""
        if self._strips is not None:
            self._strips.collect(self._light, self._ahead)

    def average(self, samples: int) -> Floats:
        """Divide the light of the current frame, (R, C), by its number of renders, in place.

        Parameters
        ----------
        samples
            Number of renders of each row, for bands of rows; otherwise the renders are counted.
        """
        exposures = self._exposures if self._strips is None else samples
        if exposures > 1:
            self._light *= 1.0 / exposures
        return self._light

    def discard(self) -> None:
        """Discard the current exposure."""
        self.collect()
        self._light[:] = 0.0
        self._exposures = 0

    def turn(self) -> None:
        """Continue with the next frame, parts of which may be exposed already."""
        self._light, self._ahead = self._ahead, self._light

    def mean(self, data: mujoco.MjData) -> float:
        """Compute the mean grey of the present scene, with all rows at this moment, outside any exposure."""
        self._render(data)
        return float(cv2.mean(self._grey)[0])

    def still(self, data: mujoco.MjData) -> Floats:
        """Render the present scene, (R, C) float32, with all rows at this moment, outside any exposure."""
        self._render(data)
        return self._shrunk()

    def _render(self, data: mujoco.MjData) -> None:
        """Render the whole picture as grey levels, first row uppermost."""
        rgb = self._offscreen.render(data, self._eye)
        cv2.cvtColor(rgb, cv2.COLOR_RGB2GRAY, dst=self._grey)  # BT.601: the Y of YUV
        cv2.flip(self._grey, 0, dst=self._grey)  # OpenGL's first row is the lowest

    def _shrunk(self) -> Floats:
        """Average the render's pixels within each pixel of the picture, (R, C)."""
        height, width = self._light.shape
        grey = self._grey.astype(np.float32)
        return np.asarray(cv2.resize(grey, (width, height), interpolation=cv2.INTER_AREA), np.float32)


def slots_of(config: CameraConfig) -> int:
    """Count the framebuffer's slots: with bands one for each sample of an exposure, and one for the next frame."""
    return min(config.exposure_samples + 1, _MOST_SLOTS) if _has_bands(config) else 1


def render_shape(config: CameraConfig) -> tuple[int, int]:
    """Compute rows and columns of a whole render."""
    return config.height * config.supersample, config.width * config.supersample * config.supersample_columns


def _has_bands(config: CameraConfig) -> bool:
    return config.row_time_us > 0.0


# Bands of rows: a rolling shutter.


class Strips:
    """Draws bands of rows, and reads several of them together, because OpenGL waits at each reading.

    A band is drawn into the first slot of the framebuffer without unread pixels in its rows. If there is none,
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
        self._drawn: dict[int, list[Render]] = {}  # slot -> the bands in it that are not yet read

    def draw(self, data: mujoco.MjData, camera: mujoco.MjvCamera, render: Render, light: Floats, ahead: Floats) -> None:
        """Draw a band of the present scene. ``light`` and ``ahead`` are passed to `collect` if that is due."""
        taken = {
            slot
            for slot, bands in self._drawn.items()
            if any(band.top < render.bottom and render.top < band.bottom for band in bands)
        }
        slot = next((slot for slot in range(self._slots) if slot not in taken), None)
        if slot is None:
            self.collect(light, ahead)
            slot = 0
        self._offscreen.draw(data, camera, self._rows(render.top, render.bottom), slot)
        self._drawn.setdefault(slot, []).append(render)

    def collect(self, light: Floats, ahead: Floats) -> None:
        """Read the drawn bands, and add them to the exposures.

        Parameters
        ----------
        light, ahead
            The exposures of the current and of the next frame, (R, C).
        """
        drawn, self._drawn = self._drawn, {}
        for slot, bands in sorted(drawn.items()):
            top, bottom = min(band.top for band in bands), max(band.bottom for band in bands)
            grey = self._read(top, bottom, slot)
            for render in bands:
                target = ahead if render.ahead else light
                target[render.top : render.bottom] += render.parts * grey[render.top - top : render.bottom - top]

    def _read(self, top: int, bottom: int, slot: int) -> Floats:
        """Read rows of a slot as grey levels, top row first."""
        rgb = self._offscreen.read(self._rows(top, bottom), slot)
        grey = cv2.flip(cv2.cvtColor(rgb, cv2.COLOR_RGB2GRAY), 0).astype(np.float32)
        if grey.shape == (bottom - top, self._width):
            return grey
        return np.asarray(cv2.resize(grey, (self._width, bottom - top), interpolation=cv2.INTER_AREA), np.float32)

    def _rows(self, top: int, bottom: int) -> range:
        """Convert rows to rows of the framebuffer, counted from the bottom."""
        return range((self._height - bottom) * self._scale, (self._height - top) * self._scale)
