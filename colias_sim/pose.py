"""A robot's pose, the speeds of its wheels, and the bearing of another robot."""

from __future__ import annotations

import math
from dataclasses import dataclass

WheelSpeeds = tuple[float, float]
"""Speeds of the left and the right wheel at their rims, in m/s, forward positive."""


@dataclass(frozen=True, slots=True)
class Pose:
    """A place and a heading on the floor.

    Parameters
    ----------
    x, y
        Position in metres: x ahead of the observer's start in a trial, y to its left.
    heading
        Direction in radians, counter-clockwise from x.
    """

    x: float
    y: float
    heading: float


def bearing(observer: Pose, target: Pose, forward: float) -> float:
    """Compute the angle of a target off the observer's optical axis.

    Parameters
    ----------
    observer, target
        Poses of the two robots.
    forward
        Distance of the lens ahead of the observer's centre, in metres.

    Returns
    -------
    float
        Angle in radians, right positive as in the image.

    Examples
    --------
    >>> from math import degrees
    >>> from colias_sim import Pose, bearing
    >>> round(degrees(bearing(Pose(0.0, 0.0, 0.0), Pose(0.1, -0.1, 0.0), forward=0.0)))
    45
    """
    x, y = observer.x + forward * math.cos(observer.heading), observer.y + forward * math.sin(observer.heading)
    return math.remainder(observer.heading - math.atan2(target.y - y, target.x - x), 2 * math.pi)
