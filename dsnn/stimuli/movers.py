"""People and cars that cross a frame: their positions in time, and the boxes that they are painted from.

Proportions refer to the body's height. A person consists of head, trunk, and two legs of two boxes each, which slide
back and forth like a walker's. A car is a body, a cabin and two wheels.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np

from dsnn.stimuli.stimulus import Box

Kind = Literal["person", "car"]

WIDTH = {"person": 0.33, "car": 2.9}
"""Width of the whole outline. A car is 4.2 m long and 1.45 m high."""
STRIDE = 0.85
"""Length of two steps of a walker."""
FOOT_SWING = STRIDE / (2 * math.pi)
"""Amplitude of a foot about the hip. A foot then rests on the ground for an instant in each stride."""
TRUNK_WIDTH, HEAD_WIDTH, LEG_WIDTH = 0.24, 0.13, 0.12
HEAD, HIP, KNEE = 0.13, 0.55, 0.77
"""Lower ends of head, trunk and thighs, down from the top."""
THIGH_SWING, SHANK_SWING = 0.25, 0.75
"""Swing of the middle of thigh and shank, as shares of the foot's swing: a leg turns about the hip."""
CAMERA_HEIGHT = 1.15
"""Height of the camera above the ground, in heights of a body: 2 m for a person of 1.75 m."""
WHEEL_GREY = 25.0


@dataclass(frozen=True, slots=True)
class Mover:
    """One person or car that crosses a frame at a constant velocity.

    Parameters
    ----------
    kind
        ``person`` or ``car``.
    height
        Height of the whole outline, px.
    velocity
        px/s, rightward positive.
    enters_s
        Time at which its front is at the frame's border.
    ground
        Row on which it stands, px.
    columns
        Width of the frame, px.
    greys
        Grey levels of a person's trunk, legs and head, or of a car's body, wheels and cabin.
    """

    kind: Kind
    height: float
    velocity: float
    enters_s: float
    ground: float
    columns: int
    greys: tuple[float, float, float]

    @property
    def width(self) -> float:
        """Width of the whole outline, px."""
        return WIDTH[self.kind] * self.height

    @property
    def leaves_s(self) -> float:
        """Time at which its back is at the other border, s."""
        return self.enters_s + (self.columns + self.width) / abs(self.velocity)

    def gone(self, seconds: float) -> float:
        """Compute the distance covered at a time, px; negative before it enters."""
        return abs(self.velocity) * (seconds - self.enters_s)

    def box(self, seconds: float) -> Box:
        """Return the whole outline at a time, including the range of the swinging legs."""
        return self._part(seconds, 0.0, WIDTH[self.kind], 0.0, 1.0)

    def parts(self, seconds: float) -> Iterator[tuple[Box, float]]:
        """Yield the boxes and greys to paint at a time, in this order."""
        first, second, third = self.greys
        if self.kind == "car":
            yield self._part(seconds, -0.06, 1.68, 0.0, 0.4), third
            yield self._part(seconds, 0.0, WIDTH["car"], 0.38, 0.88), first
            for axle in (-0.93, 0.93):
                yield self._part(seconds, axle, 0.44, 0.7, 1.0), second
            return
        swing = FOOT_SWING * math.sin(2 * math.pi * self.gone(seconds) / (STRIDE * self.height))
        for side in (1.0, -1.0):
            yield self._part(seconds, side * THIGH_SWING * swing, LEG_WIDTH, HIP, KNEE), second
            yield self._part(seconds, side * SHANK_SWING * swing, LEG_WIDTH, KNEE, 1.0), second
        yield self._part(seconds, 0.0, TRUNK_WIDTH, HEAD, HIP), first
        yield self._part(seconds, 0.0, HEAD_WIDTH, 0.0, HEAD), third

    def _part(self, seconds: float, ahead: float, width: float, top: float, bottom: float) -> Box:
        """Make a box whose middle is ``ahead`` of the body's; all in shares of the height, from the top."""
        h = self.height
        middle = self.gone(seconds) - self.width / 2 + ahead * h
        x = middle if self.velocity > 0 else self.columns - middle
        return Box.about(x, self.ground - h + (top + bottom) / 2 * h, width * h, (bottom - top) * h)


def group(nearest: Mover, count: int, rng: np.random.Generator) -> tuple[Mover, ...]:
    """Make several movers in one direction, one after another, with different distances, paces and greys.

    Parameters
    ----------
    nearest
        The nearest possible mover: the others are as high or up to 35 % less.
    count
        How many.
    rng
        Draws them.

    Returns
    -------
    tuple of Mover
        The movers from the farthest to the nearest, which is the order of painting. A farther mover is smaller,
        proportionally slower, and higher up in the frame. Paces differ by up to 10 %. Each enters once the one before
        has moved 0.8 to 1.8 times its own width.
    """
    movers, enters_s = [], nearest.enters_s
    for _ in range(count):
        scale, pace, behind = rng.uniform(0.65, 1.0), rng.uniform(0.9, 1.1), rng.uniform(0.8, 1.8)
        greys = rng.uniform(20.0, 235.0, 3)
        lower = WHEEL_GREY if nearest.kind == "car" else float(greys[1])
        one = Mover(
            nearest.kind,
            nearest.height * scale,
            nearest.velocity * scale * pace,
            enters_s,
            nearest.ground - CAMERA_HEIGHT * nearest.height * (1.0 - scale),
            nearest.columns,
            (float(greys[0]), lower, float(greys[2])),
        )
        movers.append(one)
        enters_s += behind * one.width / abs(one.velocity)
    return tuple(sorted(movers, key=lambda one: one.height))
