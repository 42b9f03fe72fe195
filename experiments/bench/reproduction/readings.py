"""The readings of the paper where one was taken of several: what its claims come to under each, side by side."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from experiments.bench.offline import OfflineReport
from experiments.bench.sources import robot_claims
from experiments.bench.stats import clips as clips_claims
from experiments.bench.stats.count import count
from experiments.bench.stats.judging import FALLING, ROBOT_SPEEDS
from experiments.bench.stats.verdict import Outcome, Verdict
from experiments.bench.studies.replicates import Replicate
from experiments.claims.readings import READINGS, Reading, bears_on
from experiments.clutter_frames import OF, prefix
from experiments.studies.sensitivity import STUDY as ON_ROBOT
from experiments.studies.sensitivity_clips import STUDY as ON_CLIPS

NOT_RUN = "not run"
FALLING_IN, FRAMES_IN, WINDOW = "ensembles", "clutter-frames", "C29"
"""Experiments that show the other reading of delays and of speeds, and the claim that is that of the time window."""
MOVED = frozenset(claim for study in (ON_ROBOT, ON_CLIPS) for claim in study.claims)
"""The claims of the studies of sensitivity, whose levels have the names of the other readings."""


@dataclass(frozen=True, slots=True)
class Side:
    """Outcome of a claim under one reading.

    Parameters
    ----------
    verdict
        That of its first replicate; `NOT_RUN` where there is none.
    held
        In how many replicates it held, in words; or why it was not run.
    n
        Trials or clips of the first replicate.
    decided
        The number that decided there.
    where
        The experiment, or what was moved.
    """

    verdict: str
    held: str
    n: int = 0
    decided: str = ""
    where: str = ""

    def __str__(self) -> str:
        """The side in words."""
        if self.verdict == NOT_RUN:
            return f"{NOT_RUN}: {self.held}"
        decided = f"; decided by: {self.decided}" if self.decided else ""
        return f"{self.held} ({self.where}; replicate 0: {self.verdict}, n = {self.n}{decided})"


@dataclass(frozen=True, slots=True)
class Row:
    """A claim under a reading taken and under the others, in the order of `Reading.others`."""

    claim: str
    taken: Side
    others: tuple[Side, ...]


@dataclass(frozen=True, slots=True)
class Chapter:
    """One reading of the chapter, with a row for each claim that it was chosen for."""

    reading: Reading
    rows: tuple[Row, ...]


@dataclass(frozen=True, slots=True)
class Evidence:
    """Results of a reproduction, as judged and as rows.

    Parameters
    ----------
    verdicts
        Claim -> its verdict under the readings taken.
    replicates
        The experiments with the robot.
    shows
        The off-line experiments.
    moved
        What was moved -> claim -> its outcome in one replicate.
    name
        What a replicate with the robot is called.
    """

    verdicts: Mapping[str, Verdict]
    replicates: Sequence[Replicate]
    shows: Sequence[OfflineReport]
    moved: Mapping[str, Mapping[str, Outcome]]
    name: str = "replicate"


def chapters(evidence: Evidence) -> list[Chapter]:
    """Return the readings in their order, each with what its claims came to."""
    return [
        Chapter(
            reading,
            tuple(
                Row(claim, _taken(evidence.verdicts[claim], evidence.name), _others(reading, claim, evidence))
                for claim in bears_on(reading)
            ),
        )
        for reading in READINGS
    ]


def _taken(verdict: Verdict, name: str) -> Side:
    outcome = verdict.outcome
    if not verdict.experiment:
        return Side(NOT_RUN, outcome.measured)
    held = verdict.count.sentence(name)
    return Side(outcome.verdict, held, outcome.n, outcome.decided, verdict.experiment)


def _others(reading: Reading, claim: str, evidence: Evidence) -> tuple[Side, ...]:
    side = _SIDES.get(reading.id, _moved)
    return tuple(side(claim, name, evidence) for name in reading.others)


def _falling(claim: str, _: str, evidence: Evidence) -> Side:
    """Judged in every replicate, on the variant of ensembles whose delays fall, at the paper's speeds."""
    outcomes = []
    for replicate in evidence.replicates:
        lost = replicate.lost.get((FALLING_IN, FALLING), 0)
        rows = [row for row in replicate.of(FALLING) if row["experiment"] == FALLING_IN]
        at_speeds = [row for row in rows if row["speed_cm_s"] in ROBOT_SPEEDS]
        if not at_speeds:
            return Side(NOT_RUN, f"{FALLING_IN} was not shown to {FALLING}")
        judged = robot_claims.outcome(claim, at_speeds, replicate.thresholds[FALLING])
        outcomes.append(judged.withheld(f"{lost} trials failed") if lost else judged)
    return _side(outcomes, FALLING_IN, evidence.name)


def _per_frame(claim: str, _: str, evidence: Evidence) -> Side:
    """Judged at every seed, on those clips in px a frame that are the claim's own."""
    frames = next((show for show in evidence.shows if show.plan.experiment.name == FRAMES_IN), None)
    if frames is None:
        return Side(NOT_RUN, f"{FRAMES_IN} was not run")
    begins = next(prefix(experiment) for experiment in OF if claim in experiment.claims)
    of_claim = [row for row in frames.rows if row["clip"].startswith(begins)]
    outcomes = [
        clips_claims.judge(
            claim, [row for row in of_claim if row["repeat"] == repeat], frames.plan.thresholds, frames.rows
        )
        for repeat in sorted({row["repeat"] for row in of_claim})
    ]
    return _side(outcomes, FRAMES_IN) if outcomes else Side(NOT_RUN, f"{FRAMES_IN} has no clips")


def _moved(claim: str, name: str, evidence: Evidence) -> Side:
    """One replicate, of the studies of sensitivity."""
    if claim not in MOVED:
        return Side(NOT_RUN, "the studies of sensitivity do not judge this claim")
    outcome = evidence.moved.get(name, {}).get(claim)
    if outcome is None:
        return Side(NOT_RUN, "it takes a replicate with this moved (--quick moves nothing)")
    return _side([outcome], f"sensitivity, {name}", evidence.name)


def _windowed(_: str, __: str, evidence: Evidence) -> Side:
    return _taken(evidence.verdicts[WINDOW], evidence.name)


def _side(outcomes: Sequence[Outcome], where: str, name: str = "replicate") -> Side:
    first = outcomes[0]
    held = count([outcome.verdict for outcome in outcomes]).sentence(name)
    return Side(first.verdict, held, first.n, first.deciding, where)


_SIDES: Mapping[str, Callable[[str, str, Evidence], Side]] = {
    "tau_s_rises_with_spacing": _falling,
    "speeds_in_px_per_second": _per_frame,
    "whole_crossing": _windowed,
}
"""Reading -> how a claim is judged under another one, where that is no level of the studies of sensitivity."""
