"""Robots in a running simulation: command their wheels, and read their poses."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from colias_sim.config import RobotConfig
from colias_sim.motors import MotorBoard, Motors
from colias_sim.pose import Pose, WheelSpeeds

if TYPE_CHECKING:
    import mujoco

EASE = 2.0
"""Largest acceleration of `Robot.ease` at the wheels' rims, in m/s^2.

The tyres hold about 8 m/s^2, but a robot whose wheels reverse faster than this falls over.
"""


class Robot:
    """A robot that drives by two wheels: access to its own entries of the simulation's state.

    Parameters
    ----------
    model, data
        The compiled scene and its state.
    name
        Name of the robot in the scene.
    config
        The robot's settings.

    Raises
    ------
    KeyError
        The scene has no robot of that name.
    """

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData, name: str, config: RobotConfig) -> None:
        self.name = name
        self.config = config
        self._data = data
        slot, serial = config.command_slot_ms / 1000, config.serial_ms / 1000
        self._motors = Motors(config) if config.power_step_cm_s else None
        self._board = MotorBoard(slot, serial) if slot else None
        self._eased = False
        self._radius, self._track = config.wheel_radius_cm / 100, config.track_cm / 100
        joint = data.joint(f"{name}/free")
        self._forces = data.body(f"{name}/base").xfrc_applied
        self._qpos, self._qvel = joint.qpos, joint.qvel
        self._left, self._right = data.actuator(f"{name}/left").ctrl, data.actuator(f"{name}/right").ctrl

    @property
    def pose(self) -> Pose:
        """The pose of the robot's centre."""
        x, y, _, w, qx, qy, qz = self._qpos.tolist()
        return Pose(x, y, math.atan2(2 * (w * qz + qx * qy), 1 - 2 * (qy * qy + qz * qz)))

    @property
    def height(self) -> float:
        """Height of the body's origin above the floor, in metres."""
        return float(self._qpos[2])

    @property
    def velocity(self) -> tuple[float, float]:
        """Velocity of the centre (vx, vy) in the world's frame, in m/s."""
        vx, vy = self._qvel[:2].tolist()
        return vx, vy

    @property
    def turn_rate(self) -> float:
        """Yaw rate of the body, in rad/s, left positive."""
        return float(self._qvel[5])

    def twist(self, torque: float) -> None:
        """Apply a torque about the vertical axis, until the next call.

        Parameters
        ----------
        torque
            In N m, left positive.
        """
        self._forces[5] = torque

    def place(self, pose: Pose) -> None:
        """Place the robot at rest, at the start of a trial only.

        Parameters
        ----------
        pose
            Where it stands.
        """
        half = pose.heading / 2
        self._qpos[:] = [pose.x, pose.y, 0.0, math.cos(half), 0.0, 0.0, math.sin(half)]
        self._qvel[:] = 0.0
        if self._board is not None:
            self._board.clear()

    def restart(self, rng: np.random.Generator) -> None:
        """Discard all commands, and draw the inequality of the motors, if it has a spread.

        Parameters
        ----------
        rng
            Generator of the trial or episode. Without a spread nothing is drawn from it.
        """
        self._eased = False
        if self._board is not None:
            self._board.clear()
        if self._motors is not None:
            self._motors.draw(rng)

    @property
    def queues(self) -> bool:
        """Whether the robot has a motor board, so that `tick` must be called in every control interval."""
        return self._board is not None

    def begins(self) -> float:
        """Find the time at which a command that is sent now starts.

        Returns
        -------
        float
            Time of the simulation in seconds: now, or with a motor board the start of a slot.
        """
        now = float(self._data.time)
        return now if self._board is None else self._board.begins(now)

    def realised(self, wheels: WheelSpeeds) -> WheelSpeeds:
        """Compute the speeds at which the motors turn for commanded speeds.

        Parameters
        ----------
        wheels
            The commanded speeds.

        Returns
        -------
        tuple of float
            The same speeds, or with 8-bit powers (`RobotConfig`) the speeds of the nearest powers.
        """
        if self._motors is None:
            return wheels
        return self._motors.speeds(*self._motors.powers(*wheels))

    def drive(self, wheels: WheelSpeeds) -> None:
        """Command wheel speeds until the next call. Beyond ``max_speed_cm_s`` they saturate.

        With a motor board the command replaces the waiting ones, and starts with the next slot.

        Parameters
        ----------
        wheels
            The wanted speeds.
        """
        self._eased = False
        self._turn(*self._commanded(wheels))

    def queue(self, wheels: WheelSpeeds, slots: int) -> None:
        """Append a command to the motor board's queue.

        Parameters
        ----------
        wheels
            The wanted speeds.
        slots
            Number of slots that it lasts. If no other command waits at its end, the wheels stop.

        Raises
        ------
        ValueError
            If the robot has no motor board.
        """
        if self._board is None:
            raise ValueError("command_slot_ms=0: this robot has no queue of commands")
        self._eased = False
        self._board.put(self.realised(wheels), float(self._data.time), slots)

    def tick(self) -> None:
        """Start the motor board's command of the present slot. `Simulation` calls it.

        A slot that begins within a control interval takes effect in the next one. At 30 frames/s slots of 100 ms begin
        with an interval. `ease` reads the board itself.
        """
        if self._board is not None and not self._eased:
            self._turn(*self._board.at(float(self._data.time)))

    def _commanded(self, wheels: WheelSpeeds) -> WheelSpeeds:
        """Return the present target speeds of the wheels, if ``wheels`` are commanded now."""
        real = self.realised(wheels)
        if self._board is None:
            return real
        now = float(self._data.time)
        self._board.put(real, now, preempt=True)
        return self._board.at(now)

    def _turn(self, left: float, right: float) -> None:
        self._left[0], self._right[0] = left / self._radius, right / self._radius

    def ease(self, wheels: WheelSpeeds, dt: float) -> None:
        """Command wheel speeds with limited acceleration: as `drive`, but changed by at most 2 m/s^2 times ``dt``.

        The limit acts after powers and slots, between one command and the next.

        Parameters
        ----------
        wheels
            The wanted speeds.
        dt
            Length of the control interval, in seconds.
        """
        left, right = self._left.item() * self._radius, self._right.item() * self._radius
        most = EASE * dt
        self._eased = True
        wanted_left, wanted_right = self._commanded(wheels)
        self._turn(
            left + min(max(wanted_left - left, -most), most), right + min(max(wanted_right - right, -most), most)
        )

    def wheels_for(self, speed: float, turn: float) -> WheelSpeeds:
        """Compute wheel speeds by inverse kinematics.

        Parameters
        ----------
        speed
            Speed of the centre along the heading, in m/s.
        turn
            Turn rate in rad/s, left positive.

        Returns
        -------
        tuple of float
            The speeds. If one exceeds the maximum, both are scaled by one factor, which preserves the curvature.
        """
        left, right = speed - turn * self._track / 2, speed + turn * self._track / 2
        limit = self.config.max_speed_cm_s / 100
        scale = min(1.0, limit / max(abs(left), abs(right), 1e-9))
        return left * scale, right * scale


class ParkedRobot:
    """A robot that is fixed to the floor, as an obstacle.

    Parameters
    ----------
    model
        The compiled scene.
    name
        Name of the robot in the scene.

    Raises
    ------
    KeyError
        The scene has no robot of that name.
    """

    velocity = 0.0, 0.0
    """It stands still, in m/s."""

    def __init__(self, model: mujoco.MjModel, name: str) -> None:
        self.name = name
        body = model.body(f"{name}/base")
        self._pos, self._quat = body.pos, body.quat
        self.pose = Pose(0.0, 0.0, 0.0)

    def place(self, pose: Pose) -> None:
        """Fix the robot at another pose, at the start of a trial only.

        Parameters
        ----------
        pose
            Where it stands.
        """
        self.pose = pose
        self._pos[:2] = pose.x, pose.y
        self._quat[:] = math.cos(pose.heading / 2), 0.0, 0.0, math.sin(pose.heading / 2)
