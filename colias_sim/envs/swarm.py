"""Several robots that all see, in one world, advanced frame by frame."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Collection, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self

import numpy as np
import numpy.typing as npt
from pydantic import Field, model_validator
from pydantic.dataclasses import dataclass

from colias_sim.config import CameraConfig, SceneConfig
from colias_sim.envs.geometry import gap_to_arena
from colias_sim.envs.options import FPS, STRICT, CameraSettings, EnvOptions
from colias_sim.envs.senses import Model, Response, build_model, senses_events
from colias_sim.envs.world import World
from colias_sim.pose import Pose, WheelSpeeds
from colias_sim.streams import film, sensor
from dsnn.field_docs import unit, with_field_docs

if TYPE_CHECKING:
    from colias_sim.simulation import Simulation

WALL = "wall"
"""What a robot touches that touches no robot: the wall, or an obstacle."""
AWAY_M = 10.0
"""Distance from the arena's middle at which robots stand that have left it."""


APART = 15
"""Frames without touching after which two robots that touch have collided once more."""


@dataclasses.dataclass(frozen=True, slots=True)
class Body:
    """What a robot knows beside what it sees.

    Parameters
    ----------
    number
        Its number, from 0.
    time_s
        Time since the trial began.
    touched
        Whether its hull touched anything in the last frame.
    wall_m, wall_bearing
        Distance from its hull to the wall, and the wall's direction off its heading in radians, right positive.
    """

    number: int
    time_s: float
    touched: bool
    wall_m: float
    wall_bearing: float


Drive = Callable[[Any, Body], WheelSpeeds]
"""A type: function of a model's response, or ``None`` of a robot that sees nothing, and of a `Body`, that returns the
wheel speeds, left and right, as shares of the maximum."""


@with_field_docs
@dataclass(frozen=True, kw_only=True, config=STRICT)
class SwarmOptions(EnvOptions):
    """Keyword arguments of `swarm_env`."""

    robots: int = Field(default=12, ge=1, le=30)
    """Robots, each of which sees and is an agent."""
    body: Literal["colias", "colias_black"] = "colias_black"
    """Variant of the robots: colias_black has a shell around it."""
    eyes: Mapping[str, CameraSettings] = Field(default_factory=dict)
    """Cameras of single robots, by name, where they are not camera."""
    crash: Literal["leave", "stop"] = "leave"
    """Whether a robot that touches anything is taken out of the arena, or stands where it is for the rest."""
    steps: Annotated[int, unit("steps")] = Field(default=1800, ge=1)
    """Steps after which an episode is truncated."""

    @model_validator(mode="after")
    def _swarm_is_possible(self) -> Self:
        if self.randomise != 0.0:
            raise ValueError(f"randomise is for one robot, so it must be 0 in a swarm, got {self.randomise}")
        if unknown := [name for name in self.eyes if name not in self.names]:
            raise ValueError(f"eyes must name robots of {', '.join(self.names)}, got {unknown[0]}")
        return self

    @property
    def names(self) -> tuple[str, ...]:
        """The robots' names: ``robot0`` and so on."""
        return tuple(f"robot{number}" for number in range(self.robots))

    def cameras(self) -> dict[str, CameraConfig]:
        """Make the settings of each robot's camera.

        Returns
        -------
        dict of str to CameraConfig
            The settings by the robot's name, with their noise.
        """
        own = {name: self.eyes.get(name, self.camera) for name in self.names}
        return {name: replace(self, camera=camera, eyes={}).noisy_camera() for name, camera in own.items()}


class Agent(World):
    """One robot of a `Swarm`.

    Attributes
    ----------
    present
        Whether it is in the arena.
    wheels
        The last command, left and right, as shares of the maximum.
    """

    def __init__(self, sim: Simulation, name: str, options: SwarmOptions, model: Model | None) -> None:
        self.name, self.options, self._model = name, options, model
        self._luma, self.present, self.wheels = np.zeros((0, 0), np.uint8), True, (0.0, 0.0)
        self._responses, self._events = [], []
        super().__init__(sim, name)

    @property
    def responses(self) -> list[Response]:
        """Its model's responses since the last reset, or since the last action of an agent."""
        return self._responses

    def restart(self, noise: np.random.Generator) -> None:
        """Begin an episode, after the simulation's reset."""
        self._rest()
        self._film, self.present, self.wheels = noise, True, (0.0, 0.0)
        self._responses, self._events = [], []
        if self._model is not None:
            self._model.reset()

    def command(self, wheels: npt.NDArray[np.float32] | tuple[float, float]) -> None:
        """Command wheel speeds, left and right, as shares of the maximum, until the next call."""
        self.wheels = float(wheels[0]), float(wheels[1])
        fastest = self._observer.config.max_speed_cm_s / 100
        self._command = self.wheels[0] * fastest, self.wheels[1] * fastest

    def _notice_touch(self) -> None:
        """`Swarm` finds the touches of all at once."""


