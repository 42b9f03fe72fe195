"""Experiments: a design that lists its conditions, repeats, and the claims it bears on."""

from __future__ import annotations

import dataclasses
import itertools
import math
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any, Literal, Protocol, get_args

import numpy as np

from colias_sim import Schedule
from colias_sim.config import CameraConfig, RobotConfig, SceneConfig
from experiments.bench.robot.hand import Hand
from experiments.bench.robot.mechanism.parts import NEEDED
from experiments.bench.robot.path import Path
from experiments.bench.run.errors import check_declared, plain, short
from experiments.bench.run.models import ConfiguredModel
from experiments.bench.stats.claim import Claim, check_claims

Motion = Literal["translation", "approach", "recession"]
Direction = Literal["rightward", "leftward", "straight"]
Drawing = Literal["spikes", "mechanism", "excitation"]
WORDS = {"motion": get_args(Motion), "direction": get_args(Direction)}
LIMITS = {
    "speed_cm_s": (0.1, 100.0), "distance_cm": (0.5, 100.0), "far_cm": (1.0, 100.0), "angle_deg": (-80.0, 80.0),
    "shell_grey": (0.0, 1.0), "wall_contrast": (0.0, 4.0), "observer_speed_cm_s": (-35.0, 35.0),
    "observer_turn_deg_s": (-360.0, 360.0), "acceleration_cm_s2": (1.0, 1000.0),
}  # fmt: skip
OPTIONAL = {"far_cm", "angle_deg", "shell_grey", "wall_contrast"}
SCRIPTED = ("path", "observer", "movers", "hand")
"""The fields of a condition that are no columns: its paths, which the name in ``motion`` stands for."""
BY_HAND = "by-hand"
"""The motion of trials that were driven by hand."""
WHERE_SET = {"where_set": True}
"""Metadata of fields that descriptions have only where they are set: `experiments.bench.store.description.plain`."""
MOST_MOVERS = 6
START_CM_S2 = 100.0
"""The acceleration with which a stimulus starts where its condition does not say."""
DEPTH = ("approach", "recession")
_PLACES = 400
"""Places of a path from which its direction and its distance are told."""
_NAME = re.compile(r"[a-z][a-z0-9-]{0,39}")


