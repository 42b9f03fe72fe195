"""The options of an env's reset: values of factors, and start poses, for one episode."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from colias_sim.config import CameraConfig
from colias_sim.envs.episode_settings import EpisodeSettings
from colias_sim.envs.factors import FACTORS, Factor, reason
from colias_sim.envs.flags import is_flag, one_line, whole
from colias_sim.envs.geometry import ARENA_RADIUS, CLEARANCE, HULL_RADIUS, gap_to_arena, random_poses
from colias_sim.envs.world import OBSERVER
from colias_sim.pose import Pose
from colias_sim.tuning import check_tunable
from scenes.hints import nearest

if TYPE_CHECKING:
    from colias_sim.obstacles import Obstacle

POSES = "poses"
"""The option that has start poses; every other option is the name of a factor."""
START = "start"
"""The factor that moves the observer's start; a pose of the observer stands in its place."""
FARTHEST_CM = 100 * (ARENA_RADIUS - HULL_RADIUS - CLEARANCE)
"""Largest distance of a given start from the arena's middle, in cm."""
_APART = 2 * HULL_RADIUS + CLEARANCE


@dataclass(frozen=True, slots=True)
class ResetOptions:
    """Options of one episode, checked.

    Parameters
    ----------
    values
        Factor -> a value for each of its parts, in the factor's unit.
    poses
        Robot -> its start.
    """

    values: Mapping[str, tuple[float, ...]] = field(default_factory=dict)
    poses: Mapping[str, Pose] = field(default_factory=dict)


def checked_seed(seed: Any) -> int | None:
    """Check the argument ``seed`` of an env's ``reset``.

    Parameters
    ----------
    seed
        A whole number of any type, or ``None``.

    Returns
    -------
    int or None
        The same.

    Raises
    ------
    ValueError
        In one line that names the value and what is legal.
    """
    number = whole(seed)
    if seed is not None and (number is None or number < 0):
        raise ValueError(f"seed={one_line(seed)}: expected a whole number from 0, or None")
    return number


def checked_reset_options(
    given: Mapping[str, Any] | None, plain: EpisodeSettings, made_with: CameraConfig, robots: Collection[str],
    obstacles: Collection[Obstacle] = (),
) -> ResetOptions:  # fmt: skip
    """Check the argument ``options`` of an env's ``reset``.

    Parameters
    ----------
    given
        Names of factors -> a number, or two for a factor with two parts; ``poses`` -> {robot: (x_cm, y_cm,
        heading_deg)}. ``None`` is the same as none.
    plain
        The settings of an episode without randomisation.
    made_with
        The settings that the camera was made with.
    robots
        The names of the env's robots.
    obstacles
        What stands in the arena.

    Returns
    -------
    ResetOptions
        The same; values in the order of `FACTORS`.

    Raises
    ------
    ValueError
        In one line that names the option, its value and what is legal.
    """
    if given is None:
        return ResetOptions()
    if not isinstance(given, Mapping):
        raise ValueError(f"reset(options={one_line(given)}): expected a mapping from names to values")
    known = (*FACTORS, POSES)
    for name in given:
        if name not in known:
            near = nearest(name, known, after="; ")
            raise ValueError(f"reset(options): no such option '{name}' ({near}all: {', '.join(known)})")
    values = {name: _values(factor, given[name]) for name, factor in FACTORS.items() if name in given}
    _check_together(values, plain, made_with)
    poses = _poses(given.get(POSES, {}), robots, obstacles)
    if OBSERVER in poses:
        if START in values:
            raise ValueError(f"reset(options): {START} and a pose of '{OBSERVER}': give one of the two")
        values[START] = (0.0, 0.0)
    return ResetOptions(values, poses)


def placed(
    places: Mapping[str, Pose], given: Mapping[str, Pose], rng: np.random.Generator,
    obstacles: Collection[Obstacle] = (),
) -> dict[str, Pose]:  # fmt: skip
    """Put robots at given starts; others that would stand in the way are drawn anew.

    Parameters
    ----------
    places
        The start of every robot, as drawn.
    given
        The starts that were asked for. No two are nearer to each other than `CLEARANCE`.
    rng
        Generator of the starts that are drawn anew.
    obstacles
        What stands in the arena.

    Returns
    -------
    dict
        The starts. Robots that are not in ``given`` stay where they were drawn, unless their hull would come within
        `CLEARANCE` of a given one.
    """
    poses = {**places, **given}
    for name in places:
        if name not in given and _near(poses[name], given.values()):
            others = [pose for other, pose in poses.items() if other != name]
            (poses[name],) = random_poses(rng, 1, others, clear=_APART, obstacles=obstacles)
    return poses


