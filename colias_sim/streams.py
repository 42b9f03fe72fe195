"""The random streams of an env's episodes, by name.

``world`` is Gymnasium's own generator: where everybody starts, how others drive, light, randomisation, disturbances.
``film`` is the camera's noise. It is seeded by a draw from the world, so that what happens in an episode is the same
whatever is observed of it. Trials bring generators of their own to `Simulation.reset` and `Simulation.step`.
"""

from __future__ import annotations

import numpy as np
from gymnasium.utils import seeding


def world(seed: int) -> np.random.Generator:
    """The generator that an env has after ``reset(seed=seed)``, before anything is drawn from it."""
    return seeding.np_random(seed)[0]


def film(drawn_from: np.random.Generator) -> np.random.Generator:
    """The camera's generator for an episode of the world ``drawn_from``: takes one draw from it."""
    return np.random.default_rng(int(drawn_from.integers(2**63)))
