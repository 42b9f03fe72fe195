"""Replicates of the paper's experiments with the robot, and what stands for their rows."""

from __future__ import annotations

from experiments.judge.replicates import EVERY_MODEL
from experiments.judge.sweep import read
from experiments.paper.reproduce import replicates_plan


def design(count=1, repeats=5, seed=0):
    """The plan of some replicates."""
    return replicates_plan(count, repeats, seed)


def first(plan):
    """The trials of replicate 0."""
    return plan.specs[: len(plan.specs) // plan.study.replicates]


def every(plan, rows):
    """The replicates of a plan, from the rows that there are."""
    return read(plan, rows).replicates[(), EVERY_MODEL]
