"""A differential-drive robot inside a running simulation: wheel commands in, pose out."""

from __future__ import annotations

import math
from dataclasses import dataclass

import mujoco

from colias_sim.config import RobotConfig

EASE = 2.0
"""m/s^2 at the wheels' rims; the tyres hold some 8, and a robot that is thrown to and fro harder falls over."""


@dataclass(frozen=True, slots=True)
class Pose:
    """Position in metres and heading in radians, on the floor; x ahead of the observer, y to its left."""

    x: float
    y: float
    heading: float


@dataclass(frozen=True, slots=True)
class WheelSpeeds:
    """Rim speeds of the wheels in m/s, forward positive."""

    left: float
    right: float


class Robot:
    """Handle of one robot: the qpos, qvel and ctrl entries that are its own."""

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData, name: str, config: RobotConfig) -> None:
        self.name = name
        self.config = config
        self._radius, self._track = config.wheel_radius_cm / 100, config.track_cm / 100
        joint = data.joint(f"{name}/free")
        self._forces = data.body(f"{name}/base").xfrc_applied
        self._qpos, self._qvel = joint.qpos, joint.qvel
        self._left, self._right = data.actuator(f"{name}/left"), data.actuator(f"{name}/right")

    @property
    def pose(self) -> Pose:
        """Where the robot's centre is and where it points."""
        x, y, _, w, qx, qy, qz = self._qpos.tolist()
        return Pose(x, y, math.atan2(2 * (w * qz + qx * qy), 1 - 2 * (qy * qy + qz * qz)))

    @property
    def height(self) -> float:
        """Height of the body's origin above the floor in metres: how far the robot bobs."""
        return float(self._qpos[2])

    @property
    def velocity(self) -> tuple[float, float]:
        """Velocity of the centre (vx, vy) in m/s, world frame."""
        vx, vy = self._qvel[:2].tolist()
        return vx, vy

    @property
    def turn_rate(self) -> float:
        """Yaw rate of the body in rad/s, left positive."""
        return float(self._qvel[5])

    def twist(self, torque: float) -> None:
        """Push the body about its vertical axis with ``torque`` N m, left positive, until told otherwise."""
        self._forces[5] = torque

    def place(self, pose: Pose) -> None:
        """Put the robot down at rest; for the start of a trial only."""
        half = pose.heading / 2
        self._qpos[:] = [pose.x, pose.y, 0.0, math.cos(half), 0.0, 0.0, math.sin(half)]
        self._qvel[:] = 0.0

    def drive(self, wheels: WheelSpeeds) -> None:
        """Command the wheels until told otherwise; beyond `RobotConfig.max_speed_cm_s` they saturate."""
        self._left.ctrl[:] = wheels.left / self._radius
        self._right.ctrl[:] = wheels.right / self._radius

    def ease(self, wheels: WheelSpeeds, dt: float) -> None:
        """`drive`, but from what was commanded before by at most `EASE` in ``dt`` seconds: for those who may jerk."""
        left, right = float(self._left.ctrl[0]) * self._radius, float(self._right.ctrl[0]) * self._radius
        most = EASE * dt
        self.drive(
            WheelSpeeds(
                left + min(max(wheels.left - left, -most), most), right + min(max(wheels.right - right, -most), most)
            )
        )

    def wheels_for(self, speed: float, turn: float) -> WheelSpeeds:
        """Inverse kinematics: wheel speeds for ``speed`` in m/s and ``turn`` in rad/s, left positive.

        Where one wheel would pass the maximum both are slowed alike, so that the curvature stays.
        """
        left, right = speed - turn * self._track / 2, speed + turn * self._track / 2
        limit = self.config.max_speed_cm_s / 100
        scale = min(1.0, limit / max(abs(left), abs(right), 1e-9))
        return WheelSpeeds(left * scale, right * scale)


class Parked:
    """Handle of a robot that is fixed to the floor: an obstacle."""

    def __init__(self, model: mujoco.MjModel, name: str) -> None:
        self.name = name
        body = model.body(f"{name}/base")
        self._pos, self._quat = body.pos, body.quat
        self.pose = Pose(0.0, 0.0, 0.0)

    def place(self, pose: Pose) -> None:
        """Fix the robot somewhere else; for the start of a trial only."""
        self.pose = pose
        self._pos[:2] = pose.x, pose.y
        self._quat[:] = math.cos(pose.heading / 2), 0.0, 0.0, math.sin(pose.heading / 2)


def bearing(observer: Pose, target: Pose, forward: float) -> float:
    """Angle of ``target`` from the optical axis, seen from a lens ``forward`` metres ahead of the observer's centre.

    Radians, left positive.
    """
    x, y = observer.x + forward * math.cos(observer.heading), observer.y + forward * math.sin(observer.heading)
    angle = math.atan2(target.y - y, target.x - x) - observer.heading
    return math.remainder(angle, 2 * math.pi)
