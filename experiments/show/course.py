"""Courses of a trial's robots, from a condition and a seed; the room that they need is checked before any trial."""

from __future__ import annotations

import dataclasses
import functools
import math
from collections.abc import Iterable, Sequence
from itertools import combinations, product
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from colias_sim import PathFollower, Pose, Route, Schedule, Stretch, bearing
from colias_sim.arena import arena_files
from colias_sim.config import RobotConfig, SceneConfig
from colias_sim.motors import TOP_POWER, Motors
from experiments.base.errors import as_usage_error
from experiments.base.streams import stream
from experiments.declare.conditions import DEPTH, Condition, Hand, Trajectory, pose_of
from experiments.settings.settings import Settings
from scenes import ARENAS

if TYPE_CHECKING:
    from colias_sim.obstacles import Obstacle

ROBOT_RADIUS_CM = 2.0
"""Radius of a hull, and of the stimulus's shell where the settings leave it as it is."""
MARGIN_CM = 0.6
"""Distance beyond the edge of the view at which a crossing starts and ends: room for the errors of the start pose."""

STILL_S = 0.3
"""Time for which the stimulus stands in view before an approach or recession, and after it."""

ALWAYS_S = 600.0
"""Longer than any trial."""


Course = dict[str, Schedule]
"""The schedule of each robot of a trial (m, s), the stimulus first. One with an acceleration of ``inf`` is driven by
time alone. A trial is over when the stimulus has come to the end of its route. The others are set down where theirs
begin.
"""
STANDING = Schedule(Route(Pose(0.0, 0.0, 0.0), (Stretch(seconds=ALWAYS_S),)), math.inf)
"""An observer that stands where it does in most trials."""


def half_crossing(distance: float, radius: float, hfov: float) -> float:
    """Sideways distance from the optical axis at which a disc of ``radius`` just leaves the view (m, m, rad)."""
    return distance * math.tan(hfov / 2) + radius / math.cos(hfov / 2)


def nominal(condition: Condition, settings: Settings) -> Course:
    """Return the course without errors of the start pose."""
    exact = dataclasses.replace(settings, pose_sd_mm=0.0, heading_sd_deg=0.0)
    return course(condition, exact, stream("course.nominal", 0))[0]


def course(condition: Condition, settings: Settings, rng: np.random.Generator) -> tuple[Course, Pose]:
    """Return the course with the errors of the stimulus's start, and the pose at which that is set down.

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
    route, acceleration = ideal["stimulus"].route, ideal["stimulus"].acceleration
    start, end = route.start, route.point(route.length)
    x, y = start.x + dx, start.y + dy
    shifted = dataclasses.replace(route, start=Pose(x, y, start.heading + skew))
    if condition.motion in DEPTH:
        towards = math.atan2(end.y - y, end.x - x)
        length = math.hypot(end.x - x, end.y - y)
        stretches = tuple(dataclasses.replace(s, length=length) if s.moves else s for s in route.stretches)
        shifted = Route(Pose(x, y, towards), stretches)
    heading = shifted.start.heading + (skew if condition.motion in DEPTH else 0.0)
    return {**ideal, "stimulus": Schedule(shifted, acceleration)}, Pose(x, y, heading)


def measured(stimulus: Schedule, robot: RobotConfig) -> tuple[tuple[float, float], ...]:
    """Return the parts of the stimulus's route in which its speed is measured, each between two distances along it."""
    return stimulus.route.measured(stimulus.acceleration, robot.command_slot_ms / 1000 if robot.open_loop else 0.0)


def _by_hand(hand: Hand, settings: Settings) -> tuple[Course, Pose]:
    """Return where the robots are put down, and for how long; what they do there is in the hand's commands."""
    lasting = (Stretch(seconds=hand.frames / settings.camera.fps),)
    start, observer = pose_of(hand.stimulus), Route(pose_of(hand.observer), STANDING.route.stretches)
    return {"stimulus": Schedule(Route(start, lasting), math.inf), "observer": Schedule(observer, math.inf)}, start


