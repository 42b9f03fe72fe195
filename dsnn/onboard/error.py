"""Measure the error of the robot's arithmetic: compare the float and on-board networks' responses to equal frames."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
import numpy.typing as npt

from dsnn.direction.network import DSNN
from dsnn.model import ResponseSeries
from dsnn.onboard.model import OnboardDSNN
from dsnn.onboard.params import OnboardParams
from dsnn.params import DSNNParams


def differences(exact: ResponseSeries, onboard: ResponseSeries) -> dict[str, float]:
    """Compare ``onboard`` with ``exact``, the responses to the same frames, as `compare` does."""
    size = np.abs(np.concatenate([exact.hs - onboard.hs, exact.vs - onboard.vs]))
    before, after = (np.concatenate([series.hs_spikes, series.vs_spikes]) for series in (exact, onboard))
    turned = before * after < 0
    gained = np.where(turned, np.abs(after), np.maximum(np.abs(after) - np.abs(before), 0))
    lost = np.where(turned, np.abs(before), np.maximum(np.abs(before) - np.abs(after), 0))
    median, high = np.quantile(size, (0.5, 0.99))
    peak = max(np.abs(exact.hs).max(), np.abs(exact.vs).max())
    return {
        "frames": len(exact.hs), "median": float(median), "high": float(high), "worst": float(size.max()),
        "peak": float(peak), "spikes": int(np.abs(before).sum()), "gained": int(gained.sum()), "lost": int(lost.sum()),
    }  # fmt: skip


def float_params(params: OnboardParams) -> DSNNParams:
    """Return the DSNN's parameters in ``params``, without the formats."""
    return DSNNParams(**{name: getattr(params, name) for name in DSNNParams.__dataclass_fields__})


def compare(frames: Iterable[npt.NDArray[Any]], params: OnboardParams) -> dict[str, float]:
    """Run the float and the on-board network on the same frames, and compare their responses.

    Parameters
    ----------
    frames
        (T, R, C), or an iterable of one or more frames (R, C), grey levels from 0 to 255.
    params
        Parameters of the on-board network. The float network has the same, without the formats.

    Returns
    -------
    dict of str to float
        ``frames``: number of frames compared. ``median``, ``high``, ``worst``: median, 99th percentile and maximum of
        the absolute difference of potentials, over frames and both systems, HS and VS. ``peak``: the largest absolute
        potential of the float network, for comparison. ``spikes``: number of spikes of the float network. ``gained``,
        ``lost``: spikes of only the on-board or only the float network, the positive and the negative differences of
        counts, summed over frames and systems. If the signs are opposite, all spikes of both count.

    Raises
    ------
    dsnn.FrameError
        A frame has another shape or type, or values outside 0 to 255.

    Examples
    --------
    >>> from dsnn import OnboardParams
    >>> from dsnn.onboard.error import compare
    >>> from dsnn.stimuli import stimulus
    >>> clip = stimulus("plain", rows=72, columns=99)
    >>> compare([frame.luma for frame in clip], OnboardParams())["worst"] < 0.1
    True
    """
    stack = list(frames)
    shape = stack[0].shape[:2]
    return differences(DSNN(shape, float_params(params)).run(stack), OnboardDSNN(shape, params).run(stack))
