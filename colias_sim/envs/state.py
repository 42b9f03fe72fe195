"""The state of the world as an observation for privileged baselines, which a real robot cannot know."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from colias_sim.config import RobotConfig
from scenes import ARENA_RADIUS_CM

Vector = npt.NDArray[np.float32]

SPEED, TURN, LENGTH = 0.35, 5.0, 2 * ARENA_RADIUS_CM / 100
"""The scales of speeds (m/s), turn rates (rad/s) and distances (m): a state's entry is the quantity over its scale."""
OWN_ENTRIES, OTHER_ENTRIES = 7, 5
"""Number of entries of the state vector for the observer, and for each other robot."""


@dataclass(frozen=True, slots=True)
class Other:
    """Another robot in the observer's frame of reference.

    Parameters
    ----------
    distance
        Gap between the two hulls, in metres.
    bearing
        Direction of the other robot off the observer's heading, in radians, right positive.
    ahead, left
        Velocity of the other robot relative to the observer's, along the observer's heading and to its left, in m/s.
    """

    distance: float
    bearing: float
    ahead: float
    left: float


@dataclass(frozen=True, slots=True)
class State:
    """The state of the world in the observer's frame of reference: the privileged observation.

    Parameters
    ----------
    speed
        Speed of the observer along its heading, in m/s.
    turn_rate
        Turn rate of the observer's body, in rad/s, left positive.
    slip
        Turn rate of the observer relative to the wall, in rad/s, left positive.
    drift
        Rate at which the disturbance (drum or push) alone would turn the view, in rad/s, left positive.
    wall_distance
        Distance from the observer's hull to the nearest point of the wall or of an obstacle, in metres.
    wall_bearing
        Direction of that point off the heading, in radians, right positive.
    others
        The other robots: the target first, then the rest by distance.
    full_turn
        Turn rate of the observer with its wheels at full speed against each other, in rad/s. It is no part of `vector`.

    Examples
    --------
    >>> from colias_sim.envs import State
    >>> state = State(speed=0.1, turn_rate=0.0, slip=0.0, drift=0.0, wall_distance=0.4, wall_bearing=0.5, others=())
    >>> round(State.read(state.vector()).wall_bearing, 3)
    0.5
    """

    speed: float
    turn_rate: float
    slip: float
    drift: float
    wall_distance: float
    wall_bearing: float
    others: tuple[Other, ...]
    full_turn: float = RobotConfig().full_turn

    def vector(self) -> Vector:
        """Encode the state as the observation ``state``.

        Returns
        -------
        ndarray
            (7 + 5 N,) float32 for N other robots. Each quantity is divided by its scale and clipped to [-1, 1].
            Directions are encoded as sine and cosine, left positive like the turn rates, so the sine has the opposite
            sign of a bearing's.
        """
        observer = (
            self.speed / SPEED, self.turn_rate / TURN, self.slip / TURN, self.drift / TURN,
            self.wall_distance / LENGTH, -math.sin(self.wall_bearing), math.cos(self.wall_bearing),
        )  # fmt: skip
        others = (
            (o.distance / LENGTH, -math.sin(o.bearing), math.cos(o.bearing), o.ahead / SPEED, o.left / SPEED)
            for o in self.others
        )
        values = [*observer, *(value for other in others for value in other)]
        return np.minimum(np.maximum(np.array(values, np.float32), -1.0), 1.0)

    @classmethod
    def read(cls, vector: Sequence[float] | Vector, full_turn: float = RobotConfig().full_turn) -> State:
        """Decode the observation ``state``, the inverse of `vector`.

        Parameters
        ----------
        vector
            (7 + 5 N,) numbers in [-1, 1].
        full_turn
            That of the env's robot, as ``env.unwrapped.state`` has it.

        Returns
        -------
        State
            The state in SI units. Quantities that `vector` clipped stay clipped.

        Raises
        ------
        ValueError
            The number of entries is not 7 + 5 N.
        """
        speed, turn, slip, drift, wall, sine, cosine, *rest = (float(value) for value in vector)
        others = tuple(
            Other(d * LENGTH, -math.atan2(s, c), ahead * SPEED, left * SPEED)
            for d, s, c, ahead, left in zip(*(rest[i::OTHER_ENTRIES] for i in range(OTHER_ENTRIES)), strict=True)
        )
        return cls(
            speed * SPEED,
            turn * TURN,
            slip * TURN,
            drift * TURN,
            wall * LENGTH,
            -math.atan2(sine, cosine),
            others,
            full_turn,
        )
