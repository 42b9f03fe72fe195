"""Domain randomisation: the factors that may vary between episodes, their draws, and the resulting settings.

To add a factor, add an entry to `FACTORS`, and apply it in `changed`, or give it a value in `USUAL` and apply it in the
env's reset. No factor compiles the scene again.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np

from colias_sim import streams
from colias_sim.config import CameraConfig, RobotConfig, SceneConfig, check_tunable
from scenes.hints import nearest

Range = tuple[float, float]
"""The lower and the upper end of a factor's uniform distribution."""

WIDEST_LIGHT = 0.3
"""Largest change of the lamps, as a share of their light, at strength 1."""
WIDEST_SHELL = 0.4
"""Largest increase of the shells' reflectance at strength 1."""
WIDEST_MOTOR = 0.05
"""Largest change of each wheel's speed, as a share, at strength 1."""
WIDEST_TILT_DEG = 3.0
"""Largest tilt of the camera in pitch and in yaw, in degrees, at strength 1."""
USUAL_SHELL = SceneConfig().shell_grey
"""Default reflectance of the other robots' shells."""


@dataclass(frozen=True, slots=True)
class Factor:
    """One factor that may vary between episodes.

    Parameters
    ----------
    unit
        Unit of its values; empty for a share or a factor.
    low, high
        Bounds of its values.
    changes
        What it changes, in words.
    parts
        The names of its values in ``info["randomised"]``. Each is drawn from the same range.
    """

    unit: str
    low: float
    high: float
    changes: str
    parts: tuple[str, ...]


FACTORS: Mapping[str, Factor] = MappingProxyType({
    "light": Factor("", 0.05, 2.0, "the light of all lamps, times the arena's", ("light",)),
    "noise": Factor("", 0.0, 10.0, "the camera's photon and read noise (sd), times what else is set", ("noise",)),
    "ae_target": Factor("grey levels", 1.0, 254.0, "the target of a camera with auto exposure", ("ae_target",)),
    "row_time_us": Factor("us", 0.0, 20000.0, "the camera's time from a row to the next; 0: a global shutter",
                          ("row_time_us",)),
    "blur_px": Factor("px", 0.0, 8.0, "the lens's point spread (sd)", ("blur_px",)),
    "tilt": Factor("degrees", -15.0, 15.0, "the camera's direction: pitch and yaw, each drawn",
                   ("pitch_deg", "yaw_deg")),
    "wall": Factor("", 0.0, 4.0, "the contrast of the wall's texture, times the arena's", ("wall",)),
    "shell": Factor("", 0.0, 1.0, "the reflectance of the other robots' shells", ("shell",)),
    "start": Factor("cm", -20.0, 20.0, "the observer's start, moved ahead and to the left, each drawn; "
                    "less far where it would come within 1 cm of a robot or the wall", ("ahead_cm", "left_cm")),
    "mass_g": Factor("g", 10.0, 100.0, "the observer's mass; its moments of inertia stay", ("mass_g",)),
    "motor_gain": Factor("", 0.25, 2.5, "the gain of the observer's wheel servos, times the robot's", ("motor_gain",)),
    "wheel_gain": Factor("", 0.5, 1.5, "the commanded speeds of the observer's wheels, a factor for each",
                         ("left_wheel_gain", "right_wheel_gain")),
    "latency_ms": Factor("ms", 0.0, 500.0, "the time from an action to the command to the wheels, in whole control "
                         "intervals of 16.7 ms", ("latency_ms",)),
})  # fmt: skip
"""Name -> factor, in the order of a reset's ``info``."""

PRESET = "preset"
"""The key of a mapping that names a preset; the other entries are added to it."""