def _near(pose: Pose, others: Iterable[Pose]) -> bool:
    return any(math.hypot(pose.x - other.x, pose.y - other.y) < _APART for other in others)


def _values(factor: Factor, given: Any) -> tuple[float, ...]:
    """Return a value for each part of a factor, checked."""
    legal = f"{factor.low:g} .. {factor.high:g}" + (f" {factor.unit}" if factor.unit else "")
    wanted = "a number" if len(factor.parts) == 1 else f"two numbers ({', '.join(factor.parts)})"
    values = _numbers(given, len(factor.parts))
    if values is None:
        raise ValueError(f"reset(options): {factor.name}={one_line(given)}: expected {wanted} in {legal}")
    if not all(factor.low <= value <= factor.high for value in values):
        raise ValueError(f"reset(options): {factor.name}={one_line(given)}: legal is {legal}")
    return values


def _numbers(given: Any, count: int) -> tuple[float, ...] | None:
    """``count`` numbers as floats; ``None`` for anything else."""
    try:
        numbers = (given,) if np.ndim(given) == 0 else tuple(given)
    except ValueError:  # rows of different lengths
        return None
    if len(numbers) != count or any(isinstance(one, str | bytes) or is_flag(one) for one in numbers):
        return None
    try:
        return tuple(float(one) for one in numbers)
    except (TypeError, ValueError, OverflowError):  # the last: a whole number beyond the floats
        return None


def _check_together(
    values: Mapping[str, tuple[float, ...]], plain: EpisodeSettings, made_with: CameraConfig
) -> None:  # fmt: skip
    """Raise ``ValueError`` for values that this env's robot and camera cannot take without being compiled anew."""
    settings = plain
    lamps, bands = made_with.auto_exposure or made_with.gain != 1.0, made_with.row_time_us > 0.0
    for name, values_of_name in values.items():
        try:
            settings = FACTORS[name].change(settings, values_of_name)
            check_tunable(settings.camera, made_with, lamps=lamps, bands=bands)
        except ValueError as error:
            shown_value = values_of_name[0] if len(values_of_name) == 1 else values_of_name
            raise ValueError(f"reset(options): {name}={shown_value}: {reason(error)}") from None


def _poses(given: Any, robots: Collection[str], obstacles: Collection[Obstacle]) -> dict[str, Pose]:
    """Start poses, checked against the arena, its obstacles and each other."""
    if not isinstance(given, Mapping):
        raise ValueError(f"reset(options): poses={one_line(given)}: expected {{robot: (x_cm, y_cm, heading_deg)}}")
    poses: dict[str, Pose] = {}
    for name, place in given.items():
        if name not in robots:
            near = nearest(name, robots, after="; ")
            raise ValueError(f"reset(options): poses: no robot '{name}' ({near}all: {', '.join(robots)})")
        numbers = _numbers(place, 3)
        if numbers is None or not all(map(math.isfinite, numbers)):
            raise ValueError(
                f"reset(options): poses: {name}={one_line(place)}: expected three numbers, x_cm, y_cm, heading_deg"
            )
        x_cm, y_cm, heading_deg = numbers
        if math.hypot(x_cm, y_cm) > FARTHEST_CM + 1e-9:
            raise ValueError(
                f"reset(options): poses: {name}={one_line(place)}: "
                f"legal is up to {FARTHEST_CM:g} cm from the arena's middle"
            )
        pose = Pose(x_cm / 100, y_cm / 100, math.radians(heading_deg))
        if _near(pose, poses.values()):
            raise ValueError(
                f"reset(options): poses: {name}={one_line(place)} is within {100 * _APART:g} cm of another robot's: "
                f"expected {100 * _APART:g} cm or more between centres"
            )
        if gap_to_arena(pose, obstacles)[0] < CLEARANCE - 1e-9:
            raise ValueError(
                f"reset(options): poses: {name}={one_line(place)} is within {100 * CLEARANCE:g} cm of an obstacle: "
                "expected a place that is free"
            )
        poses[name] = pose
    return poses
