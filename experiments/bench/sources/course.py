"""Starts and courses of a trial's robots: the geometry of the paper's robot tests, from a condition and a seed."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass

import numpy as np

from colias_sim import PathFollower, Pose, Route, Schedule, Stretch
from experiments.bench.run.streams import stream
from experiments.bench.sources.conditions import DEPTH, Condition
from experiments.bench.sources.experiment import Settings
from experiments.bench.sources.hand import Hand, pose_of
from experiments.bench.sources.path import Path

ROBOT_RADIUS_CM = 2.0
"""Radius of a hull, and of the stimulus's shell where the settings leave it as it is."""
MARGIN_CM = 0.6
"""Distance beyond the edge of the view at which a crossing starts and ends: room for the errors of the start pose."""

STILL_S = 0.3
"""Time for which the stimulus stands in view before an approach or recession, and after it."""

ALWAYS_S = 600.0
"""Longer than any trial."""


@dataclass(frozen=True, slots=True)
class Course:
    """The schedules of all robots of a trial (m, s). One with an acceleration of ``inf`` is driven by time alone.

    The stimulus is set down at ``start``. Its speed is measured in the ``parts`` of its route, each from one distance
    along it to another. A trial is over when it has come to the end of its route. The observer and the ``movers`` are
    set down where theirs begin.
    """

    stimulus: Schedule
    start: Pose
    parts: tuple[tuple[float, float], ...]
    observer: Schedule
    movers: tuple[Schedule, ...] = ()

    @property
    def others(self) -> dict[str, Schedule]:
        """The robots beside the stimulus, by name."""
        return {"observer": self.observer, **{f"mover{i}": mover for i, mover in enumerate(self.movers)}}


STANDING = Schedule(Route(Pose(0.0, 0.0, 0.0), (Stretch(seconds=ALWAYS_S),)), math.inf)
"""An observer that stands where it does in most trials."""


def body_cm(settings: Settings) -> float:
    """Return the radius of the stimulus with its shell, which may be wider than its hull."""
    return max(ROBOT_RADIUS_CM, settings.scene.shell_width_cm / 2)


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
    if condition.hand is not None:
        return _by_hand(condition.hand, settings)
    if condition.path is not None:
        ideal = _scripted(condition, condition.path, settings)
    else:
        ideal = _crossing(condition, settings) if condition.motion == "translation" else _angular(condition, settings)
    dx, dy = rng.normal(0.0, settings.pose_sd_mm / 1000, 2)
    skew = rng.normal(0.0, math.radians(settings.heading_sd_deg))
    route = ideal.stimulus.route
    start, end = route.start, route.point(route.length)
    x, y = start.x + dx, start.y + dy
    shifted = dataclasses.replace(route, start=Pose(x, y, start.heading + skew))
    if condition.motion in DEPTH:
        towards = math.atan2(end.y - y, end.x - x)
        length = math.hypot(end.x - x, end.y - y)
        stretches = tuple(dataclasses.replace(s, length=length) if s.moves else s for s in route.stretches)
        shifted = Route(Pose(x, y, towards), stretches)
    stimulus = Schedule(shifted, ideal.stimulus.acceleration)
    slot = settings.robot.command_slot_ms / 1000 if settings.robot.open_loop else 0.0
    heading = shifted.start.heading + (skew if condition.motion in DEPTH else 0.0)
    return dataclasses.replace(
        ideal, stimulus=stimulus, start=Pose(x, y, heading), parts=shifted.measured(stimulus.acceleration, slot)
    )


def _by_hand(hand: Hand, settings: Settings) -> Course:
    """Return where the robots are put down, and for how long; what they do there is in the hand's commands."""
    lasting = (Stretch(seconds=hand.frames / settings.camera.fps),)
    start, observer = pose_of(hand.stimulus), Route(pose_of(hand.observer), STANDING.route.stretches)
    return Course(Schedule(Route(start, lasting), math.inf), start, (), Schedule(observer, math.inf))


