"""The DSNN as Colias's own processor could run it, in the form that is there: C, or NumPy."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, NoReturn

import numpy as np
import numpy.typing as npt

from dsnn import forms
from dsnn.frames import Channels, checked_shape, luma
from dsnn.model import Response, ResponseSeries, run_model
from dsnn.native.onboard import NativeOnboard
from dsnn.onboard.fixed import constants
from dsnn.onboard.numpy_form import NumpyOnboard
from dsnn.onboard.params import OnboardParams


class OnboardDSNN:
    """The directionally selective neural network in whole numbers of 8 and 16 bits.

    Both forms give the same bits: ``dsnn/onboard/numpy_form.py`` is the specification, and ``dsnn/native/onboard.c``,
    which the robot runs, is tested against it. HS and VS are multiples of 2 to the power -15.

    A frame of floating type is rounded to whole grey levels, as the camera gives them. A frame has at most 256 spikes.

    Parameters
    ----------
    shape : tuple of int
        (R, C) of the frames, at most 4096 each.
    params : OnboardParams, optional
        Constants and formats; the paper's off-line constants in the default format if left out.
    form : {"native", "numpy"}, optional
        As of `dsnn.direction.network.DSNN`.

    Attributes
    ----------
    form : str
        The form that runs.

    Raises
    ------
    dsnn.frames.FrameError
        Of a shape or frame that it cannot take.
    dsnn.forms.FormError
        Of an unknown form, and of ``"native"`` where that is not built.
    """

    def __init__(self, shape: tuple[int, int], params: OnboardParams | None = None, *, form: str | None = None) -> None:
        self.shape = checked_shape(shape)
        self.params = params or OnboardParams()
        self.fixed = constants(self.shape, self.params)
        self.form = forms.chosen(form)
        stages = NativeOnboard if self.form == "native" else NumpyOnboard
        self._stages: NativeOnboard | NumpyOnboard = stages(self.fixed)

    def __reduce__(self) -> NoReturn:
        raise TypeError("an OnboardDSNN cannot be copied or pickled: make another of the same shape and params")

    def reset(self) -> None:
        """Return to the state before the first frame."""
        self._stages.reset()

    def step(self, frame: npt.NDArray[Any], *, channels: Channels = "grey", maps: bool = False) -> Response:
        """Answer the next frame; see `dsnn.frames.luma` for what a frame may be."""
        grey = luma(frame, self.shape, channels)
        return self._stages.step(grey if grey.dtype == np.uint8 else np.rint(grey).astype(np.uint8), maps)

    def run(self, frames: Iterable[npt.NDArray[Any]], *, channels: Channels = "grey") -> ResponseSeries:
        """Reset, then answer every frame of a (T, R, C) array or iterable."""
        return run_model(self, frames, channels=channels)
