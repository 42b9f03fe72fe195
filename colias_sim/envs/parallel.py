"""PettingZoo's parallel env of a swarm, and its view as a vector env with a row for each agent."""

from __future__ import annotations

from typing import Any

import gymnasium as gym
import numpy as np
import numpy.typing as npt
from gymnasium import error, spaces
from gymnasium.vector.utils import batch_space, concatenate, create_empty_array, iterate
from pettingzoo import ParallelEnv

from colias_sim.envs.base import TOUCH_COST
from colias_sim.envs.geometry import given_poses, placed, random_poses
from colias_sim.envs.options import FPS
from colias_sim.envs.randomise import draw
from colias_sim.envs.render import Renderer
from colias_sim.envs.senses import action_space, observation_space, wheels_of
from colias_sim.envs.swarm import Swarm, SwarmOptions
from colias_sim.streams import clearing, episode, world

Array = npt.NDArray[Any]


class SwarmEnv(ParallelEnv):  # type: ignore[misc]  # where PettingZoo is not installed
    """Many robots that all see, as agents; make it by `colias_sim.swarm_env`, which says what the task is.

    Spaces, ``info`` and the option ``poses`` of a reset are those of the single envs (``help(colias_sim.envs)``).
    An agent whose robot touches anything is terminated. It is then absent from ``agents``, and from what the next step
    returns. With ``crash="leave"`` its robot is out of the arena for the rest, with ``crash="stop"`` it stands there.

    Parameters
    ----------
    options
        The checked arguments.
    """

    metadata: dict[str, Any] = {"render_modes": ["human", "rgb_array"], "name": "colias_swarm_v0"}  # noqa: RUF012

    def __init__(self, options: SwarmOptions) -> None:
        self.options, self.render_mode = options, options.render_mode
        self.metadata = {**self.metadata, "render_fps": FPS / options.frames_per_step}
        self.swarm = Swarm(options)
        self._agents = self.swarm.agents
        self.possible_agents: list[str] = list(options.names)
        self.agents: list[str] = []
        shapes = {name: (camera.height, camera.width) for name, camera in options.cameras().items()}
        self.observation_spaces = {
            name: observation_space(options.observation, shape, options.robots - 1) for name, shape in shapes.items()
        }
        self.action_spaces = {name: action_space(options.actions) for name in shapes}
        self._rng = world(0)
        self._steps = 0
        show = options.render_mode is not None
        self._renderer = Renderer(self.swarm.sim, options, options.names[0]) if show else None

    def observation_space(self, agent: str) -> spaces.Space[Any]:
        """Return an agent's observation space."""
        return self.observation_spaces[agent]

    def action_space(self, agent: str) -> spaces.Space[Any]:
        """Return an agent's action space."""
        return self.action_spaces[agent]

    def reset(
        self, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, Any], dict[str, dict[str, Any]]]:  # fmt: skip
        """Begin an episode with every robot at a random place.

        Parameters
        ----------
        seed
            Seed of this and the following episodes; ``None`` continues with the present generator.
        options
            ``poses``: {robot: (x_cm, y_cm, heading_deg)}.

        Returns
        -------
        observations, infos : dict
            By agent: the first frame, in which the robots stand.

        Raises
        ------
        ValueError
            A pose is refused.
        """
        obstacles = self.swarm.sim.obstacles
        poses = given_poses((options or {}).get("poses", {}), self.possible_agents, obstacles)
        if seed is not None:
            self._rng = world(seed)
        # In the order of the single envs' draws, so that the world of one robot is theirs.
        drawn = episode(self._rng)
        starts = random_poses(self._rng, len(self.possible_agents), obstacles=obstacles)
        placements = dict(zip(self.possible_agents, starts, strict=True))
        draw(0.0, {}, self._rng, drawn)
        if poses:
            placements = placed(placements, poses, clearing(drawn), obstacles)
        self.swarm.reset(placements, self._rng, drawn)
        self.agents, self._steps = [*self.possible_agents], 0
        self.swarm.advance(self.agents)
        if self._renderer:
            self._renderer.show()
        return self._seen(), {name: agent._info({}) for name, agent in self._agents.items()}

    def step(self, actions: dict[str, Any]) -> tuple[
        dict[str, Any], dict[str, float], dict[str, bool], dict[str, bool], dict[str, dict[str, Any]]
    ]:  # fmt: skip
        """Apply an action of each agent for ``frame_skip`` frames.

        Parameters
        ----------
        actions
            Agent -> action, for all ``agents``.

        Returns
        -------
        observations, rewards, terminated, truncated, infos : dict
            By agent, of those that were live before this step.

        Raises
        ------
        gymnasium.error.InvalidAction
            An agent has no action, or one that is none.
        gymnasium.error.ResetNeeded
            There was no reset yet, or the episode is over.
        """
        if not self.agents:
            raise error.ResetNeeded("step() before reset(), or after the end of an episode: call reset()")
        if lacking := [name for name in self.agents if name not in actions]:
            raise error.InvalidAction(f"actions must have one for each of {', '.join(self.agents)}, got none for"
                                      f" {lacking[0]}")  # fmt: skip
        live, skip, options = list(self.agents), self.options.frames_per_step, self.options
        for name, wheels in {name: wheels_of(self.action_spaces[name], actions[name]) for name in live}.items():
            self._agents[name].command(wheels)
        ahead = dict.fromkeys(live, 0.0)
        for index in range(skip):
            taken = options.processor.takes(index, options.processor.every - 1)
            look = options.observation in ("neural", "both") or index == skip - 1
            self.swarm.advance(live if look else (), taken=taken)
            for name in live:
                ahead[name] += self._agents[name].speed / (options.robot.max_speed_cm_s / 100) / skip
        touched = {name for name in live if self._agents[name]._touched}
        self._steps += 1
        over = self._steps >= options.steps
        terms = {name: {"ahead": ahead[name], "touch": -TOUCH_COST * (name in touched)} for name in live}
        infos = {name: self._agents[name]._info(terms[name]) for name in live}
        seen = self._seen()
        for name in touched:
            self._agents[name].command((0.0, 0.0))
            if options.crash == "leave":
                self.swarm.remove(name)
        self.agents = [] if over else [name for name in live if name not in touched]
        if self._renderer:
            self._renderer.show()
        terminated = {name: name in touched for name in live}
        truncated = {name: over and name not in touched for name in live}
        return seen, {name: sum(own.values()) for name, own in terms.items()}, terminated, truncated, infos

    def render(self) -> Any:
        """Draw the arena from above: (``render_height``, ``render_width``, 3) uint8 for ``rgb_array``, or ``None``."""
        return self._renderer.picture() if self._renderer else None

    def close(self) -> None:
        """Free every OpenGL context."""
        if self._renderer:
            self._renderer.close()
        self.swarm.sim.close()

    def _seen(self) -> dict[str, Any]:
        return {name: self._agents[name]._observation() for name in self.agents}

    def rows(self) -> SwarmRows:
        """View this env as a Gymnasium vector env with a row for each agent.

        Returns
        -------
        SwarmRows
            The view. Step and reset through it alone.
        """
        return SwarmRows(self)


