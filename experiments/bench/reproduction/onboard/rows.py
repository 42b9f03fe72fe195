"""What each claim comes to in each format, and how far each format is from the float network."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from experiments.bench.judging.count import count
from experiments.bench.judging.statistics import proportion_interval
from experiments.bench.judging.verdict import Outcome
from experiments.bench.reproduction.onboard.formats import CLAIMS, FLOAT, FORMATS, Format
from experiments.bench.reproduction.onboard.series import HS, SPIKES
from experiments.bench.reproduction.replicates import Replicate, of_model
from experiments.bench.store.rows import Failure

FILE, STUDY = "onboard.json", "onboard"
LOST = ("sometimes", "fails")
"""The words of a claim that does not survive: see `experiments.bench.judging.count`."""


@dataclass(frozen=True, slots=True)
class ClaimRow:
    """What a claim comes to in one format.

    Parameters
    ----------
    claim, label
        The claim, and the format as ``--model`` takes it.
    held, vacuous, untested, replicates
        In how many of ``replicates`` it held, was vacuous, or could not be judged.
    low, high
        The exact 95 % interval of the share in which it held.
    lost, gained
        In how many replicates it held of the float network and not here, and the reverse.
    word
        ``holds``, ``sometimes``, ``fails``, or empty with too few replicates for a word.
    decided
        The number that decided in replicate 0.
    """

    claim: str
    label: str
    held: int
    vacuous: int
    untested: int
    replicates: int
    low: float
    high: float
    lost: int
    gained: int
    word: str
    decided: str


@dataclass(frozen=True, slots=True)
class ErrorRow:
    """How far a format is from the float network, frame by frame, on the same trials.

    Parameters
    ----------
    label
        The format.
    frames, trials
        How many frames, of how many trials.
    median, most, worst
        Median, 99th percentile and largest ``|HS - HS of the float network|`` of a frame.
    spikes
        Spikes of the float network in these frames, of either sign.
    gained, lost
        Spikes of a frame that the float network has not, and those that it alone has, over all frames; as
        `dsnn.onboard.error.differences` counts them.
    """

    label: str
    frames: int
    trials: int
    median: float
    most: float
    worst: float
    spikes: int
    gained: int
    lost: int


@dataclass(frozen=True, slots=True)
class Onboard:
    """The table of claims over formats.

    Parameters
    ----------
    formats
        Those compared: the float network, the best format that fits, then others.
    claims, errors
        A row for each claim and format, and one for each format but the float network.
    replicates, repeats, seed
        How many replicates, trials of each condition in one, and the seed of replicate 0.
    failures
        What failed.
    """

    formats: Sequence[Format]
    claims: Sequence[ClaimRow]
    errors: Sequence[ErrorRow]
    replicates: int
    repeats: int
    seed: int
    failures: Sequence[Failure] = ()

    def row(self, claim: str, label: str) -> ClaimRow:
        """Return what a claim comes to in one format."""
        return next(row for row in self.claims if (row.claim, row.label) == (claim, label))

    def broken(self) -> list[str]:
        """Return the claims that do not survive: they hold of the float network, and not of the best format."""
        plain, best = (each.label for each in self.formats[:2])
        return [
            claim for claim in CLAIMS if self.row(claim, plain).word == "holds" and self.row(claim, best).word in LOST
        ]


def tabled(
    every: Sequence[Replicate], repeats: int, seed: int, failures: Sequence[Failure] = (),
    formats: Sequence[Format] = FORMATS,
) -> Onboard:  # fmt: skip
    """Judge every claim of `CLAIMS` in every format and replicate, and measure the errors.

    Parameters
    ----------
    every
        The replicates, whose rows have the series of the formats' potentials.
    repeats, seed, failures
        As of `Onboard`.
    formats
        Those that were shown, the float network first.
    """
    outcomes = {
        (claim, each.label): [of_model(claim, own, each.label) for own in every] for claim in CLAIMS for each in formats
    }
    claims = [
        _claim_row(claim, each.label, outcomes[claim, each.label], outcomes[claim, formats[0].label])
        for claim in CLAIMS
        for each in formats
    ]
    errors = [error_row(each.label, every, formats[0].label) for each in formats[1:]]
    return Onboard(tuple(formats), tuple(claims), tuple(errors), len(every), repeats, seed, tuple(failures))


def _claim_row(claim: str, label: str, found: Sequence[Outcome], plain: Sequence[Outcome]) -> ClaimRow:
    counted = count([each.verdict for each in found])
    pairs = [(own.verdict == "holds", float_.verdict == "holds") for own, float_ in zip(found, plain, strict=True)]
    low, high = proportion_interval(counted.holds, counted.replicates)
    return ClaimRow(
        claim, label, counted.holds, counted.unjudged.get("silent model", 0), counted.unjudged.get("not shown", 0),
        counted.replicates, low, high,
        sum(before and not own for own, before in pairs), sum(own and not before for own, before in pairs),
        counted.word, found[0].decided,
    )  # fmt: skip


def error_row(label: str, every: Sequence[Replicate], plain: str = FLOAT) -> ErrorRow:
    """Measure a format against the float network, on all trials that both answered."""
    own, float_ = _series(every, label), _series(every, plain)
    both = [key for key in float_ if key in own]
    if not both:
        return ErrorRow(label, 0, 0, *(float("nan"),) * 3, 0, 0, 0)
    hs, spikes = (np.concatenate([own[key][part] for key in both]) for part in (0, 1))
    wanted, expected = (np.concatenate([float_[key][part] for key in both]) for part in (0, 1))
    error = np.abs(hs - wanted)
    # A spike of the other sign is one lost and one gained.
    same = np.where(spikes * expected > 0, np.minimum(np.abs(spikes), np.abs(expected)), 0)
    gained, lost = int((np.abs(spikes) - same).sum()), int((np.abs(expected) - same).sum())
    return ErrorRow(
        label, error.size, len(both), float(np.median(error)), float(np.quantile(error, 0.99)), float(error.max()),
        int(np.abs(expected).sum()), gained, lost,
    )  # fmt: skip


def _series(every: Sequence[Replicate], label: str) -> Mapping[tuple[int, Any, Any], tuple[Any, Any]]:
    """Replicate, experiment and seed of a trial -> HS and spikes in its frames; without those that were not kept."""
    return {
        (number, row["experiment"], row["seed"]): (np.asarray(row[HS], np.float64), np.asarray(row[SPIKES], np.int64))
        for number, each in enumerate(every)
        for row in each.of(label)
        if row.get(HS) is not None
    }
