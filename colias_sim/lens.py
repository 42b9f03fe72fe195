"""The blur of a camera's lens."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float32]


def point_spread(sd_px: float) -> Floats:
    """Compute the lens's point spread on the picture's grid, along one axis: the discrete Gaussian.

    Its variance is exactly ``sd_px^2`` and its modulation transfer exp(sd^2 (cos 2 pi f - 1)) at f cycles a px, at any
    width. A Gaussian sampled at whole pixels has neither where it is narrower than a pixel.

    Parameters
    ----------
    sd_px
        Standard deviation, in px.

    Returns
    -------
    ndarray
        Its weights, (2 h + 1,) float32, of sum 1; h is 4 sd, rounded up, and one more.

    References
    ----------
    Lindeberg 1990, "Scale-space for discrete signals", IEEE Trans. PAMI 12(3).
    """
    half = int(np.ceil(4.0 * sd_px)) + 1
    transfer = np.exp(sd_px**2 * (np.cos(2 * np.pi * np.fft.rfftfreq(256)) - 1.0))
    weights = np.roll(np.fft.irfft(transfer, 256), half)[: 2 * half + 1]
    kernel: Floats = (weights / weights.sum()).astype(np.float32)
    return kernel
