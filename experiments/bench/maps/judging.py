"""From a map's trials to its cells: in how many replicates each claim holds at each point, and the measures there."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from experiments.bench.clips.claims import ClipClaim
from experiments.bench.clips.claims import judge as judge_clips
from experiments.bench.judging.claim import Claim
from experiments.bench.judging.verdict import Outcome, Verdict, together
from experiments.bench.maps.measures import Measure
from experiments.bench.maps.plan import MapPlan, Share
from experiments.bench.robot.claims import RobotClaim
from experiments.bench.robot.claims import judge as judge_trials
from experiments.bench.robot.sweep.grid import Point
from experiments.bench.store.rows import group

Rows = Sequence[Mapping[str, Any]]
ByTrial = Mapping[tuple[Any, ...], Rows]
"""(Trial, label of a model) -> its rows."""

TOGETHER = "all"
"""What stands for all claims of a map together, where there are several."""


@dataclass(frozen=True, slots=True)
class Cell:
    """One claim at one point, or all claims together there.

    Parameters
    ----------
    point
        The point.
    claim
        Id of the claim, or `TOGETHER`.
    experiment
        The experiment whose trials answer for it; empty of all claims together.
    held, vacuous, untested, of
        Replicates in which it holds, in which it holds of a network that answers nothing, in which it could not be
        judged, and all of them. All claims together hold in a replicate if each of them does; if none fails, they are
        untested where one is, and else vacuous.
    decided, measured
        The deciding number of replicate 0 with its bound, and all that was measured.
    trouble
        What went wrong in a user's own judge, in any replicate; empty if nothing did.
    """

    point: Point
    claim: str
    experiment: str
    held: int
    vacuous: int
    untested: int
    of: int
    decided: str = ""
    measured: str = ""
    trouble: str = ""

    @property
    def holds(self) -> bool:
        """Whether it holds in every replicate."""
        return self.held == self.of

    def shown(self) -> str:
        """Return the count as figure and table show it; ``v`` marks a cell where it is vacuous in a replicate."""
        return f"{self.held}/{self.of}{'v' if self.vacuous else ''}"


@dataclass(frozen=True, slots=True)
class Number:
    """One measure at one point.

    Parameters
    ----------
    point
        The point.
    measure
        The measure.
    experiment
        The experiment whose trials it is measured on.
    value
        Of the trials of all replicates together; ``None`` where there is none.
    lowest, highest
        Of the replicates' own values; ``None`` where there are none.
    mark
        What is to be known of the value, in a few words; empty if nothing is.
    unmeasured, of
        Replicates without a value, and all of them.
    said
        What the value was found from, or why there is none.
    """

    point: Point
    measure: Measure
    experiment: str
    value: float | None
    lowest: float | None
    highest: float | None
    mark: str
    unmeasured: int
    of: int
    said: str

    def shown(self) -> str:
        """Return the value as figure and table show it."""
        return "-" if self.value is None else f"{self.value:.3f}" if abs(self.value) < 1.0 else f"{self.value:.3g}"


def cells(made: MapPlan, rows: Rows) -> list[Cell]:
    """The counts of every claim, then of all together, at every point.

    Parameters
    ----------
    made
        The map's plan.
    rows
        The rows of its ``trials.parquet``.
    """
    by_trial = group(rows, "trial", "model")
    judged: dict[tuple[str, Share], Verdict] = {}
    found: list[Cell] = []
    for point in made.points:
        own: list[list[Verdict]] = []
        for claim, experiment in made.claims:
            verdicts = []
            for share in _shares(made, point, experiment):
                key = (claim.id, share)  # points may have their trials in common
                if key not in judged:
                    judged[key] = _verdict(claim, share, by_trial, made.things)
                verdicts.append(judged[key])
            own.append(verdicts)
            trouble = next((each.trouble for each in verdicts if each.trouble), "")
            counted = _cell(point, claim.id, experiment, [each.outcome.verdict for each in verdicts], verdicts[0])
            found.append(replace(counted, trouble=trouble))
        if len(own) > 1:
            whole = [together([each.outcome.verdict for each in column]) for column in zip(*own, strict=True)]
            found.append(_cell(point, TOGETHER, "", whole))
    return found


def numbers(made: MapPlan, rows: Rows) -> list[Number]:
    """The measures at every point.

    Parameters
    ----------
    made
        The map's plan.
    rows
        The rows of its ``trials.parquet``.
    """
    by_trial = group(rows, "trial", "model")
    return [
        _number(made, measure, experiment, point, by_trial)
        for point in made.points
        for measure, experiment in made.measures
    ]


def _shares(made: MapPlan, point: Point, experiment: str) -> list[Share]:
    return [made.share(point, experiment, replicate) for replicate in range(made.replicates)]


def _rows(share: Share, by_trial: ByTrial, things: str) -> tuple[list[Mapping[str, Any]], str]:
    """The rows of a share under the models' names without the grid's values, and what is lost of them, in words."""
    own: list[Mapping[str, Any]] = []
    lost = 0
    for trial in share.trials:
        there = [
            {**row, "model": each.name} for each in share.watchers for row in by_trial.get((trial, each.label), ())
        ]
        lost += len(there) < len(share.watchers)
        own += there
    return own, f"{lost} of {len(share.trials)} {things} have no rows" if lost else ""


def _verdict(claim: Claim, share: Share, by_trial: ByTrial, things: str) -> Verdict:
    """One claim on one share: untested where trials are lost, as the others are not the design."""
    own, lost = _rows(share, by_trial, things)
    if lost:
        return claim.verdict(Outcome.unjudged(lost, n=len(own)))
    judged = share.watchers[0]
    if isinstance(claim, ClipClaim):
        return claim.verdict(judge_clips(claim, own, {each.name: each.threshold for each in share.watchers}))
    assert isinstance(claim, RobotClaim)
    return judge_trials(claim, own, judged.threshold, judged.name)


def _number(made: MapPlan, measure: Measure, experiment: str, point: Point, by_trial: ByTrial) -> Number:
    """One measure at one point, on the replicates of which no trial is lost."""
    shares = _shares(made, point, experiment)
    judged = shares[0].watchers[0]
    whole: list[Mapping[str, Any]] = []
    values, why = [], ""
    for share in shares:
        rows, lost = _rows(share, by_trial, made.things)
        if lost:
            why = lost
            continue
        own = [row for row in rows if row["model"] == judged.name]
        value = measure.of(own, judged.threshold).value
        whole += own
        if value is not None:
            values.append(value)
    found = measure.of(whole, judged.threshold) if whole else None
    said = "; ".join(filter(None, (why, found.said if found else "")))
    value, mark = (found.value, found.mark) if found else (None, "")
    lowest, highest = (min(values), max(values)) if values else (None, None)
    return Number(
        point, measure, experiment, value, lowest, highest, mark, len(shares) - len(values), len(shares), said
    )


def _cell(point: Point, claim: str, experiment: str, verdicts: Sequence[str], first: Verdict | None = None) -> Cell:
    held, vacuous, untested = (list(verdicts).count(word) for word in ("holds", "silent model", "not shown"))
    said = (first.outcome.decided, first.outcome.measured) if first else ()
    return Cell(point, claim, experiment, held, vacuous, untested, len(verdicts), *said)


def table(made: MapPlan, found: Sequence[Cell], measured: Sequence[Number] = ()) -> list[dict[str, Any]]:
    """The rows of ``map.csv``: the values of the axes, and a claim with its counts or a measure with its number."""
    of_claims = [
        {
            **_values(made, cell.point), "claim": cell.claim, "experiment": cell.experiment, "held": cell.held,
            "of": cell.of, "vacuous": cell.vacuous, "untested": cell.untested, "decided": cell.decided,
            "measured": cell.measured,
        }
        for cell in found
    ]  # fmt: skip
    of_measures = [
        {
            **_values(made, each.point), "measure": each.measure.name, "experiment": each.experiment,
            "value": each.value, "unit": each.measure.unit, "lowest": each.lowest, "highest": each.highest,
            "mark": each.mark, "of": each.of, "untested": each.unmeasured, "measured": each.said,
        }
        for each in measured
    ]  # fmt: skip
    rows: list[dict[str, Any]] = [*of_claims, *of_measures]
    names = list(dict.fromkeys(name for row in rows for name in row))
    return [{name: row.get(name) for name in names} for row in rows]


def _values(made: MapPlan, point: Point) -> dict[str, float | str]:
    """The values of the axes at a point."""
    return {
        axis.name: axis.values()[axis.levels.index(level)]
        for axis, (_, level) in zip(made.axes, point.values, strict=True)
    }


def regions(found: Sequence[Cell]) -> list[str]:
    """How much of the grid each claim holds on, and all together, a line each."""
    lines = []
    for claim, chosen in by_claim(found).items():
        whole = sum(cell.holds for cell in chosen)
        share = f"at {whole} of {len(chosen)} points ({whole / len(chosen):.0%})"
        untested = sum(cell.untested > 0 for cell in chosen)
        vacuous = sum(cell.vacuous > 0 for cell in chosen)
        also = f"; not judged in every replicate at {untested}" if untested else ""
        also += f"; vacuous in a replicate at {vacuous}" if vacuous else ""
        every = f"in {chosen[0].of} of {chosen[0].of} replicates" if chosen[0].of > 1 else "in the one replicate"
        who = "all claims together hold" if claim == TOGETHER else f"{claim} holds"
        lines.append(f"{who} {every} {share}{also}")
    return lines


def by_claim(found: Sequence[Cell]) -> dict[str, list[Cell]]:
    """The cells of each claim, in order."""
    groups: dict[str, list[Cell]] = {}
    for cell in found:
        groups.setdefault(cell.claim, []).append(cell)
    return groups


def reaches(measured: Sequence[Number]) -> list[str]:
    """From where to where each measure goes over the grid, and at how many points what is to be known, a line each."""
    lines = []
    for name, chosen in by_measure(measured).items():
        values = [each.value for each in chosen if each.value is not None]
        unit = f" {chosen[0].measure.unit}" if chosen[0].measure.unit else ""
        parts = [f"{name} is {min(values):.3g} to {max(values):.3g}{unit}" if values else f"{name} has no value"]
        marks = [each.mark for each in chosen if each.mark]
        parts += [f"{mark} at {marks.count(mark)} of {len(chosen)} points" for mark in dict.fromkeys(marks)]
        without = sum(each.value is None for each in chosen)
        parts += [f"no value at {without} of {len(chosen)}"] if without and values else []
        lines.append("; ".join(parts))
    return lines


def by_measure(measured: Sequence[Number]) -> dict[str, list[Number]]:
    """The numbers of each measure, in order."""
    groups: dict[str, list[Number]] = {}
    for each in measured:
        groups.setdefault(each.measure.name, []).append(each)
    return groups
