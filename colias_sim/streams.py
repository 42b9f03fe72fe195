"""The random streams of an env's episodes, by name.

``world`` is Gymnasium's own generator. It decides the starts of all robots, the driving of the other robots, light,
randomisation and disturbances. ``film`` is the generator of the camera's noise, seeded by one draw from the world,
so an episode is the same whatever is observed of it. Trials of the testbed pass generators of their own to
`Simulation.reset` and `Simulation.step`.
"""

from __future__ import annotations

import numpy as np
from gymnasium.utils import seeding


def world(seed: int) -> np.random.Generator:
    """Make the generator that an env has after ``reset(seed=seed)``, before anything is drawn from it."""
    return seeding.np_random(seed)[0]


def film(drawn_from: np.random.Generator) -> np.random.Generator:
    """Make the camera's generator for an episode, by one draw from the generator of its world."""
    return np.random.default_rng(int(drawn_from.integers(2**63)))
