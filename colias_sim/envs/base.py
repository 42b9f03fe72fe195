"""What every env shares: the robot, its wheels and eye, the others around it, and Gymnasium's contract."""

from __future__ import annotations

import dataclasses
import math
from abc import abstractmethod
from collections.abc import Mapping
from typing import Any, ClassVar, Generic, TypeVar

import gymnasium as gym
import mujoco
import numpy as np
import numpy.typing as npt
from gymnasium import error, spaces

from colias_sim import gl
from colias_sim.config import CameraConfig, RobotConfig, SceneConfig
from colias_sim.envs.actions import action_space, wheels_of
from colias_sim.envs.drivers import Driver, gap_to, wall
from colias_sim.envs.options import Answer, EnvOptions, Model, checked
from colias_sim.envs.senses import Other, State, build_model, neural, space
from colias_sim.envs.showing import Shower
from colias_sim.robot import Pose, Robot, WheelSpeeds
from colias_sim.simulation import Simulation
from colias_sim.streams import film

OBSERVER, TARGET = "observer", "target"
TOUCH_COST = 10.0
WIDEST_LIGHT, WIDEST_SHELL, WIDEST_MOTOR, WIDEST_TILT = 0.3, 0.4, 0.05, math.radians(3.0)
"""Domain randomisation at its widest: lamps by a share, shells' reflectance up to, wheels by a share, camera by."""

Options = TypeVar("Options", bound=EnvOptions)


