"""Optics of the camera: lamps, lens, noise, and the tone of the sensor's signal processor."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import cv2
import mujoco
import numpy as np
import numpy.typing as npt

from colias_sim.config import CameraConfig
from colias_sim.registers import GAMMA_INPUTS, UNIT_CONTRAS

Floats = npt.NDArray[np.float32]
WARM_UP_ROWS = 2
_STANDARD_NORMAL = np.zeros(1), np.ones(1)
WHITE = 255.0
_GAMMA_END = 256.0
"""End of the gamma curve's highest segment, in input and output. Register SLOP is its slope times 64."""


class Lamps:
    """The lamps of a model and its headlight, with a common factor on their light.

    A camera's gain and exposure time scale the light before OpenGL rounds it to 8 bits. Emission of materials is not
    scaled; the materials of this package's scenes emit nothing.

    Parameters
    ----------
    model
        The compiled scene.
    """

    def __init__(self, model: mujoco.MjModel) -> None:
        headlight = model.vis.headlight
        self._every: tuple[npt.NDArray[np.float32], ...] = (
            model.light_ambient, model.light_diffuse, model.light_specular,
            headlight.ambient, headlight.diffuse, headlight.specular,
        )  # fmt: skip
        self.look()

    def look(self) -> None:
        """Find the lamps' colours that are not black, because the others need no scaling."""
        self._lit = [colours for colours in self._every if colours.any()]

    @contextmanager
    def scaled(self, factor: float) -> Iterator[None]:
        """Multiply the light by ``factor`` within a context, and restore its exact value afterwards."""
        before = [colours.copy() for colours in self._lit]
        for colours in self._lit:
            colours *= np.float32(factor)
        try:
            yield
        finally:
            for colours, plain in zip(self._lit, before, strict=True):
                colours[:] = plain


def point_spread(sd_px: float) -> Floats:
    """Compute the lens's point spread on the picture's grid, along one axis: the discrete Gaussian.

    Its variance is exactly ``sd_px^2``, and its modulation transfer exp(sd^2 (cos 2 pi f - 1)) at f cycles per px, at
    any width. A sampled Gaussian has neither if it is narrower than a pixel.

    Parameters
    ----------
    sd_px
        Standard deviation, in px.

    Returns
    -------
    ndarray
        Its weights, (2 h + 1,) float32, of sum 1, with h = ceil(4 sd) + 1.

    References
    ----------
    Lindeberg 1990, "Scale-space for discrete signals", IEEE Trans. PAMI 12(3).
    """
    half = int(np.ceil(4.0 * sd_px)) + 1
    transfer = np.exp(sd_px**2 * (np.cos(2 * np.pi * np.fft.rfftfreq(256)) - 1.0))
    weights = np.roll(np.fft.irfft(transfer, 256), half)[: 2 * half + 1]
    kernel: Floats = (weights / weights.sum()).astype(np.float32)
    return kernel


def falloff(rows: int, columns: int, focal_px: float, exponent: float) -> Floats:
    """Compute a lens's falloff: the light at each pixel as a share of the light on the axis, cos(angle)^exponent.

    Parameters
    ----------
    rows, columns
        Size of the picture, whose middle is on the axis.
    focal_px
        Focal length, px.
    exponent
        The power: 4 is the natural falloff of a lens without mechanical vignetting, 0 none.

    Returns
    -------
    ndarray
        Shares, 0 to 1, (R, C) float32, at the pixels' middles.
    """
    y, x = np.arange(rows) - (rows - 1) / 2, np.arange(columns) - (columns - 1) / 2
    tangent_squared = (x**2 + y[:, np.newaxis] ** 2) / focal_px**2
    share: Floats = ((1.0 + tangent_squared) ** (-exponent / 2)).astype(np.float32)
    return share


class Noise:
    """Photon and read noise of a frame. Both are Gaussian, which holds for photon noise above some tens of electrons.

    Parameters
    ----------
    config
        The camera's settings.
    """

    def __init__(self, config: CameraConfig) -> None:
        shape = config.height, config.width
        self._on = config.shot_noise > 0.0 or config.read_noise > 0.0
        self._photons = config.gain * config.shot_noise**2 / 255.0
        self._read_variance = np.full(shape, (config.gain * config.read_noise) ** 2, np.float32)
        self._noise, self._spread = np.zeros(shape, np.float32), np.empty(shape, np.float32)
        self._tape = np.empty((config.height + WARM_UP_ROWS, config.width), np.float32)

    def draw(self, light: Floats, rng: np.random.Generator) -> Floats:
        """Draw the noise of one frame.

        Parameters
        ----------
        light
            The frame without noise, in grey levels, (R, C).
        rng
            Generator of the noise. Without noise nothing is drawn from it.

        Returns
        -------
        ndarray
            The noise to add, (R, C) float32. The next call overwrites this array.
        """
        if not self._on:
            return self._noise
        # OpenCV's generator, seeded for each frame from the trial's, is five times faster than NumPy's. Its first
        # numbers after seeding correlate with the seed: they are drawn into rows above the picture and not used.
        cv2.setRNGSeed(int(rng.bit_generator.random_raw()) & 0x7FFFFFFF)  # of 32 or 64 bits
        cv2.randn(self._tape, *_STANDARD_NORMAL)
        cv2.scaleAdd(light, self._photons, self._read_variance, self._spread)
        np.sqrt(self._spread, out=self._spread)
        return np.multiply(self._tape[WARM_UP_ROWS:], self._spread, out=self._noise)


class Tone:
    """Gamma curve, contrast and brightness of a sensor, in this order.

    Parameters
    ----------
    config
        The camera's settings.
    """

    def __init__(self, config: CameraConfig) -> None:
        self._inputs = np.array([0.0, *GAMMA_INPUTS, _GAMMA_END])
        self._outputs = np.array([0.0, *config.gamma_points, _GAMMA_END])
        self._gamma = config.gamma
        self._slope = config.contrast / UNIT_CONTRAS
        self._offset = config.contrast_center * (1.0 - self._slope) + config.brightness

    @property
    def on(self) -> bool:
        """Whether any stage changes a grey level."""
        return self._gamma or (self._slope, self._offset) != (1.0, 0.0)

    def of(self, light: Floats) -> Floats:
        """Compute the luma of grey levels, without noise and rounding.

        Parameters
        ----------
        light
            Grey levels in proportion to the light, (R, C). They are first clipped to 0..255, as in the
            analogue-to-digital converter.

        Returns
        -------
        ndarray
            Luma in the full range, 0 to 255, (R, C) float32.
        """
        grey = np.clip(light, 0.0, WHITE)
        if self._gamma:
            grey = np.minimum(np.interp(grey, self._inputs, self._outputs), WHITE)
        luma: Floats = np.clip(self._slope * grey + self._offset, 0.0, WHITE).astype(np.float32)
        return luma
