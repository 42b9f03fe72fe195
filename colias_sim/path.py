"""Routes on the floor with a speed profile, and drivers along them: by feedback of the pose, or by time."""

from __future__ import annotations

import itertools
import math
from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from itertools import groupby

from colias_sim.pose import Pose, WheelSpeeds
from colias_sim.robot import Robot

LONGEST_START = 0.9
"""Largest share of the path from one stop to the next in which no speed is measured."""
STRAIGHT = 1e-9
"""Curvature, 1/m, below which a stretch counts as straight."""


@dataclass(frozen=True, slots=True)
class Stretch:
    """A piece of a route: a line or an arc with constant acceleration, or a time spent on the spot.

    Parameters
    ----------
    length
        Length in metres; 0 on the spot.
    speed, end_speed
        Speeds at its two ends, in m/s; the speed between them changes evenly in time.
    curvature
        Curvature in 1/m, left positive; 0 is straight.
    seconds
        Time that the robot stands or turns, where the length is 0.
    rate
        Turn rate on the spot, in rad/s, left positive.

    Examples
    --------
    >>> from math import degrees, pi
    >>> from colias_sim import Pose, Route, Stretch
    >>> quarter = Stretch(length=0.1 * pi / 2, speed=0.05, end_speed=0.05, curvature=10.0)
    >>> round(degrees(quarter.turn))
    90
    >>> route = Route(Pose(0.0, 0.0, 0.0), (quarter,))
    """

    length: float = 0.0
    speed: float = 0.0
    end_speed: float = 0.0
    curvature: float = 0.0
    seconds: float = 0.0
    rate: float = 0.0

    @property
    def moves(self) -> bool:
        """Whether the robot changes its place."""
        return self.length > 0

    @property
    def turn(self) -> float:
        """Angle in radians by which the heading changes, left positive."""
        return self.curvature * self.length if self.moves else self.rate * self.seconds

    @property
    def acceleration(self) -> float:
        """Acceleration in m/s^2."""
        return (self.end_speed**2 - self.speed**2) / (2 * self.length) if self.moves else 0.0

    def speed_at(self, within: float) -> float:
        """Compute the speed at a distance from the beginning.

        Parameters
        ----------
        within
            Distance from the beginning, in metres.

        Returns
        -------
        float
            Speed in m/s.
        """
        if self.speed == self.end_speed:
            return self.speed
        share = min(max(within / self.length, 0.0), 1.0)
        return math.sqrt(self.speed**2 + (self.end_speed**2 - self.speed**2) * share)

    def point(self, start: Pose, within: float) -> Pose:
        """Find the pose at a distance from the beginning.

        Parameters
        ----------
        start
            Pose at the beginning of the piece.
        within
            Distance from the beginning, in metres.

        Returns
        -------
        Pose
            The pose there, in the path's direction.
        """
        h, k = start.heading, self.curvature
        if abs(k) < STRAIGHT:
            return Pose(start.x + within * math.cos(h), start.y + within * math.sin(h), h)
        turned = h + k * within
        return Pose(
            start.x + (math.sin(turned) - math.sin(h)) / k, start.y - (math.cos(turned) - math.cos(h)) / k, turned
        )

    def measured(self, start: Pose, pose: Pose) -> tuple[float, float]:
        """Measure the position of a pose along the piece and its lateral offset.

        Parameters
        ----------
        start
            Pose at the beginning of the piece.
        pose
            The pose; its heading does not matter.

        Returns
        -------
        tuple of float
            Distance along the piece and lateral offset (left positive), in metres.
        """
        dx, dy, h = pose.x - start.x, pose.y - start.y, start.heading
        if abs(self.curvature) < STRAIGHT:
            return dx * math.cos(h) + dy * math.sin(h), dy * math.cos(h) - dx * math.sin(h)
        radius = 1.0 / self.curvature
        side = math.copysign(1.0, radius)
        dx, dy = dx + radius * math.sin(h), dy - radius * math.cos(h)  # from the arc's centre
        middle = self.turn / 2
        turned = middle + math.remainder(math.atan2(dy, dx) + side * math.pi / 2 - h - middle, 2 * math.pi)
        return turned * radius, radius - side * math.hypot(dx, dy)


