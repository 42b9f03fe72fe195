"""The DSNN, in the form that is there: in C (`dsnn.native`), or its reference (`dsnn.direction.reference`)."""

from __future__ import annotations

from typing import Any

import numpy.typing as npt

from dsnn import forms
from dsnn.direction.reference import ReferenceNetwork
from dsnn.model import Model, Response
from dsnn.native import NativeNetwork
from dsnn.params import DSNNParams


class DSNN(Model[DSNNParams]):
    """The directionally selective neural network, fast enough to close the loop.

    Assumed where the paper leaves it open: LA is 0 where the two Gaussians differ in sign (``polarity``); F keeps no
    negative part (``rectified``); the gain of a low-pass is dt / (dt + tau) (``lowpass``); Gaussians are cut at 4
    sigma; beyond the border the last row and column go on; pairs of cells that leave the image are dropped. Of the
    model of 2017 no constant could be read: it is taken for this one with ``fdsr`` false.

    Not safe to share between threads: make one per thread.

    Parameters
    ----------
    shape
        (R, C) of the frames, 2 or more each.
    params
        The constants of the network; the paper's off-line ones, ``DSNNParams()``, if left out.
    form
        ``native`` or ``reference``: in C, or as `ReferenceDSNN`, which agree within 1e-5 in HS and VS. By default the
        native one where it is built, unless the environment variable ``DSNN_FORM`` says another.

    Attributes
    ----------
    form : str
        The form that runs.

    Raises
    ------
    dsnn.FrameError
        The shape is not two whole numbers from 2 up.
    dsnn.forms.FormError
        The form is unknown, or is ``native`` where that is not built.

    References
    ----------
    Fu, Bellotto and Yue 2018, arXiv 1808.07692; without FDSR, Fu and Yue 2017, IJCNN, as that paper tells of it.

    Examples
    --------
    >>> import numpy as np
    >>> from dsnn import DSNN, DSNNParams
    >>> model = DSNN((72, 99), DSNNParams.robot())
    >>> model.step(np.zeros((72, 99), np.uint8)).hs
    0.0
    """

    def __init__(self, shape: tuple[int, int], params: DSNNParams | None = None, *, form: str | None = None) -> None:
        super().__init__(shape, params, DSNNParams)
        self.form = forms.chosen(form)
        network = NativeNetwork if self.form == "native" else ReferenceNetwork
        self._network: NativeNetwork | ReferenceNetwork = network(self.shape, self.params)

    def reset(self) -> None:
        """Return to the state before the first frame."""
        self._network.reset()

    def _respond(self, luminance: npt.NDArray[Any], maps: bool) -> Response:
        return self._network.step(luminance, maps=maps)

    def azimuth(self) -> float:
        """Return where in the view the motion of the last frame was.

        Returns
        -------
        float
            The mean column of the squared ON and OFF activity after FDSR, from -1 at the left edge to 1 at the right;
            0 where nothing moved.
        """
        return self._network.azimuth()


class ReferenceDSNN(DSNN):
    """The DSNN as its equations read, 17 times slower than `dsnn.DSNN`, which is tested against it.

    Assumed: what `dsnn.DSNN` assumes.

    Parameters
    ----------
    shape
        (R, C) of the frames, 2 or more each.
    params
        The constants; those of ``DSNNParams()`` if left out.

    Raises
    ------
    dsnn.FrameError
        The shape is not two whole numbers from 2 up.

    References
    ----------
    Fu, Bellotto and Yue 2018, arXiv 1808.07692.
    """

    def __init__(self, shape: tuple[int, int], params: DSNNParams | None = None) -> None:
        super().__init__(shape, params, form="reference")
