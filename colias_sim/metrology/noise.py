"""Noise by grey level, the photon transfer and the fixed pattern (EMVA 1288)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from colias_sim.metrology.errors import MetrologyError

Floats = npt.NDArray[np.float64]
Images = npt.NDArray[np.uint8]

QUANTISATION = 1.0 / 12.0
"""Variance of rounding to whole grey levels."""
CLIP_SDS = 4.0
"""A pixel counts where its mean is this many sd away from 0 and from 255: clipping makes noise look smaller."""
SCATTER_SDS = 4.0
"""Bound on the scatter of `unsteadiness` where all is noise, about one over the root of the number of values."""
LEAST_PIXELS = 30
"""Width of a bin of grey levels."""


@dataclass(frozen=True, slots=True)
class NoiseLevels:
    """Temporal noise of a still scene by grey level.

    Parameters
    ----------
    mean, variance
        Of each bin of pixels, (N,), in grey levels and their squares. The rounding's variance is taken off.
    pixels
        How many pixels each bin has, (N,).
    """

    mean: Floats
    variance: Floats
    pixels: npt.NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class PhotonTransfer:
    """The line ``variance = slope mean + dark_sd^2`` of the photon transfer.

    Parameters
    ----------
    slope
        Grey levels of variance for each of mean.
    dark_sd
        Noise without light, sd in grey levels.
    """

    slope: float
    dark_sd: float

    def shot_noise(self, gain: float) -> float:
        """Compute ``shot_noise`` of `colias_sim.CameraConfig`: slope = gain shot_noise^2 / 255.

        Parameters
        ----------
        gain
            The camera's gain.

        Returns
        -------
        float
            The shot noise, a setting of the camera.
        """
        return math.sqrt(max(self.slope, 0.0) * 255.0 / gain)

    def read_noise(self, gain: float) -> float:
        """Compute ``read_noise`` of `colias_sim.CameraConfig`: dark_sd = gain read_noise.

        Parameters
        ----------
        gain
            The camera's gain.

        Returns
        -------
        float
            The read noise, a setting of the camera.
        """
        return self.dark_sd / gain


def noise_levels(frames: Images, bins: int = 16) -> NoiseLevels:
    """Measure temporal noise by grey level.

    Parameters
    ----------
    frames
        Of a still scene under constant light, (T, R, C), T of at least 8. It should have many grey levels, or be
        taken together with others by `photon_transfer`.
    bins
        Number of bins of pixels of similar grey.

    Returns
    -------
    NoiseLevels
        The bins that have pixels enough.

    Raises
    ------
    MetrologyError
        There are too few frames, or every pixel is clipped.
    """
    if len(frames) < 8:
        raise MetrologyError(f"{len(frames)} frames of the still scene: noise takes 8 or more (60 are good)")
    stack = frames.astype(np.float64)
    mean, variance = stack.mean(0).ravel(), stack.var(0, ddof=1).ravel()
    whole = ((stack.min(0) > 0.0) & (stack.max(0) < 255.0)).ravel()  # of a clipped pixel less noise is seen
    spread = np.sqrt(np.median(variance[whole])) if whole.any() else np.inf
    inside = (mean > CLIP_SDS * spread) & (mean < 255.0 - CLIP_SDS * spread)
    if inside.sum() < LEAST_PIXELS:
        raise MetrologyError("the still scene is clipped at 0 or 255: take it with other light")
    mean, variance = mean[inside], variance[inside]
    edges = np.linspace(mean.min(), mean.max() + 1e-9, bins + 1)
    place = np.digitize(mean, edges) - 1
    used = [index for index in range(bins) if (place == index).sum() >= LEAST_PIXELS]
    return NoiseLevels(
        np.array([mean[place == index].mean() for index in used]),
        np.array([variance[place == index].mean() for index in used]) - QUANTISATION,
        np.array([(place == index).sum() for index in used], np.int64),
    )


def unsteadiness(frames: Images) -> float:
    """Measure which share of the temporal variance of a still scene is no noise of its pixels: it was not still.

    Parameters
    ----------
    frames
        Of a scene that should be still under constant light, (T, R, C), T of 3 or more.

    Returns
    -------
    float
        A share of the variance, 0 to 1: of slow change, by which frames far apart differ more than neighbours do (von
        Neumann), or of the mean of the whole picture, whichever is more. 0 where it is no more than noise leaves.
    """
    stack = frames.astype(np.float64)
    variance = float(stack.var(0, ddof=1).mean())
    if len(stack) < 3 or variance <= 0.0:
        return 0.0
    slow = 1.0 - float((np.diff(stack, axis=0) ** 2).mean()) / 2.0 / variance
    whole = float(stack.mean((1, 2)).var(ddof=1)) / variance - 1.0 / stack[0].size
    return max(slow, whole, 0.0) if max(slow, whole) > SCATTER_SDS / math.sqrt(stack.size) else 0.0


def photon_transfer(levels: Sequence[NoiseLevels]) -> PhotonTransfer:
    """Fit the photon transfer's line to the noise of one still scene, or of several under different light.

    Parameters
    ----------
    levels
        From `noise_levels`, one or more. Bins count by the precision of their variance: the root of their pixels over
        it.

    Returns
    -------
    PhotonTransfer
        The line.

    Raises
    ------
    MetrologyError
        All grey levels are alike: they span less than 10.

    References
    ----------
    EMVA 1288, Release 4.0.
    """
    mean, variance = (np.concatenate([getattr(level, name) for level in levels]) for name in ("mean", "variance"))
    pixels = np.concatenate([level.pixels for level in levels])
    if np.ptp(mean) < 10.0:
        problem = (
            f"the still scene's grey levels span {np.ptp(mean):.1f}: shot and read noise are told apart from 10 on"
        )
        raise MetrologyError(problem)
    weight = np.sqrt(pixels) / np.maximum(variance, 1e-3)
    slope, dark = np.polyfit(mean, variance, 1, w=weight)
    return PhotonTransfer(float(slope), math.sqrt(max(float(dark), 0.0)))


def fixed_pattern(frames: Images) -> float:
    """Measure the fixed pattern: how unequal the pixels are on an evenly lit patch, apart from temporal noise.

    Parameters
    ----------
    frames
        Of an evenly lit patch, (T, R, C). Shading up to the second order over the patch is taken off.

    Returns
    -------
    float
        Its sd in grey levels: the spatial variance of the mean frame less what temporal noise leaves in it. 0 where
        noise accounts for all of it. The simulated eye has none.

    Raises
    ------
    MetrologyError
        There is one frame alone, which does not tell the pattern from noise.

    References
    ----------
    EMVA 1288, Release 4.0: the correction of spatial variance for temporal noise.
    """
    if len(frames) < 2:
        raise MetrologyError(f"{len(frames)} frame of the lit patch: its pattern is told from noise by 2 or more")
    stack = frames.astype(np.float64)
    mean, temporal = stack.mean(0), float(stack.var(0, ddof=1).mean())
    y, x = (axis.ravel() / max(axis.max(), 1) for axis in np.indices(mean.shape))
    basis = np.stack([np.ones_like(x), x, y, x * y, x * x, y * y], axis=1)
    shading, *_ = np.linalg.lstsq(basis, mean.ravel(), rcond=None)
    left = mean.ravel() - basis @ shading
    spatial = float((left**2).sum()) / (left.size - basis.shape[1])
    return math.sqrt(max(spatial - temporal / len(frames), 0.0))