@dataclass(frozen=True)
class Route:
    """A path on the floor with a speed profile: a sequence of stretches.

    Speeds may step where two stretches meet. A robot takes such a step with an acceleration, as it starts and stops.

    Parameters
    ----------
    start
        Pose at its start; the heading is the direction of the path.
    stretches
        Its pieces, in order.
    backward
        Whether the robot drives backward, and faces the other way.

    Examples
    --------
    >>> from colias_sim import Pose, Route
    >>> route = Route.line(Pose(0.0, 0.0, 0.0), length=0.3, speed=0.02)
    >>> route.point(0.1)
    Pose(x=0.1, y=0.0, heading=0.0)
    """

    start: Pose
    stretches: tuple[Stretch, ...]
    backward: bool = False

    @classmethod
    def line(cls, start: Pose, length: float, speed: float, *, wait: float = 0.0, rest: float | None = None) -> Route:
        """Make a straight route at one speed.

        Parameters
        ----------
        start
            Pose at its start.
        length, speed
            Length in metres, and speed in m/s.
        wait
            Time in seconds for which the robot stands first.
        rest
            Time in seconds for which it stands at the end; ``None``: it does not stop.

        Returns
        -------
        Route
            The route.
        """
        before = (Stretch(seconds=wait),) if wait else ()
        after = () if rest is None else (Stretch(seconds=rest),)
        return cls(start, (*before, Stretch(length, speed, speed), *after))

    @property
    def stops(self) -> bool:
        """Whether the robot stands at its end."""
        return not self.stretches or not self.stretches[-1].moves

    @cached_property
    def begins(self) -> tuple[float, ...]:
        """Distance in metres from the start to each stretch, and to the end."""
        along = [0.0]
        for stretch in self.stretches:
            along.append(along[-1] + stretch.length)
        return tuple(along)

    @property
    def length(self) -> float:
        """Length in metres."""
        return self.begins[-1]

    @cached_property
    def poses(self) -> tuple[Pose, ...]:
        """Pose at the beginning of each stretch, and at the end."""
        poses = [self.start]
        for stretch in self.stretches:
            pose = poses[-1]
            poses.append(
                stretch.point(pose, stretch.length)
                if stretch.moves
                else Pose(pose.x, pose.y, pose.heading + stretch.turn)
            )
        return tuple(poses)

    def measured(self, acceleration: float, slot: float = 0.0) -> tuple[tuple[float, float], ...]:
        """List the parts in which the robot can drive at the set speed: between starts and stops.

        Parameters
        ----------
        acceleration
            Acceleration of starts and stops, in m/s^2.
        slot
            Time in seconds by which it may brake earlier, because of the duration of its commands.

        Returns
        -------
        tuple of tuple of float
            Begin and end of each part along the route, in metres.
        """
        parts = []
        indices = range(len(self.stretches))
        for moves, group in groupby(indices, key=lambda index: self.stretches[index].moves):
            if not moves:
                continue
            driven = list(group)
            begin, end = self.begins[driven[0]], self.begins[driven[-1] + 1]
            first, last = self.stretches[driven[0]].speed, self.stretches[driven[-1]].end_speed
            starting, stopping = PathFollower.run_up(first, acceleration), 0.0
            if driven[-1] + 1 < len(self.stretches):
                stopping = PathFollower.braking(last, acceleration) + last * slot
            share = min(1.0, LONGEST_START * (end - begin) / (starting + stopping))
            parts.append((begin + share * starting, end - share * stopping))
        return tuple(parts)

    def body(self, pose: Pose) -> Pose:
        """Convert a pose on the path to the robot's pose, which is reversed if it drives backward.

        Parameters
        ----------
        pose
            A pose on the path, in the path's direction.

        Returns
        -------
        Pose
            The pose of the robot.
        """
        return Pose(pose.x, pose.y, pose.heading - math.pi) if self.backward else pose

    def point(self, along: float) -> Pose:
        """Find a pose on the path.

        Parameters
        ----------
        along
            Distance from the start, in metres.

        Returns
        -------
        Pose
            The pose there, in the path's direction. Before the start and beyond the end it is on the tangent.
        """
        moving = [i for i, stretch in enumerate(self.stretches) if stretch.moves]
        index = max((i for i in moving if self.begins[i] <= along), default=moving[0] if moving else 0)
        if not moving:
            return self.start
        within = along - self.begins[index]
        if 0.0 <= within <= self.stretches[index].length:
            return self.stretches[index].point(self.poses[index], within)
        end = self.poses[index] if within < 0 else self.poses[index + 1]
        return Stretch(1.0).point(end, within if within < 0 else within - self.stretches[index].length)


