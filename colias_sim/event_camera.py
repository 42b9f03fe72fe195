"""An event camera in the place of a robot's camera: draws the light between frames, and finds its events."""

from __future__ import annotations

from dataclasses import replace

import mujoco
import numpy as np

from colias_sim.config import CameraConfig, EventConfig
from colias_sim.events import EventPixels, Events, Light
from colias_sim.offscreen import Offscreen
from colias_sim.scene import steps_per_command
from colias_sim.sensor import Sensor, render_shape


class EventCamera:
    """An event camera where a robot's camera is, with the same pixels and an ideal lens.

    `Simulation` does all of the following with ``events=EventConfig()``. It samples the light after every physics step,
    or between two by interpolated poses, on a picture of its own, so that frames stay as they are. The light is in grey
    levels as OpenGL draws it: gain and exposure of the frame's camera do not change it. A wall that turns is drawn up
    to one control interval late, because it moves evenly here and at once in frames. A camera holds an OpenGL context:
    close it, in the thread and process that made it.

    Parameters
    ----------
    model
        The compiled scene.
    name
        Name of the camera in the scene.
    camera
        The settings of the frame's camera: size, view and place.
    config
        The settings of the event camera.

    Raises
    ------
    KeyError
        The scene has no camera of that name.
    colias_sim.GLUnavailable
        No OpenGL backend works.

    Examples
    --------
    >>> import numpy as np
    >>> from colias_sim import EventConfig, Pose, Simulation
    >>> rng = np.random.default_rng(0)
    >>> with Simulation(events=EventConfig.preset("ideal")) as simulation:
    ...     simulation.reset({"observer": Pose(0.0, 0.0, 0.0), "stimulus": Pose(0.15, 0.0, 0.0)}, rng)
    ...     frame = simulation.step(rng)
    ...     simulation.event_camera.take().size
    0
    """

    def __init__(self, model: mujoco.MjModel, name: str, camera: CameraConfig, config: EventConfig) -> None:
        self._model, self._state = model, mujoco.MjData(model)
        eye = mujoco.MjvCamera()
        eye.type, eye.fixedcamid = mujoco.mjtCamera.mjCAMERA_FIXED.value, model.camera(name).id
        fine = replace(camera, supersample=1, supersample_columns=config.supersample_columns, row_time_us=0.0)
        self._offscreen = Offscreen(model, *render_shape(fine))
        self._sensor = Sensor(eye, self._offscreen, fine)
        self._pixels = EventPixels((camera.height, camera.width), config)
        self._parts, self._steps = config.samples_per_step, steps_per_command(camera.fps)

    def close(self) -> None:
        """Free the OpenGL context."""
        self._offscreen.close()

    def retexture(self, texture: int) -> None:
        """Upload a texture of the model that has changed.

        Parameters
        ----------
        texture
            Its index in the model.
        """
        self._offscreen.retexture(texture)

    def restart(self, data: mujoco.MjData, rng: np.random.Generator) -> None:
        """Start again with a still scene.

        Parameters
        ----------
        data
            State of the scene.
        rng
            Generator of thresholds and noise, kept until the next restart.
        """
        self._wall = self._wall_at = self._wall_to = self._model.body("wall").quat.copy()
        self._pose, self._turned = data.qpos.copy(), self._steps
        self._pixels.restart(self._drawn(self._pose), data.time, rng)

    def see(self, data: mujoco.MjData) -> None:
        """Sample the light since the last call, one physics step ago.

        Parameters
        ----------
        data
            State of the scene. It does not change.
        """
        if (self._model.body("wall").quat != self._wall_to).any():
            self._wall_at, self._wall_to, self._turned = self._wall, self._model.body("wall").quat.copy(), 0
        way = np.empty(self._model.nv)
        mujoco.mj_differentiatePos(self._model, way, 1.0, self._pose, data.qpos)

        def light(share: float) -> Light:
            pose = self._pose.copy()
            mujoco.mj_integratePos(self._model, pose, way, share)
            turned = min((self._turned + share) / self._steps, 1.0)
            self._wall = self._wall_at + turned * (self._wall_to - self._wall_at)
            return self._drawn(pose)

        self._pixels.sample(light, data.time, self._parts)
        self._turned += 1
        self._pose = data.qpos.copy()

    def take(self) -> Events:
        """Return the events since the last call.

        Returns
        -------
        ndarray
            (N,) of ``colias_sim.events.EVENT``, in order of time, read-only: ``t`` in s of simulation, ``x`` and ``y``
            the column and row of a frame's pixel, ``polarity`` 1 for ON (brighter) and -1 for OFF.
        """
        return self._pixels.take()

    def _drawn(self, pose: np.ndarray) -> Light:
        """Draw everything in a state of its own, and the wall where it is now."""
        model, state, wall = self._model, self._state, self._model.body("wall").quat
        state.qpos[:] = pose
        commanded, wall[:] = wall.copy(), self._wall
        mujoco.mj_kinematics(model, state)
        mujoco.mj_camlight(model, state)
        wall[:] = commanded
        return self._sensor.still(state)