_LIGHT = 1.0 - WIDEST_LIGHT, 1.0 + WIDEST_LIGHT
_WHEELS = 1.0 - WIDEST_MOTOR, 1.0 + WIDEST_MOTOR
PRESETS: Mapping[str, Mapping[str, Range]] = MappingProxyType({
    # The ranges of strength 1, and a camera that is better or worse than its data sheet.
    "domain": {
        "light": _LIGHT, "noise": (0.5, 2.0), "blur_px": (0.0, 0.5), "tilt": (-WIDEST_TILT_DEG, WIDEST_TILT_DEG),
        "shell": (USUAL_SHELL, USUAL_SHELL + WIDEST_SHELL), "wheel_gain": _WHEELS,
    },
    # Around CameraConfig.preset("ov7670"); the deviation of a real camera is assumed.
    "ov7670": {
        "light": _LIGHT, "noise": (0.5, 2.0), "ae_target": (88.0, 128.0), "row_time_us": (376.0, 460.0),
        "blur_px": (0.15, 0.62),
    },
    # Around RobotConfig.preset("colias4"), likewise.
    "colias4": {"mass_g": (26.0, 30.0), "motor_gain": (0.8, 1.25), "wheel_gain": _WHEELS, "latency_ms": (0.0, 50.0)},
})  # fmt: skip
"""Name of a preset -> factor -> range."""

Values = dict[str, tuple[float, ...]]
"""Factor -> a value for each of its parts, in the factor's unit."""

USUAL: Values = {
    "light": (1.0,), "tilt": (0.0, 0.0), "wall": (1.0,), "shell": (USUAL_SHELL,), "start": (0.0, 0.0),
    "wheel_gain": (1.0, 1.0), "latency_ms": (0.0,),
}  # fmt: skip
"""The values of an episode without randomisation, of the factors that are no settings of the camera or the robot."""


def checked_randomise(value: Any) -> float | dict[str, Range]:
    """Check the argument ``randomise`` of an env.

    Parameters
    ----------
    value
        A number from 0 to 1, the name of a preset, or a mapping from factors to ranges.

    Returns
    -------
    float or dict
        The number, or the ranges in the order of `FACTORS`, including the preset's.

    Raises
    ------
    ValueError
        A name is unknown, or a value is out of range.
    """
    if isinstance(value, int | float | np.integer | np.floating) and 0.0 <= value <= 1.0:
        return float(value)
    if not isinstance(value, str | Mapping):
        raise ValueError(
            f"expected a number from 0 to 1, a preset ({', '.join(PRESETS)}), or {{factor: (low, high)}}, got {value!r}"
        )
    given = {PRESET: value} if isinstance(value, str) else dict(value)
    ranges = dict(_preset(given.pop(PRESET))) if PRESET in given else {}
    for name, ends in given.items():
        low, high = _checked(name, ends, 2)
        if low > high:
            raise ValueError(f"{name} must have its lower end first, got {ends!r}")
        ranges[name] = low, high
    return {name: ranges[name] for name in FACTORS if name in ranges}


def _preset(name: Any) -> Mapping[str, Range]:
    if name not in list(PRESETS):
        raise ValueError(f"no preset '{name}' ({nearest(name, PRESETS, after='; ')}all: {', '.join(PRESETS)})")
    return PRESETS[name]


def _checked(name: str, given: Any, count: int) -> tuple[float, ...]:
    """Check ``count`` values of a factor; ``ValueError`` for an unknown factor or a value out of its range."""
    if name not in FACTORS:
        raise ValueError(f"no factor '{name}' ({nearest(name, FACTORS, after='; ')}all: {', '.join(FACTORS)})")
    factor = FACTORS[name]
    try:
        values = np.atleast_1d(np.asarray(given, np.float64))
    except (TypeError, ValueError):
        values = np.empty(0)
    if values.shape != (count,) or not ((factor.low <= values) & (values <= factor.high)).all():
        numbers_ = "a number" if count == 1 else f"{count} numbers"
        ends = f"between {factor.low:g} and {factor.high:g} {factor.unit}".rstrip()
        raise ValueError(f"{name} must be {numbers_} {ends}, got {given!r}")
    return tuple(values.tolist())


def given_values(
    options: Mapping[str, Any], camera: CameraConfig, robot: RobotConfig, randomise: float | Mapping[str, Range],
    made_with: CameraConfig,
) -> Values:  # fmt: skip
    """Check the factors among the options of a reset.

    Parameters
    ----------
    options
        Factor -> a number, or two for a factor with two parts.
    camera, robot
        The settings of an episode without randomisation.
    randomise
        The checked argument of the env.
    made_with
        The settings that the camera was made with.

    Returns
    -------
    dict
        Factor -> its values.

    Raises
    ------
    ValueError
        A factor is unknown, a value is out of range, or this env's robot or camera refuses it.
    """
    values: Values = {}
    for name, given in options.items():
        values[name] = _checked(name, given, len(FACTORS[name].parts) if name in FACTORS else 1)
    if values:
        for end in camera_ends(camera, robot, randomise, values):
            check_tunable(end, made_with)
    return values


