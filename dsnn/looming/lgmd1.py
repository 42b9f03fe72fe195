"""LGMD1, the locust's looming detector in the form of Yue and Rind (2006)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any

import cv2
import numpy as np
import numpy.typing as npt
from pydantic import Field

from dsnn import forms
from dsnn.field_docs import parameters, unit
from dsnn.filters import Floats, Retina, total
from dsnn.looming.layers import Detector, Grouping, convolve, ring
from dsnn.native import NativeLGMD1


@parameters
class LGMD1Params:
    """Parameters of the LGMD1. The defaults are the literature's, and thresholds are in 8-bit grey levels."""

    w_i: float = Field(default=0.6, ge=0.0, le=10.0)
    """Weight of inhibition."""
    w_side: float = Field(default=0.25, ge=0.0, le=10.0)
    """Weight of the inhibition from each of a cell's four sides."""
    w_corner: float = Field(default=0.125, ge=0.0, le=10.0)
    """Weight of the inhibition from each of a cell's four corners."""
    c_w: float = Field(default=4.0, gt=0.0, le=1e3)
    """Divisor of the largest group in the scale of the grouping."""
    delta_c: float = Field(default=0.01, gt=0.0, le=1e3)
    """Scale of the grouping where nothing is excited."""
    t_g: float = Field(default=30.0, ge=0.0, le=1e6)
    """Threshold of the grouped excitation."""
    t_ffi: Annotated[float, unit("grey levels")] = Field(default=10.0, ge=0.0, le=255.0)
    """Mean change of the last frame that vetoes spikes."""
    t_sp: float = Field(default=0.78, gt=0.5, le=1.0)
    """Spike threshold on the potential k."""
    n_sp: Annotated[int, unit("frames")] = Field(default=5, ge=1, le=1000)
    """Number of consecutive frames with a spike that signal a collision."""

    @classmethod
    def presets(cls) -> Mapping[str, LGMD1Params]:
        """Make the presets.

        ``paper`` has the literature's constants. ``firmware`` has the thresholds of the public firmware of Colias for
        this detector's successor, which is the LGMD1 once self-inhibition is switched off. Its T_s of 0.72 is ``t_sp``,
        and its 4 consecutive spikes are ``n_sp``. Its mean change of 10 is a ``t_ffi`` of 20, because the firmware
        halves changes. ``arena`` has the firmware's T_s for the arena, 0.65. The firmware's other constants belong to
        other layers.

        Returns
        -------
        mapping of str to LGMD1Params
            Name -> parameters: ``paper``, ``firmware`` and ``arena``.
        """
        return {
            "paper": cls(),
            "firmware": cls(t_sp=0.72, t_ffi=20.0, n_sp=4),
            "arena": cls(t_sp=0.65, t_ffi=20.0, n_sp=4),
        }


class LGMD1(Detector[LGMD1Params]):
    """Excitation, delayed lateral inhibition, grouping, and a feed-forward veto.

    With P the change of luminance: ``S = max(|P(t)| - w_i |W * P(t-1)|, 0)``, where W is the ring of a cell's eight
    neighbours. S is grouped: with Ce its 3x3 mean, ``G = S Ce / (delta_c + max Ce / c_w)``, and 0 below ``t_g``. The
    potential is ``k = 1 / (1 + exp(-sum G / N))`` for N cells. Channel: ``looming``, k from 0.5 up to 1, with one spike
    in a frame whose k reaches ``t_sp``. ``collision`` is true if the last ``n_sp`` frames all had a spike. Feed-forward
    inhibition: there is no spike where the mean of ``|P(t-1)|`` reaches ``t_ffi``.

    Assumed where the source leaves it open: P has no residue of older changes. Cells outside the field are 0.
    Feed-forward inhibition stops the spike and leaves k unchanged. There is no time constant: the model works frame by
    frame. P, and so every threshold, depends on frame rate and image size.

    Costs about 0.2 of a DSNN step at 99x72.

    Parameters
    ----------
    shape
        (R, C) of the frames, 2 or more each.
    params
        The constants; by default ``LGMD1Params()``.
    form
        ``native`` (in C) or ``reference`` (in NumPy), as in `dsnn.DSNN`.

    Raises
    ------
    dsnn.FrameError
        The shape is not two whole numbers from 2 up.
    dsnn.forms.FormError
        The form is unknown, or is ``native`` where that is not built.

    References
    ----------
    Yue and Rind 2006, IEEE Transactions on Neural Networks 17.

    Examples
    --------
    >>> from dsnn import LGMD1
    >>> from dsnn.stimuli import stimulus
    >>> clip = stimulus("looming")
    >>> series = LGMD1(clip.shape).run(frame.luma for frame in clip)
    >>> series.accumulated_spikes("looming") > 0
    True
    """

    def __init__(self, shape: tuple[int, int], params: LGMD1Params | None = None, *, form: str | None = None) -> None:
        super().__init__(shape, params, LGMD1Params)
        q = self.params
        self.form = forms.chosen(form)
        self._layers: _NumpyLayers | NativeLGMD1
        if self.form == "native":
            names = ("w_i", "w_side", "w_corner", "t_g", "c_w", "delta_c", "t_ffi", "t_sp")
            self._layers = NativeLGMD1(self.shape, **{name: getattr(q, name) for name in names})
        else:
            self._layers = _NumpyLayers(self.shape, q)

    def _forget(self) -> None:
        self._layers.reset()

    def _detect(self, luminance: npt.NDArray[Any]) -> tuple[float, int]:
        return self._layers.step(luminance)


class _NumpyLayers:
    """The detector's layers in NumPy and OpenCV."""

    def __init__(self, shape: tuple[int, int], params: LGMD1Params) -> None:
        self._params = params
        self._retina = Retina(shape)
        self._kernel = ring(params.w_side, params.w_corner)
        self._grouping = Grouping(shape, params.c_w, params.delta_c, params.t_g)
        self._excitation, self._s, self._zeros = np.zeros((3, *shape), np.float32)
        self._inhibition: Floats = np.zeros(shape, np.float32)
        self.reset()

    def reset(self) -> None:
        self._retina.reset()
        self._inhibition[:] = 0.0  # of the last frame's P, as is the change
        self._change = 0.0

    def step(self, luma: npt.NDArray[Any]) -> tuple[float, int]:
        """Return the membrane potential after the next frame, and its spike, 0 or 1."""
        q = self._params
        p = self._retina.step(luma)
        excitation = np.abs(p, out=self._excitation)
        s = cv2.scaleAdd(self._inhibition, -q.w_i, excitation, self._s)
        np.maximum(s, self._zeros, out=self._s)
        k = self._grouping.potential(self._s)
        spike = k >= q.t_sp and self._change < q.t_ffi
        np.abs(convolve(p, self._kernel, self._inhibition), out=self._inhibition)
        self._change = total(excitation) / excitation.size
        return k, int(spike)
