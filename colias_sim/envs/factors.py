"""The factors of ``randomise``: what may vary from episode to episode, between which ends, and how.

To add a factor, add an entry to `FACTORS`. Nothing is compiled anew for any of them.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np
from pydantic import ValidationError

from colias_sim import streams
from colias_sim.config import SceneConfig
from colias_sim.envs.episode_settings import EpisodeSettings
from colias_sim.envs.flags import is_flag
from scenes.hints import nearest

Range = tuple[float, float]
"""The lower and the upper end of what a factor is drawn from, uniformly."""

WIDEST_LIGHT = 0.3
"""Largest change of the lamps, as a share of their light, at strength 1."""
WIDEST_SHELL = 0.4
"""Largest increase of the shells' reflectance at strength 1."""
WIDEST_MOTOR = 0.05
"""Largest change of each wheel's speed, as a share, at strength 1."""
WIDEST_TILT_DEG = 3.0
"""Largest tilt of the camera in pitch and in yaw, in degrees, at strength 1."""


@dataclass(frozen=True, slots=True)
class Factor:
    """One thing that may vary.

    Parameters
    ----------
    name
        The key in ``randomise``.
    unit
        Unit of its values; empty for a share or a factor.
    low, high
        The legal ends of a range.
    changes
        What it changes, in words.
    change
        Gives the settings of an episode with the values drawn. Raises ``ValueError`` where these are not legal.
    parts
        The names of the values drawn, as ``info["randomised"]`` has them. Each is drawn from the same range.
    """

    name: str
    unit: str
    low: float
    high: float
    changes: str
    change: Callable[[EpisodeSettings, tuple[float, ...]], EpisodeSettings]
    parts: tuple[str, ...]

    def draw(self, episode: int, ends: Range) -> tuple[float, ...]:
        """Draw the values of an episode, from the factor's own stream of the episode's seed."""
        return tuple(streams.factor(episode, self.name).uniform(*ends, len(self.parts)).tolist())


def _camera(name: str) -> Callable[[EpisodeSettings, tuple[float, ...]], EpisodeSettings]:
    """Change one setting of the camera."""

    def change(settings: EpisodeSettings, values: tuple[float, ...]) -> EpisodeSettings:
        camera = dataclasses.replace(settings.camera, **{name: values[0]})  # type: ignore[arg-type]
        return dataclasses.replace(settings, camera=camera)

    return change


def _own(name: str, scale: float = 1.0) -> Callable[[EpisodeSettings, tuple[float, ...]], EpisodeSettings]:
    """Change one of the settings themselves, to the values times ``scale``."""

    def change(settings: EpisodeSettings, values: tuple[float, ...]) -> EpisodeSettings:
        scaled = tuple(value * scale for value in values)
        return dataclasses.replace(settings, **{name: scaled if len(scaled) > 1 else scaled[0]})  # type: ignore[arg-type]

    return change


def _noise(settings: EpisodeSettings, values: tuple[float, ...]) -> EpisodeSettings:
    shot, read = values[0] * settings.camera.shot_noise, values[0] * settings.camera.read_noise
    return dataclasses.replace(settings, camera=dataclasses.replace(settings.camera, shot_noise=shot, read_noise=read))


def _target(settings: EpisodeSettings, values: tuple[float, ...]) -> EpisodeSettings:
    if not settings.camera.auto_exposure:
        raise ValueError('without auto_exposure it changes nothing: give camera="ov7670", or another that has it')
    return _camera("ae_target")(settings, values)


def _mass(settings: EpisodeSettings, values: tuple[float, ...]) -> EpisodeSettings:
    return dataclasses.replace(settings, robot=dataclasses.replace(settings.robot, mass_g=values[0]))


def _motor(settings: EpisodeSettings, values: tuple[float, ...]) -> EpisodeSettings:
    gain = values[0] * settings.robot.motor_gain
    return dataclasses.replace(settings, robot=dataclasses.replace(settings.robot, motor_gain=gain))


