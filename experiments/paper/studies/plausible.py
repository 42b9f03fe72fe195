"""The plausible set: apparatus drawn from what nobody knows of the robot's, and the share in which the claims hold.

What follows was committed before any of it was run.

**Sample.** 128 points, drawn independently and uniformly over `BOX`; and 128 with every range halved about its
evidence, where the category with the evidence has half the weight more. Each point plays half the paper's repeats, and
is judged on C14 to C20 and C32. Reported is the share of points in which all hold, with its exact 95 % interval, for
each state of gamma too; and without C18 and C20, which the equations imply. Points that keep all claims or all but one,
the ten nearest to the evidence, are judged by three fresh full designs. Shares over the range of one unknown or of two
are exploration. Not judged counts as not held.

**Its own check.** Twenty points that keep C14 play the robot: fresh seeds, the paper's repeats. A point of the sample
is accepted where at most one of the eight verdicts differs from the robot's. The check passes where the true point is
accepted for at least `LEAST_ACCEPTED` of the twenty, and the median accepted set is under a third of the sample.
`LEAST_ACCEPTED` is the 5 % quantile of Binomial(20, p), where p is the lower end of the share of pairs of fresh
replicates, of ten apparatus two each, that differ in at most one verdict: ``colias sweep plausible-pilot`` gives it,
before the check is run. Under 10 the check is weak.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import accumulate, combinations, product
from statistics import median
from typing import Any, Literal

from experiments import Study
from experiments.base.streams import stream
from experiments.judge.tests import proportion_interval
from experiments.paper.studies.robot import WHOLE

Setting = Mapping[str, str]
"""Name of each unknown -> its value at a point, as ``--set`` takes it."""
Verdicts = Sequence[Sequence[bool]]
"""Of each point, whether each claim holds."""


@dataclass(frozen=True, slots=True)
class Unknown:
    """Something of the apparatus that no source settles.

    Parameters
    ----------
    name, key
        What it is called, and its key of ``--set``.
    scale
        Of a range ``linear`` or ``log``; ``one of`` several values.
    values
        The ends of the range, or the values.
    evidence
        The value that the evidence supports best.
    source
        The evidence.
    """

    name: str
    key: str
    scale: Literal["linear", "log", "one of"]
    values: tuple[Any, ...]
    evidence: Any
    source: str

    def place(self, value: Any) -> float:
        """Return where in the range a value is, from 0 to 1."""
        low, high = map(float, self.values)
        if self.scale == "log":
            return math.log(float(value) / low) / math.log(high / low)
        return (float(value) - low) / (high - low)

    def at(self, share: float, narrow: bool) -> str:
        """Return the value below which a share of the draws lies, which may be ``narrow`` about the evidence."""
        if self.scale == "one of":
            weights = [1.5 if narrow and value == self.evidence else 1.0 for value in self.values]
            ends = zip(self.values, accumulate(weights), strict=True)
            return str(next(value for value, end in ends if share * sum(weights) < end))
        low, high = self.values
        if narrow:
            share = min(max(self.place(self.evidence) - 0.25, 0.0), 0.5) + share / 2
        return f"{low * (high / low) ** share if self.scale == 'log' else low + share * (high - low):.6g}"

    def part(self, value: str) -> str:
        """Return the part of its range that a value is in: itself, or a third."""
        thirds = ("lower third", "middle third", "upper third")
        return value if self.scale == "one of" else thirds[min(int(3 * self.place(value)), 2)]


BOX = (
    Unknown("gamma", "camera.preset", "one of", ("ov7670", "ov7670-gamma", "ov7670-gamma-metered"),
            "ov7670-gamma-metered", "on after a reset, and the public firmware never writes COM13; where the loop"
            " meters is open, and a sibling's data sheet hints at behind the curve"),
    Unknown("every", "processor.every", "one of", ("1", "2", "3"), "2", "our count of the byte network is 27 to 33 ms"
            " of a frame's 33, the float network does not fit, and the firmware then skips a frame; the paper: 30 fps"),
    Unknown("floor", "scene.floor", "linear", (0.02, 0.85), 0.1, "public pictures of the group's arena (2019): a black"
            " screen as floor"),
    Unknown("wall", "scene.wall_cm", "linear", (30.0, 100.0), 45.0, "white walls in those pictures, no distance; the"
            " bench's own"),
    Unknown("light", "scene.light", "log", (0.25, 2.0), 1.0, "none; the bench's own"),
    Unknown("exposure target", "camera.ae_target", "linear", (60.0, 180.0), 108.0, "data sheet: the middle of AEB and"
            " AEW after a reset, which the firmware leaves"),
    Unknown("falloff", "camera.vignetting", "linear", (0.0, 4.0), 2.0, "none; from no falloff to the natural one"),
    Unknown("low-pass", "dsnn.lowpass", "one of", ("backward-euler", "two-tap-fdsr"), "two-tap-fdsr", "all public code"
            " of the first author"),
    Unknown("delays", "dsnn.tau_s", "one of", ("10,200", "200,10"), "200,10", "the paper's words, 'a linearly decaying"
            " function', read plainly; the bench has them rising, for C15"),
    Unknown("start acceleration", "experiment.acceleration_cm_s2", "log", (10.0, 100.0), 17.0, "none; the bench's own,"
            " a compromise"),
    Unknown("K_sp", "dsnn.k_sp", "linear", (1.0, 3.0), 2.0, "the paper's range, 1 to 3, and no value for the robot"),
)  # fmt: skip
"""What nobody knows of the robot's apparatus."""
POINTS = 128
"""Points of either sample."""
IMPLIED = ("C18", "C20")
"""Claims that the equations imply, whatever is seen."""
STUDY = Study(
    name="plausible",
    summary="the share of plausible apparatus in which the claims about the robot hold, 128 points over a box",
    claims=("C14", "C15", "C16", "C17", "C18", "C19", "C20", "C32"),
    experiments=WHOLE,
    repeats=5,
    replicates=1,
)
PILOT = replace(
    STUDY, name="plausible-pilot", summary="how far two designs of one apparatus agree", repeats=10, replicates=2
)
"""Ten apparatus, two full designs each: run before the check of ``plausible``, of which it gives the bound."""
LEAST_ACCEPTED: int | None = None
"""Of twenty robots those for which the true point has to be accepted; ``None`` until the pilot was run."""
NEAREST, FRESH, ROBOTS, PAIRS = 10, 3, 20, 10


