"""The on-board DSNN as a vision model, for the Colias's processor, computed in C or NumPy."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from dsnn import forms
from dsnn.model import Model, Response
from dsnn.native.onboard import NativeOnboard
from dsnn.onboard.fixed import constants
from dsnn.onboard.numpy_form import NumpyOnboard
from dsnn.onboard.params import OnboardParams


class OnboardDSNN(Model[OnboardParams]):
    """The DSNN in whole numbers of 8 and 16 bits, as the Colias's processor could run it.

    Both forms give the same bits: ``dsnn/onboard/numpy_form.py`` is the specification, and ``dsnn/native/onboard.c``,
    which the robot runs, is tested against it. HS and VS are multiples of 2 to the power -15.

    Assumed: Every format and its rounding are our choice. The rest is as in `dsnn.DSNN`.

    Floating-point frames are rounded to whole grey levels, as the camera gives them. There are at most 256 spikes in a
    frame.

    Parameters
    ----------
    shape
        (R, C) of the frames, 2 to 4096 each.
    params
        Constants and formats; by default the paper's off-line constants in the default format.
    form
        ``native`` (in C) or ``reference`` (in NumPy), as in `dsnn.DSNN`.

    Attributes
    ----------
    form : str
        The form that runs.

    Raises
    ------
    dsnn.FrameError
        The shape is not two whole numbers from 2 to 4096.
    dsnn.forms.FormError
        The form is unknown, or is ``native`` where that is not built.

    References
    ----------
    Fu, Bellotto and Yue 2018, arXiv 1808.07692; the formats are our choice.

    Examples
    --------
    >>> from dsnn import OnboardDSNN
    >>> from dsnn.stimuli import stimulus
    >>> clip = stimulus("plain", motion="leftward", rows=72, columns=99, width=20, height=40)
    >>> series = OnboardDSNN(clip.shape).run(frame.luma for frame in clip)
    >>> bool(series.hs.min() < -0.1)
    True
    """

    def __init__(self, shape: tuple[int, int], params: OnboardParams | None = None, *, form: str | None = None) -> None:
        super().__init__(shape, params, OnboardParams)
        self.fixed = constants(self.shape, self.params)
        self.form = forms.chosen(form)
        stages = NativeOnboard if self.form == "native" else NumpyOnboard
        self._stages: NativeOnboard | NumpyOnboard = stages(self.fixed)

    def reset(self) -> None:
        """Return to the state before the first frame."""
        self._stages.reset()

    def _respond(self, luminance: npt.NDArray[Any], maps: bool) -> Response:
        whole = luminance if luminance.dtype == np.uint8 else np.rint(luminance).astype(np.uint8)
        return self._stages.step(whole, maps)
