"""The envs by name. A new one is a file with its class and a line in `ENVS`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

import gymnasium as gym


@dataclass(frozen=True, slots=True)
class EnvEntry:
    """A registered env: its class as ``module:name``, and after how many steps an episode is truncated."""

    entry_point: str
    max_episode_steps: int
    summary: str

    @property
    def vector_entry_point(self) -> str:
        """What makes many of them at once."""
        return f"colias_sim.envs.vector:{self.entry_point.rpartition(':')[2].lower()}"


ENVS: Mapping[str, EnvEntry] = MappingProxyType(
    {
        "colias_sim/Avoidance-v0": EnvEntry(
            "colias_sim.envs.avoidance:Avoidance", 1800, "wander about without touching anything"
        ),
        "colias_sim/Fixation-v0": EnvEntry(
            "colias_sim.envs.fixation:Fixation", 600, "keep a moving robot in the middle of the view"
        ),
        "colias_sim/Optomotor-v0": EnvEntry(
            "colias_sim.envs.optomotor:Optomotor", 450, "hold the heading against a turning drum or a push"
        ),
        "colias_sim/Pursuit-v0": EnvEntry(
            "colias_sim.envs.pursuit:Pursuit", 900, "follow another robot at a set distance"
        ),
    }
)


def register_envs() -> None:
    """Make `ENVS` known to ``gymnasium.make``; once is enough, again does nothing."""
    for name, entry in ENVS.items():
        if name not in gym.registry:
            gym.register(
                name,
                entry_point=entry.entry_point,
                vector_entry_point=entry.vector_entry_point,
                max_episode_steps=entry.max_episode_steps,
            )
