"""The noise of a camera: photons and read-out."""

from __future__ import annotations

import cv2
import numpy as np
import numpy.typing as npt

from colias_sim.config import CameraConfig

Floats = npt.NDArray[np.float32]
WARM_UP_ROWS = 2
_STANDARD_NORMAL = np.zeros(1), np.ones(1)


class Noise:
    """Draws photon and read noise of a frame, both Gaussian, as photon noise is above some tens of electrons.

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
            What to add, (R, C) float32. The next call overwrites this array.
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
