"""What an experiment is: a design that lists its conditions, repeats, and the claims it bears on."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass as plain_dataclass
from typing import Annotated, Any, Literal, Protocol

import numpy as np
from pydantic import ConfigDict, Field
from pydantic.dataclasses import dataclass

from colias_sim.config import CameraConfig, RobotConfig, SceneConfig

_STRICT = ConfigDict(extra="forbid", allow_inf_nan=False)

SpeedCmS = Annotated[float, Field(ge=0.5, le=35.0)]
DistanceCm = Annotated[float, Field(ge=3.0, le=20.0)]
Direction = Literal["rightward", "leftward"]


@plain_dataclass(frozen=True, slots=True)
class Condition:
    """What a trial sets: how the stimulus moves past the observer. ``None`` where a motion has no such quantity."""

    motion: Literal["translation"]
    speed_cm_s: float
    distance_cm: float
    angle_deg: float | None
    direction: Direction

    def label(self) -> str:
        """The condition in a person's words."""
        return f"{self.motion} {self.direction}, {self.speed_cm_s:g} cm/s at {self.distance_cm:g} cm"


CONDITION_COLUMNS = tuple(field.name for field in dataclasses.fields(Condition))


class Design(Protocol):
    """The parameters of an experiment, a frozen dataclass that ``--set experiment.NAME=VALUE`` reaches."""

    @property
    def pose_sd_mm(self) -> float:
        """Spread of the stimulus's start position."""
        ...

    @property
    def heading_sd_deg(self) -> float:
        """Spread of the stimulus's start heading."""
        ...

    def conditions(self) -> tuple[Condition, ...]:
        """Every condition, in the order tables and figures show them."""
        ...


@dataclass(frozen=True, config=_STRICT)
class Translation:
    """Straight crossings of the field of view, perpendicular to the optical axis, all speeds at all distances."""

    speeds_cm_s: tuple[SpeedCmS, ...] = Field(min_length=1, description="speeds of the stimulus")
    distances_cm: tuple[DistanceCm, ...] = Field(min_length=1, description="camera to path")
    direction: Literal["rightward", "leftward", "both"] = Field(default="rightward", description="in the image")
    pose_sd_mm: float = Field(default=1.0, ge=0.0, le=5.0, description="spread of the start position, along both axes")
    heading_sd_deg: float = Field(default=1.0, ge=0.0, le=5.0, description="spread of the path's heading")

    def conditions(self) -> tuple[Condition, ...]:
        """Speeds within distances within directions."""
        both: tuple[Direction, ...] = ("rightward", "leftward")
        return tuple(
            Condition("translation", speed, distance, None, direction)
            for direction in both
            if self.direction in (direction, "both")
            for distance in self.distances_cm
            for speed in self.speeds_cm_s
        )


@plain_dataclass(frozen=True, slots=True)
class Experiment:
    """A declaration: ``repeats`` trials of each condition of ``design``, drawn against the column ``varies``.

    Raises ``ValueError`` on a declaration that cannot be run as it stands.
    """

    name: str
    summary: str
    design: Design
    varies: Literal["speed_cm_s", "distance_cm", "angle_deg"]
    repeats: int = 10
    claims: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if not isinstance(self.repeats, int) or isinstance(self.repeats, bool) or self.repeats < 1:
            raise ValueError(f"experiment {self.name}: repeats={self.repeats!r}: legal is a whole number from 1 up")
        if not isinstance(self.claims, tuple):
            raise ValueError(f"experiment {self.name}: claims={self.claims!r}: legal is a tuple of names")
        if not dataclasses.is_dataclass(self.design) or not hasattr(self.design, "conditions"):
            raise ValueError(f"experiment {self.name}: design={self.design!r}: legal is a dataclass with conditions()")
        self._check_conditions(self.design.conditions())

    def _check_conditions(self, conditions: tuple[Condition, ...]) -> None:
        if not conditions:
            raise ValueError(f"experiment {self.name}: its design has no conditions")
        twice = next((c for i, c in enumerate(conditions) if c in conditions[:i]), None)
        if twice is not None:
            raise ValueError(f"experiment {self.name}: the condition '{twice.label()}' is there twice")
        if self.varies not in CONDITION_COLUMNS or any(getattr(c, self.varies) is None for c in conditions):
            raise ValueError(f"experiment {self.name}: varies={self.varies!r}: not a number in every condition")


@plain_dataclass(frozen=True, slots=True)
class Settings:
    """Everything a trial needs beside its condition and seed."""

    model: str
    network: Any
    robot: RobotConfig
    camera: CameraConfig
    scene: SceneConfig
    pose_sd_mm: float
    heading_sd_deg: float


@plain_dataclass(frozen=True, slots=True)
class TrialSpec:
    """One trial, wholly determined: `experiments.bench.trial.run_trial` is a pure function of it."""

    experiment: str
    index: int
    repeat: int
    seed: int
    condition: Condition
    settings: Settings


def trial_seed(seed: int, index: int) -> int:
    """The seed of trial ``index``: a function of the experiment's seed and the index alone, in 0..2^32-1."""
    return int(np.random.SeedSequence(seed, spawn_key=(index,)).generate_state(1)[0])


def trial_specs(experiment: Experiment, settings: Settings, repeats: int, seed: int) -> list[TrialSpec]:
    """Every trial, a whole round of conditions before the next repeat.

    So a run cut short stays balanced, and more repeats only append: the first trials are the same ones.
    """
    conditions = experiment.design.conditions()
    return [
        TrialSpec(experiment.name, index, index // len(conditions), trial_seed(seed, index), condition, settings)
        for index, condition in enumerate(conditions * repeats)
    ]


def half_crossing(distance: float, radius: float, hfov: float) -> float:
    """Sideways distance from the optical axis at which a disc of ``radius`` just leaves the view (m, m, rad)."""
    return distance * math.tan(hfov / 2) + radius / math.cos(hfov / 2)
