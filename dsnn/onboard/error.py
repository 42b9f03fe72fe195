"""Changes by the robot's arithmetic: answers of two networks to the same frames, compared."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from dsnn.direction.network import DSNN
from dsnn.model import ResponseSeries
from dsnn.onboard.model import OnboardDSNN
from dsnn.onboard.params import OnboardParams
from dsnn.params import DSNNParams


@dataclass(frozen=True, slots=True)
class ErrorReport:
    """Distance of potentials and spikes from those of the float network, HS and VS taken together.

    Parameters
    ----------
    frames
        How many were compared.
    median, high, worst
        Of the difference of potentials in size, over frames and both systems: median, 99th percentile, largest.
    peak
        The largest potential of the float network in size, for comparison.
    spikes
        Of the float network.
    gained, lost
        Spikes that only one of them has: over frames and systems, the sum of the differences of counts where it is
        positive, and where it is negative. Of opposite signs all spikes of both count.
    """

    frames: int
    median: float
    high: float
    worst: float
    peak: float
    spikes: int
    gained: int
    lost: int


def differences(exact: ResponseSeries, answered: ResponseSeries) -> ErrorReport:
    """Compare ``answered`` with ``exact``, both of the same frames."""
    size = np.abs(np.concatenate([exact.hs - answered.hs, exact.vs - answered.vs]))
    before, after = (np.concatenate([series.hs_spikes, series.vs_spikes]) for series in (exact, answered))
    turned = before * after < 0
    gained = np.where(turned, np.abs(after), np.maximum(np.abs(after) - np.abs(before), 0))
    lost = np.where(turned, np.abs(before), np.maximum(np.abs(before) - np.abs(after), 0))
    median, high = np.quantile(size, (0.5, 0.99))
    peak = max(np.abs(exact.hs).max(), np.abs(exact.vs).max())
    return ErrorReport(
        len(exact.hs), float(median), float(high), float(size.max()), float(peak), int(np.abs(before).sum()),
        int(gained.sum()), int(lost.sum()),
    )  # fmt: skip


def float_params(params: OnboardParams) -> DSNNParams:
    """Return the DSNN's parameters among ``params``, without the formats."""
    return DSNNParams(**{name: getattr(params, name) for name in DSNNParams.__dataclass_fields__})


def compare(frames: Iterable[npt.NDArray[Any]], params: OnboardParams) -> ErrorReport:
    """Show frames to the float network and to the on-board one, and compare their answers.

    Parameters
    ----------
    frames
        (T, R, C), or an iterable of one or more frames (R, C), grey levels from 0 to 255.
    params
        Of the on-board network; the float one has the same but for the formats.

    Returns
    -------
    ErrorReport
        How far the potentials and spikes of the on-board network are from those of the float one.

    Raises
    ------
    dsnn.FrameError
        The models cannot take a frame.

    Examples
    --------
    >>> from dsnn import OnboardParams
    >>> from dsnn.onboard.error import compare
    >>> from dsnn.stimuli import stimulus
    >>> clip = stimulus("plain", rows=72, columns=99)
    >>> compare([frame.luma for frame in clip], OnboardParams()).worst < 0.1
    True
    """
    stack = list(frames)
    shape = stack[0].shape[:2]
    return differences(DSNN(shape, float_params(params)).run(stack), OnboardDSNN(shape, params).run(stack))