def _scripted(condition: Condition, path: Trajectory, settings: Settings) -> Course:
    """Take the paths of a condition of one's own."""
    acceleration, ahead = condition.acceleration_cm_s2 / 100, settings.camera.forward_cm
    route = path.stimulus_route(condition.acceleration_cm_s2, ahead)
    observer = STANDING if condition.observer is None else Schedule(_to_rest(condition.observer.route()), acceleration)
    movers = (Schedule(_to_rest(mover.route(ahead)), acceleration) for mover in condition.movers)
    named = {f"mover{i}": mover for i, mover in enumerate(movers)}
    return {"stimulus": Schedule(route, acceleration), "observer": observer, **named}


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
    return {"stimulus": Schedule(Route.line(start, length, speed), acceleration), "observer": observer}


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
                turn = f"the observer's turn of {condition.observer_turn_deg_s:g} degrees/s"
                raise ValueError(f"{turn} keeps a stimulus of {condition.speed_cm_s:g} cm/s in view")
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
    assert condition.angle_deg is not None and condition.far_cm is not None, "a condition in depth has both"
    near, far, speed = condition.distance_cm / 100, condition.far_cm / 100, condition.speed_cm_s / 100
    outward = -math.radians(condition.angle_deg)  # negative angles on the left, where y is positive
    length = -near * math.cos(outward) + math.sqrt(far**2 - (near * math.sin(outward)) ** 2)
    point = Pose(settings.camera.forward_cm / 100 + near, 0.0, outward)
    end = Stretch(length).point(point, length)
    start = point if condition.motion == "recession" else Pose(end.x, end.y, outward + math.pi)
    acceleration = condition.acceleration_cm_s2 / 100
    route = Route.line(start, length, speed, wait=STILL_S, rest=STILL_S)
    return {"stimulus": Schedule(route, acceleration), "observer": STANDING}


# --- room -------------------------------------------------------------------------------------------------------------

STEERING_SHARE = 0.95
"""Share of a wheel's top speed that a drive along a path may use; the rest keeps it there."""
SHORTEST_STEADY_CM = 2.0
"""Least length of a line that must be left at constant speed: the speed is measured there."""
EVERY_S = 0.02
"""Time between two moments at which places are checked."""


def files(scene: SceneConfig) -> list[str]:
    """List the user's own files that a scene is made of.

    Parameters
    ----------
    scene
        The scene's settings.

    Returns
    -------
    list of str
        Absolute paths: of the arena with what it names, and of the pictures on wall and shell.

    Raises
    ------
    UsageError
        The arena cannot be read.
    """
    pictures = [str(Path(path).resolve()) for path in (scene.wall, scene.shell_picture) if path]
    return [*map(str, _own_files(scene.arena)), *pictures]


def _own_files(source: str) -> dict[Path, str]:
    """List a user's own files of an arena with their digests; `UsageError` where it is refused."""
    with as_usage_error():
        return arena_files(source)


def obstacles(source: str) -> tuple[Obstacle, ...]:
    """List what stands in an arena, by its name or the path of its file; those that ship are empty rooms.

    Raises
    ------
    UsageError
        The arena is refused, in one line.
    """
    return () if source in ARENAS else _obstacles(source, tuple(_own_files(source).items()))


@functools.lru_cache(maxsize=4)
def _obstacles(source: str, _digests: tuple[object, ...]) -> tuple[Obstacle, ...]:
    from colias_sim.obstacles import obstacles as standing
    from colias_sim.scene import compile_arena

    with as_usage_error():
        return standing(compile_arena(source))


def check(conditions: Iterable[Condition], settings: Settings) -> None:
    """Check that the trials of conditions are possible. Those driven by hand are not checked.

    Raises
    ------
    UsageError
        Wheels are too slow or would stand, robots would touch each other, the wall or an obstacle, counting 3 sd of
        the errors with which the stimulus is set down, or the stimulus never comes into view. In one line.
    """
    around = obstacles(settings.scene.arena)
    for condition in conditions:
        if condition.hand is None:
            with as_usage_error(f"{condition.label()}: "):
                _check(condition, settings, around)


