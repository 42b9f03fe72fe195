"""Checks of paths of one's own against wheels, arena, bodies and view, before any trial runs."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator

from colias_sim import Pose, bearing
from colias_sim.config import RobotConfig
from colias_sim.motors import TOP_POWER
from experiments.bench.robot.experiment import Condition, Settings
from experiments.bench.robot.path import Leg, Path
from experiments.bench.robot.trajectory import ROBOT_RADIUS_CM, body_cm, nominal
from experiments.bench.run.errors import UsageError
from scenes import ARENA_RADIUS_CM

STEERING_SHARE = 0.95
"""Share of a wheel's top speed that a straight drive may use; the rest keeps it on its line."""

EVERY_S = 0.02
"""Time between two moments at which places are checked."""

Places = dict[str, list[Pose]]


def check(condition: Condition, settings: Settings) -> None:
    """Raise `UsageError` for paths that wheels, arena or bodies make impossible, and for one that is never seen."""
    label, paths = condition.label(), dict(_paths(condition))
    for name, path in paths.items():
        for index in range(len(path.legs)):
            _check_wheels(f"{label}: {name}.", path, index, settings.robot)
    course = nominal(condition, settings)
    scripts = {"path": course.stimulus, "observer": course.observer}
    scripts |= {f"movers[{i}]": mover for i, mover in enumerate(course.movers)}
    schedules = {name: script.schedule() for name, script in scripts.items()}
    moments = [i * EVERY_S for i in range(math.ceil(schedules["path"].seconds / EVERY_S) + 1)]
    places = {name: [schedule.pose(time) for time in moments] for name, schedule in schedules.items()}
    for name in paths:
        radius_cm = ROBOT_RADIUS_CM if name == "observer" else body_cm(settings)
        _check_wall(f"{label}: {name}", places[name], moments, radius_cm)
    _check_bodies(label, places, moments, settings)
    _check_view(label, places, settings)


def _paths(condition: Condition) -> Iterator[tuple[str, Path]]:
    if condition.path is not None:
        yield "path", condition.path
    if condition.observer is not None:
        yield "observer", condition.observer
    yield from ((f"movers[{i}]", mover) for i, mover in enumerate(condition.movers))


def _check_wheels(where: str, path: Path, index: int, robot: RobotConfig) -> None:
    """Refuse a leg that asks more of a wheel than it gives, or so little that its motor stands."""
    leg, step = path.legs[index], robot.power_step_cm_s
    top = STEERING_SHARE * robot.max_speed_cm_s
    limit = f"{STEERING_SHARE:.0%} of robot.max_speed_cm_s={robot.max_speed_cm_s:g}; the rest is for steering"
    if step and TOP_POWER * step < top:
        top, limit = TOP_POWER * step, f"what robot.power_step_cm_s={step:g} gives"
    if max(leg.speed_cm_s, leg.end_cm_s) > top:
        name, fastest = max(("speed_cm_s", leg.speed_cm_s), ("to_cm_s", leg.end_cm_s), key=lambda pair: pair[1])
        raise UsageError(
            f"{where}{path.where(index, name)}={fastest:.3g}: faster than the wheels: legal is up to {top:.4g} cm/s "
            f"({limit}); lower it"
        )
    rims = [speed + _turning(leg, speed, robot) for speed in (leg.speed_cm_s, leg.end_cm_s)]
    if max(rims) > top:
        remedy = "more length_cm or less speed_cm_s" if leg.length_cm else "more seconds"
        remedy = "wider bends, or less speed there" if path.of else remedy
        raise UsageError(
            f"{where}{path.where(index, 'turn_deg')}={leg.turn_deg:.3g}: it turns faster than the wheels: the outer "
            f"one would run at {max(rims):.3g} cm/s; legal is up to {top:.4g} cm/s ({limit}); give it {remedy}"
        )
    inner = [
        abs(speed - _turning(leg, speed, robot)) for speed in (leg.speed_cm_s, leg.end_cm_s) if speed or leg.turn_deg
    ]
    least = max(robot.dead_band, 1) * step
    if step and min(inner, default=least) < least:
        raise UsageError(
            f"{where}{path.where(index, 'speed_cm_s')}={leg.speed_cm_s:.3g}: a wheel would run at {min(inner):.3g} "
            f"cm/s; legal is from {least:.3g}, below which it stands (robot.dead_band={robot.dead_band}); raise it"
        )


def _turning(leg: Leg, speed: float, robot: RobotConfig) -> float:
    """Speed in cm/s that turning adds to the outer wheel."""
    turn = math.radians(abs(leg.turn_deg))
    if leg.length_cm:
        return turn / leg.length_cm * speed * robot.track_cm / 2
    return turn / leg.seconds * robot.track_cm / 2 if leg.seconds else 0.0


def _check_wall(where: str, poses: list[Pose], moments: list[float], radius_cm: float) -> None:
    reach, time = max(
        (100 * math.hypot(pose.x, pose.y) + radius_cm, time) for pose, time in zip(poses, moments, strict=True)
    )
    if reach > ARENA_RADIUS_CM:
        raise UsageError(
            f"{where}.x_cm, y_cm, legs: beyond the arena: {time:.2f} s after it starts, any run-up included, its body "
            f"is {reach:.1f} cm from the centre; legal is up to {ARENA_RADIUS_CM:g}; begin it elsewhere, or shorten it"
        )


def _check_bodies(label: str, places: Places, moments: list[float], settings: Settings) -> None:
    """Refuse robots that would touch, counting 3 sd of the errors with which the stimulus is set down."""
    skew, start = math.sin(math.radians(3 * settings.heading_sd_deg)), places["path"][0]
    for (one, ones), (other, others) in itertools.combinations(places.items(), 2):
        bodies = sum(ROBOT_RADIUS_CM if name == "observer" else body_cm(settings) for name in (one, other))
        for here, there, time in zip(ones, others, moments, strict=True):
            errors = 0.0
            if one == "path":
                errors = 0.3 * settings.pose_sd_mm + 100 * skew * math.hypot(here.x - start.x, here.y - start.y)
            room = 100 * math.hypot(here.x - there.x, here.y - there.y) - bodies - errors
            if room <= 0:
                raise UsageError(
                    f"{label}: {one}.x_cm, y_cm, legs: at {time:.2f} s its body comes within {room:.1f} cm of that of "
                    f"{other}, counting 3 sd of the start pose's errors; legal is above 0; lead it farther away"
                )


def _check_view(label: str, places: Places, settings: Settings) -> None:
    half, forward = settings.camera.hfov_deg / 2, settings.camera.forward_cm / 100
    seen = zip(places["observer"], places["path"], strict=True)
    nearest = min(abs(math.degrees(bearing(observer, stimulus, forward))) for observer, stimulus in seen)
    if nearest > half:
        raise UsageError(
            f"{label}: path.x_cm, y_cm, heading_deg: never in view: it comes no nearer to the optical axis than "
            f"{nearest:.0f} degrees; legal is within {half:g} (camera.hfov_deg={settings.camera.hfov_deg:g}); begin it "
            "elsewhere, or turn it"
        )
