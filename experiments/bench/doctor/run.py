"""All checks, one after another."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from experiments.bench.doctor import installed, picture
from experiments.bench.doctor.finding import Finding

REPORT = "report it, with the output of 'colias doctor --json'"


def examine() -> Iterator[Finding]:
    """Yield what every check finds, as soon as it is known."""
    checks: tuple[tuple[str, Callable[[], Finding | list[Finding]]], ...] = (
        ("python", installed.python),
        ("packages", installed.packages),
        ("lock", installed.lock),
        ("rendering", picture.drawing),
        ("network", installed.network),
        ("rerun viewer", installed.viewer),
        ("extras", installed.extras),
    )
    for name, check in checks:
        try:
            findings = check()
        except Exception as error:  # a check that breaks is a finding, and the others still answer
            problem = f"the check itself broke: {type(error).__name__}: {error}"
            findings = Finding(name, "fails", " ".join(problem.split())[:300], REPORT)
        yield from findings if isinstance(findings, list) else [findings]