@dataclass(frozen=True, slots=True)
class Condition:
    """Setting of a trial. ``None`` where a motion has no such quantity, or where the settings decide.

    Parameters
    ----------
    motion
        ``translation``: the stimulus crosses the view, perpendicular to the optical axis. ``approach``: it drives
        straight at a point before the camera. ``recession``: it drives the same line the other way. Any other name, of
        lower-case letters, digits and ``-``: it takes the ``path``, and `Condition.along` fills in the numbers.
    direction
        Of the stimulus's image: ``rightward`` or ``leftward``; ``straight`` on the optical axis.
    speed_cm_s
        Speed of the stimulus, 0.1 to 100 cm/s.
    distance_cm
        From the camera to the path of a crossing, or to the near end of an approach or recession, 0.5 to 100 cm.
    far_cm
        From the camera to the far end of an approach or recession, above ``distance_cm``, up to 100 cm.
    angle_deg
        Of the line of an approach or recession to the optical axis, -80 to 80 degrees, negative on the robot's left.
    shell_grey
        Reflectance of the stimulus's shell, 0 to 1.
    wall_contrast
        Contrast of the arena's wall, 0 to 4; 1 is its own.
    observer_speed_cm_s, observer_turn_deg_s
        At which the observer drives, -35 to 35 cm/s, forward positive, and turns, -360 to 360 degrees/s, left positive.
    acceleration_cm_s2
        With which the stimulus starts, and stops, 1 to 1000 cm/s2. A crossing starts outside the view, and is at its
        speed when it comes in: there nothing of it is seen. For one that accelerates in view see `Condition.along`.
    path
        The stimulus's path, of a motion with a name of its own.
    observer
        The observer's path beside it; otherwise it stands.
    movers
        Paths of further robots, up to 6, that look like the stimulus.
    hand
        Commands and changes by frame of a trial that ``colias live`` recorded, instead of a path.

    Raises
    ------
    ValueError
        No trial can have the value. Whether robots and arena allow it is checked when a run is planned.

    Examples
    --------
    >>> from experiments import Condition
    >>> Condition("translation", "rightward", speed_cm_s=6.0, distance_cm=8.0).label()
    'translation rightward, 6 cm/s at 8 cm'
    """

    motion: str
    direction: Direction
    speed_cm_s: float
    distance_cm: float
    far_cm: float | None = None
    angle_deg: float | None = None
    shell_grey: float | None = None
    wall_contrast: float | None = None
    observer_speed_cm_s: float = 0.0
    observer_turn_deg_s: float = 0.0
    acceleration_cm_s2: float = START_CM_S2
    path: Path | None = dataclasses.field(default=None, metadata=WHERE_SET)
    observer: Path | None = dataclasses.field(default=None, metadata=WHERE_SET)
    movers: tuple[Path, ...] = dataclasses.field(default=(), metadata=WHERE_SET)
    hand: Hand | None = dataclasses.field(default=None, metadata=WHERE_SET)

    @classmethod
    def along(
        cls,
        motion: str,
        path: Path,
        *,
        direction: Direction | None = None,
        observer: Path | None = None,
        movers: Sequence[Path] = (),
        shell_grey: float | None = None,
        wall_contrast: float | None = None,
        acceleration_cm_s2: float = START_CM_S2,
    ) -> Condition:
        """Make a condition in which the stimulus takes a path of one's own.

        Parameters
        ----------
        motion
            Its name in tables and figures, of lower-case letters, digits and ``-``: ``accelerating``.
        path
            The stimulus's path.
        direction
            Of its image; left out, it is that from the bearing at its start to that at its end.
        observer, movers
            Paths of the observer and of further robots. All robots begin at the same time.
        shell_grey, wall_contrast
            As of a `Condition`.
        acceleration_cm_s2
            With which robots take a step of the speed: at the start, at the end, or between two legs.

        Returns
        -------
        Condition
            With the mean speed of the path in ``speed_cm_s``, but for starts and stops, its least distance from the
            camera's place in ``distance_cm``, and the observer's mean speed and turn rate.

        Raises
        ------
        ValueError
            No trial can have the value.

        Examples
        --------
        >>> from experiments import Condition, Leg, Path
        >>> path = Path([Leg(16, speed_cm_s=4, to_cm_s=20)], x_cm=8, y_cm=8, heading_deg=-90)
        >>> Condition.along("accelerating", path).label()
        'accelerating rightward, 12 cm/s at 8 cm'
        """
        if not isinstance(path, Path):
            raise ValueError(f"condition {motion}: path={short(path)}: expected an experiments.Path")
        if not path.length_cm:
            raise ValueError(f"condition {motion}: path: none of its legs has a length_cm: the stimulus has to move")
        start = _number("acceleration_cm_s2", acceleration_cm_s2, *LIMITS["acceleration_cm_s2"])
        route = path.stimulus_route(start)
        speed = 100 * Schedule(route, start / 100).speed_over(route.measured(start / 100))
        length = path.length_cm / 100
        places = [route.point(route.length - length * (1 - i / _PLACES)) for i in range(_PLACES + 1)]
        swept = math.degrees(
            sum(
                math.remainder(math.atan2(b.y, b.x) - math.atan2(a.y, a.x), 2 * math.pi)
                for a, b in itertools.pairwise(places)
            )
        )
        drive = turn = 0.0
        if isinstance(observer, Path) and observer.seconds:
            drive = round(observer.length_cm / observer.seconds, 3)
            turn = round(math.fsum(leg.turn_deg for leg in observer.legs) / observer.seconds, 3)
        return cls(
            motion,
            direction or ("straight" if abs(swept) < 1.0 else "leftward" if swept > 0 else "rightward"),
            round(speed, 3),
            round(100 * min(math.hypot(place.x, place.y) for place in places), 3),
            shell_grey=shell_grey,
            wall_contrast=wall_contrast,
            observer_speed_cm_s=drive,
            observer_turn_deg_s=turn,
            acceleration_cm_s2=start,
            path=path,
            observer=observer,
            movers=tuple(movers),
        )

    def columns(self) -> dict[str, Any]:
        """Return what the tables have of it, by column.

        Returns
        -------
        dict of str to Any
            Every field but the paths.
        """
        return {name: getattr(self, name) for name in CONDITION_COLUMNS}

    def _check_paths(self) -> None:
        """Raise ``ValueError`` for paths of a motion of the paper, and for a motion with a name but no path."""
        if self.hand is not None:
            if self.path is not None or self.motion != BY_HAND or not isinstance(self.hand, Hand):
                raise ValueError(f"condition: hand with motion={self.motion!r}: legal is {BY_HAND}, without a path")
            return
        if self.path is None:
            given = next((name for name in SCRIPTED if getattr(self, name)), None)
            if given:
                raise ValueError(f"condition: {given} with motion={self.motion!r}: legal beside a path; give it one")
            return
        if self.motion in WORDS["motion"] or not isinstance(self.motion, str) or not _NAME.fullmatch(self.motion):
            raise ValueError(
                f"condition: motion={self.motion!r} with a path: legal is a name of its own, of lower-case letters, "
                "digits and -"
            )
        object.__setattr__(self, "movers", tuple(self.movers))
        if len(self.movers) > MOST_MOVERS:
            raise ValueError(f"condition {self.motion}: {len(self.movers)} movers: legal are up to {MOST_MOVERS}")
        paths = {"path": self.path, **({} if self.observer is None else {"observer": self.observer})}
        for name, path in {**paths, **{f"movers[{i}]": mover for i, mover in enumerate(self.movers)}}.items():
            if not isinstance(path, Path):
                raise ValueError(f"condition {self.motion}: {name}={short(path)}: expected an experiments.Path")
            for index, leg in enumerate(path.legs):
                if abs(leg.acceleration_cm_s2) > self.acceleration_cm_s2:
                    raise ValueError(
                        f"condition {self.motion}: {name}.{path.where(index, 'to_cm_s')}={leg.end_cm_s:g} from "
                        f"{leg.speed_cm_s:g} cm/s in {leg.length_cm:.3g} cm is {abs(leg.acceleration_cm_s2):.0f} "
                        f"cm/s2: legal is up to acceleration_cm_s2={self.acceleration_cm_s2:g}; make it longer, or "
                        "raise that"
                    )

    def __post_init__(self) -> None:
        self._check_paths()
        for name, words in WORDS.items():
            if name == "motion" and (self.path is not None or self.hand is not None):
                continue
            if getattr(self, name) not in words:
                more = ", or a name of its own for a path (Condition.along)" if name == "motion" else ""
                raise ValueError(f"condition: {name}={getattr(self, name)!r}: legal is {', '.join(words)}{more}")
            object.__setattr__(self, name, plain(getattr(self, name)))
        depth = self.motion in DEPTH
        needed = {"angle_deg", "far_cm"} if depth else set()
        for name, (low, high) in LIMITS.items():
            value = getattr(self, name)
            if value is None and name in OPTIONAL - needed:
                continue
            if value is None:
                raise ValueError(
                    f"condition: {name}=None: legal is a number from {low:g} to {high:g} ({self.motion} needs it)"
                )
            object.__setattr__(self, name, _number(name, value, low, high))  # whole numbers too: a column has one type
        if (self.direction == "straight") and self.motion == "translation":
            raise ValueError(f"condition: direction={self.direction!r}: a translation goes rightward or leftward")
        if depth and self.far_cm is not None and self.far_cm <= self.distance_cm:
            raise ValueError(f"condition: far_cm={self.far_cm:g}: legal is above distance_cm={self.distance_cm:g}")

    def label(self) -> str:
        """Write the condition in words.

        Returns
        -------
        str
            As tables and figures show it.
        """
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


