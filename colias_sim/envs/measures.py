"""Declare the measures of an env's episodes; the program that plays the episodes computes them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

ColumnKind = Literal["mean", "mean_abs", "mean_abs_error", "optomotor_gain", "rms", "share"]


@dataclass(frozen=True, slots=True)
class EpisodeColumn:
    """A column of the table of episodes, one number for each episode, computed from the ``info`` of its steps.

    Parameters
    ----------
    name
        Name of the column.
    kind
        ``mean``: the mean of ``info`` over the steps. ``mean_abs``: the mean of its absolute value. ``mean_abs_error``:
        the mean absolute difference from the env's argument ``target``. ``optomotor_gain``: ``1 - sum(slip sign(drift))
        / sum(|drift|)``, null if the drift is always 0. ``rms``: the root of the mean square of ``info``, in which
        opposite signs do not cancel. ``share``: the share of the steps in which ``info`` is true.
    info
        The key of ``info``; for ``optomotor_gain`` the key of the slip.
    target
        For ``mean_abs_error`` the env's argument with the target value, for ``optomotor_gain`` the key of ``info`` with
        the drift; otherwise empty.
    """

    name: str
    kind: ColumnKind
    info: str
    target: str = ""

    @property
    def ends(self) -> tuple[float, float]:
        """The least and the largest possible value of the kind, which bound its intervals."""
        if self.kind in ("mean", "optomotor_gain"):
            return -math.inf, math.inf
        return 0.0, 1.0 if self.kind == "share" else math.inf


IN_VIEW = EpisodeColumn("in_view", "share", "in_view")
OFF_AXIS = EpisodeColumn("off_axis_deg", "mean_abs", "bearing_deg")
"""Column of every env with a target."""

COLLISIONS = PER_MINUTE, PER_METRE, FREE_DISTANCE = "collisions/min", "collisions/m", "free distance (m)"
"""Measures of collisions: their rates, and the distance per collision."""
RETURN = "return"
"""The mean sum of an episode's rewards, in the column ``reward``. Every env has it, as its last measure."""
