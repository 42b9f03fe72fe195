"""The experiment of one trial by hand: what ``colias live`` records, and ``colias run --again`` repeats."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from typing import Any

from pydantic import TypeAdapter, ValidationError

from colias_sim import bearing
from experiments.bench.run.errors import UsageError, explain
from experiments.bench.sources.conditions import BY_HAND, Condition
from experiments.bench.sources.experiment import Experiment
from experiments.bench.sources.hand import Hand

NAME = "live"
"""The name of the experiment."""


@dataclasses.dataclass(frozen=True, slots=True)
class ByHand:
    """The design of a trial by hand: one condition, without errors of the start pose.

    Parameters
    ----------
    hand
        What was done.
    """

    hand: Hand
    pose_sd_mm: float = 0.0
    heading_sd_deg: float = 0.0

    def conditions(self) -> tuple[Condition, ...]:
        """List its condition.

        Returns
        -------
        tuple of Condition
            One. Its speed is the mean of the stimulus's commanded speeds, each by how long it lasted, its distance
            that of the stimulus from the observer's middle at the start, and its direction, by the first command that
            moves the stimulus, that in which its bearing begins to go.
        """
        hand = self.hand
        moves = [command for command in hand.commands if command.robot == "stimulus"]
        ends = [*(command.frame for command in moves[1:]), hand.frames][: len(moves)]
        driven = math.fsum(abs(c.speed_cm_s) * (end - c.frame) for c, end in zip(moves, ends, strict=True))
        speed = driven / hand.frames
        away = math.hypot(hand.stimulus.x_cm - hand.observer.x_cm, hand.stimulus.y_cm - hand.observer.y_cm)
        first = next((command.speed_cm_s for command in moves if command.speed_cm_s), 0.0)
        here, observer = hand.stimulus.pose, hand.observer.pose
        step = math.copysign(0.01, first) if first else 0.0
        there = dataclasses.replace(
            here, x=here.x + step * math.cos(here.heading), y=here.y + step * math.sin(here.heading)
        )
        swept = math.remainder(bearing(observer, there, 0.0) - bearing(observer, here, 0.0), 2 * math.pi)
        straight = abs(swept) < math.radians(0.1)
        return (
            Condition(
                BY_HAND, "straight" if straight else "rightward" if swept > 0 else "leftward",
                min(max(round(speed, 3), 0.1), 100.0), min(max(round(away, 3), 0.5), 100.0), hand=hand,
            ),
        )  # fmt: skip


def visit(hand: Hand) -> Experiment:
    """Return the experiment of a trial by hand.

    Parameters
    ----------
    hand
        What was done.
    """
    return Experiment(NAME, "driven by hand, from the page of colias live", ByHand(hand), "speed_cm_s", 1)


def described(experiment: object) -> dict[str, Any] | None:
    """Return what `declared` takes of an experiment that was driven by hand; ``None`` of any other."""
    design = getattr(experiment, "design", None)
    return {NAME: dataclasses.asdict(design.hand)} if isinstance(design, ByHand) else None


def declared(value: Any, where: str) -> Experiment | None:
    """Return the experiment that `described` describes; ``None`` where it describes none.

    Raises
    ------
    UsageError
        A value of it is not legal.
    """
    if not isinstance(value, Mapping) or set(value) != {NAME}:
        return None
    try:
        return visit(TypeAdapter(Hand).validate_python(value[NAME]))
    except ValidationError as error:
        raise UsageError(f"{where}: {explain(error)}") from None