class Tracker:
    """Tracks a robot's position on a route from its successive poses.

    It chooses the nearer of two successive stretches and never goes back, so a route may cross itself.

    Parameters
    ----------
    route
        The route.

    Examples
    --------
    >>> from colias_sim import Pose, Route, Tracker
    >>> tracker = Tracker(Route.line(Pose(0.0, 0.0, 0.0), length=0.3, speed=0.02))
    >>> tracker.see(Pose(0.1, 0.01, 0.0))
    >>> round(tracker.along, 3), round(tracker.offset, 3)
    (0.1, 0.01)
    """

    def __init__(self, route: Route) -> None:
        self._route = route
        self._moving = [i for i, stretch in enumerate(route.stretches) if stretch.moves]
        self.index = self._moving[0] if self._moving else 0
        self.within = self.along = self.offset = 0.0

    def see(self, pose: Pose, last: int | None = None) -> None:
        """Process the next pose and update the attributes.

        Parameters
        ----------
        pose
            Pose of the robot.
        last
            Index of the last possible stretch; ``None``: any.
        """
        if not self._moving:
            return
        index, distance = self.index, None
        for following in self._moving[self._moving.index(index) + 1 :]:
            if last is not None and following > last:
                break
            distance = self._away(index, pose) if distance is None else distance
            there = self._away(following, pose)
            if there > distance:
                break
            index, distance = following, there
        self.index = index
        self.within, self.offset = self._route.stretches[index].measured(self._route.poses[index], pose)
        self.along = self._route.begins[index] + self.within

    def _away(self, index: int, pose: Pose) -> float:
        """Compute the distance of a pose from a stretch between its ends."""
        stretch = self._route.stretches[index]
        within, offset = stretch.measured(self._route.poses[index], pose)
        return math.hypot(within - min(max(within, 0.0), stretch.length), offset)


@dataclass(frozen=True, slots=True)
class Phase:
    """A part of a schedule: from ``begin`` (s) and ``along`` (m), with a constant acceleration, on one stretch."""

    begin: float
    seconds: float
    along: float
    speed: float
    acceleration: float
    stretch: int

    def covered(self, time: float) -> float:
        """Compute the distance in metres from the start of the route at a time within the phase."""
        lasting = min(max(time - self.begin, 0.0), self.seconds)
        return self.along + self.speed * lasting + self.acceleration * lasting**2 / 2


