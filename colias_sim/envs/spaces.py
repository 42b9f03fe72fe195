"""The spaces of an env."""

from __future__ import annotations

from typing import Any

from gymnasium import spaces

from colias_sim.envs.actions import action_space
from colias_sim.envs.observations import observation_space
from colias_sim.envs.options import EnvOptions


def spaces_of(options: EnvOptions) -> tuple[spaces.Space[Any], spaces.Space[Any]]:
    """Make the observation space and the action space of an env with these options."""
    camera = options.plain_settings().camera
    shape = camera.height, camera.width
    return observation_space(options.observation, shape, options.robots), action_space(options.actions)
