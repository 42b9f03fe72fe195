"""Several robots that all see, in one world, advanced frame by frame."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, Literal, Self

import numpy as np
import numpy.typing as npt
from pydantic import Field, model_validator
from pydantic.dataclasses import dataclass

from colias_sim.config import CameraConfig, SceneConfig
from colias_sim.envs.options import STRICT, CameraSettings, EnvOptions
from colias_sim.envs.senses import Model, build_model, senses_events
from colias_sim.envs.world import World
from colias_sim.pose import Pose
from colias_sim.streams import film, sensor
from dsnn.field_docs import unit, with_field_docs

if TYPE_CHECKING:
    from colias_sim.simulation import Simulation

AWAY_M = 10.0
"""Distance from the arena's middle at which robots stand that have left it."""


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
    """One robot of a `Swarm`."""

    def __init__(self, sim: Simulation, name: str, options: SwarmOptions, model: Model | None) -> None:
        self.options, self._model = options, model
        self._luma = np.zeros((0, 0), np.uint8)
        super().__init__(sim, name)

    def restart(self, noise: np.random.Generator) -> None:
        """Begin an episode, after the simulation's reset."""
        self._rest()
        self._film = noise
        if self._model is not None:
            self._model.reset()
        self.command((0.0, 0.0))

    def command(self, wheels: npt.NDArray[np.float32] | tuple[float, float]) -> None:
        """Begin a step: command wheel speeds, left and right, as shares of the maximum, until the next call."""
        fastest = self._observer.config.max_speed_cm_s / 100
        self._command = float(wheels[0]) * fastest, float(wheels[1]) * fastest
        self._responses, self._events, self._driven = [], [], 0.0


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

    def reset(self, placements: Mapping[str, Pose], rng: np.random.Generator, episode: int) -> None:
        """Begin an episode.

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
        for number, agent in enumerate(self.agents.values()):
            agent.restart(film(episode, number))

    def advance(self, look: Collection[str], *, taken: bool = True) -> None:
        """Advance by one frame.

        Parameters
        ----------
        look
            The robots that look, if they have cameras.
        taken
            Whether their models take this frame.
        """
        self.sim.advance(self._drive, look=look)
        for agent in self.agents.values():
            agent._arrive()
        for name in look if self.sim.seeing else ():
            self.agents[name]._look(taken)

    def remove(self, name: str) -> None:
        """Take a robot out of the arena for the rest of the episode: nobody sees it and nothing touches it."""
        self.sim.robots[name].place(Pose(AWAY_M, self.options.names.index(name) * 0.1, 0.0))

    def _drive(self, dt: float) -> None:
        for agent in self.agents.values():
            agent._drive(dt)