FACTORS: Mapping[str, Factor] = MappingProxyType({
    factor.name: factor
    for factor in (
        Factor("light", "", 0.05, 2.0, "the light of all lamps, times the arena's", _own("light"), ("light",)),
        Factor("noise", "", 0.0, 10.0, "the camera's photon and read noise (sd), times what else is set",
               _noise, ("noise",)),
        Factor("ae_target", "grey levels", 1.0, 254.0, "the target of a camera with auto exposure",
               _target, ("ae_target",)),
        Factor("row_time_us", "us", 0.0, 20000.0, "the camera's time from a row to the next; 0: a global shutter",
               _camera("row_time_us"), ("row_time_us",)),
        Factor("blur_px", "px", 0.0, 8.0, "the lens's point spread (sd)", _camera("blur_px"), ("blur_px",)),
        Factor("tilt", "degrees", -15.0, 15.0, "the camera's direction: pitch and yaw, each drawn",
               _own("tilt", math.pi / 180), ("pitch_deg", "yaw_deg")),
        Factor("wall", "", 0.0, 4.0, "the contrast of the wall's texture, times the arena's",
               _own("wall_contrast"), ("wall",)),
        Factor("shell", "", 0.0, 1.0, "the reflectance of the other robots' shells", _own("shell_grey"), ("shell",)),
        Factor("start", "cm", -20.0, 20.0, "the observer's start, moved ahead and to the left, each drawn; "
               "less far where it would come within 1 cm of a robot or the wall",
               _own("shift", 0.01), ("ahead_cm", "left_cm")),
        Factor("mass_g", "g", 10.0, 100.0, "the observer's mass; its moments of inertia stay", _mass, ("mass_g",)),
        Factor("motor_gain", "", 0.25, 2.5, "the gain of the observer's wheel servos, times the robot's",
               _motor, ("motor_gain",)),
        Factor("wheel_gain", "", 0.5, 1.5, "the commanded speeds of the observer's wheels, a factor for each",
               _own("wheel_gains"), ("left_wheel_gain", "right_wheel_gain")),
        Factor("latency_ms", "ms", 0.0, 500.0,
               "the time from an action to the command to the wheels, in whole control intervals of 16.7 ms",
               _own("latency", 0.001), ("latency_ms",)),
    )
})  # fmt: skip
"""Name -> factor, in the order in which they are applied."""

PRESET = "preset"
"""A mapping's key that names a preset, to which the mapping's other entries are added."""

_LIGHT = 1.0 - WIDEST_LIGHT, 1.0 + WIDEST_LIGHT
_WHEELS = 1.0 - WIDEST_MOTOR, 1.0 + WIDEST_MOTOR
PRESETS: Mapping[str, Mapping[str, Range]] = MappingProxyType({
    # The ranges of strength 1, and a camera that is better or worse than its data sheet.
    "domain": {
        "light": _LIGHT, "noise": (0.5, 2.0), "blur_px": (0.0, 0.5), "tilt": (-WIDEST_TILT_DEG, WIDEST_TILT_DEG),
        "shell": (SceneConfig().shell_grey, SceneConfig().shell_grey + WIDEST_SHELL), "wheel_gain": _WHEELS,
    },
    # Around CameraConfig.preset("ov7670"): how far a robot's own eye may be from it is assumed.
    "ov7670": {
        "light": _LIGHT, "noise": (0.5, 2.0), "ae_target": (88.0, 128.0), "row_time_us": (376.0, 460.0),
        "blur_px": (0.15, 0.62),
    },
    # Around RobotConfig.preset("colias4"), likewise.
    "colias4": {"mass_g": (26.0, 30.0), "motor_gain": (0.8, 1.25), "wheel_gain": _WHEELS, "latency_ms": (0.0, 50.0)},
})  # fmt: skip
"""Name -> factor -> range: what a name given as ``randomise`` is short for."""