def _scripted(condition: Condition, path: Path, settings: Settings) -> Course:
    """Take the paths of a condition of one's own."""
    acceleration, ahead = condition.acceleration_cm_s2 / 100, settings.camera.forward_cm
    route = path.stimulus_route(condition.acceleration_cm_s2, ahead)
    observer = STANDING if condition.observer is None else Schedule(_to_rest(condition.observer.route()), acceleration)
    movers = tuple(Schedule(_to_rest(mover.route(ahead)), acceleration) for mover in condition.movers)
    return Course(Schedule(route, acceleration), route.start, (), observer, movers)


def _to_rest(route: Route) -> Route:
    """Return a route at whose end the robot stands for the rest of the trial."""
    return dataclasses.replace(route, stretches=(*route.stretches, Stretch(seconds=ALWAYS_S)))


def _crossing(condition: Condition, settings: Settings) -> Course:
    camera = settings.camera
    distance, speed = condition.distance_cm / 100, condition.speed_cm_s / 100
    half = half_crossing(distance, settings.scene.shell_width_cm / 200, math.radians(camera.hfov_deg)) + MARGIN_CM / 100
    acceleration = condition.acceleration_cm_s2 / 100
    run_up = PathFollower.run_up(speed, acceleration)
    side = 1.0 if condition.direction == "rightward" else -1.0  # y is the observer's left
    before, after = half, half
    if condition.observer_speed_cm_s or condition.observer_turn_deg_s:
        before, after = _seen_from_moving(condition, settings, run_up, side)
    start = Pose(camera.forward_cm / 100 + distance, side * (before + run_up), -side * math.pi / 2)
    length = run_up + before + after
    # When the stimulus is on the axis, the observer is at the origin.
    observer = _steady(condition, _observer(condition, -(run_up + before) / speed))
    return Course(Schedule(Route.line(start, length, speed), acceleration), start, (), observer)


def _steady(condition: Condition, start: Pose) -> Schedule:
    """Return the script of an observer that keeps driving and turning, from the first moment on."""
    drive, turn = condition.observer_speed_cm_s / 100, math.radians(condition.observer_turn_deg_s)
    if not (drive or turn):
        return STANDING
    if not drive:
        return Schedule(Route(start, (Stretch(seconds=ALWAYS_S, rate=turn),)), math.inf)
    if drive < 0:
        start = dataclasses.replace(start, heading=start.heading + math.pi)
    speed = abs(drive)
    stretch = Stretch(speed * ALWAYS_S, speed, speed, turn / speed)
    return Schedule(Route(start, (stretch,), backward=drive < 0), math.inf)


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
    camera, radius = settings.camera, settings.scene.shell_width_cm / 200
    forward = camera.forward_cm / 100
    ray = side * seen_from.heading + math.radians(camera.hfov_deg) / 2
    if not -math.pi / 2.2 < ray < math.pi / 2.2:
        return None
    lens_x = seen_from.x + forward * math.cos(seen_from.heading)
    lens_y = side * (seen_from.y + forward * math.sin(seen_from.heading))
    ahead = forward + condition.distance_cm / 100 - lens_x
    return lens_y + ahead * math.tan(ray) + radius / math.cos(ray) + MARGIN_CM / 100


def _angular(condition: Condition, settings: Settings) -> Course:
    """Return the course between a point on the axis, ``distance_cm`` before the lens, and one ``far_cm`` from it."""
    if condition.angle_deg is None or condition.far_cm is None:
        raise ValueError(f"{condition.motion} needs angle_deg and far_cm")
    near, far, speed = condition.distance_cm / 100, condition.far_cm / 100, condition.speed_cm_s / 100
    outward = -math.radians(condition.angle_deg)  # negative angles on the left, where y is positive
    length = -near * math.cos(outward) + math.sqrt(far**2 - (near * math.sin(outward)) ** 2)
    point = Pose(settings.camera.forward_cm / 100 + near, 0.0, outward)
    end = Stretch(length).point(point, length)
    start = point if condition.motion == "recession" else Pose(end.x, end.y, outward + math.pi)
    acceleration = condition.acceleration_cm_s2 / 100
    route = Route.line(start, length, speed, wait=STILL_S, rest=STILL_S)
    return Course(Schedule(route, acceleration), start, (), STANDING)
