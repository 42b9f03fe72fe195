"""The world of an env, without Gymnasium: an observer that sees, among other robots, advanced one frame at a time."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from colias_sim.envs.geometry import gap_to_arena, gap_to_robot
from colias_sim.envs.options import EnvOptions
from colias_sim.envs.scripted import Driver
from colias_sim.envs.senses import Model, Response, neural_observation, senses_events
from colias_sim.envs.state import Other, State
from colias_sim.events import Events, event_counts, joined
from colias_sim.pose import Pose

if TYPE_CHECKING:
    from colias_sim.simulation import Simulation

OBSERVER, TARGET = "observer", "target"
"""Names of the robot that the agent drives, and of the target robot in some tasks."""


class World:
    """The observer among other robots. `ColiasEnv` adds rewards and Gymnasium's contract, an `Agent` a policy's needs.

    Parameters
    ----------
    sim
        The simulation.
    name
        Name of the robot that is the observer.
    """

    options: EnvOptions
    _model: Model | None
    _luma: npt.NDArray[np.uint8]
    _responses: list[Response]
    _events: list[Events]
    _film: np.random.Generator

    def __init__(self, sim: Simulation, name: str) -> None:
        self._sim, self._observer = sim, sim.robots[name]
        self._hull = sim.model.geom(f"{name}/hull").id
        self._rest()

    # A subclass may disturb the world.

    def _disturb(self, dt: float) -> float:
        """Disturb drum and robot for ``dt`` seconds; return the disturbance's own turn rate of the view, in rad/s."""
        return 0.0

    def _wall_rate(self) -> float:
        """Return the rate at which the wall turns, in rad/s, left positive."""
        return 0.0

    def _measures(self) -> dict[str, Any]:
        """Compute the entries of ``info`` that only this env has.

        Returns
        -------
        dict
            Name -> value; names end in their units.
        """
        return {}

    # Read-only views, for rewards, recordings and baselines.

    @property
    def luma(self) -> npt.NDArray[np.uint8]:
        """The last frame, (R, C) uint8, read-only; zeros with ``observation="state"``."""
        return self._luma

    @property
    def model(self) -> Model | None:
        """The vision model of neural observations; ``None`` with other observations."""
        return self._model

    @property
    def response(self) -> Response | None:
        """The vision model's response to the last frame; ``None`` without a model."""
        return self._responses[-1] if self._responses else None

    @property
    def events(self) -> Events:
        """The events of the last step, (N,) of ``colias_sim.events.EVENT``; none without an event camera."""
        return joined(self._events)

    @property
    def poses(self) -> dict[str, Pose]:
        """The pose of every robot, by name."""
        return self._sim.poses

    @property
    def state(self) -> State:
        """The state of the world, in SI units, with any observation."""
        here, (vx, vy) = self._here, self._observer.velocity
        cos, sin = math.cos(here.heading), math.sin(here.heading)
        seen = []
        for name, robot in self._sim.everyone.items():
            if name == self._observer.name:
                continue
            gap, direction = gap_to_robot(here, robot.pose)
            ux, uy = robot.velocity
            du, dv = ux - vx, uy - vy
            seen.append((name != TARGET, Other(gap, -direction, du * cos + dv * sin, dv * cos - du * sin)))
        seen.sort(key=lambda entry: (entry[0], entry[1].distance))
        gap, direction = gap_to_arena(here, self._sim.obstacles)
        return State(
            vx * cos + vy * sin, self.turn_rate, self.slip, self._drift, gap, -direction,
            tuple(other for _, other in seen), self._observer.config.full_turn,
        )  # fmt: skip

    @property
    def speed(self) -> float:
        """The observer's speed along its heading, in m/s."""
        heading, (vx, vy) = self._here.heading, self._observer.velocity
        return vx * math.cos(heading) + vy * math.sin(heading)

    @property
    def turn_rate(self) -> float:
        """The turn rate of the observer's body, in rad/s, left positive."""
        return self._observer.turn_rate

    @property
    def slip(self) -> float:
        """The observer's turn rate relative to the wall, in rad/s, left positive."""
        return self.turn_rate - self._wall_rate()

    # Private.

    def _look(self, taken: bool) -> None:
        """Develop the camera's frame that ends now; the model responds to it, or to events, if it is ``taken``."""
        self._luma = self._sim.camera(self._observer.name).develop(self._film, self._sim.data.time).luma
        if taken and self._sim.event_camera:
            self._events.append(self._sim.event_camera.take())
        if taken and self._model is not None:
            self._responses.append(self._model.step(self._events[-1] if senses_events(self._model) else self._luma))

    def _observation(self) -> Any:
        match self.options.observation:
            case "state":
                return self.state.vector()
            case "neural":
                return neural_observation(self._responses)
            case "events":
                return event_counts(self.events, self._luma.shape)
        pixels = self._luma[..., None].copy()  # a copy that the agent may modify
        if self.options.observation == "pixels":
            return pixels
        return {"pixels": pixels, "neural": neural_observation(self._responses)}

    def _info(self, terms: Mapping[str, float]) -> dict[str, Any]:
        """Collect the reward's terms as ``reward_...``, and the measures, whose names end in their units."""
        rewards = {f"reward_{name}": value for name, value in terms.items()}
        return {**rewards, **self._motion(), **self._measures(), **self._true_motion()}

    def _true_motion(self) -> dict[str, float]:
        """Summarise what truly moved in the last frame: the robots that drive, or the wall where none does."""
        if not self.options.truth:
            return {}
        truth = self._sim.truth(robot=self._observer.name)
        return truth.columns(set(self._sim.robots) - {self._observer.name} or {"wall"})

    def _motion(self) -> dict[str, float | bool]:
        """Compute the observer's motion for every env's ``info``; names end in their units."""
        pose = self._here
        return {
            "x_cm": 100 * pose.x, "y_cm": 100 * pose.y, "heading_deg": math.degrees(pose.heading),
            "driven_cm": 100 * self._driven, "turn_deg_s": math.degrees(self.turn_rate),
            "slip_deg_s": math.degrees(self.slip), "drift_deg_s": math.degrees(self._drift),
            "touched": self._touched,
        }  # fmt: skip

    def _rest(self) -> None:
        """Reset the episode's state to its state before the first episode; the simulation does not change."""
        self._command = 0.0, 0.0
        self._delay(0.0)
        self._drivers: Mapping[str, Driver] = {}
        self._drift = self._driven = 0.0
        self._touched = False
        self._here = self._observer.pose

    def _delay(self, latency: float) -> None:
        """Delay commands by ``latency`` seconds, rounded to control intervals."""
        intervals = round(latency / self._sim.command_interval)
        self._sent = deque([self._command] * intervals)

    def _advance(self, look: bool) -> None:
        """Advance by one frame; with ``look``, expose the camera. Add up the distance driven, and detect touches."""
        self._sim.advance(self._drive, look=look)
        self._arrive()

    def _arrive(self) -> None:
        """Note pose, touch and distance driven at the end of a frame."""
        before = self._here
        self._notice_touch()
        self._here = self._observer.pose
        self._driven += math.hypot(self._here.x - before.x, self._here.y - before.y)

    def _drive(self, dt: float) -> None:
        """Command the wheels of all robots, and disturb the world, for a control interval of ``dt`` seconds."""
        self._notice_touch()
        self._sent.append(self._command)
        self._observer.ease(self._sent.popleft(), dt)
        poses = self.poses if self._drivers else {}
        for name, driver in self._drivers.items():
            self._sim.robots[name].ease(driver.wheels(dt, poses), dt)
        self._drift = self._disturb(dt)

    def _notice_touch(self) -> None:
        if not self._touched:
            self._touched = self._hull in self._sim.data.contact.geom.ravel().tolist()


def parked_robots(count: int) -> dict[str, str]:
    """Make ``count`` parked robots: name -> variant."""
    return {f"parked{i}": "colias_parked" for i in range(1, count + 1)}