class Schedule:
    """The planned motion of a robot along a route: its pose at every time, from rest at its start.

    Parameters
    ----------
    route
        The route.
    acceleration
        Acceleration of starts, stops and steps of the speed, in m/s^2. ``inf``: immediate.

    Examples
    --------
    >>> from colias_sim import Pose, Route, Schedule
    >>> schedule = Schedule(Route.line(Pose(0.0, 0.0, 0.0), length=0.3, speed=0.02), acceleration=float("inf"))
    >>> round(schedule.pose(5.0).x, 3)
    0.1
    """

    def __init__(self, route: Route, acceleration: float) -> None:
        self.route, self.acceleration = route, acceleration
        self.phases = tuple(_phases(route, acceleration))
        self._begins = [phase.begin for phase in self.phases]
        last = self.phases[-1]
        self.seconds = last.begin + last.seconds

    def _at(self, time: float) -> Phase:
        return self.phases[max(bisect_right(self._begins, time) - 1, 0)]

    def covered(self, time: float) -> float:
        """Compute the distance covered at a time; beyond the end it continues at the last speed.

        Parameters
        ----------
        time
            Seconds from its start.

        Returns
        -------
        float
            Distance in metres.
        """
        phase = self._at(time)
        beyond = 0.0 if self.route.stops else max(time - self.seconds, 0.0)
        return phase.covered(time) + beyond * self.route.stretches[-1].end_speed

    def heading(self, time: float) -> float:
        """Compute the direction of the path at a time.

        Parameters
        ----------
        time
            Seconds from its start.

        Returns
        -------
        float
            Heading in radians, not wrapped.
        """
        phase = self._at(time)
        stretch, start = self.route.stretches[phase.stretch], self.route.poses[phase.stretch]
        if stretch.moves:
            return start.heading + stretch.curvature * (phase.covered(time) - self.route.begins[phase.stretch])
        return start.heading + stretch.rate * min(max(time - phase.begin, 0.0), phase.seconds)

    def pose(self, time: float) -> Pose:
        """Compute the planned pose of the robot at a time.

        Parameters
        ----------
        time
            Seconds from its start.

        Returns
        -------
        Pose
            The pose of the robot.
        """
        phase = self._at(time)
        stretch, start = self.route.stretches[phase.stretch], self.route.poses[phase.stretch]
        if stretch.moves:
            return self.route.body(stretch.point(start, phase.covered(time) - self.route.begins[phase.stretch]))
        return self.route.body(Pose(start.x, start.y, self.heading(time)))

    def mean(self, begin: float, end: float) -> tuple[float, float]:
        """Compute the mean speed and turn rate between two times.

        Parameters
        ----------
        begin, end
            Seconds from the start; ``end`` is the later.

        Returns
        -------
        tuple of float
            Speed in m/s, and turn rate in rad/s, left positive.
        """
        phase = self._at(begin)
        stretch = self.route.stretches[phase.stretch]
        if not phase.acceleration and end <= phase.begin + phase.seconds:  # exactly what was asked for
            return phase.speed, phase.speed * stretch.curvature if stretch.moves else stretch.rate
        lasting = end - begin
        return (self.covered(end) - self.covered(begin)) / lasting, (self.heading(end) - self.heading(begin)) / lasting

    def speed_between(self, begin: float, end: float) -> float:
        """Compute the mean speed between two places.

        Parameters
        ----------
        begin, end
            Distances from the start of the route, in metres.

        Returns
        -------
        float
            Speed in m/s.
        """
        one, other = self._phase_of(begin), self._phase_of(end)
        if one is other and not one.acceleration:
            return one.speed
        return (end - begin) / (self._time_at(end, other) - self._time_at(begin, one))

    def speed_over(self, parts: Sequence[tuple[float, float]]) -> float:
        """Compute the mean speed over several parts of the route.

        Parameters
        ----------
        parts
            Begin and end of each part along the route, in metres.

        Returns
        -------
        float
            Speed in m/s.
        """
        speeds = [self.speed_between(begin, end) for begin, end in parts]
        if len(speeds) == 1:
            return speeds[0]
        lengths = [end - begin for begin, end in parts]
        return sum(lengths) / sum(length / speed for length, speed in zip(lengths, speeds, strict=True))

    def _phase_of(self, along: float) -> Phase:
        moving = [phase for phase in self.phases if self.route.stretches[phase.stretch].moves]
        return moving[max(bisect_right([phase.along for phase in moving], along) - 1, 0)]

    @staticmethod
    def _time_at(along: float, phase: Phase) -> float:
        left = along - phase.along
        end_speed = math.sqrt(max(phase.speed**2 + 2 * phase.acceleration * left, 0.0))
        return phase.begin + 2 * left / (phase.speed + end_speed) if left else phase.begin


