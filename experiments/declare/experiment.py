"""Experiments with the robot: a design that lists its conditions, repeats, and the claims it bears on; and designs."""

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import KW_ONLY, dataclass, field
from typing import Annotated, Any, ClassVar, Literal, Protocol, TypeVar, get_args

from pydantic import Field

from dsnn.field_docs import parameters, unit
from experiments.base.errors import check_declared, check_known
from experiments.base.user_code import run_main
from experiments.declare.claim import Claim, check_claims
from experiments.declare.conditions import BY_HAND, CONDITION_COLUMNS, WHERE_SET, Condition, Direction, Hand, Motion

Drawing = Literal["spikes", "mechanism", "excitation"]
WHOLE, BALANCED = "dsnn", "dsnn:w_i=1"
"""The network, and the one whose inhibition weighs as much as its excitation."""
EXCITED = ("dsnn-off-blocked:w_i=0", "dsnn-on-blocked:w_i=0")
"""The ON pathway and the OFF pathway, each alone, with excitation alone."""
OPPOSED = ("dsnn-off-blocked:w_i=1", "dsnn-on-blocked:w_i=1")
"""Parts of the network with inhibition of weight 1."""
PARTS = (*EXCITED, *OPPOSED)
NEEDED = (WHOLE, BALANCED, *PARTS)
"""Models that the figure of excitation takes."""


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
    settings
        Parameter -> value that its trials have where ``--set`` says nothing: ``{"scene.arena": "dim"}``.
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
    arena: str = field(default="", metadata=WHERE_SET)
    settings: Mapping[str, Any] = field(default_factory=dict, metadata=WHERE_SET)
    file: str = field(default="", compare=False, repr=False, kw_only=True)
    kind: ClassVar[str] = "trials"

    def __post_init__(self) -> None:
        check_declared(self.name, self.repeats, self.models)
        check_claims(self.name, self.claims)
        where = f"experiment {self.name}"
        object.__setattr__(self, "models", tuple(self.models))
        settings = {key: tuple(value) if isinstance(value, Iterator) else value for key, value in self.settings.items()}
        object.__setattr__(self, "settings", settings)  # they are read in every plan
        check_known(f"{where}: figure", self.figure, get_args(Drawing))
        if self.figure == "excitation" and not set(NEEDED) <= set(self.models):
            raise ValueError(f"{where}: figure='excitation' needs the models {', '.join(NEEDED)}")
        conditions = self.conditions()
        if not conditions or self.varies not in CONDITION_COLUMNS or None in self._varied(conditions):
            raise ValueError(f"{where}: varies must be a field that every condition sets, got {self.varies!r}")
        columns = [tuple(condition.columns().values()) for condition in conditions]
        if twice := [one.label() for index, one in enumerate(conditions) if columns[index] in columns[:index]]:
            raise ValueError(f"{where}: the condition '{twice[0]}' is there twice; give each path a motion of its own")
        crossings = all(condition.motion == "translation" for condition in conditions)
        if self.figure == "mechanism" and not (crossings and isinstance(self._varied(conditions)[0], float)):
            raise ValueError(f"{where}: figure='mechanism' needs translations alone, and varies to be a number")

    def _varied(self, conditions: Iterable[Condition]) -> list[Any]:
        return [getattr(condition, self.varies) for condition in conditions]

    def conditions(self) -> tuple[Condition, ...]:
        """List the conditions of its design, in order.

        Returns
        -------
        tuple of Condition
            One for each trial of a round.
        """
        return tuple(self.design.conditions())

    def main(self) -> None:
        """Run the experiment of the file that is executed, as ``colias run FILE`` does with its options.

        Examples
        --------
        The last lines of a file that declares ``EXPERIMENT``:

        >>> if __name__ == "__main__":  # doctest: +SKIP
        ...     EXPERIMENT.main()
        """
        run_main()


# --- designs ----------------------------------------------------------------------------------------------------------

SpeedCmS = Annotated[float, Field(ge=0.5, le=35.0), unit("cm/s")]
DistanceCm = Annotated[float, Field(ge=3.0, le=20.0), unit("cm")]
Ways = Literal["rightward", "leftward", "both"]
Value = TypeVar("Value")


Several = Annotated[tuple[Value, ...], Field(min_length=1)]


def _ways(chosen: Ways) -> tuple[Direction, ...]:
    both: tuple[Direction, ...] = ("rightward", "leftward")
    return tuple(way for way in both if chosen in (way, "both"))


