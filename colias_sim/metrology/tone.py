"""Tone and falloff: the gamma curve from a chart of grey steps, contrast and brightness, and a lens's falloff."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from colias_sim.metrology.errors import MetrologyError
from colias_sim.registers import GAMMA_INPUTS, UNIT_CONTRAS

Floats = npt.NDArray[np.float64]
Images = npt.NDArray[np.uint8]

MARGIN = 2.0
"""A step of a chart counts where its luma is this many grey levels from 0 and from 255: clipping bends the line."""


@dataclass(frozen=True, slots=True)
class LumaLine:
    """The line ``luma = slope grey + offset`` of contrast and brightness.

    Parameters
    ----------
    slope
        Grey levels of luma for each of grey.
    offset
        Luma at grey 0, in grey levels.
    """

    slope: float
    offset: float

    @property
    def contrast(self) -> float:
        """``contrast`` of `colias_sim.CameraConfig`, which is register CONTRAS: 64 times the slope."""
        return UNIT_CONTRAS * self.slope

    def brightness(self, center: float) -> float:
        """Compute ``brightness`` of `colias_sim.CameraConfig`.

        Parameters
        ----------
        center
            The camera's ``contrast_center``, in grey levels. The line alone does not tell it from brightness.

        Returns
        -------
        float
            The offset of luma in grey levels: register BRIGHT with its sign.
        """
        return self.offset - center * (1.0 - self.slope)


def grey_steps(patches: Sequence[Images]) -> Floats:
    """Measure the mean luma of each step of a chart of grey steps.

    Parameters
    ----------
    patches
        Frames of each step's patch, (T, R, C) or (R, C), evenly lit.

    Returns
    -------
    ndarray
        Means, (N,), in grey levels.
    """
    return np.array([patch.mean(dtype=np.float64) for patch in patches])


def gamma_points(grey: Floats, luma: Floats) -> Floats:
    """Read a gamma curve where its registers have it: ``gamma_points`` of `colias_sim.CameraConfig`.

    Parameters
    ----------
    grey
        Grey of each step before the curve, (N,): reflectance in proportion to the light, 255 where it saturates.
    luma
        Luma of each step, (N,), from `grey_steps`.

    Returns
    -------
    ndarray
        GAM1 to GAM15, (15,), in grey levels, by lines between the steps. Without a curve they are its inputs.

    Raises
    ------
    MetrologyError
        The steps do not span the curve's inputs.
    """
    order = np.argsort(grey)
    low, high = float(grey[order[0]]), float(grey[order[-1]])
    if low > GAMMA_INPUTS[0] or high < GAMMA_INPUTS[-1]:
        raise MetrologyError(
            f"the chart's steps span grey {low:.0f} to {high:.0f}: a gamma curve takes {GAMMA_INPUTS[0]} to "
            f"{GAMMA_INPUTS[-1]}"
        )
    return np.interp(GAMMA_INPUTS, grey[order], luma[order])


def luma_line(grey: Floats, luma: Floats) -> LumaLine:
    """Fit the line of contrast and brightness to a chart of grey steps.

    Parameters
    ----------
    grey
        Grey of each step before contrast and brightness, (N,): the chart's luma with both registers as after a reset.
    luma
        Luma of each step with the registers in question, (N,).

    Returns
    -------
    LumaLine
        Its slope and offset, of the steps that are not clipped.

    Raises
    ------
    MetrologyError
        Fewer than 3 steps are not clipped.
    """
    inside = (luma > MARGIN) & (luma < 255.0 - MARGIN) & (grey > MARGIN) & (grey < 255.0 - MARGIN)
    if inside.sum() < 3:
        raise MetrologyError(f"{inside.sum()} steps of the chart are not clipped at 0 or 255: a line takes 3 or more")
    slope, offset = np.polyfit(grey[inside], luma[inside], 1)
    return LumaLine(float(slope), float(offset))


def falloff_exponent(flat: Images, focal_px: float) -> float:
    """Measure a lens's falloff: ``vignetting`` of `colias_sim.CameraConfig`.

    Parameters
    ----------
    flat
        Frames of an evenly bright field that fills the view, (T, R, C), without gamma curve.
    focal_px
        Focal length, px.

    Returns
    -------
    float
        The power of the cosine of the angle to the axis by which the light falls: 4 is natural falloff, 0 none.

    Raises
    ------
    MetrologyError
        A pixel is clipped in all frames.
    """
    mean = flat.mean(0, dtype=np.float64)
    if mean.min() <= 0.0 or mean.max() >= 255.0:
        raise MetrologyError("the even field is clipped at 0 or 255: take it with other light")
    y, x = (axis - (size - 1) / 2 for axis, size in zip(np.indices(mean.shape), mean.shape, strict=True))
    cosine = 1.0 / np.hypot(1.0, np.hypot(x, y) / focal_px)
    return float(np.polyfit(np.log(cosine).ravel(), np.log(mean).ravel(), 1)[0])
