"""The base class of the envs: Gymnasium's contract, around the observer's wheels and camera."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, ClassVar, Generic, cast

import gymnasium as gym
import numpy as np
import numpy.typing as npt
from gymnasium import error

from colias_sim.config import SceneConfig
from colias_sim.envs.actions import action_space, wheels_of
from colias_sim.envs.factors import ends_of, ranges_of
from colias_sim.envs.geometry import gap_to_arena, moved
from colias_sim.envs.models import Model, ModelResponse
from colias_sim.envs.observations import observation_space
from colias_sim.envs.options import EnvOptions, Options
from colias_sim.envs.randomisation import Randomisation
from colias_sim.envs.reset_options import checked_reset_options, checked_seed, placed
from colias_sim.envs.scripted import Driver
from colias_sim.envs.task import TOUCH_COST, Task
from colias_sim.envs.vision import Vision
from colias_sim.envs.world import OBSERVER
from colias_sim.gl import has_screen
from colias_sim.pose import Pose, WheelSpeeds
from colias_sim.streams import clearing, episode, film, world

if TYPE_CHECKING:
    from colias_sim.obstacles import Obstacle

MOST_STARTS = 500
"""Draws of an episode's start among obstacles."""


class ColiasEnv(Task, gym.Env[Any, Any], Generic[Options]):
    """Base class of the envs.

    A subclass declares its keyword arguments as a dataclass (``options_type``, see `keyword_arguments` for its
    constructor), the other robots (`_others`), the start of an episode (`_begin`) and the reward (`_reward`).

    Parameters
    ----------
    options
        The checked keyword arguments of the subclass.

    Raises
    ------
    ValueError
        If the vision model cannot be built from ``options.model``, and for an arena that is refused.
    colias_sim.GLUnavailable
        Where nothing can render, and for ``render_mode="human"`` where there is no screen.
    """

    metadata: dict[str, Any] = {"render_modes": ["human", "rgb_array"], "render_fps": 30}  # noqa: RUF012
    options_type: ClassVar[type[EnvOptions]] = EnvOptions
    options: Options

    def __init__(self, options: Options) -> None:
        # Not before: MuJoCo takes its time to load, and whoever lists the envs does without.
        from colias_sim.envs.apparatus import Apparatus
        from colias_sim.envs.render import Renderer
        from colias_sim.simulation import Simulation

        self.options = options
        self.render_mode = options.render_mode
        # The class has every mode, as gym.make asks it; the checkers ask the env.
        modes = [mode for mode in ColiasEnv.metadata["render_modes"] if mode != "human" or has_screen()]
        self.metadata = {"render_modes": modes, "render_fps": 30.0 / options.frame_skip}
        plain = options.plain_settings()
        robot, camera = plain.robot, plain.camera
        self._fastest = robot.max_speed_cm_s / 100
        shape = camera.height, camera.width
        self.observation_space = observation_space(options.observation, shape, options.robots)
        self.action_space = action_space(options.actions)
        self._vision = Vision(options, shape)
        others = self._others()
        # A camera is made for the upper ends of what is drawn: those need the most room.
        _, most = ends_of(plain, ranges_of(cast(Any, options.randomise)))
        sim = Simulation(
            robot, most.camera, SceneConfig(arena=options.arena), {OBSERVER: "colias", **others},
            fence=True, seeing=options.observation != "state",
        )  # fmt: skip
        try:
            self._renderer = Renderer(sim, options) if options.render_mode else None
        except BaseException:
            sim.close()
            raise
        super().__init__(sim)
        shells = [name for name, variant in others.items() if variant != "colias"]
        self._plain, self._made_with = plain, most.camera
        self._randomisation = Randomisation(plain, cast(Any, options.randomise))
        self._apparatus = Apparatus(sim, OBSERVER, shells, plain, self._retexture)
        self._begun = self._running = self._closed = False
        self._forget()
        try:
            self._drawn(world(0))  # an arena without room for the robots is refused here
        except ValueError:
            self.close()
            raise

    # Gymnasium's contract.

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Begin a new episode, whether or not the last one has ended.

        Parameters
        ----------
        seed
            Seed of this episode and of those that follow it, 0 or more; ``None`` goes on with the present generator.
        options
            For this episode alone: factors of ``randomise`` -> their values, and ``poses`` -> {robot: (x_cm, y_cm,
            heading_deg)}. What is not named is as the env's arguments and the seed say.

        Returns
        -------
        observation : ndarray or dict of str to ndarray
            The observation of the first frame, in which the robot stands.
        info : dict
            See the env's page.

        Raises
        ------
        ValueError
            For a seed or an option that is unknown or not legal, in one line. Nothing has changed then.
        gymnasium.error.ClosedEnvironmentError
            After `close`.
        """
        self._check_open()
        asked = checked_reset_options(options, self._plain, self._made_with, self._sim.everyone, self._sim.obstacles)
        super().reset(seed=checked_seed(seed))
        self._forget()
        # The camera's noise has a generator of its own: the world is then the same whatever is observed, and
        # baselines with other observations can be compared in pairs.
        rng = episode(self.np_random)
        placements, drivers = self._drawn(self.np_random)
        drawn = self._randomisation.draw(self.np_random, rng, asked.values)
        settings = drawn.settings
        self._apparatus.set(settings)
        self._wheel_gains = settings.wheel_gains
        self._delay(settings.latency)
        if settings.shift != (0.0, 0.0):
            placements = moved(placements, OBSERVER, *settings.shift, self._sim.obstacles)
        if asked.poses:
            placements = placed(placements, asked.poses, clearing(rng), self._sim.obstacles)
        self._sim.reset(placements, self.np_random, light=settings.light)
        self._drivers = drivers
        self._vision.begin(film(rng))
        self._frame(look=True)
        self._begun = self._running = True
        if self._renderer:
            self._renderer.begin()
        info = self._info({})
        return self._observation(), {**info, "randomised": dict(drawn.values)} if drawn.values else info

    def step(self, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """Hold one action for ``frame_skip`` frames.

        Parameters
        ----------
        action
            An element of the action space.

        Returns
        -------
        observation : ndarray or dict of str to ndarray
            The observation of the last frame.
        reward : float
            The sum of the reward's terms, each the mean over the frames, but for ``touch``.
        terminated : bool
            Whether the observer touched anything.
        truncated : bool
            False: the time limit is Gymnasium's wrapper.
        info : dict
            The reward's terms as ``reward_...`` and the measures of the env's page.

        Raises
        ------
        gymnasium.error.InvalidAction
            If the action is not in the action space; nothing has moved then.
        gymnasium.error.ResetNeeded
            Before the first reset, and after the end of an episode.
        gymnasium.error.ClosedEnvironmentError
            After `close`.
        """
        self._check_open()
        if not self._running:
            raise error.ResetNeeded("step() before reset(), or after the episode's end: call reset() first")
        self._wheels = self._steer(wheels_of(self.action_space, action))
        left, right = (float(w) * self._fastest * gain for w, gain in zip(self._wheels, self._wheel_gains, strict=True))
        self._command = WheelSpeeds(left, right)
        self._vision.forget()
        self._driven = 0.0
        terms: dict[str, float] = {}
        skip = self.options.frame_skip
        for index in range(skip):
            self._frame(look=self._vision.model is not None or index == skip - 1)
            for name, value in self._reward().items():
                terms[name] = terms.get(name, 0.0) + value / skip
        terms["touch"] = -TOUCH_COST if self._touched else 0.0
        self._running = not self._touched
        if self._renderer:
            self._renderer.step()
        return self._observation(), sum(terms.values()), self._touched, False, self._info(terms)

    def render(self) -> Any:
        """Show the scene by ``render_mode``.

        Returns
        -------
        ndarray or None
            For ``rgb_array`` a picture (``render_height``, ``render_width``, 3) uint8; otherwise ``None``, as the
            viewer's window shows the scene.

        Raises
        ------
        gymnasium.error.ResetNeeded
            Before the first reset.
        gymnasium.error.ClosedEnvironmentError
            After `close`.
        """
        self._check_open()
        if self._renderer is None:
            gym.logger.warn("render() without a render_mode: give one to gym.make, for example 'rgb_array'")
            return None
        if not self._begun:
            raise error.ResetNeeded("render() before reset(): call reset() first")
        return self._renderer.picture()

    def close(self) -> None:
        """Free every OpenGL context. A second call does nothing."""
        if not self._closed:
            self._closed = True
            if self._renderer:
                self._renderer.close()
            self._sim.close()

    # Read-only views, for recordings and baselines.

    @property
    def luma(self) -> npt.NDArray[np.uint8]:
        """The last frame, (R, C) uint8, read-only; zeros with ``observation="state"``, which renders nothing."""
        return self._vision.luma

    @property
    def model(self) -> Model | None:
        """The vision model of neural observations; ``None`` with other observations."""
        return self._vision.model

    @property
    def answer(self) -> ModelResponse | None:
        """The vision model's answer to the last frame; ``None`` without a model."""
        return self._vision.answer

    @property
    def wheels(self) -> npt.NDArray[np.float32]:
        """The last command to the wheels, (2,): left and right, as shares of the maximum."""
        return self._wheels

    @property
    def obstacles(self) -> tuple[Obstacle, ...]:
        """The obstacles that stand in the arena, beside the wall."""
        return self._sim.obstacles

    # Private.

    def _retexture(self, texture: int) -> None:
        """Give a texture that has changed to all who hold a copy."""
        if self._sim.seeing:
            self._sim.camera.retexture(texture)
        if self._renderer:
            self._renderer.retexture(texture)

    def _drawn(self, rng: np.random.Generator) -> tuple[Mapping[str, Pose], Mapping[str, Driver]]:
        """Draw an episode, again as long as a robot would stand in an obstacle; ``ValueError`` where that is always."""
        if not self._sim.obstacles:
            return self._begin(rng)
        for _ in range(MOST_STARTS):
            placements, drivers = self._begin(rng)
            gaps = {name: gap_to_arena(pose, self._sim.obstacles)[0] for name, pose in placements.items()}
            if min(gaps.values()) > 0.0:
                return placements, drivers
        name = min(gaps, key=lambda name: gaps[name])
        raise ValueError(
            f"arena {self.options.arena}: its obstacles leave no room for {name} in {MOST_STARTS} draws of the start:"
            " move them, or make fewer or smaller ones"
        )

    def _forget(self) -> None:
        """Set what an episode changes back to what it is before the first one."""
        self._rest()
        self._wheels, self._wheel_gains = np.zeros(2, np.float32), (1.0, 1.0)
        self._vision.forget()

    def _frame(self, look: bool) -> None:
        """Advance the world by one frame; with ``look``, render it and ask the model."""
        self._advance(look)
        if look and self.options.observation != "state":
            self._vision.look(self._sim.camera, self._sim.data.time)

    def _observation(self) -> Any:
        return self.state.vector() if self.options.observation == "state" else self._vision.observation()

    def _info(self, terms: Mapping[str, float]) -> dict[str, Any]:
        """Return the reward's terms as ``reward_...``, and the measures; their names end in their units."""
        rewards = {f"reward_{name}": value for name, value in terms.items()}
        return {**rewards, **self._motion(), **self._measures()}

    def _check_open(self) -> None:
        if self._closed:
            raise error.ClosedEnvironmentError("this env is closed: make a new one")
