"""A running simulation: physics, and robots with their cameras, advanced one frame at a time."""

from __future__ import annotations

import copy
import math
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import replace
from functools import lru_cache
from itertools import combinations, groupby, pairwise, product
from types import TracebackType
from typing import Any

import mujoco
import numpy as np
from pydantic import validate_call

from colias_sim.camera import Camera, Frame, cameras
from colias_sim.config import CameraConfig, EventConfig, RobotConfig, SceneConfig
from colias_sim.event_camera import EventCamera
from colias_sim.exposure import Render
from colias_sim.obstacles import obstacles
from colias_sim.pose import Pose
from colias_sim.robot import ParkedRobot, Robot
from colias_sim.scene import compile_model, steps_per_command, steps_per_frame, timestep
from colias_sim.snapshot import PARTS, SCENE
from colias_sim.truth import Moment, Picture, Truth
from dsnn.snapshot import pack, put, take, unpack

SETTLE_STEPS = 150
"""Physics steps for robots to settle on their wheels at a reset."""
ROBOT_DIAMETER = 0.04
"""Diameter of a hull, in metres."""

INTEGRATION = mujoco.mjtState.mjSTATE_INTEGRATION
"""All of MuJoCo's state that its next step depends on."""
VALUES = Frame, Pose, CameraConfig, Moment, Picture

Control = Callable[[float], None]
"""A controller. It is called before each control interval with its length in seconds, and calls `Robot.drive`."""

TRIAL_ROBOTS = {"observer": "colias", "stimulus": "colias_black"}
"""The robots of a trial: name -> variant."""


