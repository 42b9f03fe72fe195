"""Clips that many tests of models show: a crossing that is no mirror image of itself, an approach, a texture."""

import numpy as np

from tests.conftest import crossing

SHAPE = (72, 99)


def oblique(dark=True):
    """A clip that is no mirror image of itself: fast to the right, slowly down."""
    return np.stack([np.roll(frame, i // 2, axis=0) for i, frame in enumerate(crossing(dark=dark))])


def approach(dark=True, shape=SHAPE, size=4.0, focal=70.7):
    """A square of 4 cm coming at constant speed from 25 cm to 5 cm, off the field's centre, (100, R, C) uint8."""
    rows, columns = shape
    field, thing = (240.0, 20.0) if dark else (20.0, 240.0)
    frames = []
    for distance in np.linspace(25.0, 5.0, 100):
        half = focal * size / 2 / distance
        down, across = (
            np.clip(at + 1 + half, 0, 1) * np.clip(half - at, 0, 1)
            for at in (np.arange(rows) - rows / 2 + 3, np.arange(columns) - columns / 2 - 5)
        )
        frames.append(np.rint(field + (thing - field) * np.outer(down, across)))
    return np.stack(frames).astype(np.uint8)


def texture(shape=SHAPE, seed=4):
    """A blurred random pattern from 0 to 255, float64, that meets itself at the border."""
    rows, columns = shape
    down, across = np.fft.fftfreq(rows)[:, None], np.fft.fftfreq(columns)
    smooth = np.exp(-0.5 * (2 * np.pi * 2.0) ** 2 * (down**2 + across**2))
    pattern = np.fft.ifft2(np.fft.fft2(np.random.default_rng(seed).normal(size=shape)) * smooth).real
    return np.interp(pattern, (pattern.min(), pattern.max()), (0.0, 255.0))
