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

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
import polars as pl

from experiments.bench.run.rows import group

Floats = npt.NDArray[np.float64]
Rows = Sequence[Mapping[str, Any]]

WHOLE = "dsnn"
BALANCED = "dsnn:w_i=1"
"""The network whose inhibition weighs as much as its excitation."""
EXCITED = ("dsnn-off-blocked:w_i=0", "dsnn-on-blocked:w_i=0")
"""The ON pathway and the OFF pathway, each alone, with excitation alone."""
OPPOSED = ("dsnn-off-blocked:w_i=1", "dsnn-on-blocked:w_i=1")
"""Parts of the network with inhibition of weight 1."""
PARTS = (*EXCITED, *OPPOSED)
NEEDED = (WHOLE, BALANCED, *PARTS)
"""The models that an experiment with this figure declares."""

MOTION = ("motion", "direction", "speed_cm_s", "distance_cm", "angle_deg")
"""Columns that tell of a condition."""


def without_parts(rows: Sequence[Any]) -> list[Any]:
    """Return the rows of whole networks: `PARTS` are there to be put together, not to be compared."""
    return [row for row in rows if row["model"] not in PARTS]


def before_sigmoid(potential: Floats) -> Floats:
    """Invert the sigmoid of one pathway.

    Parameters
    ----------
    potential
        One pathway's share of HS, in (-0.5, 0.5).

    Returns
    -------
    ndarray
        The low-passed field sum over ``4 C R K_sig``; infinite where the potential is at its ceiling.
    """
    with np.errstate(divide="ignore"):
        sums: Floats = 0.5 * np.arctanh(2.0 * potential)
    return sums


@dataclass(frozen=True, slots=True)
class Trial:
    """One trial of T frames. All arrays are of shape (T,), sums of ON and OFF, potentials in units of HS."""

    index: int
    time_s: Floats
    excitation: Floats
    inhibition: Floats
    """I itself, without its weight."""
    hs: Floats
    """Potential HS of the network as it is."""
    spikes: npt.NDArray[np.int64]
    """Spikes of the network in each frame, with the potential's sign."""
    hs_balanced: Floats
    """HS with w_i = 1."""
    spikes_balanced: npt.NDArray[np.int64]


def directional(trial: Trial, w_i: float) -> Floats:
    """``(1 + w_i) (E - I) / 2``: the part of E - w_i I that changes its sign with the direction."""
    return (1.0 + w_i) / 2.0 * (trial.excitation - trial.inhibition)


def residue(trial: Trial, w_i: float) -> Floats:
    """``(1 - w_i) (E + I) / 2``: what the weight leaves of symmetric motion, rightward or 0."""
    return (1.0 - w_i) / 2.0 * (trial.excitation + trial.inhibition)


@dataclass(frozen=True, slots=True)
class Course:
    """All trials of one condition.

    Parameters
    ----------
    condition
        The row of its first trial.
    trials
        One or more, each cut to the frames that all of them have.
    w_i
        Weight of inhibition of the network as it is.
    """

    condition: Mapping[str, Any]
    trials: tuple[Trial, ...]
    w_i: float

    @property
    def time_s(self) -> Floats:
        """Time of the frames, shape (T,)."""
        return self.trials[0].time_s

    def curves(self) -> dict[str, Floats]:
        """Return what is drawn against `time_s`: name -> an array of shape (trials, T)."""
        quantities = {
            "excitation": [trial.excitation for trial in self.trials],
            "weighted_inhibition": [self.w_i * trial.inhibition for trial in self.trials],
            "directional": [directional(trial, self.w_i) for trial in self.trials],
            "residue": [residue(trial, self.w_i) for trial in self.trials],
            "hs": [trial.hs for trial in self.trials],
            "hs_w_i_1": [trial.hs_balanced for trial in self.trials],
        }
        return {name: np.stack(values) for name, values in quantities.items()}

    def firing(self, *, balanced: bool = False) -> int:
        """Tell how many trials have a spike, as the network is or with w_i = 1."""
        return sum(bool((t.spikes_balanced if balanced else t.spikes).any()) for t in self.trials)