@parameters
class Placement:
    """The errors with which the stimulus of a design is set down."""

    _: KW_ONLY
    pose_sd_mm: Annotated[float, Field(ge=0.0, le=5.0), unit("mm")] = 1.0
    """Spread of the start position, along both axes."""
    heading_sd_deg: Annotated[float, Field(ge=0.0, le=5.0), unit("degrees")] = 1.0
    """Spread of the path's heading."""


@parameters
class Translation(Placement):
    """Straight crossings of the field of view, perpendicular to the optical axis, all speeds at all distances."""

    speeds_cm_s: Several[SpeedCmS]
    """Speeds of the stimulus."""
    distances_cm: Several[DistanceCm]
    """Distance from the camera to the path."""
    direction: Ways = "rightward"
    """Direction of the crossing in the image."""

    def conditions(self) -> tuple[Condition, ...]:
        """List the conditions: speeds within distances within directions.

        Returns
        -------
        tuple of Condition
            One for each trial of a round.
        """
        return tuple(
            Condition("translation", way, speed, distance)
            for way in _ways(self.direction)
            for distance in self.distances_cm
            for speed in self.speeds_cm_s
        )


@parameters
class Depth(Placement):
    """What approaches and recessions have in common."""

    _: KW_ONLY
    speed_cm_s: Annotated[float, Field(ge=0.5, le=15.0), unit("cm/s")] = 6.0
    """Speed of the stimulus."""
    near_cm: Annotated[float, Field(ge=4.0, le=10.0), unit("cm")] = 5.0
    """Distance from the camera to the near end of approach and recession, on the axis."""
    far_cm: Annotated[float, Field(ge=15.0, le=25.0), unit("cm")] = 20.0
    """Distance from the camera to the far end of approach and recession."""
    # Starts and stops happen in view, and an abrupt start 5 cm away is a flash of motion of its own.
    acceleration_cm_s2: Annotated[float, Field(ge=5.0, le=200.0), unit("cm/s2")] = 17.0
    """Acceleration with which approach and recession start and stop."""

    def at(self, motion: Motion, angle: float) -> Condition:
        """Return the approach or recession along a line at ``angle`` degrees.

        Parameters
        ----------
        motion
            ``approach``, whose image moves in from a side, or ``recession``, whose image moves out to it.
        angle
            To the optical axis, negative on the robot's left.

        Returns
        -------
        Condition
            The condition.
        """
        inward = (angle < 0) == (motion == "approach")
        way: Direction = "straight" if angle == 0 else "rightward" if inward else "leftward"
        return Condition(motion, way, self.speed_cm_s, self.near_cm, self.far_cm, angle,
                         acceleration_cm_s2=self.acceleration_cm_s2)  # fmt: skip


@parameters
class Angular(Depth):
    """Straight lines at several angles to the optical axis, through one point before the camera."""

    motion: Literal["approach", "recession"]
    """Whether the stimulus moves towards the camera or away from it."""
    angles_deg: Several[Annotated[float, Field(ge=-60.0, le=60.0), unit("degrees")]] = (-30.0, -15.0, 0.0, 15.0, 30.0)
    """Angle of the path to the optical axis, negative on the robot's left."""

    def conditions(self) -> tuple[Condition, ...]:
        """List the conditions: one for each angle.

        Returns
        -------
        tuple of Condition
            One for each trial of a round.
        """
        return tuple(self.at(self.motion, angle) for angle in self.angles_deg)


@parameters
class General(Depth):
    """One of each motion: straight approach and recession, a crossing each way."""

    distance_cm: DistanceCm = 8.0
    """Distance from the camera to the path of the crossings."""

    def conditions(self) -> tuple[Condition, ...]:
        """List the conditions: approach, recession, rightward, leftward.

        Returns
        -------
        tuple of Condition
            One for each trial of a round.
        """
        crossings = (Condition("translation", way, self.speed_cm_s, self.distance_cm) for way in _ways("both"))
        return (self.at("approach", 0.0), self.at("recession", 0.0), *crossings)