class SwarmRows(gym.vector.VectorEnv[Any, Any, Array]):
    """A swarm as a Gymnasium vector env: row k is the agent k, all in one world, for one policy.

    When an agent crashes, its row is terminated. ``final_obs`` and ``final_info`` of ``info`` have its last
    observation and info, as with the autoreset ``SAME_STEP``. Until the world ends, the row is empty then: observations
    and rewards are 0, its actions are ignored, and ``info["absent"]`` is true for it. The world ends after ``steps``,
    or when nobody is left. All rows that are not terminated are truncated then, empty ones too, and the observations
    returned are those of the next episode.

    Parameters
    ----------
    env
        The env. Its agents have equal spaces.

    Raises
    ------
    ValueError
        The agents' cameras differ in their size.
    """

    def __init__(self, env: SwarmEnv) -> None:
        self.env, self.num_envs = env, len(env.possible_agents)
        self.metadata = {**env.metadata, "autoreset_mode": gym.vector.AutoresetMode.SAME_STEP}
        self.single_observation_space = env.observation_spaces[env.possible_agents[0]]
        if any(space != self.single_observation_space for space in env.observation_spaces.values()):
            raise ValueError("eyes must have equal sizes, as rows of one array have, got several")
        self.single_action_space = env.action_spaces[env.possible_agents[0]]
        self.observation_space = batch_space(self.single_observation_space, self.num_envs)
        self.action_space = batch_space(self.single_action_space, self.num_envs)
        self.render_mode = env.render_mode
        empty = create_empty_array(self.single_observation_space, self.num_envs)
        self._nothing = next(iter(iterate(self.observation_space, empty)))

    def reset(
        self, *, seed: int | list[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:  # fmt: skip
        """Begin an episode of all; ``seed`` is a number, as there is one world. See `SwarmEnv.reset`."""
        seen, infos = self.env.reset(seed if isinstance(seed, int) else None, options)
        return self._stacked(seen), self._joined(infos)

    def step(self, actions: Array) -> tuple[Any, Array, Array, Array, dict[str, Any]]:
        """Step every agent that is left.

        Parameters
        ----------
        actions
            A row for each agent.

        Returns
        -------
        observations, rewards, terminated, truncated, infos
            With a row for each agent.
        """
        names = self.env.possible_agents
        live = set(self.env.agents)
        given = {name: action for name, action in zip(names, actions, strict=True) if name in live}
        seen, rewards, terminated, truncated, infos = self.env.step(given)
        ended = not self.env.agents
        info = self._joined(infos)
        dead = np.array([terminated.get(name, False) for name in names])
        late = np.array([truncated.get(name, ended) for name in names]) & ~dead
        if (dead | late).any():
            info["final_obs"] = np.full(self.num_envs, None, object)
            for k in np.flatnonzero(dead | late):
                info["final_obs"][k] = seen.get(names[k], self._nothing)
            info["final_info"] = self._joined({name: infos[name] for name in infos if terminated[name] or ended})
        for name in [name for name in seen if terminated[name]]:
            del seen[name]
        if ended:
            seen, _ = self.env.reset()
        return self._stacked(seen), np.array([rewards.get(name, 0.0) for name in names]), dead, late, info

    def render(self) -> tuple[Any, ...] | None:
        """Draw the arena, once for each row, as Gymnasium wants it."""
        return (self.env.render(),) * self.num_envs

    def for_sb3(self) -> Any:
        """View the rows as stable-baselines3 wants them, which then takes them as they are.

        Returns
        -------
        stable_baselines3.common.vec_env.VecEnv
            The view.

        Raises
        ------
        ModuleNotFoundError
            stable-baselines3 is not installed, the extra ``[train]``.
        """
        from colias_sim.envs.sb3 import SB3Rows

        return SB3Rows(self)

    def close_extras(self, **kwargs: object) -> None:
        """Free every OpenGL context."""
        self.env.close()

    def _stacked(self, seen: dict[str, Any]) -> Any:
        rows = [seen.get(name, self._nothing) for name in self.env.possible_agents]
        empty: Any = create_empty_array(self.single_observation_space, self.num_envs)
        return concatenate(self.single_observation_space, rows, empty)

    def _joined(self, infos: dict[str, dict[str, Any]]) -> dict[str, Any]:
        """Join infos: entry -> its values by row, NaN where an agent has none, and ``absent``."""
        names = self.env.possible_agents
        keys = dict.fromkeys(key for info in infos.values() for key in info)
        joined: dict[str, Any] = {
            key: np.array([float(infos[name][key]) if name in infos else np.nan for name in names]) for key in keys
        }
        return {**joined, "absent": np.array([name not in infos for name in names])}
