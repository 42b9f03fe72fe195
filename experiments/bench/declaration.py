"""What an experiment is: a design that lists its conditions, repeats, and the claims it bears on."""

from __future__ import annotations

import dataclasses
import itertools
import re
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, Literal, Protocol, get_args

import numpy as np

from colias_sim.config import CameraConfig, RobotConfig, SceneConfig
from experiments.bench.models import Chosen

Motion = Literal["translation", "approach", "recession"]
Direction = Literal["rightward", "leftward", "straight"]


WORDS = {"motion": get_args(Motion), "direction": get_args(Direction)}
LIMITS = {
    "speed_cm_s": (0.1, 100.0), "distance_cm": (0.5, 100.0), "far_cm": (1.0, 100.0), "angle_deg": (-80.0, 80.0),
    "shell_grey": (0.0, 1.0), "wall_contrast": (0.0, 4.0), "observer_speed_cm_s": (-35.0, 35.0),
    "observer_turn_deg_s": (-360.0, 360.0), "acceleration_cm_s2": (1.0, 1000.0),
}  # fmt: skip
OPTIONAL = {"far_cm", "angle_deg", "shell_grey", "wall_contrast"}


@dataclass(frozen=True, slots=True)
class Condition:
    """What a trial sets. ``None`` where a motion has no such quantity, or where the settings decide.

    Crossings (``translation``) pass perpendicular to the optical axis at ``distance_cm``. ``approach`` drives
    straight from ``far_cm`` away to the point ``distance_cm`` before the camera, along a line at ``angle_deg`` to
    the axis, negative on the robot's left; ``recession`` drives the same line the other way.

    Raises ``ValueError`` on a value no trial can have; whether robots and arena allow it is checked when a run is
    planned.
    """

    motion: Motion
    direction: Direction
    """Of the image of the stimulus; ``straight`` on the axis."""
    speed_cm_s: float
    distance_cm: float
    far_cm: float | None = None
    angle_deg: float | None = None
    shell_grey: float | None = None
    wall_contrast: float | None = None
    observer_speed_cm_s: float = 0.0
    observer_turn_deg_s: float = 0.0
    """Left positive."""
    acceleration_cm_s2: float = 100.0
    """With which the stimulus starts, and stops."""

    def __post_init__(self) -> None:
        for name, said in WORDS.items():
            if getattr(self, name) not in said:
                raise ValueError(f"condition: {name}={getattr(self, name)!r}: legal is {', '.join(said)}")
        depth = self.motion != "translation"
        needed = {"angle_deg", "far_cm"} if depth else set()
        for name, (low, high) in LIMITS.items():
            value = getattr(self, name)
            if value is None and name in OPTIONAL - needed:
                continue
            if isinstance(value, bool) or not isinstance(value, int | float) or not low <= value <= high:
                why = f" ({self.motion} needs it)" if value is None else ""
                raise ValueError(f"condition: {name}={value!r}: legal is a number from {low:g} to {high:g}{why}")
            object.__setattr__(self, name, float(value))  # whole numbers too: a column has one type
        if (self.direction == "straight") and not depth:
            raise ValueError(f"condition: direction={self.direction!r}: a translation goes rightward or leftward")
        if depth and self.far_cm is not None and self.far_cm <= self.distance_cm:
            raise ValueError(f"condition: far_cm={self.far_cm:g}: legal is above distance_cm={self.distance_cm:g}")

    def label(self) -> str:
        """The condition in a person's words."""
        where = f"at {self.distance_cm:g} cm" if self.angle_deg is None else f"along {self.angle_deg:g} degrees"
        parts = [f"{self.motion} {self.direction}, {self.speed_cm_s:g} cm/s {where}"]
        if self.shell_grey is not None:
            parts.append(f"shell grey {self.shell_grey:g}")
        if self.wall_contrast is not None:
            parts.append(f"wall contrast {self.wall_contrast:g}")
        if self.observer_speed_cm_s:
            parts.append(f"observer driving {self.observer_speed_cm_s:g} cm/s")
        if self.observer_turn_deg_s:
            parts.append(f"observer turning {self.observer_turn_deg_s:g} degrees/s")
        return ", ".join(parts)


CONDITION_COLUMNS = tuple(field.name for field in dataclasses.fields(Condition))
MOST_CONDITIONS = 100_000


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

    def conditions(self) -> Iterable[Condition]:
        """Every condition, in the order tables and figures show them; the same ones at every call."""
        ...