class ColiasEnv(gym.Env[Any, Any], Generic[Options]):
    """Base of the envs: a subclass says who else is there, what they do, and what is rewarded."""

    metadata: dict[str, Any] = {"render_modes": ["human", "rgb_array", "rgb_array_list"], "render_fps": 30}  # noqa: RUF012
    options_type: ClassVar[type[EnvOptions]] = EnvOptions
    options: Options
    _drivers: Mapping[str, Driver]
    _answers: list[Answer]
    _wheel_gains: tuple[float, float]
    _drift: float
    _driven: float
    _touched: bool

    def __init__(self, **options: Any) -> None:
        self.options = own = checked(self.options_type, options)  # type: ignore[assignment]
        self.render_mode = own.render_mode
        self.metadata = {"render_modes": _render_modes(), "render_fps": 30.0 / own.frame_skip}
        robot, camera = RobotConfig(), _camera(own)
        self._fastest = robot.max_speed_cm_s / 100
        self._shape = camera.height, camera.width
        self.observation_space, self.action_space = spaces_of(own)
        model = build_model(own.model, self._shape)  # always: a wrong one is told of, whatever is observed
        self._model = model if own.observation in ("neural", "both") else None
        self._sim = Simulation(
            robot, camera, SceneConfig(arena=own.arena), {OBSERVER: "colias", **self._others()},
            fence=True, seeing=own.observation != "state",
        )  # fmt: skip
        try:
            self._shower = Shower(self._sim, own) if own.render_mode else None
        except BaseException:
            self._sim.close()
            raise
        self._hull = self._sim.model.geom(f"{OBSERVER}/hull").id
        self._eye = self._sim.model.camera(f"{OBSERVER}/eye")
        self._eye_quat = self._eye.quat.copy()
        self._luma = np.zeros(self._shape, np.uint8)
        self._luma.flags.writeable = False
        self._begun = self._running = self._closed = False
        self._forget()

    # What a subclass says.

    @abstractmethod
    def _others(self) -> Mapping[str, str]:
        """The other robots, name -> variant, ``options.robots`` of them."""

    @abstractmethod
    def _begin(self, rng: np.random.Generator) -> tuple[Mapping[str, Pose], Mapping[str, Driver]]:
        """Draw an episode: where everybody stands, the observer too, and who drives the others."""

    @abstractmethod
    def _reward(self) -> dict[str, float]:
        """The terms of the reward of the last frame, without that of touching."""

    def _disturb(self, dt: float) -> float:
        """Act on drum and robot for ``dt`` seconds; the rate in rad/s at which that alone would turn the view."""
        return 0.0

    def _steer(self, wheels: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
        """The wheel command that comes of an action: here the action."""
        return wheels

    # Gymnasium's contract.

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Begin a new episode, in the middle of another too; the observation is of the first frame, at rest.

        ``options`` has no entries of its own: any raises ``ValueError``.
        """
        self._check_open()
        check_reset_options(options)
        super().reset(seed=seed)
        self._forget()
        # Noise of its own: what happens is then the same whatever is observed, and baselines compare in pairs.
        self._film = film(self.np_random)
        placements, drivers = self._begin(self.np_random)
        light = self._randomise(self.np_random)
        self._sim.reset(placements, self.np_random, light=light)
        self._drivers = drivers
        if self._model is not None:
            self._model.reset()
        self._frame(look=True)
        self._begun = self._running = True
        if self._shower:
            self._shower.begin()
        return self._observation(), self._info({})

    def step(self, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """Hold ``action`` for ``frame_skip`` frames.

        Raises `gymnasium.error.InvalidAction` for an action that is not in the action space, naming it,
        `gymnasium.error.ResetNeeded` before the first reset and after an end, and
        `gymnasium.error.ClosedEnvironmentError` once closed.
        """
        self._check_open()
        if not self._running:
            raise error.ResetNeeded("step() before reset(), or after the episode's end: call reset() first")
        self._wheels = self._steer(wheels_of(self.action_space, action))
        left, right = (float(w) * self._fastest * gain for w, gain in zip(self._wheels, self._wheel_gains, strict=True))
        self._command = WheelSpeeds(left, right)
        self._answers, self._driven = [], 0.0
        terms: dict[str, float] = {}
        skip = self.options.frame_skip
        for index in range(skip):
            self._frame(look=self._model is not None or index == skip - 1)
            for name, value in self._reward().items():
                terms[name] = terms.get(name, 0.0) + value / skip
        terms["touch"] = -TOUCH_COST if self._touched else 0.0
        self._running = not self._touched
        if self._shower:
            self._shower.step()
        return self._observation(), sum(terms.values()), self._touched, False, self._info(terms)

    def render(self) -> Any:
        """By ``render_mode``: an RGB picture, those since the last call, or nothing (the viewer shows it)."""
        self._check_open()
        if self._shower is None:
            gym.logger.warn("render() without a render_mode: give one to gym.make, for example 'rgb_array'")
            return None
        if not self._begun:
            raise error.ResetNeeded("render() before reset(): call reset() first")
        return self._shower.picture()

    def close(self) -> None:
        """Free every OpenGL context; a second call does nothing."""
        if not self._closed:
            self._closed = True
            if self._shower:
                self._shower.close()
            self._sim.close()

    # What the bench may read.

    @property
    def poses(self) -> dict[str, Pose]:
        """Where every robot is."""
        return {name: robot.pose for name, robot in self._sim.everyone.items()}

    @property
    def luma(self) -> npt.NDArray[np.uint8]:
        """The last frame, (R, C) uint8, read-only; zeros with ``observation="state"``, which sees nothing."""
        return self._luma

    @property
    def model(self) -> Model | None:
        """The vision model of neural observations; ``None`` where nothing asks it."""
        return self._model

    @property
    def answer(self) -> Answer | None:
        """The vision model's answer to the last frame; ``None`` without a model."""
        return self._answers[-1] if self._answers else None

    @property
    def wheels(self) -> npt.NDArray[np.float32]:
        """The last command, (2,): left and right, as shares of the maximum."""
        return self._wheels

    @property
    def state(self) -> State:
        """What the observation ``state`` says, in units."""
        here, (vx, vy) = self._sim.robots[OBSERVER].pose, self._sim.robots[OBSERVER].velocity
        cos, sin = math.cos(here.heading), math.sin(here.heading)
        seen = []
        for name, robot in self._sim.everyone.items():
            if name == OBSERVER:
                continue
            there = robot.pose
            gap, direction = gap_to(here, there)
            ux, uy = robot.velocity if isinstance(robot, Robot) else (0.0, 0.0)
            du, dv = ux - vx, uy - vy
            seen.append((name != TARGET, Other(gap, direction, du * cos + dv * sin, dv * cos - du * sin)))
        seen.sort(key=lambda entry: (entry[0], entry[1].distance))
        gap, direction = wall(here)
        return State(
            self.speed, self.turn_rate, self.slip, self._drift, gap, direction,
            tuple(other for _, other in seen),
        )  # fmt: skip

    @property
    def speed(self) -> float:
        """Along the heading, in m/s."""
        heading, (vx, vy) = self._sim.robots[OBSERVER].pose.heading, self._sim.robots[OBSERVER].velocity
        return vx * math.cos(heading) + vy * math.sin(heading)

    @property
    def turn_rate(self) -> float:
        """Of the body, in rad/s, left positive."""
        return self._sim.robots[OBSERVER].turn_rate

    @property
    def slip(self) -> float:
        """The turn rate against the wall, in rad/s, left positive."""
        return self.turn_rate - self._wall_rate()

    # The rest is its own.

    def _forget(self) -> None:
        """What an episode leaves behind, as it is before the first."""
        self._command, self._wheels, self._wheel_gains = WheelSpeeds(0.0, 0.0), np.zeros(2, np.float32), (1.0, 1.0)
        self._drivers, self._answers, self._drift, self._driven, self._touched = {}, [], 0.0, 0.0, False

    def _wall_rate(self) -> float:
        return 0.0

    def _frame(self, look: bool) -> None:
        """One frame of the world, with what is seen and touched in it."""
        before = self._sim.robots[OBSERVER].pose
        self._sim.advance(self._drive, look=look)
        self._notice_touch()
        after = self._sim.robots[OBSERVER].pose
        self._driven += math.hypot(after.x - before.x, after.y - before.y)
        if look and self.options.observation != "state":
            frame = self._sim.camera.develop(self._film, self._sim.data.time)
            self._luma = frame.luma
            if self._model is not None:
                self._answers.append(self._model.step(frame.luma))

    def _drive(self, dt: float) -> None:
        """Before each control interval: the wheels of all, drum and push."""
        self._notice_touch()
        self._sim.robots[OBSERVER].ease(self._command, dt)
        poses = self.poses if self._drivers else {}
        for name, driver in self._drivers.items():
            self._sim.robots[name].ease(driver.wheels(dt, poses), dt)
        self._drift = self._disturb(dt)

    def _notice_touch(self) -> None:
        if not self._touched:
            self._touched = bool((self._sim.data.contact.geom == self._hull).any())

    def _randomise(self, rng: np.random.Generator) -> float:
        """Draw what domain randomisation varies; all is drawn always, so its strength changes nothing else."""
        wide = self.options.randomise
        light, shell, left, right, pitch, yaw = rng.uniform(-1.0, 1.0, 6).tolist()
        self._wheel_gains = 1.0 + wide * WIDEST_MOTOR * left, 1.0 + wide * WIDEST_MOTOR * right
        grey = SceneConfig().shell_grey + wide * WIDEST_SHELL * (shell + 1.0) / 2
        for name, variant in self._others().items():
            if variant != "colias":
                self._sim.model.material(f"{name}/shell").rgba[:3] = grey
        tilt = np.zeros(4)
        mujoco.mju_euler2Quat(tilt, np.array([pitch, yaw, 0.0]) * wide * WIDEST_TILT, "xyz")
        mujoco.mju_mulQuat(self._eye.quat, self._eye_quat, tilt)
        return float(1.0 + wide * WIDEST_LIGHT * light)

    def _observation(self) -> Any:
        kind = self.options.observation
        if kind == "state":
            return self.state.vector()
        if kind == "neural":
            return neural(self._answers)
        pixels = self._luma[..., None].copy()  # the agent's own: it may write to it
        return pixels if kind == "pixels" else {"pixels": pixels, "neural": neural(self._answers)}

    def _info(self, terms: Mapping[str, float]) -> dict[str, Any]:
        """The reward's terms, and what measures a behaviour; units are in the names."""
        pose = self._sim.robots[OBSERVER].pose
        measures = {
            "x_cm": 100 * pose.x, "y_cm": 100 * pose.y, "heading_deg": math.degrees(pose.heading),
            "driven_cm": 100 * self._driven, "turn_deg_s": math.degrees(self.turn_rate),
            "slip_deg_s": math.degrees(self.slip), "drift_deg_s": math.degrees(self._drift),
            "touched": self._touched, **self._measures(),
        }  # fmt: skip
        return {**{f"reward_{name}": value for name, value in terms.items()}, **measures}

    def _measures(self) -> dict[str, Any]:
        """What a task adds to ``info``."""
        return {}

    def _effort(self) -> float:
        """The reward's term for sparing the motors."""
        return -0.05 * float(np.mean(self._wheels**2))

    def _check_open(self) -> None:
        if self._closed:
            raise error.ClosedEnvironmentError("this env is closed: make a new one")


def parked(count: int) -> dict[str, str]:
    """So many robots that stand about, name -> variant."""
    return {f"parked{i}": "colias_parked" for i in range(1, count + 1)}


def spaces_of(options: EnvOptions) -> tuple[spaces.Space[Any], spaces.Space[Any]]:
    """What an env of these options observes, and how it is acted on."""
    camera = _camera(options)
    return space(options.observation, (camera.height, camera.width), options.robots), action_space(options.actions)


def check_reset_options(options: Mapping[str, Any] | None) -> None:
    """Raise ``ValueError`` for any: a reset has no options of its own."""
    if options:
        raise ValueError(f"reset(options={options}): no such option; what can be set is an argument of gym.make")


def _render_modes() -> list[str]:
    """Those that this machine can show: gym.make asks the class, which has them all, its checkers the env."""
    every: list[str] = ColiasEnv.metadata["render_modes"]
    return every if gl.has_screen() else [mode for mode in every if mode != "human"]


def _camera(options: EnvOptions) -> CameraConfig:
    plain = CameraConfig()
    return dataclasses.replace(
        plain, shot_noise=options.noise * plain.shot_noise, read_noise=options.noise * plain.read_noise
    )
