"""Where the report shows why a claim comes out as it does, and what the choice of other models' constants does."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

from experiments.bench.clips.judging import ASSUMED
from experiments.bench.clips.summary import OfflineReport
from experiments.bench.judging.claims import words
from experiments.bench.judging.verdict import Outcome, Verdict
from experiments.bench.robot.mechanism.excitation import Course, described
from experiments.bench.studies import registry
from experiments.bench.studies.clips import points_of_run
from experiments.bench.studies.constants import STUDIES, compares_with, comparing, outcomes, said
from experiments.bench.studies.counts import Counts


def mechanism(claim: Verdict, there: Collection[str], courses: Mapping[str, Sequence[Course]]) -> str:
    """Return where the claim's mechanism is drawn, as ``EXPERIMENT: what``; else that its own figure is all there is.

    Parameters
    ----------
    claim
        The claim's verdict.
    there
        The names of the experiments that were run.
    courses
        Experiment -> the excitation and inhibition in its conditions, where it shows these; told in numbers.
    """
    name, what = words(claim.id).mechanism
    if name in there:
        found = courses.get(name, ())
        numbers = f"; means in units of HS where E + I is largest: {described(found)}" if found else ""
        return f"{name}: {what}{numbers}"
    if not claim.experiment:
        return "none: not judged"
    return f"{claim.experiment}: the figure of what it was judged on; no figure of the mechanism in this run"


def constants(claim: str, shows: Sequence[OfflineReport]) -> dict[str, Outcome]:
    """Return the constants of the other model -> what the claim comes to with them; empty where they were not run."""
    for report in shows:
        name = report.plan.experiment.name
        if name in STUDIES and any(getattr(each, "id", each) == claim for each in registry.find(name).claims):
            return outcomes(Counts(points_of_run(registry.find(name), report.plan), report.rows), claim)
    return {}


def assumed(claim: str, shows: Sequence[OfflineReport]) -> str:
    """Return what is assumed of the model that a claim compares the DSNN with, and with which constants it holds."""
    if claim not in comparing():
        return ""
    found = constants(claim, shows)
    others = f"in replicate 0: {said(found)}" if found else "other constants were not run here"
    return f"{ASSUMED[compares_with(claim)]}; {others}"
