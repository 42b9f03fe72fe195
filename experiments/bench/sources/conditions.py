"""Conditions of trials with the robot: what the stimulus, the observer and further robots do."""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Sequence
from typing import Annotated, Any, Literal, get_args

from pydantic import ConfigDict, Field, model_validator
from pydantic.dataclasses import dataclass

from colias_sim import Schedule
from experiments.bench.sources.hand import Hand
from experiments.bench.sources.path import Path

Motion = Literal["translation", "approach", "recession"]
Direction = Literal["rightward", "leftward", "straight"]
PAPER = get_args(Motion)
DEPTH = ("approach", "recession")
BY_HAND = "by-hand"
"""The motion of trials that were driven by hand."""
SCRIPTED = ("path", "observer", "movers", "hand")
"""The fields of a condition that are no columns: its paths, which the name in ``motion`` stands for."""
WHERE_SET = {"where_set": True}
"""Metadata of fields that descriptions have only where they are set: `experiments.bench.run.files.plain`."""
START_CM_S2 = 100.0
"""The acceleration with which a stimulus starts where its condition does not say."""
_PLACES = 400
"""Places of a path from which its direction and its distance are read."""

Length = Annotated[float, Field(ge=0.5, le=100.0)]


@dataclass(frozen=True, slots=True, config=ConfigDict(extra="forbid", allow_inf_nan=False))
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
    pydantic.ValidationError
        No trial can have the value; it is a ``ValueError``. Whether robots and arena allow it is checked when a run is
        planned.

    Examples
    --------
    >>> from experiments import Condition
    >>> Condition("translation", "rightward", speed_cm_s=6.0, distance_cm=8.0).label()
    'translation rightward, 6 cm/s at 8 cm'
    """

    motion: Annotated[str, Field(pattern="^[a-z][a-z0-9-]{0,39}$")]
    direction: Direction
    speed_cm_s: Annotated[float, Field(ge=0.1, le=100.0)]
    distance_cm: Length
    far_cm: Length | None = None
    angle_deg: Annotated[float, Field(ge=-80.0, le=80.0)] | None = None
    shell_grey: Annotated[float, Field(ge=0.0, le=1.0)] | None = None
    wall_contrast: Annotated[float, Field(ge=0.0, le=4.0)] | None = None
    observer_speed_cm_s: Annotated[float, Field(ge=-35.0, le=35.0)] = 0.0
    observer_turn_deg_s: Annotated[float, Field(ge=-360.0, le=360.0)] = 0.0
    acceleration_cm_s2: Annotated[float, Field(ge=1.0, le=1000.0)] = START_CM_S2
    path: Path | None = dataclasses.field(default=None, metadata=WHERE_SET)
    observer: Path | None = dataclasses.field(default=None, metadata=WHERE_SET)
    movers: Annotated[tuple[Path, ...], Field(max_length=6)] = dataclasses.field(default=(), metadata=WHERE_SET)
    hand: Hand | None = dataclasses.field(default=None, metadata=WHERE_SET)

    @model_validator(mode="after")
    def _check(self) -> Condition:
        own = self.motion not in PAPER
        if own != (self.path is not None or self.hand is not None):
            raise ValueError(
                f"motion must be one of {', '.join(PAPER)}, or a name of its own with a path (Condition.along), "
                f"got {self.motion}{'' if own else ' with a path'}"
            )
        if self.path is None and (self.observer or self.movers):
            raise ValueError("observer and movers need a path of the stimulus")
        if self.motion == "translation" and self.direction == "straight":
            raise ValueError("the direction of a translation must be rightward or leftward, got straight")
        if self.motion in DEPTH and (self.angle_deg is None or self.far_cm is None):
            raise ValueError(f"{self.motion} needs angle_deg and far_cm")
        if self.far_cm is not None and self.far_cm <= self.distance_cm:
            raise ValueError(f"far_cm must be above distance_cm={self.distance_cm:g}, got {self.far_cm:g}")
        for path in filter(None, (self.path, self.observer, *self.movers)):
            for index, leg in enumerate(path.legs):
                if abs(leg.acceleration_cm_s2) > self.acceleration_cm_s2:
                    raise ValueError(
                        f"legs[{index}].to_cm_s={leg.end_cm_s:g} from {leg.speed_cm_s:g} cm/s in "
                        f"{leg.length_cm:.3g} cm is {abs(leg.acceleration_cm_s2):.0f} cm/s2, above "
                        f"acceleration_cm_s2={self.acceleration_cm_s2:g}: make it longer, or raise that"
                    )
        return self

    @classmethod
    def along(
        cls, motion: str, path: Path, *, direction: Direction | None = None, observer: Path | None = None,
        movers: Sequence[Path] = (), acceleration_cm_s2: float = START_CM_S2, **looks: Any,
    ) -> Condition:  # fmt: skip
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
        acceleration_cm_s2
            With which robots take a step of the speed: at the start, at the end, or between two legs.
        **looks
            ``shell_grey`` and ``wall_contrast``, as of a `Condition`.

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
        if not path.length_cm:
            raise ValueError(f"condition {motion}: the stimulus has to move: no leg of its path has a length_cm")
        start = acceleration_cm_s2 / 100
        route = path.stimulus_route(acceleration_cm_s2)
        speed = 100 * Schedule(route, start).speed_over(route.measured(start))
        length = path.length_cm / 100
        places = [route.point(route.length - length * (1 - i / _PLACES)) for i in range(_PLACES + 1)]
        steps = [math.atan2(b.y, b.x) - math.atan2(a.y, a.x) for a, b in itertools.pairwise(places)]
        swept = math.degrees(sum(math.remainder(step, 2 * math.pi) for step in steps))
        seconds = observer.seconds if observer else 0.0
        return cls(
            motion,
            direction or ("straight" if abs(swept) < 1.0 else "leftward" if swept > 0 else "rightward"),
            round(speed, 3),
            round(100 * min(math.hypot(place.x, place.y) for place in places), 3),
            observer_speed_cm_s=round(observer.length_cm / seconds, 3) if observer and seconds else 0.0,
            observer_turn_deg_s=round(observer.turn_deg / seconds, 3) if observer and seconds else 0.0,
            acceleration_cm_s2=acceleration_cm_s2,
            path=path,
            observer=observer,
            movers=tuple(movers),
            **looks,
        )

    def columns(self) -> dict[str, Any]:
        """Return what the tables have of it, by column.

        Returns
        -------
        dict of str to Any
            Every field but the paths.
        """
        return {name: getattr(self, name) for name in CONDITION_COLUMNS}

    def label(self) -> str:
        """Write the condition in words.

        Returns
        -------
        str
            As tables and figures show it.
        """
        where = f"at {self.distance_cm:g} cm" if self.angle_deg is None else f"along {self.angle_deg:g} degrees"
        parts = [f"{self.motion} {self.direction}, {self.speed_cm_s:g} cm/s {where}"]
        looks = (("shell grey", self.shell_grey), ("wall contrast", self.wall_contrast))
        parts += [f"{look} {value:g}" for look, value in looks if value is not None]
        if self.observer_speed_cm_s:
            parts.append(f"observer driving {self.observer_speed_cm_s:g} cm/s")
        if self.observer_turn_deg_s:
            parts.append(f"observer turning {self.observer_turn_deg_s:g} degrees/s")
        return ", ".join(parts)


CONDITION_COLUMNS = tuple(field.name for field in dataclasses.fields(Condition) if field.name not in SCRIPTED)
