"""The tone of a picture: what the sensor's signal processor makes of a pixel's grey before it is luma."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from colias_sim.config import CameraConfig
from colias_sim.registers import GAMMA_INPUTS, UNIT_CONTRAS

Floats = npt.NDArray[np.float32]
WHITE = 255.0
_GAMMA_END = 256.0
"""Where the highest segment of the gamma curve ends, in input and in output: register SLOP is its slope times 64."""


class Tone:
    """Gamma curve, contrast and brightness of a sensor, in the order in which a pixel passes them.

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
        """Tell whether any stage changes a grey level."""
        return self._gamma or (self._slope, self._offset) != (1.0, 0.0)

    def of(self, light: Floats) -> Floats:
        """Return the luma of grey levels, without noise and rounding.

        Parameters
        ----------
        light
            Grey levels in proportion to the light, (R, C). Below 0 and above 255 they are clipped first, as the
            converter to digits does.

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
