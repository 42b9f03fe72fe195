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
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import accumulate, combinations, product
from pathlib import Path
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
    values: Sequence[Any]
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


TABLE = Path(__file__).with_suffix(".toml")
BOX = tuple(Unknown(**one) for one in tomllib.loads(TABLE.read_text("utf-8"))["unknown"])
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
"""Points judged again, each by so many designs; points that play the robot; apparatus of the pilot."""
APART = 1_000_000
"""Between the seeds of the sample, of the nearest judged again, of the robots and of the pilot."""


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


def _counted(whole: Sequence[bool]) -> dict[str, Any]:
    low, high = proportion_interval(sum(whole), len(whole)) if whole else (None, None)
    return {"points": len(whole), "all hold": sum(whole), "low": low, "high": high}


def shares(points: Sequence[Setting], verdicts: Verdicts) -> list[dict[str, Any]]:
    """Return the share of a sample in which all claims hold, for each state of gamma, and without two of the claims."""
    rows = []
    for without, gamma in product(((), IMPLIED), ("any", *BOX[0].values)):
        kept = [place for place, claim in enumerate(STUDY.claims) if claim not in without]
        chosen = [all(own[place] for place in kept) for point, own in zip(points, verdicts, strict=True)
                  if gamma in ("any", point["gamma"])]  # fmt: skip
        rows.append({"without": ", ".join(without), "gamma": gamma, **_counted(chosen)})
    return rows


def over(number: int, points: Sequence[Setting], verdicts: Verdicts) -> list[dict[str, Any]]:
    """Return the share over the parts of each unknown's range, or of those of each two in which all claims hold once."""
    rows = []
    for unknowns in combinations(BOX, number):
        by_part: dict[str, list[bool]] = {}
        for point, own in zip(points, verdicts, strict=True):
            by_part.setdefault(", ".join(one.part(point[one.name]) for one in unknowns), []).append(all(own))
        name = ", ".join(one.name for one in unknowns)
        rows += [{"unknown": name, "part": part, **_counted(by_part[part])} for part in sorted(by_part)
                 if number == 1 or any(by_part[part])]  # fmt: skip
    return rows


def nearest(points: Sequence[Setting], verdicts: Verdicts) -> list[int]:
    """Return the points that keep all claims, then those that lose one: the ten nearest to the evidence."""

    def away(point: Setting) -> float:
        return sum(float(point[one.name] != one.evidence) if one.scale == "one of"
                   else (one.place(point[one.name]) - one.place(one.evidence)) ** 2 for one in BOX)  # fmt: skip

    lost = [len(own) - sum(own) for own in verdicts]
    near = [place for place, number in enumerate(lost) if number <= 1]
    return sorted(near, key=lambda place: (lost[place], away(points[place])))[:NEAREST]


def bound(result: Any) -> dict[str, list[dict[str, Any]]]:
    """Return the bound of the check, from the two designs of each apparatus of the pilot."""
    from scipy.stats import binom  # not before: it takes its time to load

    pairs = list(zip(held(result), held(result, 1), strict=True))
    agree = sum(differing(one, other) <= 1 for one, other in pairs)
    low, _ = proportion_interval(agree, len(pairs))
    least = int(binom.ppf(0.05, ROBOTS, low))
    return {
        "Bound": [{"agree": agree, "of": len(pairs), "p": low, "least accepted": least, "weak": 2 * least < ROBOTS}]
    }


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
    return {"robots": len(robots), "true point accepted": true, "least": LEAST_ACCEPTED, "median share": share,
            "passes": passes}  # fmt: skip


def both(seed: int) -> list[Setting]:
    """Return the points of the whole box, then those of the halved one."""
    return [*sample(POINTS, seed), *sample(POINTS, seed, narrow=True)]


def further(result: Any, play: Any) -> dict[str, list[dict[str, Any]]]:
    """Return the tables of the sample, of its nearest points judged again, and of the check, which ``play`` plays."""
    (points, verdicts), claims = (both(result.seed), held(result)), [str(claim) for claim in STUDY.claims]
    wide, narrow = slice(0, POINTS), slice(POINTS, None)
    tables = {"Whole box": shares(points[wide], verdicts[wide]), "Halved": shares(points[narrow], verdicts[narrow]),
              "Over one unknown": over(1, points[wide], verdicts[wide]),
              "Over two": over(2, points[wide], verdicts[wide])}  # fmt: skip

    def again(name: str, places: Sequence[int], apart: int, replicates: int) -> list[list[tuple[bool, ...]]]:
        whole = replace(PILOT, name=name, claims=STUDY.claims, experiments=STUDY.experiments, replicates=replicates)
        played = play(study_of([points[place] for place in places], whole), result.seed + apart * APART)
        return [held(played, number) for number in range(replicates)]

    if near := nearest(points[wide], verdicts[wide]):
        counts = [
            [sum(one) for one in zip(*own, strict=True)] for own in zip(*again("near", near, 1, FRESH), strict=True)
        ]
        tables["Nearest points again"] = [
            {"point": place, **dict(zip(claims, own, strict=True))} for place, own in zip(near, counts, strict=True)
        ]
    if robots := [place for place, own in enumerate(verdicts[wide]) if own[0]][:ROBOTS]:
        (seen,) = again("robots", robots, 2, 1)
        tables["Check"] = [accepted(verdicts[wide], dict(zip(robots, seen, strict=True)))]
    return tables