def _phases(route: Route, acceleration: float) -> list[Phase]:
    """List the phases of a schedule: the set speed of each stretch, limited by starts and stops.

    The square of a speed is linear in the distance, both of a stretch and of a start or stop. So is their minimum.
    """
    stretches, begins = route.stretches, route.begins
    leaving = [0.0, *(stretch.end_speed for stretch in stretches)]
    coming = [*(stretch.speed for stretch in stretches), leaving[-1]]
    corners = [
        (along, min(one, other) ** 2)
        for along, one, other in zip(begins, leaving, coming, strict=True)
        if one != other and math.isfinite(acceleration)
    ]
    slope, phases, now = 2 * acceleration, list[Phase](), 0.0
    for index, stretch in enumerate(stretches):
        begin, end = begins[index], begins[index + 1]
        if not stretch.moves:
            phases.append(Phase(now, stretch.seconds, begin, 0.0, 0.0, index))
            now += stretch.seconds
            continue
        # The square of the speed at the beginning of the stretch, and its slope.
        lines = [(stretch.speed * stretch.speed, 2 * stretch.acceleration)]
        before = [square + slope * (begin - place) for place, square in corners if place <= begin]
        after = [square + slope * (place - begin) for place, square in corners if place >= end]
        lines += [(min(squares), rise) for squares, rise in ((before, slope), (after, -slope)) if squares]
        meet = {
            (other - one) / (rise - fall)
            for one, rise in lines
            for other, fall in lines
            if rise != fall and 0.0 < (other - one) / (rise - fall) < stretch.length
        }
        marks = [0.0, *sorted(meet), stretch.length]
        lowest = [min(lines, key=partial(_height, (here + there) / 2)) for here, there in itertools.pairwise(marks)]
        for line, pieces in groupby(zip(lowest, itertools.pairwise(marks), strict=True), key=lambda piece: piece[0]):
            bounds = [place for _, ends in pieces for place in ends]
            here, there = bounds[0], bounds[-1]
            speed, end_speed = (math.sqrt(max(_height(place, line), 0.0)) for place in (here, there))
            if speed + end_speed == 0.0:
                continue
            lasting = 2 * (there - here) / (speed + end_speed)
            phases.append(Phase(now, lasting, begin + here, speed, line[1] / 2, index))
            now += lasting
    return phases or [Phase(0.0, 0.0, 0.0, 0.0, 0.0, 0)]


def _height(place: float, line: tuple[float, float]) -> float:
    """Evaluate a line, given by its value at 0 and its slope, at a place."""
    return line[0] + line[1] * place