class Simulation:
    """A compiled scene with its robots, any of which may see. Use it in a ``with`` statement, or close it.

    Only `reset` and `step` draw random numbers, and only from the generators that you pass. So equal seeds give equal
    frames, in any process of a machine and after any number of earlier trials.

    The attribute ``robots`` holds the driving robots by name, ``parked`` the fixed ones, and ``everyone`` both.
    ``cameras`` holds the camera of each robot that sees, by the robot's name. ``obstacles`` lists the obstacles of the
    arena. ``command_interval`` is the time between two commands, in seconds. ``event_camera`` is that of ``events``.

    Parameters
    ----------
    robot, camera, scene
        The settings of the apparatus, or dictionaries of them; ``None`` for the defaults.
    robots
        Name -> variant of each robot, from `scenes.ROBOTS`. ``None`` for a trial's robots: ``observer``, a ``colias``,
        and ``stimulus``, a ``colias_black``.
    eye_of
        Name of the robot that sees, and whose frame `step` returns. It drives.
    fence
        Whether robots collide with the wall.
    seeing
        Whether there is a camera. Without one nothing is rendered, and only `advance` moves the simulation forward.
    truth
        Whether to remember the last frames for `truth`. It changes no frame.
    eyes
        Names of the robots that see, if these are several, or name -> settings of their cameras. All have one frame
        rate. `step` returns the frame of ``eye_of``, or of the first if that is none of them.
    events
        The settings of an event camera in the place of that of ``eye_of``, or a dictionary of them; ``None``: there is
        none. It changes no frame. With it at most one robot sees.

    Raises
    ------
    ValueError
        The arena or a variant is unknown, the arena is refused, a robot that is to see is none of the driving ones, or
        cameras differ in their frame rates.
    colias_sim.GLUnavailable
        No OpenGL backend works, unless ``seeing`` is false.

    Examples
    --------
    >>> import numpy as np
    >>> from colias_sim import Pose, Simulation
    >>> rng = np.random.default_rng(0)
    >>> with Simulation() as simulation:
    ...     simulation.reset({"observer": Pose(0.0, 0.0, 0.0), "stimulus": Pose(0.15, 0.0, 0.0)}, rng)
    ...     frame = simulation.step(rng)
    >>> frame.luma.shape
    (72, 99)
    """

    @validate_call
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
        truth: bool = False,
        eyes: Mapping[str, CameraConfig] | Sequence[str] | None = None,
        events: EventConfig | None = None,
    ) -> None:
        robot, camera, self.scene = robot or RobotConfig(), camera or CameraConfig(), scene or SceneConfig()
        named = (eye_of,) if eyes is None else eyes
        seen_by = {name: named[name] if isinstance(named, Mapping) else camera for name in named} if seeing else {}
        self.eye_of = eye_of if not seen_by or eye_of in seen_by else next(iter(seen_by))
        self.camera_config = camera = seen_by.get(self.eye_of, camera)
        if any(other.fps != camera.fps for other in seen_by.values()):
            rates = ", ".join(f"{name} {other.fps:g}" for name, other in seen_by.items())
            raise ValueError(f"eyes must have one frame rate, as frames end together, got {rates}")
        variants = dict(TRIAL_ROBOTS if robots is None else robots)
        self._robot, self._variants = robot, variants
        self._bind(compile_model(self.scene, robot, camera, variants, fence=fence, eyes=seen_by))
        self.obstacles = obstacles(self.model)
        self.frame_interval = 1.0 / camera.fps
        self._steps, self._command_steps = steps_per_frame(camera.fps), steps_per_command(camera.fps)
        self.command_interval = self._command_steps * timestep(camera.fps)
        self._lamps = self.model.light_ambient.copy(), self.model.light_diffuse.copy()
        self.wall_turn = 0.0
        if blind := next((name for name in seen_by if name not in self.robots), None):
            what = "eye_of" if eyes is None else "eyes"
            raise ValueError(f"{what} must be one of {', '.join(self.robots)}, got {blind}")
        if events is not None and len(seen_by) > 1:
            raise ValueError(f"eyes must be one robot where there is an event camera, got {', '.join(seen_by)}")
        self.cameras = cameras(self.model, seen_by, truth=truth)
        self.event_camera = None if events is None else EventCamera(self.model, f"{self.eye_of}/eye", camera, events)
        settings = (self.scene, robot, seen_by or camera, variants, self.eye_of, fence, truth, self.model.signature)
        self._kind = "Simulation", repr(settings)

    def _bind(self, model: mujoco.MjModel) -> None:
        """Find everything in a model, with new data."""
        self.model, self.data = model, mujoco.MjData(model)
        parked = {name for name in self._variants if model.body(f"{name}/base").jntnum[0] == 0}
        moving = [name for name in self._variants if name not in parked]
        self.robots = {name: Robot(model, self.data, name, self._robot) for name in moving}
        self.parked = {name: ParkedRobot(model, name) for name in self._variants if name in parked}
        self.everyone: dict[str, Robot | ParkedRobot] = {**self.robots, **self.parked}
        self._queuing = tuple(robot for robot in self.robots.values() if robot.queues)
        self._wall_quat = model.body("wall").quat

    def __enter__(self) -> Simulation:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self.close()

    @property
    def seeing(self) -> bool:
        """Whether a robot has a camera."""
        return bool(self.cameras)

    def camera(self, name: str) -> Camera:
        """Return the camera of a robot.

        Parameters
        ----------
        name
            Name of the robot.

        Returns
        -------
        Camera
            Its camera, one of ``cameras``.

        Raises
        ------
        ValueError
            The robot does not see.
        """
        if name not in self.cameras:
            raise ValueError(f"{name} has no camera: make the Simulation with eyes=('{name}',), seeing=True")
        return self.cameras[name]

    def pose(self, name: str) -> Pose:
        """Return the pose of a robot.

        Parameters
        ----------
        name
            Name of the robot.

        Returns
        -------
        Pose
            The pose of its centre.

        Raises
        ------
        KeyError
            The scene has no robot of that name.
        """
        return self.everyone[name].pose

    @property
    def poses(self) -> dict[str, Pose]:
        """The pose of every robot, by name."""
        return {name: robot.pose for name, robot in self.everyone.items()}

    def close(self) -> None:
        """Free the cameras' OpenGL contexts."""
        for camera in self.cameras.values():
            camera.close()
        if self.event_camera is not None:
            self.event_camera.close()

    def get_state(self) -> bytes:
        """Save everything that goes on, between two frames.

        Returns
        -------
        bytes
            The state, for `set_state` of a simulation with the same settings, in any process. It has physics, light,
            the wall, motors with their queues, and cameras with their exposure. Generators and controllers are yours.

        Raises
        ------
        ValueError
            There is an event camera.
        """
        if self.event_camera is not None:
            raise ValueError("a simulation with an event camera cannot be saved: make it without events")
        physics = np.empty(mujoco.mj_stateSize(self.model, INTEGRATION.value))
        mujoco.mj_getState(self.model, self.data, physics, INTEGRATION.value)
        scene = {name: getattr(self.model, name) for name in SCENE}
        return pack(self._kind, {"physics": physics, "scene": scene, **take(self, PARTS, VALUES)})

    def set_state(self, state: bytes) -> None:
        """Restore a state: what follows is equal to the bit, if generators and controllers are restored too.

        Contacts are empty until the next step.

        Parameters
        ----------
        state
            The bytes that `get_state` returned.

        Raises
        ------
        ValueError
            The bytes are no state, are damaged, or are of a simulation with other settings. The simulation is then
            unchanged.
        """
        self._restore(self._read(state))

    def copy(self) -> Simulation:
        """Make a twin in this process, which goes on from here on its own.

        Returns
        -------
        Simulation
            The twin. It shares the OpenGL context, which is freed when both are closed: use both in one thread.
        """
        twin = copy.copy(self)
        twin._bind(copy.copy(self.model))
        twins = {one: one.copy(twin.model) for one in {camera.offscreen for camera in self.cameras.values()}}
        twin.cameras = {name: camera.copy(twin.model, twins[camera.offscreen]) for name, camera in self.cameras.items()}
        twin.set_state(self.get_state())
        return twin

    def _read(self, state: bytes) -> dict[str, Any]:
        return unpack(state, self._kind, VALUES)

    def _restore(self, tree: dict[str, Any]) -> None:
        for name, values in tree.pop("scene").items():
            getattr(self.model, name)[:] = values
        for name, camera in self.cameras.items():
            camera.tune(tree["cameras"][name]["config"])
        mujoco.mj_resetData(self.model, self.data)  # contacts of another time, too
        mujoco.mj_setState(self.model, self.data, tree.pop("physics"), INTEGRATION.value)
        mujoco.mj_kinematics(self.model, self.data)
        put(self, tree, PARTS)

    def reset(
        self, placements: Mapping[str, Pose], rng: np.random.Generator, *, light: float = 1.0,
        events: np.random.Generator | None = None,
    ) -> None:  # fmt: skip
        """Start a trial: place every robot at rest, and draw the light and the wall's phase.

        Parameters
        ----------
        placements
            The pose of each robot by name. A robot without an entry stands at the origin.
        rng
            Generator of light and phase, and of the robots' draws in `Robot.restart`.
        light
            A factor on the light of the lamps, in addition to the scene's.
        events
            Generator of the event camera's thresholds and noise; ``None``: one that ``rng`` spawns.

        Raises
        ------
        ValueError
            A robot is unknown, a pose is not finite, robots overlap, or one stands in an obstacle. The simulation is
            then unchanged.
        """
        self._check(placements)
        mujoco.mj_resetData(self.model, self.data)  # in full: state that a solver keeps would change the next trial
        # Both are always drawn, so that switching one off does not change the other.
        light *= self.scene.light * max(1.0 + self.scene.light_sd * rng.standard_normal(), 0.0)
        phase = rng.uniform(0.0, 2 * np.pi)
        self.model.light_ambient[:], self.model.light_diffuse[:] = (lamp * light for lamp in self._lamps)
        self.turn_wall(phase if self.scene.turn_wall else 0.0)
        for name, pose in placements.items():
            self.everyone[name].place(pose)
        for robot in self.robots.values():
            robot.restart(rng)
        self._settle()
        for camera in self.cameras.values():
            camera.restart(self.data)
        if self.event_camera is not None:
            self.event_camera.restart(self.data, events or rng.spawn(1)[0])

    def turn_wall(self, angle: float) -> None:
        """Turn the wall with its texture about the arena's middle.

        Parameters
        ----------
        angle
            The new angle, in radians, left positive.
        """
        self.wall_turn = angle
        self._wall_quat[:] = math.cos(angle / 2), 0.0, 0.0, math.sin(angle / 2)

    def _check(self, placements: Mapping[str, Pose]) -> None:
        """Raise ``ValueError`` for poses that `reset` refuses."""
        for name, pose in placements.items():
            if name not in self.everyone:
                raise ValueError(f"no robot '{name}' in this scene: known are {', '.join(self.everyone)}")
            if not all(map(math.isfinite, (pose.x, pose.y, pose.heading))):
                raise ValueError(f"{name} must be placed at finite numbers, got {pose}")
        places = [(name, placements.get(name, Pose(0.0, 0.0, 0.0))) for name in self.everyone]
        for (one, here), (other, there) in combinations(places, 2):
            if math.hypot(here.x - there.x, here.y - there.y) < ROBOT_DIAMETER:
                raise ValueError(f"{one} at {here} and {other} at {there} must be {ROBOT_DIAMETER} m apart")
        for (name, pose), obstacle in product(places, self.obstacles):
            if obstacle.nearest(pose.x, pose.y)[0] < ROBOT_DIAMETER / 2:
                raise ValueError(
                    f"{name} at ({100 * pose.x:.3g}, {100 * pose.y:.3g}) cm stands in the obstacle {obstacle.name}"
                    f" of the arena {self.scene.arena}"
                )

    def _settle(self) -> None:
        """Let the robots sink onto their wheels by some microns, so that no camera sees this motion."""
        mujoco.mj_step(self.model, self.data, SETTLE_STEPS)
        self.data.time = 0.0
        mujoco.mj_forward(self.model, self.data)

    def step(self, rng: np.random.Generator, control: Control | None = None) -> Frame:
        """Advance by one frame, and return what the robot ``eye_of`` sees.

        Parameters
        ----------
        rng
            Generator of the camera's noise, of dropped frames and of jitter.
        control
            The controller; ``None`` leaves all commands as they are.

        Returns
        -------
        Frame
            The frame that ends now.

        Raises
        ------
        ValueError
            The simulation was made with ``seeing=False``.
        """
        self.advance(control)
        return self.camera(self.eye_of).develop(rng, self.data.time)

    def step_all(
        self, rngs: Mapping[str, np.random.Generator], control: Control | None = None
    ) -> dict[str, Frame]:  # fmt: skip
        """Advance by one frame, and return what several robots see.

        Parameters
        ----------
        rngs
            Name of a robot -> generator of its camera's noise, of its dropped frames and its jitter. Other cameras
            discard this frame without drawing it.
        control
            The controller; ``None`` leaves all commands as they are.

        Returns
        -------
        dict of str to Frame
            The frames that end now, by the names in ``rngs``.

        Raises
        ------
        ValueError
            A robot does not see.
        """
        self.advance(control, look=rngs.keys())
        return {name: self.camera(name).develop(rng, self.data.time) for name, rng in rngs.items()}

    def truth(self, since: int = 1, robot: str | None = None) -> Truth:
        """Return what each pixel of a robot's last frame truly shows.

        Parameters
        ----------
        since
            How many frames ago the frame before it was, 1 to 6.
        robot
            Name of the robot; ``None`` for ``eye_of``.

        Returns
        -------
        Truth
            Flow, depth and surface of each pixel.

        Raises
        ------
        ValueError
            ``since`` is out of range, the robot does not see, or the simulation was made without ``truth=True``.
        """
        rays = self.camera(robot or self.eye_of).rays
        if rays is None:
            raise ValueError("this simulation remembers no truth: make the Simulation with truth=True")
        return rays.truth(since)

    def advance(self, control: Control | None = None, *, look: bool | Collection[str] = True) -> None:
        """Advance by one frame without developing it; call ``develop`` of a camera for its frame.

        Parameters
        ----------
        control
            The controller; ``None`` leaves all commands as they are.
        look
            Whether to render, or the names of the robots for which to. The physics are the same either way.
        """
        looking = self.cameras.keys() & look if isinstance(look, Collection) else self.cameras if look else ()
        due = tuple(
            (name, one.renders if name in looking or one.rays else (), one.next_renders)
            for name, one in self.cameras.items()
        )
        for steps, command, renders in _events(self._steps, self._command_steps, due):
            if command and control is not None:
                control(self.command_interval)
            if command:
                for robot in self._queuing:
                    robot.tick()
            for part in [steps] if self.event_camera is None else [1] * steps:
                mujoco.mj_step(self.model, self.data, part)
                if self.event_camera is not None:
                    self.event_camera.see(self.data)
            if renders:
                mujoco.mj_kinematics(self.model, self.data)  # a step leaves these one step behind
                mujoco.mj_camlight(self.model, self.data)
                for name, render in renders:
                    camera = self.cameras[name]
                    if name in looking or render.ahead:
                        camera.expose(self.data, render)
                    if camera.rays is not None:
                        camera.rays.note(self.data, render)
        for name, camera in self.cameras.items():
            camera.collect()
            if name not in looking:
                camera.skip()


@lru_cache(maxsize=512)
def _events(
    frame: int, command: int, due: tuple[tuple[str, tuple[Render, ...], tuple[Render, ...]], ...]
) -> tuple[tuple[int, bool, tuple[tuple[str, Render], ...]], ...]:
    """Divide a frame into parts: (physics steps, whether a command precedes them, renders after them, by robot).

    ``frame`` and ``command`` are the physics steps in a frame, and between two commands. For each robot that sees, its
    name, the renders of its frame, and those of the next frame, some of which are ``due`` within this one.
    """
    commands = range(0, frame, command)
    renders: list[tuple[str, Render]] = []
    for name, now, following in due:
        renders += [(name, render) for render in now if render.step >= 1]
        ahead = (replace(render, step=render.step + frame, ahead=True) for render in following if render.step < 1)
        renders += [(name, render) for render in ahead]
    renders.sort(key=lambda one: one[1].step)
    after = {step: tuple(group) for step, group in groupby(renders, key=lambda one: one[1].step)}
    marks = sorted({*commands, *after, frame})
    return tuple((end - start, start in commands, after.get(end, ())) for start, end in pairwise(marks))
