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
from colias_sim.robot import Parked, Pose, Robot
from colias_sim.scene import FrameClock, compile_model

SETTLE_STEPS = 150
ROBOT_DIAMETER = 0.04

Control = Callable[[float], None]
"""Called before each control interval with its length in seconds; commands wheels through `Robot.drive`."""

TRIAL_ROBOTS = {"observer": "colias", "stimulus": "colias_black"}


class Simulation:
    """One compiled scene with its robots and the camera of ``eye_of``; use it in a ``with`` statement.

    ``robots`` holds those that drive, ``parked`` those that cannot, ``everyone`` both. With ``fence`` the wall can be
    bumped into. With ``seeing=False`` nothing is ever rendered, and `advance` alone moves it on.

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
        *,
        fence: bool = False,
        seeing: bool = True,
    ) -> None:
        robot, camera, self.scene = robot or RobotConfig(), camera or CameraConfig(), scene or SceneConfig()
        self.camera_config = camera
        variants = dict(TRIAL_ROBOTS if robots is None else robots)
        self.model = compile_model(self.scene, robot, camera, variants, eye_of, fence=fence)
        self.data = mujoco.MjData(self.model)
        parked = {name for name in variants if self.model.body(f"{name}/base").jntnum[0] == 0}
        self.robots = {name: Robot(self.model, self.data, name, robot) for name in variants if name not in parked}
        self.parked = {name: Parked(self.model, name) for name in variants if name in parked}
        self.everyone: dict[str, Robot | Parked] = {**self.robots, **self.parked}
        self.frame_interval = 1.0 / camera.fps
        clock = FrameClock(camera.fps)
        self._command_interval = clock.command_steps * clock.timestep
        self._events = _events(clock, exposure_steps(camera, clock.steps))
        self._unseen = _events(clock, ())
        self._lamps = self.model.light_ambient.copy(), self.model.light_diffuse.copy()
        self._wall_quat = self.model.body("wall").quat
        self.wall_turn = 0.0
        self._camera = Camera(self.model, f"{eye_of}/eye", camera) if seeing else None

    def __enter__(self) -> Simulation:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self.close()

    @property
    def camera(self) -> Camera:
        """The camera; ``ValueError`` in a simulation that does not see."""
        if self._camera is None:
            raise ValueError("this simulation was made with seeing=False: it has no camera")
        return self._camera

    def close(self) -> None:
        """Free the renderer."""
        if self._camera is not None:
            self._camera.close()

    def reset(self, placements: Mapping[str, Pose], rng: np.random.Generator, *, light: float = 1.0) -> None:
        """Start anew: every robot at rest where ``placements`` says, light and wall drawn from ``rng``.

        ``light`` is a factor on the lamps beside the scene's own.

        A robot that ``placements`` leaves out stands at the origin. Raises ``ValueError`` for an unknown robot,
        a pose that is not finite, and robots that overlap; nothing has changed then.
        """
        self._check(placements)
        mujoco.mj_resetData(self.model, self.data)  # in full: what a solver kept would change the next trial
        # Both are always drawn, so switching one off leaves the other as it was.
        light *= self.scene.light * max(1.0 + self.scene.light_sd * rng.standard_normal(), 0.0)
        phase = rng.uniform(0.0, 2 * np.pi)
        self.model.light_ambient[:], self.model.light_diffuse[:] = (lamp * light for lamp in self._lamps)
        self.turn_wall(phase if self.scene.turn_wall else 0.0)
        for name, pose in placements.items():
            self.everyone[name].place(pose)
        self._settle()
        if self._camera is not None:
            self._camera.discard()

    def turn_wall(self, angle: float) -> None:
        """Turn the wall, what is on it with it, to ``angle`` radians about the arena's middle, left positive."""
        self.wall_turn = angle
        self._wall_quat[:] = math.cos(angle / 2), 0.0, 0.0, math.sin(angle / 2)

    def _check(self, placements: Mapping[str, Pose]) -> None:
        """Raise ``ValueError`` for a robot that is not there, a pose that is no pose, and robots inside each other."""
        everyone = self.everyone
        for name, pose in placements.items():
            if name not in everyone:
                raise ValueError(f"no robot '{name}' in this scene: there are {', '.join(everyone)}")
            if not all(map(math.isfinite, (pose.x, pose.y, pose.heading))):
                raise ValueError(f"{name} is placed at {pose}: expected finite numbers")
        places = [(name, placements.get(name, Pose(0.0, 0.0, 0.0))) for name in everyone]
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

    def advance(self, control: Control | None = None, *, look: bool = True) -> None:
        """The physics and renders of one frame, which leave the exposure ready to develop; no renders if not ``look``.

        Looking changes nothing of what happens.
        """
        for steps, command, parts in self._events if look and self._camera is not None else self._unseen:
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
