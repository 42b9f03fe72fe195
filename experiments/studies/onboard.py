"""C13 to C20 in the arithmetic of the robot's own processor, in several formats of numbers."""

from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np

from experiments import Study
from experiments.bench.replicates import MODEL, Replicate
from experiments.bench.stats.count import count
from experiments.bench.study import Probe

CLAIMS = ("C13", "C14", "C15", "C16", "C17", "C18", "C19", "C20")
"""The claims about counts of spikes on the robot."""


BEST = "dsnn-onboard"
"""The best format that fits, of which alone a claim is said not to survive."""
FORMATS: Mapping[str, tuple[str, str]] = {
    MODEL: ("float32", "no"),
    BEST: ("8-bit delay states, companded, and 8-bit LA, rounded to nearest", "yes"),
    "dsnn-onboard:preset=lamina16": ("16-bit LA, which fits beside two camera frames", "no"),
    "dsnn-onboard:preset=bits16": ("16-bit delay states and LA", "no"),
    "dsnn-onboard:preset=truncated": ("the best one, truncated at every step", "yes"),
}
"""Model, as ``--model`` takes it -> what it computes with, and whether it fits into the robot's memory at 99x72 beside
three frames of its camera and 16 kB of other use, as ``colias firmware budget`` measures it."""

HS, SPIKES = "hs_series", "hs_spikes_series"
"""Columns of a trial's row: HS, in float32, and its spikes in every frame; null of a model whose are not kept."""


def series(showings: Any, *, labels: Sequence[str]) -> dict[str, dict[str, Any]]:
    """Return HS and its spikes in every frame of the models called ``labels``, of what a trial showed."""
    return {
        model.label: {
            HS: found.hs.astype(np.float32).tolist() if model.label in labels else None,
            SPIKES: found.hs_spikes.tolist() if model.label in labels else None,
        }
        for showing in showings
        for model, found in showing.series()
    }


def series_of(labels: Sequence[str]) -> Probe:
    """Return the probe that keeps HS and its spikes in every frame of the models called ``labels`` in the trials."""
    return Probe(partial(series, labels=tuple(labels)), {HS: list[float], SPIKES: list[int]})


def errors(result: Any) -> dict[str, list[dict[str, Any]]]:
    """Return the claims that each format loses and gains, and how far it is from the float network."""
    (point, plain), *others = result.plan.judged
    floats = result.replicates(point, plain)
    claims = [claim.id for claim, _ in result.plan.claims]
    return {
        "Formats": [
            {"format": model, "computes with": FORMATS[model][0], "fits": FORMATS[model][1]}
            for _, model in result.plan.judged
        ],
        "Claims lost and gained against the float network": [
            lost_and_gained(result, claim, model, plain) for claim in claims for _, model in others
        ],
        "Distance from the float network, frame by frame": [
            error_row(model, result.replicates(point, model), floats, plain) for _, model in others
        ],
    }  # fmt: skip


def lost_and_gained(result: Any, claim: str, model: str, plain: str) -> dict[str, Any]:
    """Return in how many replicates a claim holds of the float network alone, and of a format alone.

    It does not survive where it holds of the float network, over all replicates, and does not of the format.
    """
    ours, floats = (result.outcomes[(), name, claim] for name in (model, plain))
    held = [(one.verdict == "holds", other.verdict == "holds") for one, other in zip(ours, floats, strict=True)]
    words = [count(outcome.verdict for outcome in outcomes).word for outcomes in (floats, ours)]
    survives = "-" if "" in words or words[0] != "holds" else "yes" if words[1] == "holds" else "no"
    return {"claim": claim, "format": model, "lost": held.count((False, True)), "gained": held.count((True, False)),
            "survives": survives}  # fmt: skip


def error_row(
    label: str, every: Sequence[Replicate], floats: Sequence[Replicate], plain: str = MODEL
) -> dict[str, Any]:
    """Measure a format against the float network, frame by frame, on all trials that both responded in.

    ``lost`` and ``gained`` are spikes that the float network or the format alone has, over all frames, as
    `dsnn.onboard.error.differences` counts them.
    """
    format_, float_ = _series(every, label), _series(floats, plain)
    both = [key for key in float_ if key in format_]
    row = {"format": label, "frames": 0, "trials": len(both), "median of |HS error|": None, "99 %": None,
           "worst": None, "spikes in float": 0, "lost": 0, "gained": 0}  # fmt: skip
    if not both:
        return row
    ours, floats_ = (np.concatenate([found[key] for key in both], axis=1) for found in (format_, float_))
    error, spikes, expected = np.abs(ours[0] - floats_[0]), ours[1], floats_[1]
    # A spike of the other sign is one lost and one gained.
    same = np.where(spikes * expected > 0, np.minimum(np.abs(spikes), np.abs(expected)), 0)
    return {
        **row, "frames": error.size, "median of |HS error|": float(np.median(error)),
        "99 %": float(np.quantile(error, 0.99)), "worst": float(error.max()),
        "spikes in float": int(np.abs(expected).sum()), "lost": int((np.abs(expected) - same).sum()),
        "gained": int((np.abs(spikes) - same).sum()),
    }  # fmt: skip


def _series(every: Sequence[Replicate], label: str) -> dict[tuple[Any, ...], Any]:
    """Replicate, experiment and seed of a trial -> HS and its spikes, (2, T); without those that were not kept."""
    return {
        (number, row["experiment"], row["seed"]): np.array([row[HS], row[SPIKES]], np.float64)
        for number, replicate in enumerate(every)
        for row in replicate.of(label)
        if row.get(HS) is not None
    }


STUDY = Study(
    name="onboard",
    summary="C13 to C20 in the robot's own arithmetic, in several formats, beside the float network on the same trials",
    claims=CLAIMS,
    models=tuple(FORMATS),
    probe=series_of(tuple(FORMATS)),
    tables=errors,
)