class PathFollower:
    """Drives a robot along a route by feedback of heading, offset and speed.

    Steering is the linear law ``turn = v (curvature - k_heading e_heading - k_offset offset)``, which is critically
    damped in the distance travelled. The speed is the route's at the robot's place. It ramps up from rest, and down
    before a stop or a slower stretch. Near this speed an integral term acts too, because the motors' velocity servo
    alone settles slightly below it.

    Parameters
    ----------
    robot
        The robot to drive.
    route
        The route.
    acceleration
        Slope of the ramps, in m/s^2.

    Examples
    --------
    >>> import numpy as np
    >>> from colias_sim import PathFollower, Pose, Route, Simulation
    >>> start, rng = Pose(0.1, 0.1, 0.0), np.random.default_rng(0)
    >>> with Simulation(seeing=False) as simulation:
    ...     simulation.reset({"observer": Pose(0.0, 0.0, 0.0), "stimulus": start}, rng)
    ...     robot = simulation.robots["stimulus"]
    ...     follower = PathFollower(robot, Route.line(start, length=0.1, speed=0.05))
    ...     for _ in range(30):
    ...         simulation.advance(lambda dt: robot.drive(follower.wheels(dt)))
    ...     x = robot.pose.x
    >>> 0.13 < x < 0.16
    True
    """

    HEADING_GAIN = 80.0  # per metre travelled
    OFFSET_GAIN = 1600.0  # per square metre: (HEADING_GAIN / 2)^2 is critical
    ACCELERATION = 1.0  # m/s^2, the default
    INTEGRAL_GAIN = 6.0  # 1/s
    NEAR = 0.1  # share of the speed within which the integral works: no wind-up while the motors lag
    AT_REST = 0.002  # m/s
    OUT_OF_REST = 0.001  # metres by which the speed of a place is read ahead: at rest it would never be left
    SPOT_GAIN = 8.0  # 1/s, of the heading during turns on the spot
    SLOWEST = 0.25  # share of the route's top speed below which the integral term counts for no more

    def __init__(self, robot: Robot, route: Route, *, acceleration: float = ACCELERATION) -> None:
        self._robot, self._route, self._acceleration = robot, route, acceleration
        self._tracker = Tracker(route)
        self._top = max((max(s.speed, s.end_speed) for s in route.stretches), default=0.0)
        self._clock = self._since = self._ramp = self._surplus = 0.0
        self._at = 0  # the stretch that is driven, the first of those up to a stop; or the one on the spot
        self._last = self._last_before_stop()
        self._moved = False
        self.over = False

    @classmethod
    def run_up(cls, speed: float, acceleration: float = ACCELERATION) -> float:
        """Compute the distance that a robot needs from rest to hold a speed within 2 %.

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
        """Compute the distance before a stop in which a robot may be slower than its set speed.

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

    @property
    def offset(self) -> float:
        """Distance in metres from the path at the last call of `wheels`, left positive."""
        return self._tracker.offset

    def wheels(self, dt: float) -> WheelSpeeds:
        """Compute the wheel speeds to command for the next control interval.

        Parameters
        ----------
        dt
            Length of the interval, in seconds.

        Returns
        -------
        tuple of float
            The speeds.
        """
        stretch = self._go_on()
        now, self._clock = self._clock, self._clock + dt
        if stretch is not None and not stretch.moves:
            if stretch.rate:
                self._moved = False  # the robot does not hold its place while it turns
                return self._turned(stretch, now)
            if not self._moved:
                return 0.0, 0.0
        return self._followed(dt)

    def drive(self, dt: float) -> None:
        """Command the wheels for the next control interval.

        Parameters
        ----------
        dt
            Length of the interval, in seconds.
        """
        self._robot.drive(self.wheels(dt))

    def look(self) -> None:
        """Check, once a frame, whether the robot has stopped, and whether the route is over."""
        stretch = self._stretch()
        if stretch is None or stretch.moves:
            self._tracker.see(self._robot.pose, self._last)
            if not self._stops_after(self._last):
                self.over = self._tracker.along >= self._route.begins[self._last + 1]
            elif self._rests():
                self._at, self._since = self._last + 1, self._clock
        elif self._at == len(self._route.stretches) - 1:
            self.over = self._clock >= self._since + stretch.seconds - 1e-9

    def _stretch(self) -> Stretch | None:
        return self._route.stretches[self._at] if self._at < len(self._route.stretches) else None

    def _stops_after(self, index: int) -> bool:
        return index + 1 < len(self._route.stretches)

    def _last_before_stop(self) -> int:
        """Return the last stretch before the next stop."""
        last = self._at
        while last + 1 < len(self._route.stretches) and self._route.stretches[last + 1].moves:
            last += 1
        return last

    def _go_on(self) -> Stretch | None:
        """Continue with the next stretch when the time on the spot is over; return the present one."""
        while (stretch := self._stretch()) is not None and not stretch.moves:
            if self._at == len(self._route.stretches) - 1 or self._clock < self._since + stretch.seconds - 1e-9:
                return stretch
            self._at, self._since = self._at + 1, self._since + stretch.seconds
            following = self._stretch()
            if following is not None and following.moves:
                self._ramp = self._surplus = 0.0
                self._last, self._moved = self._last_before_stop(), True
                self._tracker.index = self._at
                return following
        self._moved = True
        return stretch

    def _rests(self) -> bool:
        """Whether the robot stands at the next stop."""
        speed = math.hypot(*self._robot.velocity)
        end = self._route.begins[self._last + 1]
        near = self.braking(self._route.stretches[self._last].end_speed, self._acceleration)
        return speed < self.AT_REST and self._tracker.along > end - near

    def _turned(self, stretch: Stretch, now: float) -> WheelSpeeds:
        lasting = min(now - self._since, stretch.seconds)
        wanted = self._route.body(self._route.poses[self._at]).heading + stretch.rate * lasting
        error = math.remainder(wanted - self._robot.pose.heading, 2 * math.pi)
        return self._robot.wheels_for(0.0, stretch.rate + self.SPOT_GAIN * error)

    def _followed(self, dt: float) -> WheelSpeeds:
        pose, tracker, route = self._robot.pose, self._tracker, self._route
        tracker.see(pose, self._last)
        stretch = route.stretches[tracker.index]
        heading = route.poses[tracker.index].heading + stretch.curvature * tracker.within
        vx, vy = self._robot.velocity
        target = stretch.speed_at(max(tracker.within, self.OUT_OF_REST))
        self._ramp = min(self._ramp + self._acceleration * dt, target)
        for index in range(tracker.index, self._last + 1):
            slower = route.stretches[index + 1].speed if index + 1 < len(route.stretches) else math.inf
            if slower < route.stretches[index].end_speed or not slower:
                left = max(route.begins[index + 1] - tracker.along, 0.0)
                self._ramp = min(self._ramp, math.sqrt(slower**2 + 2 * self._acceleration * left))
        error = target - (vx * math.cos(heading) + vy * math.sin(heading))
        if abs(error) < self.NEAR * target:
            self._surplus += self.INTEGRAL_GAIN * error * dt
        facing = heading - math.pi if route.backward else heading
        skew = math.remainder(pose.heading - facing, 2 * math.pi)
        back = self.HEADING_GAIN * skew + self.OFFSET_GAIN * tracker.offset
        turn = self._ramp * stretch.curvature - self._ramp * back
        speed = self._ramp * (1.0 + self._surplus / max(target, self.SLOWEST * self._top))
        return self._robot.wheels_for(-speed if route.backward else speed, turn)