def apparatus_with(camera: CameraConfig, robot: RobotConfig, values: Values) -> tuple[CameraConfig, RobotConfig]:
    """Apply the values of factors that the settings of a camera and of a robot have.

    Parameters
    ----------
    camera, robot
        The settings without these values.
    values
        Factor -> its values.

    Returns
    -------
    tuple
        Camera and robot with these values.

    Raises
    ------
    ValueError
        The robot or the camera cannot have a value.
    """
    replace = dataclasses.replace
    for name, (value, *_) in values.items():
        match name:
            case "noise":
                shot, read = value * camera.shot_noise, value * camera.read_noise
                camera = replace(camera, shot_noise=shot, read_noise=read)
            case "ae_target" if not camera.auto_exposure:
                raise ValueError(
                    'ae_target changes nothing without auto_exposure: give camera="ov7670", or another with it'
                )
            case "ae_target" | "row_time_us" | "blur_px":
                camera = replace(camera, **{name: value})
            case "mass_g":
                robot = replace(robot, mass_g=value)
            case "motor_gain":
                robot = replace(robot, motor_gain=value * robot.motor_gain)
    return camera, robot


def camera_ends(
    camera: CameraConfig, robot: RobotConfig, randomise: float | Mapping[str, Range], given: Values | None = None
) -> tuple[CameraConfig, CameraConfig]:
    """Compute the camera's settings with all factors at the lower, and at the upper end of their ranges.

    Parameters
    ----------
    camera, robot
        The settings without randomisation.
    randomise
        The checked argument of the env.
    given
        Factor -> given values, which replace both ends.

    Returns
    -------
    tuple of CameraConfig
        Lower and upper settings. A number only varies values that no robot or camera refuses.

    Raises
    ------
    ValueError
        The robot or the camera cannot have a value.
    """
    ranges = randomise if isinstance(randomise, Mapping) else {}
    low, high = ({name: (both[end],) * len(FACTORS[name].parts) for name, both in ranges.items()} for end in (0, 1))
    return apparatus_with(camera, robot, low | (given or {}))[0], apparatus_with(camera, robot, high | (given or {}))[0]


def draw(randomise: float | Mapping[str, Range], given: Values, world: np.random.Generator, episode: int) -> Values:
    """Draw the values of an episode's factors.

    Six numbers are always drawn from the world, so that ``randomise`` does not change later draws. Factors with ranges
    have their own streams, so that no factor changes another's draws.

    Parameters
    ----------
    randomise
        The checked argument of the env: a strength from 0 (none) to 1 (widest), or ranges.
    given
        Factor -> given values, which are not drawn. They change no other draw.
    world
        The generator of the episode's world.
    episode
        The seed of the episode's own streams, from `colias_sim.streams.episode`.

    Returns
    -------
    dict
        Factor -> its values, drawn or given, in the order of `FACTORS`.
    """
    light, shell, left, right, pitch, yaw = world.uniform(-1.0, 1.0, 6).tolist()
    values: Values = {}
    if isinstance(randomise, Mapping):
        for name, range_ in randomise.items():
            if name not in given:
                count = len(FACTORS[name].parts)
                values[name] = tuple(streams.factor(episode, name).uniform(*range_, count).tolist())
    elif randomise > 0.0:
        values["light"] = (1.0 + randomise * WIDEST_LIGHT * light,)
        values["shell"] = (USUAL_SHELL + randomise * WIDEST_SHELL * (shell + 1.0) / 2,)
        values["wheel_gain"] = 1.0 + randomise * WIDEST_MOTOR * left, 1.0 + randomise * WIDEST_MOTOR * right
        values["tilt"] = pitch * randomise * WIDEST_TILT_DEG, yaw * randomise * WIDEST_TILT_DEG
    values |= given
    return {name: values[name] for name in FACTORS if name in values}
