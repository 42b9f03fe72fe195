"""From a map's trials to the counts: in how many replicates each claim holds at each point."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from experiments.bench.core.store.rows import group
from experiments.bench.core.verdict import Outcome, Verdict, together
from experiments.bench.robot.claims import RobotClaim, judge
from experiments.bench.robot.map.plan import MapPlan
from experiments.bench.robot.sweep.grid import Point

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

    @property
    def holds(self) -> bool:
        """Whether it holds in every replicate."""
        return self.held == self.of

    def shown(self) -> str:
        """Return the count as figure and table show it; ``v`` marks a cell where it is vacuous in a replicate."""
        return f"{self.held}/{self.of}{'v' if self.vacuous else ''}"


def cells(made: MapPlan, rows: Sequence[Mapping[str, Any]]) -> list[Cell]:
    """The counts of every claim, then of all together, at every point.

    Parameters
    ----------
    made
        The map's plan.
    rows
        The rows of its ``trials.parquet``.
    """
    by_trial = group(rows, "trial", "model")
    judged: dict[tuple[str, str, str, int], Verdict] = {}
    found: list[Cell] = []
    for point in made.points:
        own: list[list[Verdict]] = []
        for claim, experiment in made.claims:
            verdicts = []
            for replicate in range(made.replicates):
                share = made.share(point, experiment, replicate)
                key = (claim.id, experiment, share.model, replicate)  # points may have their trials in common
                if key not in judged:
                    judged[key] = _verdict(made, claim, point, experiment, replicate, by_trial)
                verdicts.append(judged[key])
            own.append(verdicts)
            found.append(_cell(point, claim.id, experiment, [each.verdict for each in verdicts], verdicts[0]))
        if len(own) > 1:
            whole = [together([each.verdict for each in column]) for column in zip(*own, strict=True)]
            found.append(_cell(point, TOGETHER, "", whole))
    return found


def _verdict(
    made: MapPlan, claim: RobotClaim, point: Point, experiment: str, replicate: int,
    by_trial: Mapping[tuple[Any, ...], Sequence[Mapping[str, Any]]],
) -> Verdict:  # fmt: skip
    """One claim at one point in one replicate: untested where trials are lost, as the others are not the design."""
    share = made.share(point, experiment, replicate)
    own = [row for trial in share.trials for row in by_trial.get((trial, share.model), ())]
    lost = len(share.trials) - len(own)
    if lost:
        return claim.verdict(Outcome("untested", f"{lost} of {len(share.trials)} trials have no rows", n=len(own)))
    return judge(claim, own, share.threshold, made.model.label)


def _cell(point: Point, claim: str, experiment: str, verdicts: Sequence[str], first: Verdict | None = None) -> Cell:
    held, vacuous, untested = (list(verdicts).count(word) for word in ("holds", "vacuous", "untested"))
    said = (first.decided, first.measured) if first else ()
    return Cell(point, claim, experiment, held, vacuous, untested, len(verdicts), *said)


def table(made: MapPlan, found: Sequence[Cell]) -> list[dict[str, Any]]:
    """The rows of ``map.csv``: the values of the axes, the claim, the counts, what decided in replicate 0."""
    rows = []
    for cell in found:
        values = {
            axis.name: axis.values()[axis.levels.index(level)]
            for axis, (_, level) in zip(made.axes, cell.point.values, strict=True)
        }
        rows.append(
            {
                **values, "claim": cell.claim, "experiment": cell.experiment, "held": cell.held, "of": cell.of,
                "vacuous": cell.vacuous, "untested": cell.untested, "decided": cell.decided, "measured": cell.measured,
            }
        )  # fmt: skip
    return rows


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
