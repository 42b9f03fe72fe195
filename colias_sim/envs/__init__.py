"""Gymnasium envs on the simulated bench: ``import colias_sim``, then ``gymnasium.make("colias_sim/Fixation-v0")``."""

from colias_sim.envs.registry import ENVS, EnvEntry, register_envs
from colias_sim.envs.senses import NEURAL, Other, State

__all__ = ["ENVS", "NEURAL", "EnvEntry", "Other", "State", "register_envs"]
