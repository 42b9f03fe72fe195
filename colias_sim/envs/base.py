"""The base class of the envs: Gymnasium's contract, around the observer's wheels and camera."""

from __future__ import annotations

import copy
import dataclasses
import inspect
import math
from abc import abstractmethod
from collections.abc import Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar, Generic, Self

import gymnasium as gym
import numpy as np
import numpy.typing as npt
from gymnasium import error

from colias_sim.config import SceneConfig
from colias_sim.envs.geometry import gap_to_arena, given_poses, moved, placed
from colias_sim.envs.measures import SHARE, SIZE, Values
from colias_sim.envs.options import EnvOptions, Options, checked
from colias_sim.envs.randomise import FACTORS, USUAL, Values as Factors, apparatus_with, camera_ends, draw, given_values
from colias_sim.envs.scripted import Driver
from colias_sim.envs.senses import (
    NEURAL,
    PastResponse,
    action_space,
    build_model,
    observation_space,
    senses_events,
    wheels_of,
)
from colias_sim.envs.world import OBSERVER, TARGET, World, parked_robots
from colias_sim.gl import has_screen
from colias_sim.pose import Pose, bearing
from colias_sim.snapshot import PARTS, SETTINGS
from colias_sim.streams import clearing, episode, film, sensor, world
from dsnn.snapshot import Parts, Tree, attributes, pack, put, take, unpack

if TYPE_CHECKING:
    import colias_sim.truth
    from colias_sim.obstacles import Obstacle

Wheels = npt.NDArray[np.float32]

TOUCH_COST = 10.0
"""Cost of touching anything, the negative of the reward's term ``touch``."""
MOST_STARTS = 500
"""Most draws of an episode's start among obstacles."""


