"""Straight paths, and controllers that drive a robot along one: by feedback of its pose, or by time alone."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import groupby

from colias_sim.pose import Pose, WheelSpeeds
from colias_sim.robot import Robot


@dataclass(frozen=True, slots=True)
class Line:
    """A straight path on the floor.

    Parameters
    ----------
    start
        Pose at its start; the heading is its direction.
    length
        Length in metres.
    """

    start: Pose
    length: float

    def along(self, pose: Pose) -> float:
        """Measure how far a pose is from the start, along the line.

        Parameters
        ----------
        pose
            The pose; its heading does not matter.

        Returns
        -------
        float
            Distance in metres; negative before the start.
        """
        dx, dy = pose.x - self.start.x, pose.y - self.start.y
        return dx * math.cos(self.start.heading) + dy * math.sin(self.start.heading)

    def offset(self, pose: Pose) -> float:
        """Measure how far a pose is beside the line.

        Parameters
        ----------
        pose
            The pose; its heading does not matter.

        Returns
        -------
        float
            Distance in metres, left positive.
        """
        dx, dy = pose.x - self.start.x, pose.y - self.start.y
        return dy * math.cos(self.start.heading) - dx * math.sin(self.start.heading)

    def point(self, along: float) -> Pose:
        """Find a pose on the line.

        Parameters
        ----------
        along
            Distance from the start, in metres.

        Returns
        -------
        Pose
            The pose there, in the line's direction.
        """
        h = self.start.heading
        return Pose(self.start.x + along * math.cos(h), self.start.y + along * math.sin(h), h)


class PathFollower:
    """Drives a robot along a line at a set speed, by feedback of heading, offset and speed.

    Steering is the linear law ``turn = -v (k_heading e_heading + k_offset offset)``, which is critically damped in the
    distance travelled. The speed ramps up from rest. Near the set speed an integral term acts too, because the
    motors' velocity servo alone settles a little below it.

    Parameters
    ----------
    robot
        The robot to drive.
    line
        The path.
    speed
        The set speed, in m/s.
    acceleration
        Slope of the ramp, in m/s^2.
    stop
        Whether to brake to rest at the line's end.
    """

    HEADING_GAIN = 80.0  # per metre travelled
    OFFSET_GAIN = 1600.0  # per square metre: (HEADING_GAIN / 2)^2 is critical
    ACCELERATION = 1.0  # m/s^2, the default
    INTEGRAL_GAIN = 6.0  # 1/s
    NEAR = 0.1  # share of the speed within which the integral works: no wind-up while the motors lag

    def __init__(
        self, robot: Robot, line: Line, speed: float, *, acceleration: float = ACCELERATION, stop: bool = False
    ) -> None:
        self._robot, self._line, self._speed, self._stop = robot, line, speed, stop
        self._acceleration = acceleration
        self._ramp = self._surplus = 0.0

    @classmethod
    def run_up(cls, speed: float, acceleration: float = ACCELERATION) -> float:
        """Compute the way in which a robot that starts from rest comes to keep a speed within 2 %.

        Parameters
        ----------
        speed
            The set speed, in m/s.
        acceleration
            Slope of the ramp, in m/s^2.

        Returns
        -------
        float
            Length in metres.
        """
        return speed**2 / (2 * acceleration) + 0.2 * speed + 0.002

    @classmethod
    def braking(cls, speed: float, acceleration: float = ACCELERATION) -> float:
        """Compute how long before the line's end a robot that stops there may be slower than its set speed.

        Parameters
        ----------
        speed
            The set speed, in m/s.
        acceleration
            Slope of the ramp, in m/s^2.

        Returns
        -------
        float
            Length in metres.
        """
        return speed**2 / (2 * acceleration) + 0.03 * speed + 0.001

    def wheels(self, dt: float) -> WheelSpeeds:
        """Compute the wheel speeds to command for the next control interval.

        Parameters
        ----------
        dt
            Length of the interval, in seconds.

        Returns
        -------
        WheelSpeeds
            The speeds.
        """
        pose, heading = self._robot.pose, self._line.start.heading
        vx, vy = self._robot.velocity
        self._ramp = min(self._ramp + self._acceleration * dt, self._speed)
        if self._stop:
            left = max(self._line.length - self._line.along(pose), 0.0)
            self._ramp = min(self._ramp, math.sqrt(2 * self._acceleration * left))
        error = self._speed - (vx * math.cos(heading) + vy * math.sin(heading))
        if abs(error) < self.NEAR * self._speed:
            self._surplus += self.INTEGRAL_GAIN * error * dt
        skew = math.remainder(pose.heading - heading, 2 * math.pi)
        turn = -self._ramp * (self.HEADING_GAIN * skew + self.OFFSET_GAIN * self._line.offset(pose))
        return self._robot.wheels_for(self._ramp * (1.0 + self._surplus / self._speed), turn)


@dataclass(frozen=True, slots=True)
class SpeedProfile:
    """Speed over time: at rest, a ramp up, constant, and with ``stop`` a ramp down to rest.

    Parameters
    ----------
    length
        Length of the path in metres.
    speed
        The constant speed, in m/s.
    acceleration
        Slope of the ramps, in m/s^2.
    stop
        Whether to be at rest at the path's end; otherwise the speed stays constant beyond it.
    wait
        Time at rest before, in seconds.
    """

    length: float
    speed: float
    acceleration: float
    stop: bool
    wait: float = 0.0

    @property
    def seconds(self) -> float:
        """Time from the beginning of the wait until the path is covered, in seconds."""
        ramps = 1.0 if self.stop else 0.5
        return self.wait + self.length / self.speed + ramps * self.speed / self.acceleration

    def covered(self, time: float) -> float:
        """Compute the distance that is covered by a time.

        Parameters
        ----------
        time
            Seconds from the beginning of the wait.

        Returns
        -------
        float
            Distance in metres.
        """
        ramp, moving = self.speed / self.acceleration, max(time - self.wait, 0.0)
        up = min(moving, ramp)
        covered = self.acceleration * up**2 / 2 + self.speed * (moving - up)
        if self.stop:
            late = max(time - (self.seconds - ramp), 0.0)
            down = min(late, ramp)
            covered -= self.acceleration * down**2 / 2 + self.speed * (late - down)
        return covered

    def mean(self, begin: float, end: float) -> float:
        """Compute the mean speed between two times.

        Parameters
        ----------
        begin, end
            Seconds from the beginning of the wait; ``end`` is the later.

        Returns
        -------
        float
            Speed in m/s.
        """
        return (self.covered(end) - self.covered(begin)) / (end - begin)


class OpenLoop:
    """Drives a robot straight ahead by a speed profile, without looking where it is.

    Each command is the profile's mean speed in the time that the command lasts. So with perfect wheels the path's
    length is kept, however coarse the commands are. A robot with a motor board gets all commands at once, tagged with
    durations. Another gets one in each control interval.

    Parameters
    ----------
    robot
        The robot to drive.
    profile
        What it is to do, from now on.
    """

    def __init__(self, robot: Robot, profile: SpeedProfile) -> None:
        self._robot, self._profile, self._time = robot, profile, 0.0
        self._slot = robot.config.command_slot_ms / 1000
        self._slots = math.ceil(profile.seconds / self._slot - 1e-9) if self._slot else 0
        self._sent = False

    @property
    def seconds(self) -> float:
        """Time in seconds that the commands take, when a motor board has begun them."""
        return self._slots * self._slot or self._profile.seconds

    def commands(self) -> list[tuple[float, int]]:
        """List what a motor board gets.

        Returns
        -------
        list of tuple[float, int]
            Speeds in m/s, and the slots that each lasts; empty for a robot without a board.
        """
        means = [self._profile.mean(i * self._slot, (i + 1) * self._slot) for i in range(self._slots)]
        return [(speed, len(list(equal))) for speed, equal in groupby(round(mean, 9) for mean in means)]

    def drive(self, dt: float) -> None:
        """Command the wheels for the next control interval.

        Parameters
        ----------
        dt
            Length of the interval, in seconds.
        """
        if not self._slot:
            speed = self._profile.mean(self._time, self._time + dt)
            self._time += dt
            self._robot.drive(WheelSpeeds(speed, speed))
        elif not self._sent:
            self._sent = True
            for speed, slots in self.commands():
                self._robot.queue(WheelSpeeds(speed, speed), slots)