@parameters
class Crossings(Placement):
    """What crossings of one speed at one distance have in common."""

    _: KW_ONLY
    speed_cm_s: SpeedCmS = 6.0
    """Speed of the stimulus."""
    distance_cm: DistanceCm = 8.0
    """Distance from the camera to the path, in mid-crossing."""
    direction: Ways = "rightward"
    """Direction of the crossing in the image."""

    def each(self, changes: Iterable[Mapping[str, Any]]) -> tuple[Condition, ...]:
        """Return a crossing with each of the ``changes``, within directions.

        Parameters
        ----------
        changes
            Fields of a `Condition`.

        Returns
        -------
        tuple of Condition
            One for each trial of a round.
        """
        return tuple(
            Condition("translation", way, self.speed_cm_s, self.distance_cm, **changed)
            for way in _ways(self.direction)
            for changed in changes
        )


@parameters
class Contrast(Crossings):
    """Crossings by shells of several greys, before the same wall."""

    shell_greys: Several[Annotated[float, Field(ge=0.0, le=1.0)]] = (0.02, 0.2, 0.4, 0.6, 0.8, 1.0)
    """Reflectance of the stimulus's shell."""

    def conditions(self) -> tuple[Condition, ...]:
        """List the conditions: greys within directions.

        Returns
        -------
        tuple of Condition
            One for each trial of a round.
        """
        return self.each([{"shell_grey": grey} for grey in self.shell_greys])


@parameters
class Clutter(Crossings):
    """Crossings before walls of several contrasts."""

    wall_contrasts: Several[Annotated[float, Field(ge=0.0, le=4.0)]] = (0.0, 0.5, 1.0, 2.0, 4.0)
    """Contrast of the wall's texture; 1: as the arena has it."""

    def conditions(self) -> tuple[Condition, ...]:
        """List the conditions: contrasts within directions.

        Returns
        -------
        tuple of Condition
            One for each trial of a round.
        """
        return self.each([{"wall_contrast": contrast} for contrast in self.wall_contrasts])


@parameters
class Egomotion(Crossings):
    """Crossings while the observer itself turns or drives; in mid-crossing it is where it stands otherwise."""

    turns_deg_s: Several[Annotated[float, Field(ge=-30.0, le=30.0), unit("degrees/s")]] = (-5.0, -2.5, 0.0, 2.5, 5.0)
    """Turning of the observer, left positive."""
    drives_cm_s: tuple[Annotated[float, Field(ge=-5.0, le=5.0), unit("cm/s")], ...] = (-1.0, 1.0)
    """Driving of the observer where it does not turn, forward positive."""

    def conditions(self) -> tuple[Condition, ...]:
        """List the conditions: turns, then drives, within directions.

        Returns
        -------
        tuple of Condition
            One for each trial of a round.
        """
        turns = [{"observer_turn_deg_s": turn} for turn in self.turns_deg_s]
        return self.each([*turns, *({"observer_speed_cm_s": drive} for drive in self.drives_cm_s if drive)])


@parameters
class Listed(Placement):
    """A design that is a list of conditions."""

    listed: tuple[Condition, ...]
    """The conditions."""

    def conditions(self) -> tuple[Condition, ...]:
        """List its conditions.

        Returns
        -------
        tuple of Condition
            All of them.
        """
        return self.listed


# --- trials by hand ---------------------------------------------------------------------------------------------------

LIVE = "live"
"""The name of the experiment of a trial by hand: what ``colias live`` records, and ``colias run --again`` repeats."""


def visit(hand: Hand) -> Experiment:
    """Return the experiment of a trial by hand: one condition, without errors of the start pose.

    Its speed is the mean of the stimulus's commanded speeds, each by how long it lasted, its distance that of the
    robots' middles at the start, and its direction away from the side where the stimulus begins.

    Parameters
    ----------
    hand
        What was done.
    """
    moves = [(frame, abs(speed)) for frame, robot, speed, _ in hand.commands if robot == "stimulus"]
    ends = [*(frame for frame, _ in moves[1:]), hand.frames]
    driven = math.fsum(speed * (end - frame) for (frame, speed), end in zip(moves, ends, strict=False))
    (x, y, _), (from_x, from_y, _) = hand.stimulus, hand.observer
    speed, away = round(driven / hand.frames, 3), round(math.hypot(x - from_x, y - from_y), 3)
    direction: Direction = "rightward" if y > from_y else "leftward"
    condition = Condition(BY_HAND, direction, max(speed, 0.1), min(max(away, 0.5), 100.0), hand=hand)
    design = Listed((condition,), pose_sd_mm=0.0, heading_sd_deg=0.0)
    return Experiment(LIVE, "driven by hand, from the page of colias live", design, "speed_cm_s", 1)