class OpenLoop:
    """Drives a robot by a schedule, without feedback of its pose.

    Each command is the schedule's mean speed and turn rate during the command. So with perfect wheels the length of a
    straight path is exact, however coarse the commands are. A robot with a motor board receives all commands at once,
    with durations. A robot without one receives a command in each control interval.

    Parameters
    ----------
    robot
        The robot to drive.
    schedule
        The planned motion, which starts now.
    """

    def __init__(self, robot: Robot, schedule: Schedule) -> None:
        self._robot, self._schedule, self._time = robot, schedule, 0.0
        self._slot = robot.config.command_slot_ms / 1000
        self._slots = math.ceil(schedule.seconds / self._slot - 1e-9) if self._slot else 0
        self._sent = False

    @property
    def seconds(self) -> float:
        """Duration of all commands in seconds, once a motor board has started them."""
        return self._slots * self._slot or self._schedule.seconds

    def commands(self) -> list[tuple[WheelSpeeds, int]]:
        """List the commands for a motor board.

        Returns
        -------
        list of tuple
            Wheel speeds, and the number of slots that each pair lasts; empty for a robot without a board.
        """
        means = [self._schedule.mean(i * self._slot, (i + 1) * self._slot) for i in range(self._slots)]
        rounded = ((round(speed, 9), round(turn, 9)) for speed, turn in means)
        return [(self._wheels(*mean), len(list(equal))) for mean, equal in groupby(rounded)]

    def _wheels(self, speed: float, turn: float) -> WheelSpeeds:
        return self._robot.wheels_for(-speed if self._schedule.route.backward else speed, turn)

    def drive(self, dt: float) -> None:
        """Command the wheels for the next control interval.

        Parameters
        ----------
        dt
            Length of the interval, in seconds.
        """
        if not self._slot:
            mean = self._schedule.mean(self._time, self._time + dt)
            self._time += dt
            self._robot.drive(self._wheels(*mean))
        elif not self._sent:
            self._sent = True
            for wheels, slots in self.commands():
                self._robot.queue(wheels, slots)
