"""Independent random streams of an env's episodes, by name.

``world`` is Gymnasium's own generator. It draws the starts of all robots, the driving of the other robots, light,
randomisation by strength and disturbances. One draw from the world, ``episode``, seeds the streams that must not change
the world. ``film`` is the generator of a camera's noise, so an episode does not depend on the observation; each robot
that sees has its own. ``factor`` is a generator for each factor that is randomised within a range, so no factor changes
another's draws. ``clearing`` draws new starts for robots that a reset's options displace. ``sensor`` is the generator
of an event camera. Trials pass their own generators to `Simulation.reset` and `Simulation.step`.
"""

from __future__ import annotations

import numpy as np
from gymnasium.utils import seeding

_FACTORS = 4
"""First word of the spawn keys of factors; a factor's name is the rest of its key."""
_CLEARING = 5
"""The spawn key of `clearing`."""
_FILMS = 6
"""First word of the spawn keys of the films of all robots but the first."""
_SENSOR = 80
"""The spawn key of `sensor`."""


def world(seed: int) -> np.random.Generator:
    """Make the generator of an env just after ``reset(seed=seed)``, before any draw."""
    return seeding.np_random(seed)[0]


def episode(drawn_from: np.random.Generator) -> int:
    """Draw the seed of an episode's own streams from the generator of its world."""
    return int(drawn_from.integers(2**63))


def film(episode: int, robot: int = 0) -> np.random.Generator:
    """Make a camera's generator for an episode, from the seed that `episode` drew, of the robot with this number.

    That of robot 0 is the single envs', and none depends on how many robots there are.
    """
    return np.random.default_rng(np.random.SeedSequence(episode, spawn_key=(_FILMS, robot)) if robot else episode)


def factor(episode: int, name: str) -> np.random.Generator:
    """Make the generator of one factor for an episode, from the seed that `episode` drew."""
    return np.random.default_rng(np.random.SeedSequence(episode, spawn_key=(_FACTORS, *name.encode())))


def clearing(episode: int) -> np.random.Generator:
    """Make the generator of new starts for an episode, from the seed that `episode` drew."""
    return np.random.default_rng(np.random.SeedSequence(episode, spawn_key=(_CLEARING,)))


def sensor(episode: int) -> np.random.Generator:
    """Make the generator of an event camera for an episode, from the seed that `episode` drew."""
    return np.random.default_rng(np.random.SeedSequence(episode, spawn_key=(_SENSOR,)))
