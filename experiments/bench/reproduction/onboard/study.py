"""The table of claims over formats in replicates of its own: ``colias reproduce --onboard``.

Replicate r has the seeds of replicate r of ``colias reproduce``, so that the float network's column is that
reproduction's own.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from experiments.bench import registry
from experiments.bench.engine.batch import Resources
from experiments.bench.reproduction import robustness
from experiments.bench.reproduction.onboard.formats import CLAIMS, FORMATS, Format
from experiments.bench.reproduction.onboard.rows import FILE, STUDY, Onboard, tabled
from experiments.bench.reproduction.replicates import Replicate, replicate
from experiments.bench.reproduction.robustness import Case
from experiments.bench.robot.plan import plan
from experiments.bench.store.files import Files

REPLICATES = 20


def case(repeats: int, seed: int, formats: Sequence[Format] = FORMATS) -> Case:
    """Return the trials of one replicate, before all formats: the experiments that `CLAIMS` are judged in."""
    names = dict.fromkeys(robustness.judged_in()[claim] for claim in CLAIMS)
    labels = [each.label for each in formats]
    specs = [spec for name in names for spec in plan(registry.load(name), labels, (), repeats, seed).specs()]
    return Case(str(seed), tuple(specs))


def run(
    folder: Path, replicates: int, repeats: int, seed: int, resources: Resources, show: Callable[[Onboard], None],
    formats: Sequence[Format] = FORMATS,
) -> Onboard:  # fmt: skip
    """Run what is missing of the table into ``folder``, one replicate after the other.

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
    formats
        Those to compare, the float network first.

    Returns
    -------
    Onboard
        The table; ``onboard.json`` in the folder has it.
    """
    labels = tuple(each.label for each in formats)
    example = plan(registry.load(robustness.judged_in()[CLAIMS[0]]), labels, (), repeats, seed)
    every: list[Replicate] = []
    cases = [[case(repeats, seed + number, formats)] for number in range(replicates)]
    for own, rows, failures in robustness.played(
        cases, lambda r, own: robustness.batch(f"replicate {r}", own, example, labels), folder / STUDY, resources
    ):
        every.append(replicate(robustness.numbered(own), rows))
        table = tabled(every, repeats, seed, failures, formats)
        Files(folder).write_json(FILE, table)
        show(table)
    return table