def checked_randomise(value: Any) -> float | str | dict[str, Range]:
    """Check the argument ``randomise`` of an env.

    Parameters
    ----------
    value
        A number from 0 to 1, the name of a preset, or a mapping from factors to ranges.

    Returns
    -------
    float or str or dict
        The same; ranges as tuples, in the order of `FACTORS`, with those of the mapping's preset.

    Raises
    ------
    ValueError
        In one line that says what is legal.
    """
    if isinstance(value, str):
        _preset(value)
        return value
    if isinstance(value, Mapping):
        return _mapping(value)
    if isinstance(value, int | float | np.integer | np.floating) and not is_flag(value) and 0.0 <= value <= 1.0:
        return float(value)
    raise ValueError(f"expected a number in 0 .. 1, a preset ({', '.join(PRESETS)}), or {{factor: (low, high)}}")


def ranges_of(randomise: float | str | Mapping[str, Range]) -> Mapping[str, Range]:
    """List the ranges that a checked ``randomise`` asks for; none for a number: its draws are older than factors."""
    if isinstance(randomise, str):
        return PRESETS[randomise]
    return randomise if isinstance(randomise, Mapping) else {}


def ends_of(settings: EpisodeSettings, ranges: Mapping[str, Range]) -> tuple[EpisodeSettings, EpisodeSettings]:
    """Compute the settings with all factors at the lower, and with all at the upper end of their ranges.

    Raises ``ValueError`` in one line if a factor cannot be drawn from its range in this apparatus.
    """
    low = high = settings
    for name, ends in ranges.items():
        factor = FACTORS[name]
        try:
            low, high = (
                factor.change(one, (end,) * len(factor.parts)) for one, end in zip((low, high), ends, strict=True)
            )
        except ValueError as error:
            raise ValueError(f"randomise: {name}={ends}: {reason(error)}") from None
    return low, high


def reason(error: ValueError) -> str:
    """Return the text of an error in one line; pydantic's own text has several."""
    if not isinstance(error, ValidationError):
        return str(error)
    return "; ".join(_named(problem) for problem in error.errors())


def _named(problem: Mapping[str, Any]) -> str:
    """Return a problem that pydantic found, after the setting and its value where it is about one setting."""
    text = str(problem["msg"]).removeprefix("Value error, ")
    named = f"{problem['loc'][0]}={problem['input']:g}: " if problem["loc"] and _is_number(problem["input"]) else ""
    return named + text[0].lower() + text[1:]


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not is_flag(value)


def _mapping(given: Mapping[Any, Any]) -> dict[str, Range]:
    named = given.get(PRESET)
    ranges = dict(_preset(named)) if named is not None else {}
    for name, ends in given.items():
        if name == PRESET:
            continue
        if name not in FACTORS:
            raise ValueError(f"no factor '{name}' ({nearest(name, FACTORS, after='; ')}all: {', '.join(FACTORS)})")
        ranges[name] = _range(FACTORS[name], ends)
    return {name: ranges[name] for name in FACTORS if name in ranges}


def _preset(name: Any) -> Mapping[str, Range]:
    if not isinstance(name, str):
        raise ValueError(f"preset={name!r}: expected a name ({', '.join(PRESETS)})")
    if name not in PRESETS:
        raise ValueError(f"no preset '{name}' ({nearest(name, PRESETS, after='; ')}all: {', '.join(PRESETS)})")
    return PRESETS[name]


def _range(factor: Factor, ends: Any) -> Range:
    """Return the two ends, checked."""
    legal = f"{factor.low:g} .. {factor.high:g}" + (f" {factor.unit}" if factor.unit else "")
    try:
        given = tuple(ends)
        if isinstance(ends, str) or any(map(is_flag, given)):
            raise TypeError
        low, high = map(float, given)
    except (TypeError, ValueError, OverflowError):  # the last: a whole number beyond the floats
        raise ValueError(f"{factor.name}={ends!r}: expected two numbers, (low, high), in {legal}") from None
    if not (factor.low <= low <= factor.high and factor.low <= high <= factor.high):
        raise ValueError(f"{factor.name}={ends!r}: legal is {legal}")
    if low > high:
        raise ValueError(f"{factor.name}={ends!r}: expected the lower end first")
    return low, high