def _number(name: str, value: object, low: float, high: float) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not low <= value <= high:
        raise ValueError(f"{name} must be between {low:g} and {high:g}, got {value!r}")
    return float(value)


CONDITION_COLUMNS = tuple(field.name for field in dataclasses.fields(Condition) if field.name not in SCRIPTED)
MOST_CONDITIONS = 100_000


class Design(Protocol):
    """The parameters of an experiment, a frozen dataclass that ``--set experiment.NAME=VALUE`` reaches."""

    @property
    def pose_sd_mm(self) -> float:
        """Spread of the stimulus's start position."""

    @property
    def heading_sd_deg(self) -> float:
        """Spread of the stimulus's start heading."""

    def conditions(self) -> Iterable[Condition]:
        """Every condition, in the order tables and figures show them; the same ones at every call."""


def conditions_of(design: Design) -> tuple[Condition, ...]:
    """The conditions of a design. Raises ``ValueError`` where it answers with anything else."""
    expected = f"expected experiments.Condition({', '.join(CONDITION_COLUMNS)})"
    answered = design.conditions()
    if not isinstance(answered, Iterable):
        raise ValueError(f"its conditions() answers {short(answered)}: {expected}, any number of them")
    conditions = tuple(itertools.islice(answered, MOST_CONDITIONS + 1))
    for index, condition in enumerate(conditions):
        if not isinstance(condition, Condition):
            raise ValueError(f"its conditions()[{index}] is {short(condition)}: {expected}")
    if not conditions:
        raise ValueError("its design has no conditions")
    if len(conditions) > MOST_CONDITIONS:
        raise ValueError(f"its design has over {MOST_CONDITIONS} conditions")
    return conditions


