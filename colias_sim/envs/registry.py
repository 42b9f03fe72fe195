"""The envs by name. To add one, write a file with its class and its `EnvEntry`, and add a line to `ENVS`."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

import gymnasium as gym

from colias_sim.envs.avoidance import ENTRY as AVOIDANCE
from colias_sim.envs.fixation import ENTRY as FIXATION
from colias_sim.envs.measures import EnvEntry
from colias_sim.envs.optomotor import ENTRY as OPTOMOTOR
from colias_sim.envs.pursuit import ENTRY as PURSUIT

ENVS: Mapping[str, EnvEntry] = MappingProxyType(
    {
        "colias_sim/Avoidance-v0": AVOIDANCE,
        "colias_sim/Fixation-v0": FIXATION,
        "colias_sim/Optomotor-v0": OPTOMOTOR,
        "colias_sim/Pursuit-v0": PURSUIT,
    }
)
"""The registered envs: Gymnasium's id -> the `EnvEntry` in the env's own file."""


def register_envs() -> None:
    """Make `ENVS` known to ``gymnasium.make`` and ``gymnasium.make_vec``. A second call does nothing."""
    for name, entry in ENVS.items():
        if name not in gym.registry:
            gym.register(
                name,
                entry_point=entry.entry_point,
                max_episode_steps=entry.max_episode_steps,
                # Gymnasium's checker looks at the first reset alone. Where that one raises, say for a wrong option,
                # every later step fails in the checker. The tests run `check_env` on each env instead.
                disable_env_checker=True,
            )
