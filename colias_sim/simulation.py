"""The running bench: physics, robots, and the observer's camera, one frame at a time."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from itertools import combinations, pairwise
from types import TracebackType

import mujoco
import numpy as np

from colias_sim.camera import Camera, Frame, exposure_steps
from colias_sim.config import CameraConfig, RobotConfig, SceneConfig
from colias_sim.robot import Pose, Robot
from colias_sim.scene import FrameClock, compile_model

SETTLE_STEPS = 150
ROBOT_DIAMETER = 0.04

Control = Callable[[float], None]
"""Called before each control interval with its length in seconds; commands wheels through `Robot.drive`."""

TRIAL_ROBOTS = {"observer": "colias", "stimulus": "colias_black"}


class Simulation:
    """One compiled scene with its robots and the camera of ``eye_of``; use it in a ``with`` statement.

    Nothing random happens outside `reset` and `step`, and both draw only from the generators they are given,
    so equal seeds give equal frames, in any process and after any number of earlier trials.
    """

    def __init__(
        self,
        robot: RobotConfig | None = None,
        camera: CameraConfig | None = None,
        scene: SceneConfig | None = None,
        robots: Mapping[str, str] | None = None,
        eye_of: str = "observer",
    ) -> None:
        robot, camera, self.scene = robot or RobotConfig(), camera or CameraConfig(), scene or SceneConfig()
        robots = dict(TRIAL_ROBOTS if robots is None else robots)
        self.model = compile_model(self.scene, robot, camera, robots, eye_of)
        self.data = mujoco.MjData(self.model)
        self.robots = {name: Robot(self.model, self.data, name, robot) for name in robots}
        self.frame_interval = 1.0 / camera.fps
        clock = FrameClock(camera.fps)
        self._command_interval = clock.command_steps * clock.timestep
        self._events = _events(clock, exposure_steps(camera, clock.steps))
        self._lamps = self.model.light_ambient.copy(), self.model.light_diffuse.copy()
        self.camera = Camera(self.model, f"{eye_of}/eye", camera)

    def __enter__(self) -> Simulation:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self.close()

    def close(self) -> None:
        """Free the renderer."""
        self.camera.close()

    def reset(self, placements: Mapping[str, Pose], rng: np.random.Generator) -> None:
        """Start anew: every robot at rest where ``placements`` says, light and wall drawn from ``rng``.

        A robot that ``placements`` leaves out stands at the origin. Raises ``ValueError`` for an unknown robot,
        a pose that is not finite, and robots that overlap; nothing has changed then.
        """
        self._check(placements)
        mujoco.mj_resetData(self.model, self.data)  # in full: what a solver kept would change the next trial
        # Both are always drawn, so switching one off leaves the other as it was.
        light = self.scene.light * max(1.0 + self.scene.light_sd * rng.standard_normal(), 0.0)
        phase = rng.uniform(0.0, 2 * np.pi)
        self.model.light_ambient[:], self.model.light_diffuse[:] = (lamp * light for lamp in self._lamps)
        turn = phase if self.scene.turn_wall else 0.0
        self.model.body("wall").quat = [np.cos(turn / 2), 0.0, 0.0, np.sin(turn / 2)]
        for name, pose in placements.items():
            self.robots[name].place(pose)
        self._settle()
        self.camera.discard()

    def _check(self, placements: Mapping[str, Pose]) -> None:
        """Raise ``ValueError`` for a robot that is not there, a pose that is no pose, and robots inside each other."""
        for name, pose in placements.items():
            if name not in self.robots:
                raise ValueError(f"no robot '{name}' in this scene: there are {', '.join(self.robots)}")
            if not all(map(math.isfinite, (pose.x, pose.y, pose.heading))):
                raise ValueError(f"{name} is placed at {pose}: expected finite numbers")
        places = [(name, placements.get(name, Pose(0.0, 0.0, 0.0))) for name in self.robots]
        for (one, here), (other, there) in combinations(places, 2):
            if math.hypot(here.x - there.x, here.y - there.y) < ROBOT_DIAMETER:
                raise ValueError(f"{one} at {here} and {other} at {there} overlap: expected {ROBOT_DIAMETER} m apart")

    def _settle(self) -> None:
        """Let the robots sink onto their wheels: some microns, which a camera would see as motion of everything."""
        mujoco.mj_step(self.model, self.data, SETTLE_STEPS)
        self.data.time = 0.0
        mujoco.mj_forward(self.model, self.data)

    def step(self, rng: np.random.Generator, control: Control | None = None) -> Frame:
        """Advance one frame interval under ``control`` and return the frame; its noise comes from ``rng``."""
        self.advance(control)
        return self.camera.develop(rng, self.data.time)

    def advance(self, control: Control | None = None) -> None:
        """The physics and renders of one frame, which leave the exposure ready to develop."""
        for steps, command, parts in self._events:
            if command and control is not None:
                control(self._command_interval)
            mujoco.mj_step(self.model, self.data, steps)
            if parts:
                mujoco.mj_kinematics(self.model, self.data)  # a step leaves these one step behind
                mujoco.mj_camlight(self.model, self.data)
                self.camera.expose(self.data, parts)


def _events(clock: FrameClock, exposures: tuple[int, ...]) -> list[tuple[int, bool, int]]:
    """A frame's run of (physics steps, command before them?, parts of the exposure that end with them)."""
    commands = range(0, clock.steps, clock.command_steps)
    marks = sorted({*commands, *exposures, clock.steps})
    return [(end - start, start in commands, exposures.count(end)) for start, end in pairwise(marks)]