class Swarm:
    """Robots that all see, in one world, advanced one frame at a time.

    Parameters
    ----------
    options
        Their number, bodies, cameras and models.

    Attributes
    ----------
    sim
        The simulation.
    agents
        The robots by name.
    touching
        Pairs of names that touched within the last frame; the wall and obstacles are `WALL`.
    frame
        Number of frames since the reset.
    collisions
        When pairs began to touch: frame and names. They must have parted for `APART` frames to collide once more.
    errors
        Robots whose `Drive` raised -> what it raised.

    Raises
    ------
    ValueError
        The vision model cannot be built, or the arena is refused.
    colias_sim.GLUnavailable
        No OpenGL backend works.
    """

    def __init__(self, options: SwarmOptions) -> None:
        from colias_sim.simulation import Simulation  # late: MuJoCo loads slowly, and listing the envs needs none

        self.options, cameras = options, options.cameras()
        senses = options.observation in ("neural", "both")
        models = {
            name: build_model(options.model, (camera.height, camera.width)) if senses else None
            for name, camera in cameras.items()
        }
        events = options.observation == "events" or any(map(senses_events, models.values()))
        self.sim = Simulation(
            options.robot, cameras[options.names[0]], SceneConfig(arena=options.arena),
            dict.fromkeys(options.names, options.body), fence=True, seeing=options.observation != "state",
            truth=options.truth, eyes=cameras, events=options.events if events else None,
        )  # fmt: skip
        self.agents = {name: Agent(self.sim, name, options, model) for name, model in models.items()}
        self.touching: set[frozenset[str]] = set()
        self.frame, self.collisions, self.errors = 0, list[tuple[int, frozenset[str]]](), dict[str, Exception]()
        self._touched_at: dict[frozenset[str], int] = {}
        model, owners = self.sim.model, np.full(self.sim.model.nbody, WALL, object)
        for name in options.names:
            owners[model.body(f"{name}/base").id] = name
        self._owners = owners[model.body_rootid[model.geom_bodyid]]
        self._hulls = np.zeros(model.ngeom, bool)
        self._hulls[[model.geom(f"{name}/hull").id for name in options.names]] = True

    def reset(self, placements: Mapping[str, Pose], rng: np.random.Generator, episode: int) -> None:
        """Begin an episode, in which the robots stand for a frame.

        Parameters
        ----------
        placements
            The pose of each robot by name.
        rng
            Generator of light and phase, as in `colias_sim.Simulation.reset`.
        episode
            The seed of the cameras' noise: the stream of robot k depends on nothing else.
        """
        self.sim.reset(placements, rng, events=sensor(episode))
        self.frame, self.collisions, self.errors, self._touched_at = 0, [], {}, {}
        for number, agent in enumerate(self.agents.values()):
            agent.restart(film(episode, number))

    def advance(self, look: Collection[str]) -> None:
        """Advance by one frame.

        Parameters
        ----------
        look
            The robots whose frames are exposed, to be developed by each then.
        """
        self.touching = set()
        self.sim.advance(self._drive, look=look)
        self._notice()
        touched = {name for pair in self.touching for name in pair}
        for name, agent in self.agents.items():
            agent._touched = name in touched
            agent._arrive()
        for pair in sorted(self.touching, key=sorted):
            if self.frame - self._touched_at.get(pair, -APART) >= APART:
                self.collisions.append((self.frame, pair))
            self._touched_at[pair] = self.frame
        self.frame += 1

    def play(self, drives: Mapping[str, Drive]) -> None:
        """Advance by one frame; then every robot looks, and is driven on by what it sees.

        A robot whose drive or model raises stands from then on, with the exception in ``errors``. The others go on.

        Parameters
        ----------
        drives
            What drives each robot.
        """
        sees = self.sim.seeing
        well = [name for name in drives if name not in self.errors]
        self.advance(well if sees else ())
        for name in well:
            agent, pose = self.agents[name], self.sim.pose(name)
            gap, left = gap_to_arena(pose, self.sim.obstacles)
            body = Body(self.options.names.index(name), self.frame / FPS, agent._touched, gap, -left)
            try:
                if sees:
                    agent._look(taken=True)
                agent.command(np.clip(drives[name](agent.response, body), -1.0, 1.0))
            except Exception as error:  # of a user's own code
                self.errors[name] = error
                agent.command((0.0, 0.0))

    def remove(self, name: str) -> None:
        """Take a robot out of the arena for the rest of the episode: nobody sees it and nothing touches it."""
        agent = self.agents[name]
        agent.present = False
        agent.command((0.0, 0.0))
        self.sim.robots[name].place(Pose(AWAY_M, self.options.names.index(name) * 0.1, 0.0))

    def _drive(self, dt: float) -> None:
        self._notice()
        for agent in self.agents.values():
            agent._drive(dt)

    def _notice(self) -> None:
        geoms = self.sim.data.contact.geom
        pairs = self._owners[geoms[self._hulls[geoms].any(axis=1)]]
        self.touching.update(frozenset(pair) for pair in pairs.tolist())