@dataclass(frozen=True, slots=True)
class Experiment:
    """A declaration of trials with the robot.

    Parameters
    ----------
    name
        Letters, digits, ``-`` and ``_``.
    summary
        A line for ``colias list``.
    design
        A dataclass that lists the conditions: `Translation`, `Angular`, `General`, `Contrast`, `Clutter`, `Egomotion`,
        or one of your own with ``conditions()``, which returns `Condition` objects, and the fields ``pose_sd_mm`` and
        ``heading_sd_deg``, 0 to 100. Its fields answer to ``--set experiment.NAME=VALUE``.
    varies
        The column of conditions that the figure is drawn against, a field of `Condition`: ``speed_cm_s``, say.
    repeats
        Trials of each condition, 1 or more.
    claims
        Ids of the paper's claims, and claims of your own (`experiments.Claim`).
    models
        What it shows, with settings of their own as ``"dsnn:n_con=4"``; ``--model`` shows others beside them.
    figure
        ``spikes``: every trial's count, and the potential over the trial. ``mechanism``: counts, time in view, firing
        rate and potential against ``varies``, a number, of crossings. ``excitation``: excitation and inhibition of HS
        over the trial, from the models that ``approach-mechanism`` declares.
    arena
        The arena that it is shown in, where ``--set scene.arena`` names no other: a name that ``colias list`` shows, or
        the path of an .xml or .py file, relative to the file of the experiment; ``__file__`` where that declares
        ``ARENA`` too. Empty: ``bright``.
    file
        The .py file that declares it, which commands and `experiments.run` fill in.

    Raises
    ------
    ValueError
        The declaration cannot be run as it stands.

    Examples
    --------
    >>> from experiments import Experiment, Translation
    >>> fast = Experiment("fast", "fast crossings", Translation((15, 25), (6,)), varies="speed_cm_s", repeats=5)
    """

    name: str
    summary: str
    design: Design
    varies: str
    repeats: int = 10
    claims: tuple[str | Claim, ...] = ()
    models: tuple[str, ...] = ("dsnn",)
    figure: Drawing = "spikes"
    arena: str = dataclasses.field(default="", metadata=WHERE_SET)
    file: str = dataclasses.field(default="", compare=False, repr=False, kw_only=True)

    def __post_init__(self) -> None:
        check_declared("experiment", self.name, self.summary, self.repeats)
        check_claims(self.name, self.claims)
        self._check_models()
        is_instance = dataclasses.is_dataclass(self.design) and not isinstance(self.design, type)
        if not is_instance or not callable(getattr(self.design, "conditions", None)):
            problem = f"design={short(self.design)}: legal is a dataclass with conditions()"
            raise ValueError(f"experiment {self.name}: {problem}")
        for spread in ("pose_sd_mm", "heading_sd_deg"):
            value = getattr(self.design, spread, None)
            if not isinstance(value, int | float) or not 0 <= value <= 100:
                raise ValueError(f"experiment {self.name}: design.{spread} must be between 0 and 100, got {value!r}")
        try:
            conditions, again = conditions_of(self.design), conditions_of(self.design)
        except ValueError as error:
            raise ValueError(f"experiment {self.name}: {error}") from error
        if conditions != again:
            raise ValueError(f"experiment {self.name}: its conditions() answers otherwise when it is asked again")
        self._check_conditions(conditions)

    def conditions(self) -> tuple[Condition, ...]:
        """List the conditions of its design, in order.

        Parameters, returns and errors are those of `experiments.Translation.conditions`.
        """
        return conditions_of(self.design)

    def _check_models(self) -> None:
        where = f"experiment {self.name}"
        if isinstance(self.models, str) or not isinstance(self.models, Sequence) or not self.models:
            raise ValueError(f"{where}: models={short(self.models)}: legal is a tuple of names, one or more")
        object.__setattr__(self, "models", tuple(self.models))
        for index, model in enumerate(self.models):
            if not isinstance(model, str):
                raise ValueError(f"{where}: models[{index}] is {short(model)}: expected a name or a path")
        if not isinstance(self.arena, str):
            raise ValueError(f"{where}: arena={short(self.arena)}: legal is a name, or the path of a file, as a text")
        if self.figure not in get_args(Drawing):
            raise ValueError(f"{where}: figure={short(self.figure)}: legal is {', '.join(get_args(Drawing))}")
        if self.figure == "excitation" and not set(NEEDED) <= set(self.models):
            raise ValueError(f"{where}: figure='excitation': legal where models has {', '.join(NEEDED)}")

    def _check_conditions(self, conditions: tuple[Condition, ...]) -> None:
        columns = [tuple(condition.columns().values()) for condition in conditions]
        twice = next((i for i, values in enumerate(columns) if values in columns[:i]), None)
        if twice is not None:
            again = conditions[twice]
            hint = "" if again in conditions[:twice] else ": two paths; give each a motion with a name of its own"
            raise ValueError(f"experiment {self.name}: the condition '{again.label()}' is there twice{hint}")
        if self.varies not in CONDITION_COLUMNS or any(getattr(c, self.varies) is None for c in conditions):
            raise ValueError(f"experiment {self.name}: varies={self.varies!r}: no value of it in every condition")
        crossings = all(condition.motion == "translation" for condition in conditions)
        if self.figure == "mechanism" and not (crossings and isinstance(getattr(conditions[0], self.varies), float)):
            problem = "figure='mechanism': legal where all conditions are translations and varies is a number"
            raise ValueError(f"experiment {self.name}: {problem}")


