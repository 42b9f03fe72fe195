"""Gymnasium envs on the simulated testbed: ``import colias_sim``, then ``gymnasium.make("colias_sim/Fixation-v0")``."""

from colias_sim.envs.measures import RETURN, EnvEntry, EpisodeColumn, Measure
from colias_sim.envs.observations import NEURAL
from colias_sim.envs.registry import ENVS, register_envs
from colias_sim.envs.state import Other, State

__all__ = ["ENVS", "NEURAL", "RETURN", "EnvEntry", "EpisodeColumn", "Measure", "Other", "State", "register_envs"]
