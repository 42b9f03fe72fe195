"""The DSNN as a vision model, computed in C (`dsnn.native`) or by its reference (`dsnn.direction.reference`)."""

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

    Assumed where the paper leaves it open: LA is 0 where the two Gaussians differ in sign (``polarity``). F has no
    negative part (``rectified``). The gain of a low-pass is dt / (dt + tau) (``lowpass``). Gaussians are cut at 4
    sigma. The border is replicated. Pairs of cells that leave the image are dropped. The constants of the 2017 model
    were not available, so it is taken to be this model with ``fdsr`` false.

    A model is not safe to share between threads. Make one per thread.

    Parameters
    ----------
    shape
        (R, C) of the frames, 2 or more each.
    params
        The constants of the network; by default the paper's off-line setting, ``DSNNParams()``.
    form
        ``native`` (in C) or ``reference`` (as `ReferenceDSNN`), which agree within 1e-5 in HS and VS. The default is
        the environment variable ``DSNN_FORM``, or else the native form where it is built.

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
    Fu, Bellotto and Yue 2018, arXiv 1808.07692; without FDSR, Fu and Yue 2017, IJCNN, as described there.

    Examples
    --------
    >>> import numpy as np
    >>> from dsnn import DSNN, DSNNParams
    >>> model = DSNN((72, 99), DSNNParams.robot())
    >>> model.step(np.zeros((72, 99), np.uint8)).hs
    0.0
    """

    READOUT = ("on", "off", "k_sig", "k_sp", "t_sp")
    """Parameters that act on the network's sums alone: models that differ only in them need one network (`read`)."""
    AFTER_F = ("n_con", "tau_s", "tau_mp", *READOUT)
    """Parameters that act after FDSR: models that differ only in them need one retina and lamina (`follow`)."""

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

    def follow(self, front: DSNN) -> None:
        """Take F, the signal after FDSR, from another model, in the native form and if that has no fewer connections.

        Parameters
        ----------
        front
            A model that sees each frame before this one, and differs in parameters of `AFTER_F` alone.
        """
        if isinstance(self._network, NativeNetwork) and isinstance(front._network, NativeNetwork):
            self._network.follow(front._network)

    def read(self, params: DSNNParams) -> Response:
        """Respond to the last frame again, as a model with another readout would.

        Parameters
        ----------
        params
            Parameters that differ from this model's in those of `READOUT` alone.

        Returns
        -------
        Response
            The response, without maps.
        """
        return self._network.read(params)

    def azimuth(self) -> float:
        """Locate the motion of the last frame in the view.

        Returns
        -------
        float
            The mean column of the squared ON and OFF activity after FDSR, from -1 (left edge) to 1 (right edge). It is
            0 if nothing moved.
        """
        return self._network.azimuth()


class ReferenceDSNN(DSNN):
    """The DSNN written as its equations, to test `dsnn.DSNN` against. It is 17 times slower.

    Assumed: The same as in `dsnn.DSNN`.

    Parameters
    ----------
    shape
        (R, C) of the frames, 2 or more each.
    params
        The constants; by default ``DSNNParams()``.

    Raises
    ------
    dsnn.FrameError
        The shape is not two whole numbers from 2 up.

    References
    ----------
    Fu, Bellotto and Yue 2018, arXiv 1808.07692.

    Examples
    --------
    >>> from dsnn import ReferenceDSNN
    >>> from dsnn.stimuli import stimulus
    >>> clip = stimulus("plain", motion="leftward", rows=72, columns=99, width=20, height=40)
    >>> series = ReferenceDSNN(clip.shape).run(frame.luma for frame in clip)
    >>> bool(series.hs.min() < -0.1)
    True
    """

    def __init__(self, shape: tuple[int, int], params: DSNNParams | None = None) -> None:
        super().__init__(shape, params, form="reference")
