"""What the robot's true eye and wheels do to the claims: whole replicates of the paper's trials in four cells.

A cell is an eye (the default camera, or that of the robot) and a drive (pose feedback with ideal wheels, or the robot's
wheels in open loop). Its replicate r has the seeds of replicate r of ``colias reproduce``, so the cells differ in
nothing else, and the first of them is that reproduction's own.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from types import MappingProxyType

from experiments.bench import registry
from experiments.bench.engine.batch import Resources
from experiments.bench.judging.verdict import Outcome
from experiments.bench.reproduction import robustness
from experiments.bench.reproduction.replicates import Row, of_model, studied
from experiments.bench.reproduction.robustness import MODEL, Case
from experiments.bench.robot.plan import plan
from experiments.bench.store.files import Files
from experiments.bench.store.rows import Failure

CLAIMS = ("C13", "C14", "C15", "C16", "C17", "C18", "C19", "C20", "C29")
"""The claims about counts of spikes on the robot."""
EYES: Mapping[str, tuple[str, ...]] = MappingProxyType({"default": (), "ov7670": ("camera.preset=ov7670",)})
DRIVES: Mapping[str, tuple[str, ...]] = MappingProxyType({"pose feedback": (), "open loop": ("robot.preset=colias4",)})
REPLICATES = 20


@dataclass(frozen=True, slots=True)
class Cell:
    """One eye with one drive.

    Parameters
    ----------
    eye, drive
        Keys of `EYES` and `DRIVES`.
    """

    eye: str
    drive: str

    @property
    def name(self) -> str:
        """What tables and figure call it."""
        return f"{self.eye} eye, {self.drive}"

    @property
    def assignments(self) -> tuple[str, ...]:
        """The ``--set`` texts that make it."""
        return (*EYES[self.eye], *DRIVES[self.drive])


CELLS = tuple(Cell(eye, drive) for eye, drive in product(EYES, DRIVES))


@dataclass(frozen=True, slots=True)
class Driven:
    """How the stimulus moved in one cell, over all its trials so far.

    Parameters
    ----------
    trials
        How many.
    speed_error
        Mean of |reached - wanted| / wanted speed.
    path_error_mm
        Mean over trials of the largest distance from the path.
    """

    trials: int
    speed_error: float
    path_error_mm: float


@dataclass(frozen=True, slots=True)
class Fidelity:
    """The table of claims over cells, with as many replicates as there are so far.

    Parameters
    ----------
    outcomes
        (Cell, claim) -> its outcome in each replicate.
    driven
        Cell -> how the stimulus moved.
    repeats, seed
        Trials of each condition in a replicate; seed of replicate 0.
    failures
        Trials that failed.
    """

    outcomes: Mapping[tuple[Cell, str], Sequence[Outcome]]
    driven: Mapping[Cell, Driven]
    repeats: int
    seed: int
    failures: Sequence[Failure]

    @property
    def replicates(self) -> int:
        """Number of replicates."""
        return len(next(iter(self.outcomes.values())))

    def counted(self, cell: Cell, claim: str, verdict: str = "holds") -> int:
        """In how many replicates a claim came to ``verdict`` in a cell."""
        return sum(each.verdict == verdict for each in self.outcomes[cell, claim])

    def rows(self) -> list[dict[str, object]]:
        """What ``fidelity.json`` holds: a row for each cell and claim."""
        return [
            {
                "eye": cell.eye, "drive": cell.drive, "claim": claim, "held": self.counted(cell, claim),
                "vacuous": self.counted(cell, claim, "silent model"),
                "untested": self.counted(cell, claim, "not shown"),
                "replicates": len(found), "decided": found[0].decided, "measured": found[0].measured,
                "speed_error": self.driven[cell].speed_error, "path_error_mm": self.driven[cell].path_error_mm,
            }
            for (cell, claim), found in self.outcomes.items()
        ]  # fmt: skip


def cases(repeats: int, seed: int) -> list[Case]:
    """Return the trials of one replicate: a case for each of `CELLS`."""
    names = tuple(dict.fromkeys(robustness.judged_in()[claim] for claim in CLAIMS))
    return [Case(cell.name, robustness.specs(cell.assignments, repeats, seed, (MODEL,), names)) for cell in CELLS]


def run(
    folder: Path, replicates: int, repeats: int, seed: int, resources: Resources, show: Callable[[Fidelity], None]
) -> Fidelity:
    """Run what is missing of the table into ``folder``, a replicate of all cells after the other.

    Parameters
    ----------
    folder
        A new one, or one that holds a part of this table.
    replicates, repeats, seed
        How many replicates, trials of each condition in one, and the seed of the first.
    resources
        Workers, or a cluster.
    show
        Called with the table after every replicate.

    Returns
    -------
    Fidelity
        The table; ``fidelity.json`` in the folder has its rows.
    """
    example = plan(registry.load(robustness.judged_in()[CLAIMS[0]]), (MODEL,), (), repeats, seed)
    outcomes: dict[tuple[Cell, str], list[Outcome]] = {(cell, claim): [] for cell in CELLS for claim in CLAIMS}
    rows: dict[Cell, list[Row]] = {cell: [] for cell in CELLS}
    every = [cases(repeats, seed + number) for number in range(replicates)]
    for own, found, failures in robustness.played(
        every, lambda r, own: robustness.batch(f"replicate {r}", own, example), folder, resources
    ):
        for cell, each in zip(CELLS, studied(own, found), strict=True):
            rows[cell] += each.rows
            for claim in CLAIMS:
                outcomes[cell, claim].append(of_model(claim, each, MODEL))
        so_far = {key: tuple(each) for key, each in outcomes.items()}
        table = Fidelity(so_far, {cell: _driven(rows[cell]) for cell in CELLS}, repeats, seed, failures)
        Files(folder).write_json("fidelity.json", table.rows())
        show(table)
    return table


def _driven(rows: Sequence[Row]) -> Driven:
    errors = [abs(row["achieved_speed_cm_s"] / row["speed_cm_s"] - 1.0) for row in rows]
    count = max(len(rows), 1)
    return Driven(len(rows), sum(errors) / count, sum(row["path_error_mm"] for row in rows) / count)
