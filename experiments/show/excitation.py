"""Excitation and inhibition of HS over a trial, and what w_i leaves of symmetric motion.

The lobula plate sums, over the field, the excitation E (correlation in the preferred direction, rightward) and the
inhibition I (correlation in the other direction), and takes E - w_i I. With the symmetric part S = (E + I) / 2 and the
antisymmetric part A = (E - I) / 2 that is ``(1 + w_i) A + (1 - w_i) S``. A changes its sign with the direction of
motion. S is never negative, so its share is rightward whatever moves: w_i = 0.9 leaves a tenth of S, w_i = 1 nothing.

No model answers with E or I. They follow exactly from potentials of the network on the same frames. With one pathway
blocked HS is the other pathway's f(E - w_i I) alone, and ``f(x) = tanh(x / (2 C R K_sig)) / 2`` can be inverted. With
w_i = 0 that gives E, with w_i = 1 it gives E - I. The low-pass of the membrane comes before f and is linear, so E and
I are low-passed as HS is. `NEEDED` are the models that this takes.

E and I are in units of HS: divided by ``4 C R K_sig``, in which the slope of f at 0 is 1. So HS is close to E - w_i I
while it is small, and stays below it where f bends.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import polars as pl

from experiments.declare.experiment import BALANCED, EXCITED, NEEDED, OPPOSED, PARTS, WHOLE

Rows = Sequence[Mapping[str, Any]]

MOTION = ("motion", "direction", "speed_cm_s", "distance_cm", "angle_deg")
"""Columns that tell of a condition."""
CURVES = ("excitation", "weighted_inhibition", "directional", "residue", "hs", "hs_w_i_1")
"""What is drawn against time, in units of HS: each is a column, and its standard deviation another."""


def without_parts(rows: Sequence[Any]) -> list[Any]:
    """Return the rows of whole networks: `PARTS` are there to be put together, not to be compared."""
    return [row for row in rows if row["model"] not in PARTS]


def sums(frames: pl.DataFrame, w_i: float) -> pl.DataFrame:
    """Put excitation and inhibition of each trial together.

    Parameters
    ----------
    frames
        Of ``frames.parquet``: HS of each model in `NEEDED`, by trial.
    w_i
        Weight of inhibition of `WHOLE`.

    Returns
    -------
    polars.DataFrame
        A row per trial and frame: `CURVES`, the ``inhibition`` without its weight, and the ``spikes`` of the network
        as it is and, as ``spikes_w_i_1``, with w_i = 1. A trial in which one of the models is missing is left out.
    """
    shown = {label: frames.filter(pl.col("model") == label) for label in NEEDED}
    joined = shown[WHOLE].select("trial", "frame", "time_s", hs="hs", spikes="hs_spikes")
    balanced = shown[BALANCED].select("trial", "frame", hs_w_i_1="hs", spikes_w_i_1="hs_spikes")
    for other in (balanced, *(shown[label].select("trial", "frame", pl.col("hs").alias(label)) for label in PARTS)):
        joined = joined.join(other, on=("trial", "frame"), maintain_order="left")
    # The inverse of a pathway's sigmoid: its low-passed field sum over 4 C R K_sig, from its share of HS.
    excited, opposed = (pl.sum_horizontal(0.5 * (2.0 * pl.col(labels)).arctanh()) for labels in (EXCITED, OPPOSED))
    e, i = pl.col("excitation"), pl.col("inhibition")
    return (
        joined.with_columns(excitation=excited, inhibition=excited - opposed)
        .with_columns(
            weighted_inhibition=w_i * i,
            directional=(1.0 + w_i) / 2.0 * (e - i),  # the part that changes its sign with the direction
            residue=(1.0 - w_i) / 2.0 * (e + i),  # what the weight leaves of symmetric motion, rightward or 0
        )
        .drop(PARTS)
    )


def table(rows: Rows, frames: pl.DataFrame, w_i: float) -> pl.DataFrame:
    """Return the numbers that the figure shows: a row for each condition and frame that all its trials have.

    Parameters
    ----------
    rows
        Of ``trials.parquet``.
    frames, w_i
        As of `sums`.

    Returns
    -------
    polars.DataFrame
        Means over the ``n`` trials of a condition and standard deviations, empty of one trial. ``firing`` and
        ``firing_w_i_1`` count the trials that have a spike in the frame, ``fired`` and ``fired_w_i_1`` those that have
        one in any. Empty where the models of `NEEDED` are not all there.
    """
    trials = pl.DataFrame([{name: row[name] for name in ("trial", *MOTION)} for row in rows if row["model"] == WHOLE],
                          infer_schema_length=None)  # fmt: skip
    if not set(NEEDED) <= {row["model"] for row in rows}:
        return trials.clear()
    fires = {"firing": pl.col("spikes") != 0, "firing_w_i_1": pl.col("spikes_w_i_1") != 0}
    fired = {name.replace("firing", "fired"): spikes.any().over("trial") for name, spikes in fires.items()}
    n = pl.len().over(*MOTION, "frame")
    curves, i = [pl.col(name) for name in CURVES], pl.col("inhibition")
    return (
        trials.join(sums(frames, w_i).with_columns(**fires, **fired), on="trial", maintain_order="left")
        .with_columns(n=n)
        .group_by(*MOTION, "frame", maintain_order=True)
        .agg(
            pl.lit(w_i).alias("w_i"), pl.col("time_s", "n").first(), *(curve.mean() for curve in (*curves, i)),
            *(curve.std().name.suffix("_sd") for curve in curves), pl.col(*fires, *fired).sum(),
        )
        .filter(pl.col("n") == pl.col("n").max().over(*MOTION))
    )  # fmt: skip
