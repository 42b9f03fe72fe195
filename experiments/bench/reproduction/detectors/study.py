"""C21 in whole replicates before every detector and preset, in the bright arena and in the dim one.

Replicate r has the seeds of replicate r of ``colias reproduce``, so that the rows of ``lgmd1`` and ``lgmd2`` in the
bright arena are that reproduction's own.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from experiments.bench import registry
from experiments.bench.engine.batch import Batch, Resources
from experiments.bench.reproduction.detectors.causes import explained
from experiments.bench.reproduction.detectors.measure import FRAMES, SCHEMA, work
from experiments.bench.reproduction.detectors.panel import ARENAS, EXPERIMENT, PANEL
from experiments.bench.reproduction.detectors.rows import DetectorRow, EdgeRow, Shown, detector_row, edge_row, shown_in
from experiments.bench.reproduction.robustness import Case, numbered, played
from experiments.bench.robot.plan import describe, plan
from experiments.bench.robot.rows import robot_contents
from experiments.bench.robot.run import seconds
from experiments.bench.store.files import Files
from experiments.bench.store.rows import Failure

REPLICATES = 20
FILE, STUDY = "detectors.json", "detectors"


@dataclass(frozen=True, slots=True)
class Detectors:
    """The table of detectors over arenas, with as many replicates as there are so far.

    Parameters
    ----------
    rows
        One for each arena and detector, arenas first.
    edges
        The moving edge in each arena.
    replicates, repeats, seed
        How many replicates, trials of each condition in one, and the seed of replicate 0.
    failures
        Trials, and single detectors in trials, that failed.
    """

    rows: Sequence[DetectorRow]
    edges: Sequence[EdgeRow]
    replicates: int
    repeats: int
    seed: int
    failures: Sequence[Failure]


def cases(repeats: int, seed: int) -> list[Case]:
    """Return the trials of one replicate: a case for each arena, before all detectors of `PANEL`."""
    experiment, labels = registry.load(EXPERIMENT), [detector.label for detector in PANEL]
    return [
        Case(arena, tuple(plan(experiment, labels, changes, repeats, seed).specs()))
        for arena, changes in ARENAS.items()
    ]


def run(
    folder: Path, replicates: int, repeats: int, seed: int, resources: Resources, show: Callable[[Detectors], None]
) -> Detectors:
    """Run what is missing of the table into ``folder``, one replicate of both arenas after the other.

    Parameters
    ----------
    folder
        A new one, one that holds a part of this table, or that of a reproduction, whose report then shows it.
    replicates, repeats, seed
        How many replicates, trials of each condition in one, and the seed of the first.
    resources
        Workers, or a cluster.
    show
        Called with the table after every replicate.

    Returns
    -------
    Detectors
        The table; ``detectors.json`` in the folder has its rows.
    """
    shown: dict[str, list[Shown]] = {arena: [] for arena in ARENAS}
    every = [cases(repeats, seed + number) for number in range(replicates)]
    for own, rows, failures in played(
        every, lambda r, own: _batch(f"replicate {r}", own, repeats, seed + r), folder / STUDY, resources
    ):
        for case, each in zip(own, _by_case(own, rows), strict=True):
            shown[case.name].append(each)
        table = _table(shown, repeats, seed, failures)
        Files(folder).write_json(FILE, table)
        show(table)
    return table


def _table(shown: Mapping[str, Sequence[Shown]], repeats: int, seed: int, failures: Sequence[Failure]) -> Detectors:
    """The table of the replicates so far, by arena."""
    edges = {arena: edge_row(arena, PANEL[0].label, every) for arena, every in shown.items()}
    rows = [
        explained(detector_row(arena, detector, every), edges[arena])
        for arena, every in shown.items()
        for detector in PANEL
    ]
    return Detectors(tuple(rows), tuple(edges.values()), edges[rows[0].arena].replicates, repeats, seed, failures)


def _batch(name: str, own: Sequence[Case], repeats: int, seed: int) -> Batch[Any]:
    """The trials of one replicate. They leave their rows alone."""
    specs = numbered(own)
    example = plan(registry.load(EXPERIMENT), [detector.label for detector in PANEL], (), repeats, seed)
    listed = [{"case": case.name, "trials": len(case.specs), "settings": case.specs[0].settings} for case in own]
    return Batch(
        name=name,
        specs=specs,
        work=work,
        description={**describe(example), "kind": "study", "experiment": name, "trials": len(specs), "cases": listed},
        contents=robot_contents(specs, recordings=False, frames=False),
        schemas=(SCHEMA, FRAMES),
        size=seconds,
    )


def _by_case(own: Sequence[Case], rows: Sequence[Mapping[str, Any]]) -> list[Shown]:
    """The rows of a replicate's trials by case, judged."""
    found, begin = [], 0
    for case in own:
        mine = [row for row in rows if begin <= row["trial"] < begin + len(case.specs)]
        found.append(shown_in(mine, len(case.specs), case.specs[0].settings.models))
        begin += len(case.specs)
    return found