class ColiasEnv(World, gym.Env[Any, Any], Generic[Options]):
    """Base class of the envs: Gymnasium's contract for one robot with a camera.

    A subclass declares its keyword arguments as a dataclass (``options_type``), what is measured of its episodes, the
    other robots (`_others`), the start of an episode (`_begin`) and the reward (`_reward`).

    Parameters
    ----------
    **arguments
        The fields of ``options_type``; ``help(env.options)`` lists them.

    Raises
    ------
    ValueError
        An argument is unknown or out of range, the vision model cannot be built, or the arena is refused.
    colias_sim.GLUnavailable
        No OpenGL backend works, or ``render_mode="human"`` has no screen.
    """

    metadata: dict[str, Any] = {"render_modes": ["human", "rgb_array"], "render_fps": 30}  # noqa: RUF012
    options_type: ClassVar[type[EnvOptions]] = EnvOptions
    max_episode_steps: ClassVar[int]
    """Number of steps after which an episode is truncated."""
    summary: ClassVar[str]
    """The task, in a few words."""
    baselines: ClassVar[tuple[str, ...]] = ()
    """Behaviours for comparison: a random walk, driving straight, and an oracle that receives the world's state."""
    columns: ClassVar[Mapping[str, tuple[float, float]]] = MappingProxyType({})
    """Columns of its table of episodes in addition to the common ones -> their least and largest possible value."""
    measures: ClassVar[Mapping[str, str]] = MappingProxyType({})
    """Heading, with the unit, of each measure -> the column whose mean over episodes it is; without the return."""
    collisions: ClassVar[tuple[str, ...]] = ()
    """Its measures of collisions, from `colias_sim.envs.measures.COLLISIONS`."""
    note: ClassVar[str] = ""
    """A sentence or two printed under the table of measures."""
    draws_paths: ClassVar[bool] = False
    """Whether a figure of its episodes shows the observer's paths from above."""
    options: Options

    def __init_subclass__(cls, **kwargs: Any) -> None:
        super().__init_subclass__(**kwargs)
        cls.__signature__ = inspect.signature(cls.options_type)  # type: ignore[attr-defined]

    def __init__(self, **arguments: Any) -> None:
        # A late import: MuJoCo loads slowly, and listing the envs does not need it.
        from colias_sim.envs.apparatus import Apparatus
        from colias_sim.envs.render import Renderer
        from colias_sim.simulation import Simulation

        self.options = options = checked(self.options_type, arguments)  # type: ignore[assignment]
        self.render_mode = options.render_mode
        self._kind = type(self).__name__, repr(dataclasses.replace(options, model="", render_mode=None))
        # The class has every mode, as gym.make asks it; the checkers ask the env.
        modes = [mode for mode in ColiasEnv.metadata["render_modes"] if mode != "human" or has_screen()]
        self.metadata = {"render_modes": modes, "render_fps": 30.0 / options.frames_per_step}
        self._camera, self._robot = camera, robot = options.noisy_camera(), options.robot
        self._fastest, self._half_view = robot.max_speed_cm_s / 100, math.radians(camera.hfov_deg / 2)
        shape = camera.height, camera.width
        others = self._others()
        self.observation_space = observation_space(options.observation, shape, len(others))
        self.action_space = action_space(options.actions)
        model = build_model(options.model, shape)  # built even if unused, so that a wrong name is an error
        self._model = model if options.observation in ("neural", "both") else None
        self._luma = np.zeros(shape, np.uint8)
        self._luma.flags.writeable = False
        # The camera is made for the upper ends of all ranges, which need the most memory.
        self._made_with = camera_ends(camera, robot, options.randomise)[1]
        sim = Simulation(
            robot, self._made_with, SceneConfig(arena=options.arena), {OBSERVER: "colias", **others},
            fence=True, seeing=options.observation != "state", truth=options.truth,
            events=options.events if senses_events(self._model) or options.observation == "events" else None,
        )  # fmt: skip
        super().__init__(sim, OBSERVER)
        self._renderer: Renderer | None = None
        self._begun = self._running = self._closed = False
        self._forget()
        try:
            self._renderer = Renderer(sim, options, self._observer.name) if options.render_mode else None
            self._drawn(world(0))  # refuses an arena without room for the robots
        except BaseException:
            self.close()
            raise
        shells = [name for name, variant in others.items() if variant != "colias"]
        self._apparatus = Apparatus(sim, self._observer.name, shells, robot)

    # What a subclass declares. (`World` has what disturbs it.)

    @abstractmethod
    def _others(self) -> Mapping[str, str]:
        """List the other robots, once when the env is made.

        Returns
        -------
        mapping of str to str
            Name -> variant from `scenes.ROBOTS`, with ``options.robots`` entries.
        """

    @abstractmethod
    def _begin(self, rng: np.random.Generator) -> tuple[Mapping[str, Pose], Mapping[str, Driver]]:
        """Draw the start of an episode, and the drivers of the other robots.

        Parameters
        ----------
        rng
            Generator of the episode's world.

        Returns
        -------
        poses : mapping of str to Pose
            The start of every robot by name, including ``observer``.
        drivers : mapping of str to Driver
            The driver of each other robot that moves. Its ``wheels(dt, poses)`` returns the wheel speeds for a control
            interval of ``dt`` seconds.
        """

    @abstractmethod
    def _reward(self) -> dict[str, float]:
        """Compute the reward's terms of the last frame, without ``touch``.

        Returns
        -------
        dict of str to float
            Name of the term -> its value; the reward is their sum.
        """

    def _steer(self, wheels: Wheels) -> Wheels:
        """Convert the wheel speeds of an action to commanded speeds; here they are the same.

        Parameters
        ----------
        wheels
            (2,): left and right, in [-1, 1], as shares of the maximum.

        Returns
        -------
        ndarray of float32
            (2,), likewise.
        """
        return wheels

    def measured(self, infos: Mapping[str, Values]) -> dict[str, float | None]:
        """Compute the ``columns`` of an episode; ``None`` where one has no value.

        Parameters
        ----------
        infos
            Numeric entry of ``info`` -> its values in the episode's steps.

        Returns
        -------
        dict of str to float or None
            Name of the column -> value.
        """
        return {}

    # Gymnasium's contract.

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Begin a new episode, whether or not the last one has ended.

        Parameters
        ----------
        seed
            Seed of this and the following episodes, 0 or more; ``None`` continues with the present generator.
        options
            For this episode only: factors of ``randomise`` -> their values, and ``poses`` -> {robot: (x_cm, y_cm,
            heading_deg)}. Everything else follows from the env's arguments and the seed.

        Returns
        -------
        observation : ndarray or dict of str to ndarray
            The observation of the first frame, in which the robot stands.
        info : dict
            See the env's page.

        Raises
        ------
        ValueError
            An option is unknown or out of range. The env is then unchanged.
        gymnasium.error.ClosedEnvironmentError
            After `close`.
        """
        self._check_open()
        obstacles, asked = self._sim.obstacles, dict(options or {})
        poses = given_poses(asked.pop("poses", {}), self._sim.everyone, obstacles)
        given = given_values(asked, self._camera, self._robot, self.options.randomise, self._made_with)
        if self._observer.name in poses:
            given["start"] = (0.0, 0.0)  # the given pose replaces the move
        super().reset(seed=seed)
        self._forget()
        # The camera's noise has its own generator, so that the world does not depend on the observation, and
        # baselines with other observations can be compared in pairs.
        rng = episode(self.np_random)
        self._start = self.np_random.bit_generator.state
        placements, self._drivers = self._drawn(self.np_random)
        drawn = draw(self.options.randomise, given, self.np_random, rng)
        values = self._equip(drawn)
        self._wheel_gains, (ahead_cm, left_cm) = values["wheel_gain"], values["start"]
        (light,), (latency_ms,) = values["light"], values["latency_ms"]
        self._delay(0.001 * latency_ms)
        if (ahead_cm, left_cm) != (0.0, 0.0):
            placements = moved(placements, self._observer.name, 0.01 * ahead_cm, 0.01 * left_cm, obstacles)
        if poses:
            placements = placed(placements, poses, clearing(rng), obstacles)
        self._sim.reset(placements, self.np_random, light=light, events=sensor(rng))
        self._here = self._observer.pose
        self._film = film(rng)
        if self._model is not None:
            self._model.reset()
        self._frame(look=True, taken=True)
        self._begun = self._running = True
        if self._renderer:
            self._renderer.show()
        info = self._info({})
        if drawn:
            info["randomised"] = {
                part: value for name in drawn for part, value in zip(FACTORS[name].parts, drawn[name], strict=True)
            }
        return self._observation(), info

    def step(self, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """Apply one action for ``frame_skip`` frames, the last of which the vision model takes.

        Parameters
        ----------
        action
            Two wheel speeds, which are clipped to [-1, 1], or the number of a manoeuvre.

        Returns
        -------
        observation : ndarray or dict of str to ndarray
            The observation of the last frame.
        reward : float
            The sum of the reward's terms. Each term except ``touch`` is the mean over the frames.
        terminated : bool
            Whether the observer touched anything.
        truncated : bool
            Always false; Gymnasium's wrapper sets the time limit.
        info : dict
            The reward's terms as ``reward_...`` and the measures of the env's page.

        Raises
        ------
        gymnasium.error.InvalidAction
            The action is not a pair of numbers, a number is NaN, or the manoeuvre is unknown. The env is then
            unchanged.
        gymnasium.error.ResetNeeded
            Before the first reset, and after the end of an episode.
        gymnasium.error.ClosedEnvironmentError
            After `close`.
        """
        self._check_open()
        if not self._running:
            raise error.ResetNeeded("step() before reset(), or after the episode's end: call reset() first")
        self._wheels = self._steer(wheels_of(self.action_space, action))
        (left, right), (left_gain, right_gain) = self._wheels.tolist(), self._wheel_gains
        self._command = left * self._fastest * left_gain, right * self._fastest * right_gain
        self._responses, self._events = [], []
        self._driven = 0.0
        terms: dict[str, float] = {}
        skip, processor = self.options.frames_per_step, self.options.processor
        for index in range(skip):
            taken = processor.takes(index, processor.every - 1)
            self._frame(look=self._model is not None or index == skip - 1, taken=taken)
            for name, value in self._reward().items():
                terms[name] = terms.get(name, 0.0) + value / skip
        terms["touch"] = -TOUCH_COST if self._touched else 0.0
        self._running = not self._touched
        if self._renderer:
            self._renderer.show()
        return self._observation(), sum(terms.values()), self._touched, False, self._info(terms)

    def render(self) -> Any:
        """Render the scene for people, as ``render_mode`` sets.

        Returns
        -------
        ndarray or None
            For ``rgb_array`` a picture (``render_height``, ``render_width``, 3) uint8; otherwise ``None``, and a window
            shows the scene.

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

    def get_state(self) -> bytes:
        """Save everything that goes on: the world with its other robots, all streams of random numbers, the model.

        Returns
        -------
        bytes
            The state, for `set_state` of an env of this class with the same arguments, in any process. `render_mode`
            may differ. Counters of Gymnasium's wrappers, and what the agent keeps, are no part of it.

        Raises
        ------
        ValueError
            The vision model, or something that a class of yours keeps, cannot be saved: the message names it.
        gymnasium.error.ClosedEnvironmentError
            After `close`.
        """
        self._check_open()
        return pack(self._kind, self._tree() | {"_model": self._model and self._model.get_state()})

    def set_state(self, state: bytes) -> None:
        """Restore a state: equal actions then have equal observations, rewards and infos, to the bit.

        Parameters
        ----------
        state
            The bytes that `get_state` returned.

        Raises
        ------
        ValueError
            The bytes are no state, are damaged, or are of another env, arguments or model. The env is then unchanged.
        gymnasium.error.ClosedEnvironmentError
            After `close`.
        """
        self._check_open()
        tree = unpack(state, self._kind, (Pose,))
        world, model = self._sim._read(tree.pop("_sim")), tree.pop("_model")
        if self._model is not None:
            self._model.set_state(model)
        self._responses = [PastResponse(*response) for response in tree.pop("_responses")]
        if tree["_begun"]:
            self._equip(tree["_factors"])
        self._sim._restore(world)
        if tree["_drivers"]:  # are drawn again from where the episode began, and then put into their states
            rng = self.np_random = tree.pop("_np_random")
            now, rng.bit_generator.state = rng.bit_generator.state, tree["_start"]
            self._drivers = self._drawn(rng)[1]
            rng.bit_generator.state = now
        put(self, tree, self._parts)

    def copy(self) -> Self:
        """Make a twin in this process, which goes on from here on its own. Of a wrapped env call ``unwrapped.copy``.

        Returns
        -------
        ColiasEnv
            The twin. It shares the OpenGL contexts: use both in one thread. A vision model of yours is copied by
            ``copy.deepcopy``.

        Raises
        ------
        ValueError
            Something that a class of yours keeps cannot be saved.
        gymnasium.error.ClosedEnvironmentError
            After `close`.
        """
        self._check_open()
        twin = copy.copy(self)
        for name in attributes(self, self._parts) or ():
            vars(twin).pop(name, None)
        twin._sim = self._sim.copy()
        twin._observer = twin._sim.robots[self._observer.name]
        twin._model = None
        twin._renderer = None if self._renderer is None else self._renderer.copy(twin._sim)
        twin._apparatus = self._apparatus.copy(twin._sim)
        twin.set_state(pack(self._kind, self._tree() | {"_model": None}))
        twin._model = copy.deepcopy(self._model)
        return twin

    @property
    def _parts(self) -> Parts:
        mine = f"{type(self).__module__}.{type(self).__qualname__}"
        settings = frozenset(SETTINGS.split())
        return {**PARTS, mine: " ".join(name for name in vars(self) if name not in settings)}

    def _tree(self) -> Tree:
        """Return the state without that of the model."""
        responses = [[getattr(response, name) for name in NEURAL] for response in self._responses]
        return take(self, self._parts, (Pose,)) | {"_responses": responses, "_sim": self._sim.get_state()}

    # Read-only views, for recordings and baselines.

    @property
    def wheels(self) -> Wheels:
        """The last command to the wheels, (2,): left and right, as shares of the maximum."""
        return self._wheels

    def truth(self, since: int = 1) -> colias_sim.truth.Truth:
        """Return what each pixel of the last frame truly shows, with ``truth=True``; see `colias_sim.Simulation.truth`.

        Parameters
        ----------
        since
            How many frames ago the frame before it was, 1 to 6.

        Returns
        -------
        Truth
            Flow, depth and surface of each pixel.

        Raises
        ------
        ValueError
            ``since`` is out of range, or the env was made without ``truth=True``.
        """
        return self._sim.truth(since)

    @property
    def obstacles(self) -> tuple[Obstacle, ...]:
        """The obstacles in the arena, without the wall."""
        return self._sim.obstacles

    # Private.

    def _effort(self) -> float:
        """Compute the reward's term for motor effort: -0.05 times the mean square of the two wheels."""
        left, right = self._wheels
        return -0.05 * float((left * left + right * right) / 2)

    def _equip(self, drawn: Factors) -> Factors:
        """Set the apparatus to an episode's draw; return the values of all factors that are no settings."""
        self._factors, values = drawn, USUAL | drawn
        camera, self._body = apparatus_with(self._camera, self._robot, drawn)
        self._apparatus.set(camera, self._body, values, self._retexture)
        return values

    def _retexture(self, texture: int) -> None:
        """Update all copies of a changed texture."""
        for camera in self._sim.cameras.values():
            camera.retexture(texture)
        if self._sim.event_camera:
            self._sim.event_camera.retexture(texture)
        if self._renderer:
            self._renderer.retexture(texture)

    def _drawn(self, rng: np.random.Generator) -> tuple[Mapping[str, Pose], Mapping[str, Driver]]:
        """Draw an episode until no robot stands in an obstacle; ``ValueError`` after too many draws."""
        for _ in range(MOST_STARTS):
            placements, drivers = self._begin(rng)
            if not self._sim.obstacles or all(
                gap_to_arena(pose, self._sim.obstacles)[0] > 0.0 for pose in placements.values()
            ):
                return placements, drivers
        raise ValueError(f"arena {self.options.arena}: its obstacles leave no room in {MOST_STARTS} draws of the start")

    def _forget(self) -> None:
        """Reset the episode's state to its state before the first episode."""
        self._rest()
        self._wheels, self._wheel_gains = np.zeros(2, np.float32), USUAL["wheel_gain"]
        self._responses, self._events = [], []

    def _frame(self, look: bool, taken: bool) -> None:
        """Advance the world by one frame; with ``look``, develop the camera's frame; the model may take it."""
        self._advance(look)
        if look and self._sim.seeing:
            self._look(taken)

    def _check_open(self) -> None:
        if self._closed:
            raise error.ClosedEnvironmentError("this env is closed: make a new one")


class TargetEnv(ColiasEnv[Options]):
    """Base class of envs whose first other robot is the target; the rest are parked."""

    columns: ClassVar = {"in_view": SHARE, "off_axis_deg": SIZE}

    def _others(self) -> Mapping[str, str]:
        return {TARGET: "colias_black"} | parked_robots(self.options.robots - 1)

    def _measures(self) -> dict[str, Any]:
        off = self._bearing()
        return {"bearing_deg": math.degrees(off), "in_view": abs(off) < self._half_view}

    def measured(self, infos: Mapping[str, Values]) -> dict[str, float | None]:
        """Compute the columns of an episode."""
        return {"in_view": float(infos["in_view"].mean()), "off_axis_deg": float(np.abs(infos["bearing_deg"]).mean())}

    def _centre(self) -> float:
        """Compute the reward's term for a centred target: 1 on the axis, 0 at the edge of the view, at least -1."""
        return max(1.0 - abs(self._bearing()) / self._half_view, -1.0)

    def _bearing(self) -> float:
        """Compute the target's angle off the camera's axis without tilt, in radians, right positive."""
        eye = self._sim.camera_config.forward_cm / 100
        return bearing(self._here, self._sim.pose(TARGET), eye)