def conditions_of(design: Design) -> tuple[Condition, ...]:
    """The conditions of a design. Raises ``ValueError``, in one line, where it answers with anything else."""
    expected = f"expected {Condition.__module__}.Condition({', '.join(CONDITION_COLUMNS)})"
    try:
        answered = design.conditions()
        if not isinstance(answered, Iterable):
            raise ValueError(f"its conditions() answers {_short(answered)}: {expected}, any number of them")
        found = tuple(itertools.islice(answered, MOST_CONDITIONS + 1))
    except ValueError as error:
        raise ValueError(" ".join(str(error).split())) from None
    except Exception as error:
        said = " ".join(str(error).split())
        raise ValueError(f"its conditions() raises {type(error).__name__}{': ' if said else ''}{said}") from None
    for index, condition in enumerate(found):
        if not isinstance(condition, Condition):
            raise ValueError(f"its conditions()[{index}] is {_short(condition)}: {expected}")
    if not found:
        raise ValueError("its design has no conditions")
    if len(found) > MOST_CONDITIONS:
        raise ValueError(f"its design has over {MOST_CONDITIONS} conditions")
    return found


def check_declared(kind: str, name: Any, summary: Any, repeats: Any, claims: Any) -> None:
    """Raise ``ValueError`` for what no declaration of an experiment can say of itself."""
    if not isinstance(name, str) or not re.fullmatch(r"[A-Za-z0-9][A-Za-z0-9_-]*", name):
        raise ValueError(f"{kind} {_short(name)}: its name: legal are letters, digits, - and _")
    if not isinstance(summary, str):
        raise ValueError(f"{kind} {name}: summary={_short(summary)}: legal is a text")
    if not isinstance(repeats, int) or isinstance(repeats, bool) or repeats < 1:
        raise ValueError(f"{kind} {name}: repeats={_short(repeats)}: legal is a whole number from 1 up")
    if not isinstance(claims, tuple) or not all(isinstance(claim, str) for claim in claims):
        raise ValueError(f"{kind} {name}: claims={_short(claims)}: legal is a tuple of names")


def _short(value: Any) -> str:
    """A value in a line: a person has to find it again, not to read all of it."""
    said = " ".join(repr(value).split())
    return said if len(said) <= 80 else f"{said[:77]}..."


@dataclass(frozen=True, slots=True)
class Experiment:
    """A declaration: ``repeats`` trials of each condition of ``design``, drawn against the column ``varies``.

    Raises ``ValueError`` on a declaration that cannot be run as it stands.
    """

    name: str
    summary: str
    design: Design
    varies: str
    """A column of conditions: speed_cm_s, distance_cm, angle_deg, motion, ..."""
    repeats: int = 10
    claims: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        check_declared("experiment", self.name, self.summary, self.repeats, self.claims)
        made = dataclasses.is_dataclass(self.design) and not isinstance(self.design, type)
        if not made or not callable(getattr(self.design, "conditions", None)):
            said = f"design={_short(self.design)}: legal is a dataclass with conditions()"
            raise ValueError(f"experiment {self.name}: {said}")
        for spread in ("pose_sd_mm", "heading_sd_deg"):
            value = getattr(self.design, spread, None)
            if not isinstance(value, int | float) or not 0 <= value <= 100:
                raise ValueError(f"experiment {self.name}: design.{spread}={value!r}: legal is a number from 0 to 100")
        try:
            conditions, again = conditions_of(self.design), conditions_of(self.design)
        except ValueError as error:
            raise ValueError(f"experiment {self.name}: {error}") from None
        if conditions != again:
            raise ValueError(f"experiment {self.name}: its conditions() answers otherwise when it is asked again")
        self._check_conditions(conditions)

    def conditions(self) -> tuple[Condition, ...]:
        """Every condition of its design, in order."""
        return conditions_of(self.design)

    def _check_conditions(self, conditions: tuple[Condition, ...]) -> None:
        twice = next((c for i, c in enumerate(conditions) if c in conditions[:i]), None)
        if twice is not None:
            raise ValueError(f"experiment {self.name}: the condition '{twice.label()}' is there twice")
        if self.varies not in CONDITION_COLUMNS or any(getattr(c, self.varies) is None for c in conditions):
            raise ValueError(f"experiment {self.name}: varies={self.varies!r}: no value of it in every condition")


@dataclass(frozen=True, slots=True)
class Settings:
    """Everything a trial needs beside its condition and seed. Every model of ``models`` sees the same frames."""

    models: tuple[Chosen, ...]
    robot: RobotConfig
    camera: CameraConfig
    scene: SceneConfig
    pose_sd_mm: float
    heading_sd_deg: float


@dataclass(frozen=True, slots=True)
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
    conditions = experiment.conditions()
    return [
        TrialSpec(experiment.name, index, index // len(conditions), trial_seed(seed, index), condition, settings)
        for index, condition in enumerate(conditions * repeats)
    ]


def plain(value: Any) -> Any:
    """What JSON does not know: dataclasses become objects, anything else text."""
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return {field.name: getattr(value, field.name) for field in dataclasses.fields(value)}
    return str(value)
