"""A scenario: many robots that all see, what each does, and what is measured of them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Annotated, ClassVar

import numpy as np
from pydantic import ConfigDict, Field
from pydantic.dataclasses import dataclass as checked_dataclass

from colias_sim import Pose
from colias_sim.envs.crowd import Tracks
from colias_sim.envs.swarm import Drive
from dsnn.field_docs import unit, with_field_docs
from experiments.base.errors import check_name
from experiments.declare.claim import Claim

BLIND = "blind"
"""What a swarm that sees nothing is called where models are named."""


@with_field_docs
@checked_dataclass(frozen=True, config=ConfigDict(extra="forbid", use_attribute_docstrings=True))
class SwarmDesign:
    """What differs between the trials of a scenario: the section ``swarm`` of ``--set``."""

    robots: tuple[Annotated[int, Field(ge=1, le=30)], ...] = (12,)
    """Numbers of robots, each a condition."""
    speeds_cm_s: tuple[Annotated[float, Field(ge=1.0, le=20.0), unit("cm/s")], ...] = (8.0,)
    """Speeds at which robots drive ahead, each a condition."""
    seconds: Annotated[float, unit("s")] = Field(default=60.0, ge=1.0, le=3600.0)
    """Length of a trial."""


@dataclass(frozen=True, kw_only=True)
class Scenario:
    """A declaration of many robots that all see, for ``colias run``.

    Parameters
    ----------
    name, summary
        As of an `experiments.Experiment`.
    start
        Draws the start of the robots: from a generator and their number to as many `colias_sim.Pose`.
    make
        Builds what drives a robot, `Drive`: from its number, its speed ahead as a share of the maximum, the channels of
        its model (none of a blind one), and its own generator. It is called once a frame.
    models
        The swarms that are compared: the model that all of its robots have, or ``blind``.
    design
        Numbers of robots, speeds, length.
    measure
        Further columns of a trial, from its `Tracks`: column -> number.
    figure
        Column that is drawn, and its heading with the unit.
    along
        What it is drawn against: ``robots`` or ``speed_cm_s``.
    chance
        What the figure's column is by chance, from the number of robots and the speed in cm/s.
    arena
        An arena of `scenes`.
    repeats
        How often, each time from another start.
    claims
        Claims of your own, ``on="swarm"``. A judge gets the rows of one repeat, which is a replicate.
    file
        The .py file that declares it, which commands and `experiments.run` fill in.

    Raises
    ------
    ValueError
        The name cannot be one.

    Examples
    --------
    >>> import math
    >>> from colias_sim import Pose
    >>> from experiments import Scenario
    >>> ring = lambda rng, n: [Pose(0.2 * math.cos(6.28 * k / n), 0.2 * math.sin(6.28 * k / n), 0.0) for k in range(n)]
    >>> def make(number, ahead, channels, rng):
    ...     return lambda seen, body: (ahead, ahead) if number == 0 else (0.0, 0.0)
    >>> SCENARIO = Scenario(name="one-drives", summary="one drives, the rest stand", start=ring, make=make)
    """

    name: str
    summary: str
    start: Callable[[np.random.Generator, int], Sequence[Pose]]
    make: Callable[[int, float, Sequence[str], np.random.Generator], Drive]
    models: tuple[str, ...] = ("lgmd2", BLIND)
    design: SwarmDesign = field(default_factory=SwarmDesign)
    measure: Callable[[Tracks], Mapping[str, float]] | None = None
    figure: tuple[str, str] = ("collisions_a_min", "collisions a robot-minute")
    along: str = "robots"
    chance: Callable[[int, float], float] | None = None
    arena: str = "bright"
    repeats: int = 1
    claims: tuple[Claim, ...] = ()
    file: str = field(default="", compare=False, repr=False)
    kind: ClassVar[str] = "swarm"

    def __post_init__(self) -> None:
        check_name("experiment", self.name)
