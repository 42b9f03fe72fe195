"""Declare the measures of an env's episodes; the program that plays the episodes computes them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

ColumnKind = Literal["mean", "mean_abs", "mean_abs_error", "optomotor_gain", "rms", "share"]
MeasureKind = Literal["mean", "collision_rate", "free_distance"]


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


@dataclass(frozen=True, slots=True)
class EpisodeMeasure:
    """A measure of an agent over episodes, with a 95 % interval.

    Parameters
    ----------
    name
        Name and unit, as a heading.
    kind
        ``mean``: the mean of ``column`` over the episodes. ``collision_rate``: episodes that ended with a collision,
        per ``per`` of the sum of ``column``. ``free_distance``: the sum of ``column`` per collision.
    column
        A column of the table of episodes.
    per
        For ``collision_rate``: units of ``column`` per unit of the rate, for example 60 for s and minutes.
    """

    name: str
    kind: MeasureKind
    column: str
    per: float = 1.0


COLLISIONS_PER_MINUTE = EpisodeMeasure("collisions/min", "collision_rate", "seconds", per=60.0)
COLLISIONS_PER_METRE = EpisodeMeasure("collisions/m", "collision_rate", "driven_m")
FREE_DISTANCE = EpisodeMeasure("free distance (m)", "free_distance", "driven_m")
TIME_ON_TARGET = EpisodeMeasure("time on target", "mean", "in_view")
RETURN = EpisodeMeasure("return", "mean", "reward")
"""The sum of an episode's rewards. Every env has it, as its last measure."""

IN_VIEW = EpisodeColumn("in_view", "share", "in_view")
OFF_AXIS = EpisodeColumn("off_axis_deg", "mean_abs", "bearing_deg")
"""Column of every env with a target."""


@dataclass(frozen=True, slots=True)
class EnvEntry:
    """A registered env: its class, baselines and measures, declared in the env's own file.

    Parameters
    ----------
    entry_point
        The env's class, as ``module:name``.
    max_episode_steps
        Number of steps after which an episode is truncated.
    summary
        The task, in a few words.
    baselines
        Names of the behaviours for comparison: a random walk, driving straight, and an oracle that receives the state
        of the world.
    measures
        The env's measures, without `RETURN`.
    columns
        The columns of its episodes in addition to the common ones.
    note
        A sentence or two printed under the table of measures; empty for none.
    draws_paths
        Whether a figure of its episodes shows the observer's paths from above.
    """

    entry_point: str
    max_episode_steps: int
    summary: str
    baselines: tuple[str, ...] = ()
    measures: tuple[EpisodeMeasure, ...] = ()
    columns: tuple[EpisodeColumn, ...] = ()
    note: str = ""
    draws_paths: bool = False

    @property
    def all_measures(self) -> tuple[EpisodeMeasure, ...]:
        """The env's measures and `RETURN`, in the order of a table's columns."""
        return (*self.measures, RETURN)
