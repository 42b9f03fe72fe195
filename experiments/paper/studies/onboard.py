"""C13 to C20 in the arithmetic of the robot's own processor, in several formats of numbers."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from experiments import Study

if TYPE_CHECKING:
    import polars as pl

CLAIMS = ("C13", "C14", "C15", "C16", "C17", "C18", "C19", "C20")
"""The claims about counts of spikes on the robot."""
FLOAT, BEST = "dsnn", "dsnn-onboard"
"""The float network, and the best format that fits, of which alone a claim is said not to survive."""
FORMATS = (
    FLOAT,
    BEST,  # 8-bit delay states, companded, and 8-bit LA, rounded to nearest
    "dsnn-onboard:preset=lamina16",  # 16-bit LA, which fits beside two camera frames
    "dsnn-onboard:preset=bits16",  # 16-bit delay states and LA
    "dsnn-onboard:preset=truncated",  # the best one, truncated at every step
)
"""Models, as ``--model`` takes them. The best one, truncated or not, fits into the robot's memory at 99x72 beside three
frames of its camera and 16 kB of other use, as ``colias firmware budget`` measures it."""
HS, SPIKES = "hs_series", "hs_spikes_series"
"""Columns of a trial's row: HS, in float32, and its spikes in every frame; null of a model whose are not kept."""


def series(showings: Any, *, labels: Sequence[str]) -> dict[str, dict[str, Any]]:
    """Return HS and its spikes in every frame of the models called ``labels``, of what a trial showed."""
    found = {model.label: responses for showing in showings for model, responses in showing.series()}
    none = {HS: None, SPIKES: None}
    return {
        label: {HS: of.hs.astype(np.float32).tolist(), SPIKES: of.hs_spikes.tolist()} if label in labels else none
        for label, of in found.items()
    }


def probe_of(*labels: str) -> Any:
    """Return the probe of a study that keeps HS and its spikes in every frame of the models called ``labels``."""
    return partial(series, labels=labels), {HS: list[float], SPIKES: list[int]}


def errors(result: Any) -> dict[str, list[dict[str, Any]]]:
    """Return in how many replicates each format loses and gains a claim, and how far it is from the float network."""
    (point, plain), *others = result.judged
    floats = result.rows(point, plain)
    claims = []
    for claim, (_, model) in ((claim.id, other) for claim, _ in result.claims for other in others):
        ours, theirs = ([outcome.verdict for outcome in result.outcomes[point, name, claim]] for name in (model, plain))
        held = [(one == "holds", other == "holds") for one, other in zip(ours, theirs, strict=True)]
        claims.append({"claim": claim, "format": model, "lost": held.count((False, True)),
                       "gained": held.count((True, False))})  # fmt: skip
    distances = [{"format": model, **distance(result.rows(point, model), floats)} for _, model in others]
    return {
        "Claims lost and gained against the float network": claims,
        "Distance from the float network, frame by frame": distances,
    }


def distance(ours: pl.DataFrame, floats: pl.DataFrame) -> dict[str, Any]:
    """Measure a format against the float network, frame by frame, on all trials that both responded in.

    ``lost`` and ``gained`` are spikes that the float network or the format alone has, over all frames. A spike of the
    other sign is one lost and one gained.

    Parameters
    ----------
    ours, floats
        Rows of trials, with the columns `HS` and `SPIKES`.
    """
    none = {"median of |HS error|": None, "99 %": None, "worst": None}
    keys = ["replicate", "experiment", "seed"]
    wanted = [floats.select(*keys, HS, SPIKES), ours.select(*keys, HS, SPIKES).rename({HS: "hs", SPIKES: "n"})]
    trials = wanted[0].join(wanted[1], on=keys).drop_nulls([HS, "hs"])
    frames = trials.explode(HS, SPIKES, "hs", "n")
    error = (frames["hs"].cast(float) - frames[HS].cast(float)).abs().to_numpy()
    spikes, expected = frames["n"].to_numpy(), frames[SPIKES].to_numpy()
    same = np.where(spikes * expected > 0, np.minimum(np.abs(spikes), np.abs(expected)), 0)
    found = {"median of |HS error|": float(np.median(error)), "99 %": float(np.quantile(error, 0.99)),
             "worst": float(error.max())} if error.size else none  # fmt: skip
    return {
        "frames": error.size, "trials": trials.height, **found, "spikes in float": int(np.abs(expected).sum()),
        "lost": int((np.abs(expected) - same).sum()), "gained": int((np.abs(spikes) - same).sum()),
    }  # fmt: skip


STUDY = Study(
    name="onboard",
    summary="C13 to C20 in the robot's own arithmetic, in several formats, beside the float network on the same trials",
    claims=CLAIMS,
    models=FORMATS,
)