def sample(number: int, seed: int, *, narrow: bool = False) -> list[Setting]:
    """Draw points of the box.

    Parameters
    ----------
    number, seed
        How many, and the seed of the draws.
    narrow
        Whether ranges are halved about their evidence.
    """
    drawn = stream("plausible.box", seed).random((2, number, len(BOX)))[int(narrow)]
    return [{one.name: one.at(share, narrow) for one, share in zip(BOX, row, strict=True)} for row in drawn.tolist()]


def study_of(points: Sequence[Setting], study: Study = STUDY) -> Study:
    """Return a study whose points these are, by their numbers."""
    keys = {one.name: one.key for one in BOX}
    levels = {str(at): tuple(f"{keys[n]}={value}" for n, value in point.items()) for at, point in enumerate(points)}
    return replace(study, axes={"point": levels})


def held(result: Any, replicate: int = 0) -> list[tuple[bool, ...]]:
    """Return which claims hold at each point of a study that was played, in one of its replicates."""
    return [
        tuple(result.outcomes[point, model, claim.id][replicate].verdict == "holds" for claim, _ in result.claims)
        for point, model in result.judged
    ]


def differing(one: Sequence[bool], other: Sequence[bool]) -> int:
    """Return in how many claims two points differ."""
    return sum(a != b for a, b in zip(one, other, strict=True))


def _share(whole: Sequence[bool]) -> dict[str, Any]:
    low, high = proportion_interval(sum(whole), len(whole)) if whole else (None, None)
    return {"points": len(whole), "all hold": sum(whole), "low": low, "high": high}


def shares(name: str, points: Sequence[Setting], verdicts: Verdicts) -> list[dict[str, Any]]:
    """Return the share of a sample in which all claims hold, for each state of gamma, and without two of the claims."""
    rows = []
    for without, gamma in product(((), IMPLIED), ("any", *BOX[0].values)):
        counted = [place for place, claim in enumerate(STUDY.claims) if claim not in without]
        chosen = [all(own[place] for place in counted) for point, own in zip(points, verdicts, strict=True)
                  if gamma in ("any", point["gamma"])]  # fmt: skip
        rows.append({"sample": name, "claims": len(counted), "gamma": gamma, **_share(chosen)})
    return rows


def over(number: int, points: Sequence[Setting], verdicts: Verdicts) -> list[dict[str, Any]]:
    """Return the share over the parts of each unknown's range, or of each two of them."""
    rows = []
    for unknowns in combinations(BOX, number):
        by_part: dict[tuple[str, ...], list[bool]] = {}
        for point, own in zip(points, verdicts, strict=True):
            by_part.setdefault(tuple(one.part(point[one.name]) for one in unknowns), []).append(all(own))
        rows += [{"unknown": ", ".join(one.name for one in unknowns), "part": ", ".join(part), **_share(by_part[part])}
                 for part in sorted(by_part)]  # fmt: skip
    return rows


def nearest(points: Sequence[Setting], verdicts: Verdicts) -> list[int]:
    """Return the points that keep all claims, then those that lose one: the ten nearest to the evidence."""

    def away(point: Setting) -> float:
        return sum(float(point[one.name] != one.evidence) if one.scale == "one of"
                   else (one.place(point[one.name]) - one.place(one.evidence)) ** 2 for one in BOX)  # fmt: skip

    lost = [len(own) - sum(own) for own in verdicts]
    near = [place for place, number in enumerate(lost) if number <= 1]
    return sorted(near, key=lambda place: (lost[place], away(points[place])))[:NEAREST]


def bound(first: Verdicts, second: Verdicts) -> dict[str, Any]:
    """Return the bound of the check, from the verdicts of two designs of each apparatus of the pilot."""
    from scipy.stats import binom  # not before: it takes its time to load

    agree = sum(differing(a, b) <= 1 for a, b in zip(first, second, strict=True))
    low, _ = proportion_interval(agree, len(first))
    least = int(binom.ppf(0.05, ROBOTS, low))
    return {"apparatus": len(first), "agree": agree, "p": low, "least accepted": least, "weak": least < ROBOTS / 2}


def accepted(verdicts: Verdicts, robots: Mapping[int, Sequence[bool]]) -> dict[str, Any]:
    """Return what the check comes to: the robots whose own point is accepted, and the median share that is.

    Parameters
    ----------
    verdicts
        Of the sample.
    robots
        Number of the point that played the robot -> the robot's verdicts.
    """
    sets = {robot: [differing(own, seen) <= 1 for own in verdicts] for robot, seen in robots.items()}
    true, share = sum(own[robot] for robot, own in sets.items()), median(sum(own) / len(own) for own in sets.values())
    passes = None if LEAST_ACCEPTED is None else true >= LEAST_ACCEPTED and share < 1 / 3
    return {"robots": len(robots), "true point accepted": true, "least": LEAST_ACCEPTED,
            "median share accepted": share, "passes": passes}  # fmt: skip
