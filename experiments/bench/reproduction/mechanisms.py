"""Why claims of the paper hold or fail, in numbers: what the experiments that show mechanisms add to their verdicts."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

from experiments.bench.core.verdict import Verdict
from experiments.bench.robot.mechanism import excitation
from experiments.bench.robot.mechanism.excitation import Course

EXPLAINED = {
    "C17": "approach-mechanism",
    "C18": "approach-mechanism",
    "C19": "recession-mechanism",
    "C20": "recession-mechanism",
}
"""Claim -> the experiment that shows its trials' excitation and inhibition."""


def explained(verdicts: Iterable[Verdict], shown: Mapping[str, Sequence[Course]]) -> list[Verdict]:
    """Add the mechanism to the verdicts that an experiment explains.

    Parameters
    ----------
    verdicts
        Of the paper's claims.
    shown
        Experiment -> the excitation and inhibition in its conditions.
    """
    return [replace(verdict, mechanism=_mechanism(EXPLAINED.get(verdict.id, ""), shown)) for verdict in verdicts]


def _mechanism(experiment: str, shown: Mapping[str, Sequence[Course]]) -> str:
    found = shown.get(experiment, ())
    if not found:
        return ""
    return f"{experiment}, means in units of HS where E + I is largest: {excitation.described(found)}"