@dataclass(frozen=True, slots=True)
class Settings:
    """Everything a trial needs beside its condition and seed. Every model of ``models`` sees the same frames."""

    models: tuple[ConfiguredModel, ...]
    robot: RobotConfig
    camera: CameraConfig
    scene: SceneConfig
    pose_sd_mm: float
    heading_sd_deg: float


@dataclass(frozen=True, slots=True)
class TrialSpec:
    """One trial, wholly determined: `experiments.bench.robot.trial.run_trial` is a pure function of it."""

    experiment: str
    index: int
    repeat: int
    seed: int
    condition: Condition
    settings: Settings

    def frame_rates(self) -> Iterable[tuple[ConfiguredModel, float]]:
        """Return the job's models, each with the camera's frame rate, 1/s."""
        return ((model, self.settings.camera.fps) for model in self.settings.models)


def trial_seed(seed: int, index: int) -> int:
    """The seed of trial ``index``: a function of the experiment's seed and the index alone, in 0..2^32-1."""
    return int(np.random.SeedSequence(seed, spawn_key=(index,)).generate_state(1)[0])


def trial_specs(experiment: Experiment, settings: Settings, repeats: int, seed: int) -> list[TrialSpec]:
    """Every trial, by rounds of all conditions: a run cut short stays balanced, and more repeats only append."""
    conditions = experiment.conditions()
    return [
        TrialSpec(experiment.name, index, index // len(conditions), trial_seed(seed, index), condition, settings)
        for index, condition in enumerate(conditions * repeats)
    ]
