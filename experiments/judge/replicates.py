"""One replicate of a study at one point, and the outcome of each claim in it.

A claim is judged on the trials of one experiment in every replicate.
"""

from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

from experiments.declare.claim import LOOMING_DETECTORS, Claim
from experiments.declare.outcome import Outcome
from experiments.judge.judge import Row, judge
from experiments.settings.models import counted_channel
from experiments.show.robot import RobotTrial

MODEL = "dsnn"
"""The model that the paper's claims are about, where they name no other."""
EVERY_MODEL = ""
"""The name under which all models are judged where each claim is judged on the models that it is about."""


@dataclass(frozen=True, slots=True)
class Replicate:
    """The rows of a design that was run once, at one seed, for several models.

    Parameters
    ----------
    rows
        The rows of ``trials.parquet`` of all its experiments and models.
    lost
        (experiment, model) -> how many of its trials have no row, as they failed; 0 of none.
    thresholds
        Model -> channel -> its spiking threshold.
    """

    rows: tuple[Row, ...]
    lost: Mapping[tuple[str, str], int]
    thresholds: Mapping[str, Mapping[str, float | None]]

    def of(self, model: str) -> list[Row]:
        """Return the rows of one model."""
        return [row for row in self.rows if row["model"] == model]

    def threshold(self, model: str) -> float | None:
        """Return the threshold of a model's counted channel; ``None`` without one."""
        levels = self.thresholds.get(model, {})
        return levels.get(counted_channel(levels))


def replicate(specs: Sequence[RobotTrial], rows: Sequence[Row]) -> Replicate:
    """Return the replicate that ``specs`` planned, from the ``rows`` that there are; those of other trials are left."""
    planned = {(spec.experiment, spec.index, model.label): model for spec in specs for model in spec.settings.models}
    by_trial = {(row["experiment"], row["trial"], row["model"]): row for row in rows}
    lost = Counter((experiment, model) for experiment, index, model in planned.keys() - by_trial.keys())
    thresholds = {model.label: model.thresholds for model in planned.values()}
    return Replicate(tuple(by_trial[key] for key in planned if key in by_trial), lost, thresholds)


def judged(claim: Claim, trials: Replicate, place: str, model: str = EVERY_MODEL) -> Outcome:
    """Judge a claim in one replicate: for one model, or for those that it is about.

    It is about the DSNN, the models that it compares, or each looming detector; one on clips says which.
    """
    if claim.on == "clips" or (claim.models and model == EVERY_MODEL):
        return of_models(claim, trials, place)
    if claim.about == "looming" and model == EVERY_MODEL:
        return Outcome.together({name: of_model(claim, trials, name, place) for name in LOOMING_DETECTORS})
    return of_model(claim, trials, model or MODEL, place)


def of_models(claim: Claim, trials: Replicate, place: str) -> Outcome:
    """Judge a claim that names its models in one replicate. It is not judged where any of what it needs failed."""
    rows = [row for row in trials.rows if row["experiment"] == place]
    result = judge(claim, rows, trials.threshold(claim.spiking), trials.rows if claim.on == "clips" else None)
    return _unless_lost(result, sum(trials.lost.get((place, model), 0) for model in claim.models), place)


def of_model(claim: Claim, trials: Replicate, model: str, place: str) -> Outcome:
    """Judge a claim for one model in one replicate. It is not judged where any of the trials it needs failed.

    A claim about looming is judged on the spikes of the looming detector, of a model that tells direction too.
    """
    if model not in trials.thresholds:
        return Outcome.unjudged(f"{model} was not shown")
    rows_of_model, threshold = trials.of(model), trials.threshold(model)
    looming = trials.thresholds[model].get("looming")
    if claim.about == "looming" and looming is not None:
        rows_of_model = [{**row, "spikes": row.get("looming_spikes", row["spikes"])} for row in rows_of_model]
        threshold = looming
    places = places_of(claim, place, {row["experiment"] for row in rows_of_model})
    rows = [row for row in rows_of_model if row["experiment"] in places]
    lost = {name: trials.lost[name, model] for name in places if trials.lost.get((name, model))}
    return _unless_lost(judge(claim, rows, threshold, rows_of_model), sum(lost.values()), ", ".join(lost))


def places_of(claim: Claim, place: str, there: Collection[str]) -> tuple[str, ...]:
    """Return the experiments whose trials a claim is judged on.

    Parameters
    ----------
    claim
        The claim.
    place
        The experiment that tests it.
    there
        The experiments that the replicate has.

    Returns
    -------
    tuple of str
        ``place`` alone, unless the claim pools experiments: then those of them that are there.
    """
    return tuple(name for name in claim.pools if name in there) or (place,)


def _unless_lost(result: Outcome, lost: int, place: str) -> Outcome:
    """The outcome, or not judged where trials are lost: the others are not the design."""
    return result.withheld(f"{lost} of {place} failed") if lost and result.verdict != "not shown" else result
