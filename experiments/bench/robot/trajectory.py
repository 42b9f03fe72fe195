"""Starts and courses of a trial's robots: the geometry of the paper's robot tests, from a condition and a seed."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass

import numpy as np

from colias_sim import Line, PathFollower, Pose
from experiments.bench.robot.experiment import Condition, Settings
from experiments.bench.streams import stream

ROBOT_RADIUS_CM = 2.0
MARGIN_CM = 0.6
"""Distance beyond the edge of the view at which a crossing starts and ends: room for the errors of the start pose."""

STILL_S = 0.3
"""Time for which the stimulus stands in view before an approach or recession, and after it."""


@dataclass(frozen=True, slots=True)
class Course:
    """Course that the stimulus is asked to take (m, s).

    From rest at ``start`` along ``line``, at ``speed`` from ``enter`` to ``leave`` along it. It stands still for
    ``wait`` before, and for ``rest`` after it has stopped at the line's end; without ``stop`` the trial ends as it
    passes ``leave``. ``observer`` is where the observer starts.
    """

    line: Line
    start: Pose
    enter: float
    leave: float
    speed: float
    acceleration: float
    stop: bool
    wait: float
    rest: float
    observer: Pose

    @property
    def seconds(self) -> float:
        """About how long the trial takes, in simulated time."""
        return self.wait + self.rest + self.line.length / self.speed + self.speed / self.acceleration


def half_crossing(distance: float, radius: float, hfov: float) -> float:
    """Sideways distance from the optical axis at which a disc of ``radius`` just leaves the view (m, m, rad)."""
    return distance * math.tan(hfov / 2) + radius / math.cos(hfov / 2)


def nominal(condition: Condition, settings: Settings) -> Course:
    """The course without errors of the start pose."""
    exact = dataclasses.replace(settings, pose_sd_mm=0.0, heading_sd_deg=0.0)
    return course(condition, exact, stream("course.nominal", 0))


def course(condition: Condition, settings: Settings, rng: np.random.Generator) -> Course:
    """The stimulus's path, with the errors of its start pose.

    In a crossing it drives straight where it was set down pointing. An approach or recession has a point to drive
    to, from where it was set down: there the error of heading is one that it has to correct on its way.
    """
    ideal = _crossing(condition, settings) if condition.motion == "translation" else _angular(condition, settings)
    dx, dy = rng.normal(0.0, settings.pose_sd_mm / 1000, 2)
    skew = rng.normal(0.0, math.radians(settings.heading_sd_deg))
    start, end = ideal.line.start, ideal.line.point(ideal.line.length)
    x, y = start.x + dx, start.y + dy
    if not ideal.stop:
        shifted = Pose(x, y, start.heading + skew)
        return dataclasses.replace(ideal, line=Line(shifted, ideal.line.length), start=shifted)
    towards = math.atan2(end.y - y, end.x - x)
    line = Line(Pose(x, y, towards), math.hypot(end.x - x, end.y - y))
    leave = line.length - (ideal.line.length - ideal.leave)
    return dataclasses.replace(ideal, line=line, leave=leave, start=Pose(x, y, towards + skew))


def _crossing(condition: Condition, settings: Settings) -> Course:
    camera = settings.camera
    distance, speed = condition.distance_cm / 100, condition.speed_cm_s / 100
    half = half_crossing(distance, ROBOT_RADIUS_CM / 100, math.radians(camera.hfov_deg)) + MARGIN_CM / 100
    acceleration = condition.acceleration_cm_s2 / 100
    run_up = PathFollower.run_up(speed, acceleration)
    side = 1.0 if condition.direction == "rightward" else -1.0  # y is the observer's left
    before, after = half, half
    if condition.observer_speed_cm_s or condition.observer_turn_deg_s:
        before, after = _seen_from_moving(condition, settings, run_up, side)
    start = Pose(camera.forward_cm / 100 + distance, side * (before + run_up), -side * math.pi / 2)
    length = run_up + before + after
    # When the stimulus is on the axis, the observer is at the origin.
    observer = _observer(condition, -(run_up + before) / speed)
    return Course(
        Line(start, length), start, run_up, length, speed, acceleration, stop=False, wait=0.0, rest=0.0,
        observer=observer,
    )  # fmt: skip


def _observer(condition: Condition, seconds: float) -> Pose:
    """Return where the observer is ``seconds`` after mid-crossing: straight ahead or turning on the spot."""
    drive, turn = condition.observer_speed_cm_s / 100, math.radians(condition.observer_turn_deg_s)
    return Pose(drive * seconds, 0.0, turn * seconds)


def _seen_from_moving(condition: Condition, settings: Settings, run_up: float, side: float) -> tuple[float, float]:
    """Tell how far from the middle the stimulus is out of a moving observer's view: when it starts, and when it has
    crossed.

    The view's edge moves while the stimulus drives up to it, so the distances are found by iteration. Raises
    ``ValueError`` where there is no such distance: the observer turns with the stimulus and never loses it.
    """
    speed = condition.speed_cm_s / 100
    distances = []
    for sign, extra in ((-1.0, run_up), (1.0, 0.0)):  # on the side it comes from, on the side it leaves to
        reach = 0.0
        for _ in range(200):
            seen_from = _observer(condition, sign * (reach + extra) / speed)
            edge = _view_edge(condition, settings, seen_from, -sign * side)
            if edge is None or edge > 1.0:
                raise ValueError(
                    f"the observer's turn of {condition.observer_turn_deg_s:g} degrees/s keeps a stimulus of "
                    f"{condition.speed_cm_s:g} cm/s in view"
                )
            if abs(edge - reach) < 1e-6:
                break
            reach = edge
        distances.append(max(reach, 0.0))
    return distances[0], distances[1]


def _view_edge(condition: Condition, settings: Settings, seen_from: Pose, side: float) -> float | None:
    """Tell how far out, on that ``side`` of the path (1: left), the stimulus just leaves the view; ``None`` if it
    cannot.
    """
    camera, radius = settings.camera, ROBOT_RADIUS_CM / 100
    forward = camera.forward_cm / 100
    ray = side * seen_from.heading + math.radians(camera.hfov_deg) / 2
    if not -math.pi / 2.2 < ray < math.pi / 2.2:
        return None
    lens_x = seen_from.x + forward * math.cos(seen_from.heading)
    lens_y = side * (seen_from.y + forward * math.sin(seen_from.heading))
    ahead = forward + condition.distance_cm / 100 - lens_x
    return lens_y + ahead * math.tan(ray) + radius / math.cos(ray) + MARGIN_CM / 100


def _angular(condition: Condition, settings: Settings) -> Course:
    """Between a point on the axis, ``distance_cm`` before the lens, and one ``far_cm`` from the lens."""
    if condition.angle_deg is None or condition.far_cm is None:
        raise ValueError(f"{condition.motion} needs angle_deg and far_cm")
    near, far, speed = condition.distance_cm / 100, condition.far_cm / 100, condition.speed_cm_s / 100
    outward = -math.radians(condition.angle_deg)  # negative angles on the left, where y is positive
    length = -near * math.cos(outward) + math.sqrt(far**2 - (near * math.sin(outward)) ** 2)
    point = Pose(settings.camera.forward_cm / 100 + near, 0.0, outward)
    away = Line(point, length)
    end = away.point(length)
    line = away if condition.motion == "recession" else Line(Pose(end.x, end.y, outward + math.pi), length)
    acceleration = condition.acceleration_cm_s2 / 100
    enter, leave = PathFollower.run_up(speed, acceleration), length - PathFollower.braking(speed, acceleration)
    if settings.robot.open_loop:  # the slot in which the ramp down begins is slower as a whole
        leave -= speed * settings.robot.command_slot_ms / 1000
    return Course(
        line, line.start, enter, leave, speed, acceleration, stop=True, wait=STILL_S, rest=STILL_S,
        observer=Pose(0.0, 0.0, 0.0),
    )  # fmt: skip


def reach_cm(route: Course) -> float:
    """Tell how far from the arena's centre the stimulus's edge gets, which has to stay inside the wall."""
    ends = (route.line.start, route.line.point(route.line.length))
    return 100 * max(math.hypot(end.x, end.y) for end in ends) + ROBOT_RADIUS_CM


def clearance_cm(condition: Condition, settings: Settings, route: Course) -> float:
    """Room between the bodies where they come nearest, less what 3 sd of the start pose's errors may take of it."""
    errors = 0.3 * settings.pose_sd_mm
    if condition.motion == "translation":  # a skewed approach or recession errs sideways, not ahead
        errors += 50 * route.line.length * math.sin(math.radians(3 * settings.heading_sd_deg))
    forward = 100 * abs(route.observer.x)
    return settings.camera.forward_cm + condition.distance_cm - 2 * ROBOT_RADIUS_CM - forward - errors