def courses(rows: Rows, frames: pl.DataFrame, w_i: float) -> list[Course]:
    """Put excitation and inhibition together from a run's tables.

    Parameters
    ----------
    rows
        Of ``trials.parquet``.
    frames
        Of ``frames.parquet``: HS of each model in `NEEDED`, by trial.
    w_i
        Weight of inhibition of `WHOLE`.

    Returns
    -------
    list of Course
        One for each condition, in the order of the rows. A trial in which one of the models is missing is left out,
        and a condition without any other.
    """
    models = group(rows, "trial")
    whole = [row for row in rows if row["model"] == WHOLE]
    usable = [row for row in whole if {model_row["model"] for model_row in models[(row["trial"],)]} >= set(NEEDED)]
    columns = {name: frames[name].to_numpy() for name in
               ("trial", "model", "sim_time_s", "hs", "hs_spikes")}  # fmt: skip
    return [
        Course(condition_rows[0], _cut([_trial(row["trial"], columns) for row in condition_rows]), w_i)
        for condition_rows in group(usable, *MOTION).values()
    ]


def described(courses_shown: Sequence[Course]) -> str:
    """Tell in words what the figure shows of each condition, at the frame in which its mean E + I is largest."""
    parts = []
    for course in courses_shown:
        mean = {name: values.mean(axis=0) for name, values in course.curves().items()}
        peak = int(np.argmax(np.mean([trial.excitation + trial.inhibition for trial in course.trials], axis=0)))
        at = {name: float(values[peak]) for name, values in mean.items()}
        condition, count = course.condition, len(course.trials)
        angle = condition["angle_deg"]
        where = f"{condition['distance_cm']:g} cm" if angle is None else f"{angle:g} degrees"
        parts.append(
            f"{condition['motion']} {condition['direction']}, {where}: E {at['excitation']:.2f}, "
            f"{course.w_i:g} I {at['weighted_inhibition']:.2f}; of E - {course.w_i:g} I {at['directional']:+z.2f} "
            f"tells direction and {at['residue']:+z.2f} is left of symmetric motion; "
            f"{course.firing()} of {count} trials fire, and {course.firing(balanced=True)} with w_i = 1"
        )
    return "; ".join(parts)


def _trial(index: int, columns: Mapping[str, npt.NDArray[Any]]) -> Trial:
    here = columns["trial"] == index
    of_model = {model: here & (columns["model"] == model) for model in NEEDED}
    excited = sum((before_sigmoid(columns["hs"][of_model[part]]) for part in EXCITED), np.zeros(1))
    opposed = sum((before_sigmoid(columns["hs"][of_model[part]]) for part in OPPOSED), np.zeros(1))
    return Trial(
        index,
        columns["sim_time_s"][of_model[WHOLE]],
        excited,
        excited - opposed,
        columns["hs"][of_model[WHOLE]],
        columns["hs_spikes"][of_model[WHOLE]],
        columns["hs"][of_model[BALANCED]],
        columns["hs_spikes"][of_model[BALANCED]],
    )


def _cut(trials: Sequence[Trial]) -> tuple[Trial, ...]:
    """The trials without the frames after the shortest one's end: errors of the start pose make some longer."""
    shortest = min(len(trial.time_s) for trial in trials)
    return tuple(
        Trial(t.index, *(getattr(t, name)[:shortest] for name in Trial.__dataclass_fields__ if name != "index"))
        for t in trials
    )


def table(courses_shown: Sequence[Course]) -> list[dict[str, Any]]:
    """The numbers that the figure shows: a row for each condition and frame, with means and standard deviations.

    ``firing`` and ``firing_w_i_1`` count the trials that have a spike in the frame. A standard deviation of one trial
    is empty.
    """
    rows = []
    for course in courses_shown:
        curves, several = course.curves(), len(course.trials) > 1
        fires, balanced = (
            np.stack([getattr(trial, name) != 0 for trial in course.trials]).sum(axis=0)
            for name in ("spikes", "spikes_balanced")
        )
        for frame, time_s in enumerate(course.time_s):
            row = {name: course.condition[name] for name in MOTION}
            row |= {"w_i": course.w_i, "frame": frame, "sim_time_s": float(time_s), "n": len(course.trials)}
            for name, values in curves.items():
                row[name] = float(values[:, frame].mean())
                row[f"{name}_sd"] = float(values[:, frame].std(ddof=1)) if several else None
            rows.append({**row, "firing": int(fires[frame]), "firing_w_i_1": int(balanced[frame])})
    return rows
