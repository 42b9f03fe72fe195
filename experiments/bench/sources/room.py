"""Room for the robots of trials: wheels, wall, bodies, view and arena, checked before any trial runs."""

from __future__ import annotations

import functools
import math
from collections.abc import Iterable, Mapping, Sequence
from itertools import combinations
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from colias_sim import Pose, Schedule, bearing
from colias_sim.arena import Arena
from colias_sim.config import RobotConfig, SceneConfig
from colias_sim.motors import TOP_POWER, Motors
from experiments.bench.run.errors import UsageError
from experiments.bench.sources.conditions import DEPTH, Condition
from experiments.bench.sources.course import ROBOT_RADIUS_CM, Course, body_cm, nominal
from experiments.bench.sources.experiment import Settings
from scenes import ARENA_RADIUS_CM, ARENAS

if TYPE_CHECKING:
    from colias_sim.obstacles import Obstacle

STEERING_SHARE = 0.95
"""Share of a wheel's top speed that a drive along a path may use; the rest keeps it there."""
SHORTEST_STEADY_CM = 2.0
"""Least length of a line that must be left at constant speed: the speed is measured there."""
EVERY_S = 0.02
"""Time between two moments at which places are checked."""

Places = Mapping[str, Sequence[Pose]]


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
    return [*map(str, read(scene.arena).files if scene.arena not in ARENAS else ()), *pictures]


def read(source: str) -> Arena:
    """Read an arena; `UsageError` where it is refused."""
    try:
        return Arena.read(source)
    except ValueError as error:
        raise UsageError(str(error)) from error


def obstacles(source: str) -> tuple[Obstacle, ...]:
    """List what stands in an arena, by its name or the path of its file; those that ship are empty rooms.

    Raises
    ------
    UsageError
        The arena is refused, in one line.
    """
    return () if source in ARENAS else _obstacles(source, tuple(read(source).files.items()))


@functools.lru_cache(maxsize=4)
def _obstacles(source: str, _digests: tuple[object, ...]) -> tuple[Obstacle, ...]:
    from colias_sim.obstacles import obstacles as standing
    from colias_sim.scene import compile_arena

    try:
        return standing(compile_arena(source))
    except ValueError as error:
        raise UsageError(str(error)) from error


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
            try:
                _check(condition, settings, around)
            except ValueError as error:
                raise UsageError(f"{condition.label()}: {error}") from None


def _check(condition: Condition, settings: Settings, around: Sequence[Obstacle]) -> None:
    course = nominal(condition, settings)
    schedules = {"stimulus": course.stimulus, **course.others}
    for name, schedule in schedules.items():
        _check_wheels(name, schedule, settings.robot)
    if condition.path is None:
        _check_steady(condition, course)
    moments = [i * EVERY_S for i in range(math.ceil(schedules["stimulus"].seconds / EVERY_S) + 1)]
    places = {
        name: [schedule.pose(time) for time in moments]
        if any(stretch.moves or stretch.rate for stretch in schedule.route.stretches)
        else [schedule.pose(0.0)] * len(moments)
        for name, schedule in schedules.items()
    }
    radii = {name: ROBOT_RADIUS_CM if name == "observer" else body_cm(settings) for name in places}
    at = {name: 100 * np.array([(pose.x, pose.y) for pose in poses]) for name, poses in places.items()}
    skew = 0.0 if condition.motion in DEPTH else math.sin(math.radians(3 * settings.heading_sd_deg))
    errors = 0.3 * settings.pose_sd_mm + skew * np.hypot(*(at["stimulus"] - at["stimulus"][0]).T)
    for name in places:
        reach = float(np.hypot(*at[name].T).max()) + radii[name]
        if reach > ARENA_RADIUS_CM:
            raise ValueError(
                f"the {name} reaches {reach:.0f} cm from the centre; the arena ends at {ARENA_RADIUS_CM:g}"
            )
    for one, other in combinations(places, 2):
        room = np.hypot(*(at[one] - at[other]).T) - radii[one] - radii[other] - (errors if one == "stimulus" else 0.0)
        if room.min() <= 0.0:
            raise ValueError(
                f"{one} and {other} would touch: {moments[int(room.argmin())]:.2f} s after the start their bodies come "
                f"within {room.min():.1f} cm, counting 3 sd of the start pose's errors"
            )
    _check_view(places, settings)
    for obstacle in around:
        for name in places:
            room = 100 * obstacle.distances(at[name] / 100) - radii[name] - (errors if name == "stimulus" else 0.0)
            if room.min() <= 0.0:
                first = int(np.argmax(room <= 0.0))
                raise ValueError(
                    f"the {name} meets the obstacle {obstacle.name} {moments[first]:.2f} s after the start, at "
                    f"({at[name][first][0]:.1f}, {at[name][first][1]:.1f}) cm: move it, or lead the robot elsewhere"
                )


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
                raise ValueError(
                    f"a wheel of the {name} would run at {fastest:.3g} cm/s; it must be at most {top:.4g}: slow it "
                    "down, or give it wider bends"
                )
            powers = motors.powers(*wheels) if motors else wheels
            if any(wheel and abs(power) < least for wheel, power in zip(wheels, powers, strict=True)):
                raise ValueError(f"a wheel of the {name} would stand: its power {powers} is below {least} of 255")


def _check_steady(condition: Condition, course: Course) -> None:
    ((enter, leave),) = course.parts
    if leave - enter < SHORTEST_STEADY_CM / 100:
        raise ValueError(
            f"with acceleration_cm_s2={condition.acceleration_cm_s2:g} its line of "
            f"{100 * course.stimulus.route.length:.1f} cm is too short to reach that speed"
        )


def _check_view(places: Places, settings: Settings) -> None:
    half, forward = settings.camera.hfov_deg / 2, settings.camera.forward_cm / 100
    seen = zip(places["observer"], places["stimulus"], strict=True)
    nearest = min(abs(math.degrees(bearing(observer, stimulus, forward))) for observer, stimulus in seen)
    if nearest > half:
        raise ValueError(
            f"the stimulus is never in view: it comes no nearer to the optical axis than {nearest:.0f} degrees, and "
            f"half the view is {half:g}"
        )
