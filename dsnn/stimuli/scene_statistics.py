"""Measure a picture's statistics for comparison with natural images: its amplitude spectrum and its contrasts."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from dsnn.stimuli.stimulus import Luma

FITTED = (0.02, 0.4)
"""Range of spatial frequencies for the slope, cycles/px. Below it few waves fit a frame; above it pixels show."""
BINS = 16
"""Rings of equal width in log frequency."""
PATCH_PX = 32
"""Side of the patches that local contrast is measured in."""

Floats = npt.NDArray[np.float64]


def contrasts(picture: Luma) -> dict[str, float]:
    """Measure the contrasts of a picture.

    Parameters
    ----------
    picture
        (R, C) uint8, grey levels, of at least 32 px along each side.

    Returns
    -------
    dict of str to float
        ``rms``: standard deviation over mean of its grey levels. ``log_rms``: standard deviation of the natural
        logarithm of its grey levels, 0 taken as 1. ``michelson``: (H - L) / (H + L), where H and L are its 99th and its
        1st percentile. ``local_range``: 97.5th over 2.5th percentile of the RMS contrast in patches of 32 px.

    Examples
    --------
    >>> from dsnn.stimuli import contrasts, scene
    >>> 0.2 < contrasts(scene("dead-leaves", (180, 540), seed=1))["rms"] < 1.0
    True
    """
    grey = np.asarray(picture, np.float64)
    low, high = np.percentile(grey, (1, 99))
    rows, columns = (side // PATCH_PX for side in grey.shape)
    patches = grey[: rows * PATCH_PX, : columns * PATCH_PX].reshape(rows, PATCH_PX, columns, PATCH_PX)
    local = patches.std(axis=(1, 3)) / np.maximum(patches.mean(axis=(1, 3)), 1.0)
    least, most = np.percentile(local, (2.5, 97.5))
    return {
        "rms": float(grey.std() / grey.mean()),
        "log_rms": float(np.log(np.maximum(grey, 1.0)).std()),
        "michelson": float((high - low) / (high + low)),
        "local_range": float(most / least) if least else float("inf"),
    }


def amplitude_spectrum(picture: Luma) -> tuple[Floats, Floats]:
    """Compute a picture's amplitude spectrum, averaged over orientations.

    Parameters
    ----------
    picture
        (R, C) uint8, grey levels. Its borders are faded out by a Hann window.

    Returns
    -------
    tuple of numpy.ndarray
        Frequencies in cycles/px and amplitudes in grey levels, the means of up to 16 rings in log frequency.

    Examples
    --------
    >>> from dsnn.stimuli import amplitude_spectrum, scene
    >>> frequencies, amplitudes = amplitude_spectrum(scene("pink", (180, 540), seed=1))
    >>> bool(amplitudes[0] > amplitudes[-1])
    True
    """
    grey = np.asarray(picture, np.float64)
    window = np.outer(*(np.hanning(side + 2)[1:-1] for side in grey.shape))
    centred = (grey - np.average(grey, weights=window)) * window
    amplitude = np.abs(np.fft.rfft2(centred)) / window.sum()
    frequency = np.hypot(np.fft.fftfreq(grey.shape[0])[:, np.newaxis], np.fft.rfftfreq(grey.shape[1]))
    edges = np.geomspace(*FITTED, BINS + 1)
    ring = np.digitize(frequency, edges) - 1
    there = [number for number in range(BINS) if (ring == number).any()]
    means = [(frequency[ring == number].mean(), amplitude[ring == number].mean()) for number in there]
    frequencies, amplitudes = np.array(means).T
    return frequencies, amplitudes


def spectrum_slope(picture: Luma) -> float:
    """Fit the slope of a picture's amplitude spectrum in log-log coordinates.

    Parameters
    ----------
    picture
        (R, C) uint8, grey levels, of at least 64 px along each side.

    Returns
    -------
    float
        The slope: 0 for white noise, -1 for an amplitude proportional to one over frequency. Photographs of natural
        scenes have -0.8 to -1.5, on average -1.2 (Tolhurst, Tadmor and Chao 1992).

    Examples
    --------
    >>> from dsnn.stimuli import scene, spectrum_slope
    >>> -1.5 < spectrum_slope(scene("dead-leaves", (180, 540), seed=1)) < -0.8
    True
    """
    frequencies, amplitudes = amplitude_spectrum(picture)
    return float(np.polyfit(np.log(frequencies), np.log(amplitudes), 1)[0])
