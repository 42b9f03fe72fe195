"""Domain randomisation: the values of an episode, drawn from its seed as the argument ``randomise`` says."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from colias_sim.config import SceneConfig
from colias_sim.envs.episode_settings import EpisodeSettings
from colias_sim.envs.factors import (
    FACTORS,
    WIDEST_LIGHT,
    WIDEST_MOTOR,
    WIDEST_SHELL,
    WIDEST_TILT_DEG,
    Range,
    ranges_of,
)

WIDEST_TILT = math.radians(WIDEST_TILT_DEG)


@dataclass(frozen=True, slots=True)
class Drawn:
    """The draws of one episode.

    Parameters
    ----------
    values
        Name of each value -> the value, in the unit of its name; empty where nothing is randomised.
    settings
        What they amount to.
    """

    values: Mapping[str, float]
    settings: EpisodeSettings


class Randomisation:
    """Draws what varies between episodes beyond the defaults.

    Parameters
    ----------
    plain
        The settings of an episode without randomisation.
    randomise
        The env's argument, checked: 0 for none up to 1 for the widest of some factors, or ranges, or their preset.
    """

    def __init__(self, plain: EpisodeSettings, randomise: float | str | Mapping[str, Range]) -> None:
        self._plain = plain
        self._strength = randomise if isinstance(randomise, float | int) else 0.0
        self._ranges = ranges_of(randomise)

    def draw(
        self, world: np.random.Generator, episode: int, fixed: Mapping[str, tuple[float, ...]] | None = None
    ) -> Drawn:
        """Draw the values of an episode.

        Six numbers are drawn from the world whatever ``randomise`` is, so that it does not change the draws that
        follow. Factors with ranges have streams of their own: none changes the draws of the others.

        Parameters
        ----------
        world
            The generator of the episode's world.
        episode
            The seed of the episode's own streams, from `colias_sim.streams.episode`.
        fixed
            Factor -> values that are given, and therefore not drawn. They change no other draw.

        Returns
        -------
        Drawn
            The values.
        """
        units = world.uniform(-1.0, 1.0, 6).tolist()
        if self._strength > 0.0:
            return _with(self._by_strength(*units), fixed or {})
        return self._by_ranges(episode, fixed or {})

    def _by_ranges(self, episode: int, fixed: Mapping[str, tuple[float, ...]]) -> Drawn:
        values: dict[str, float] = {}
        settings = self._plain
        for name, factor in FACTORS.items():
            if name not in fixed and name not in self._ranges:
                continue
            drawn = fixed[name] if name in fixed else factor.draw(episode, self._ranges[name])
            settings = factor.change(settings, drawn)
            values |= zip(factor.parts, drawn, strict=True)
        return Drawn(values, settings)

    def _by_strength(
        self, light: float, shell: float, left: float, right: float, pitch: float, yaw: float
    ) -> Drawn:  # fmt: skip
        """Return the values that a number in 0 .. 1 asks for, of six draws from -1 to 1."""
        wide = self._strength
        settings = dataclasses.replace(
            self._plain,
            light=1.0 + wide * WIDEST_LIGHT * light,
            shell_grey=SceneConfig().shell_grey + wide * WIDEST_SHELL * (shell + 1.0) / 2,
            wheel_gains=(1.0 + wide * WIDEST_MOTOR * left, 1.0 + wide * WIDEST_MOTOR * right),
            tilt=(pitch * wide * WIDEST_TILT, yaw * wide * WIDEST_TILT),
        )
        values = {
            "light": settings.light, "shell": settings.shell_grey,
            "left_wheel_gain": settings.wheel_gains[0], "right_wheel_gain": settings.wheel_gains[1],
            "pitch_deg": math.degrees(settings.tilt[0]), "yaw_deg": math.degrees(settings.tilt[1]),
        }  # fmt: skip
        return Drawn(values, settings)


def _with(drawn: Drawn, fixed: Mapping[str, tuple[float, ...]]) -> Drawn:
    """Put given values in the place of what was drawn."""
    values, settings = dict(drawn.values), drawn.settings
    for name, given in fixed.items():
        settings = FACTORS[name].change(settings, given)
        values |= zip(FACTORS[name].parts, given, strict=True)
    return Drawn(values, settings)
