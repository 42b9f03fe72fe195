"""All checks, one after another."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

from experiments.bench.doctor import installed, machine, picture
from experiments.bench.doctor.finding import Finding

REPORT = "report it, with the output of 'colias doctor --json'"


def examine(folder: Path) -> Iterator[Finding]:
    """Yield what every check finds, as soon as it is known.

    Parameters
    ----------
    folder
        Where runs are to be written.
    """
    checks: tuple[tuple[str, Callable[[], Finding | list[Finding]]], ...] = (
        ("python", installed.python),
        ("packages", installed.packages),
        ("lock", installed.lock),
        ("rendering", picture.drawing),
        ("network", installed.network),
        ("rerun viewer", installed.viewer),
        ("cores", machine.cores),
        ("memory", machine.memory),
        ("run folder", lambda: machine.run_folder(folder)),
        ("extras", installed.extras),
    )
    for name, check in checks:
        try:
            findings = check()
        except Exception as error:  # a check that breaks is a finding, and the others still answer
            problem = f"the check itself broke: {type(error).__name__}: {error}"
            findings = Finding(name, "fails", " ".join(problem.split())[:300], REPORT)
        yield from findings if isinstance(findings, list) else [findings]
