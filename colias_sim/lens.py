"""The blur and the falloff of a camera's lens."""

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


def falloff(rows: int, columns: int, focal_px: float, exponent: float) -> Floats:
    """Compute which share of the light on the axis a lens passes to each pixel: the cosine of its angle, to a power.

    Parameters
    ----------
    rows, columns
        Of the picture, whose middle is on the axis.
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