def _check(condition: Condition, settings: Settings, around: Sequence[Obstacle]) -> None:
    schedules = nominal(condition, settings)
    stimulus = schedules["stimulus"]
    for name, schedule in schedules.items():
        _check_wheels(name, schedule, settings.robot)
    begin, end = (0.0, math.inf) if condition.path else measured(stimulus, settings.robot)[0]
    if end - begin < SHORTEST_STEADY_CM / 100:
        line = f"its line of {100 * stimulus.route.length:.1f} cm is too short to reach that speed"
        raise ValueError(f"with acceleration_cm_s2={condition.acceleration_cm_s2:g} {line}")
    moments = [i * EVERY_S for i in range(math.ceil(stimulus.seconds / EVERY_S) + 1)]
    places = {name: [schedule.pose(time) for time in moments] for name, schedule in schedules.items()}
    body_cm = max(ROBOT_RADIUS_CM, settings.scene.shell_width_cm / 2)  # a shell may be wider than the hull
    radii = {name: ROBOT_RADIUS_CM if name == "observer" else body_cm for name in places}
    at = {name: 100 * np.array([(pose.x, pose.y) for pose in poses]) for name, poses in places.items()}
    skew = 0.0 if condition.motion in DEPTH else math.sin(math.radians(3 * settings.heading_sd_deg))
    errors = 0.3 * settings.pose_sd_mm + skew * np.hypot(*(at["stimulus"] - at["stimulus"][0]).T)
    for name in places:
        reach = float(np.hypot(*at[name].T).max()) + radii[name]
        if reach > settings.scene.wall_cm:
            raise ValueError(f"the {name} reaches {reach:.0f} cm; the arena ends at {settings.scene.wall_cm:g}")
    half, forward = settings.camera.hfov_deg / 2, settings.camera.forward_cm / 100
    seen = zip(places["observer"], places["stimulus"], strict=True)
    nearest = min(abs(math.degrees(bearing(observer, stimulus, forward))) for observer, stimulus in seen)
    if nearest > half:
        raise ValueError(f"the stimulus is never in view: {nearest:.0f} degrees off, and half the view is {half:g}")
    rooms = [
        (one, f"{one} and {other} would touch", np.hypot(*(at[one] - at[other]).T) - radii[one] - radii[other])
        for one, other in combinations(places, 2)
    ]
    for name, obstacle in product(places, around):
        room = 100 * obstacle.distances(at[name] / 100) - radii[name]
        rooms.append((name, f"the {name} meets the obstacle {obstacle.name}", room))
    for name, text, room in rooms:
        touching = room - (errors if name == "stimulus" else 0.0) <= 0.0
        if touching.any():
            first = moments[int(np.argmax(touching))]
            raise ValueError(f"{text} {first:.2f} s after the start, counting 3 sd of the start pose's errors")


def _check_wheels(name: str, script: Schedule, robot: RobotConfig) -> None:
    """Refuse speeds that a wheel does not reach, and those at which its motor stands."""
    step, top = robot.power_step_cm_s, robot.max_speed_cm_s
    if not math.isinf(script.acceleration):
        top *= STEERING_SHARE
    motors, least = (Motors(robot), max(robot.dead_band, 1)) if step else (None, 0)
    if step:
        top = min(top, (TOP_POWER + 0.5) * step)
    for stretch in script.route.stretches:
        for speed in (stretch.speed, stretch.end_speed) if stretch.moves else (0.0,):
            turn = (stretch.curvature * speed if stretch.moves else stretch.rate) * robot.track_cm / 200
            wheels = (speed - turn, speed + turn)
            fastest = 100 * max(map(abs, wheels))
            if fastest > top + 1e-9:
                wheel = f"a wheel of the {name} would run at {fastest:.3g} cm/s; it must be at most {top:.4g}"
                raise ValueError(f"{wheel}: slow it down, or give it wider bends")
            powers = motors.powers(*wheels) if motors else wheels
            if any(wheel and abs(power) < least for wheel, power in zip(wheels, powers, strict=True)):
                raise ValueError(f"a wheel of the {name} would stand: its power {powers} is below {least} of 255")
