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
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from experiments import Study
from experiments.base.streams import stream
from experiments.judge.tests import proportion_interval
from experiments.paper.studies.robot import WHOLE

Setting = Mapping[str, str]
"""Name of each unknown -> its value at a point, as ``--set`` takes it."""
Verdicts = npt.NDArray[np.bool_]
"""Whether each claim holds at each point, (points, claims)."""
Tables = dict[str, list[dict[str, Any]]]


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
        """Return where in the range a value is, from 0 to 1; of several values 0 for the evidence, 1 for others."""
        if self.scale == "one of":
            return float(value != self.evidence)
        scale = math.log if self.scale == "log" else float
        low, high, at = (scale(float(one)) for one in (*self.values, value))
        return (at - low) / (high - low)

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
        return value if self.scale == "one of" else ("lower", "middle", "upper")[min(int(3 * self.place(value)), 2)]


BOX = tuple(Unknown(**one) for one in tomllib.loads(Path(__file__).with_suffix(".toml").read_text("utf-8"))["unknown"])
"""What nobody knows of the robot's apparatus."""
POINTS = 128
"""Points of either sample."""
IMPLIED = ("C18", "C20")
"""Claims that the equations imply, whatever is seen."""
STUDY = Study(
    "plausible", "the share of plausible apparatus in which the claims about the robot hold, 128 points over a box",
    claims=("C14", "C15", "C16", "C17", "C18", "C19", "C20", "C32"), experiments=WHOLE, repeats=5, replicates=1,
)  # fmt: skip
PILOT = replace(STUDY, name="plausible-pilot", summary="how far two designs of one agree", repeats=10, replicates=2)
"""Ten apparatus, two full designs each: run before the check of ``plausible``, of which it gives the bound."""
LEAST_ACCEPTED = 10
"""Of twenty robots those for which the true point has to be accepted. Of the pilot's ten pairs, from seed 1000, all ten
agreed; the lower end is 0.692."""
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


def both(seed: int) -> list[Setting]:
    """Return the points of the whole box, then those of the halved one."""
    return [*sample(POINTS, seed), *sample(POINTS, seed, narrow=True)]


def study_of(points: Sequence[Setting], study: Study = STUDY) -> Study:
    """Return a study whose points these are, by their numbers."""
    levels = {str(at): tuple(f"{one.key}={point[one.name]}" for one in BOX) for at, point in enumerate(points)}
    return replace(study, axes={"point": levels})


def sampled(study: Study, seed: int) -> Study:
    """Return the study of both samples."""
    return study_of(both(seed), study)


def pilot(study: Study, seed: int) -> Study:
    """Return the study of the pilot's apparatus."""
    return study_of(sample(PAIRS, seed + 3 * APART), study)


def held(result: Any, replicate: int = 0) -> Verdicts:
    """Return which claims hold at each point of a study that was played, in one of its replicates."""
    return np.array([[result.outcomes[point, model, claim.id][replicate].verdict == "holds"
                      for claim, _ in result.claims] for point, model in result.judged])  # fmt: skip


def over(unknowns: Sequence[Unknown], points: Sequence[Setting], whole: Verdicts) -> list[dict[str, Any]]:
    """Return the share of points in which all hold, as ``whole`` says, over the parts of unknowns' ranges."""
    parts = [", ".join(one.part(point[one.name]) for one in unknowns) for point in points]
    rows = []
    for part in sorted(set(parts)):
        own = whole[np.array(parts) == part]
        low, high = proportion_interval(int(own.sum()), len(own))
        rows.append({"unknown": ", ".join(one.name for one in unknowns), "part": part, "points": len(own),
                     "all hold": int(own.sum()), "low": low, "high": high})  # fmt: skip
    return rows


def nearest(points: Sequence[Setting], verdicts: Verdicts) -> list[int]:
    """Return the points that keep all claims, then those that lose one: the ten nearest to the evidence."""
    lost = (~verdicts).sum(axis=1)
    away = [sum((one.place(point[one.name]) - one.place(one.evidence)) ** 2 for one in BOX) for point in points]
    return [int(place) for place in np.lexsort((away, lost)) if lost[place] <= 1][:NEAREST]


def bound(result: Any) -> Tables:
    """Return the bound of the check, from the two designs of each apparatus of the pilot."""
    from scipy.stats import binom  # not before: it takes its time to load

    near = (held(result) != held(result, 1)).sum(axis=1) <= 1
    low, _ = proportion_interval(int(near.sum()), len(near))
    least = int(binom.ppf(0.05, ROBOTS, low))
    row = {"agree": int(near.sum()), "of": len(near), "p": low, "least accepted": least, "weak": 2 * least < ROBOTS}
    return {"Bound": [row]}


def accepted(verdicts: Verdicts, robots: Sequence[int], seen: Verdicts) -> dict[str, Any]:
    """Return what the check comes to: the robots whose own point is accepted, and the median share that is.

    Parameters
    ----------
    verdicts
        Of the sample.
    robots, seen
        The points that played the robot, and the robot's verdicts each time.
    """
    sets = (seen[:, None] != verdicts).sum(axis=2) <= 1
    true, share = int(sets[np.arange(len(robots)), robots].sum()), float(np.median(sets.mean(axis=1)))
    passes = true >= LEAST_ACCEPTED and share < 1 / 3
    return {"robots": len(robots), "accepted": true, "least": LEAST_ACCEPTED, "median share": share, "passes": passes}


def further(result: Any, play: Any) -> Tables:
    """Return the tables of the sample, of its nearest points judged again, and of the check, which ``play`` plays."""
    points, verdicts, claims = both(result.seed), held(result), np.array(STUDY.claims)
    wide = slice(0, POINTS)
    tables: Tables = {
        "Share in which all hold": [
            {"sample": name, "without": ", ".join(without), **row}
            for (name, own), without in product((("box", wide), ("halved", slice(POINTS, None))), ((), IMPLIED))
            for unknowns in ((), BOX[:1])
            for row in over(unknowns, points[own], verdicts[own][:, ~np.isin(claims, without)].all(axis=1))
        ]
    }
    whole = np.asarray(verdicts[wide].all(axis=1))
    tables["Over one unknown"] = [row for one in BOX for row in over([one], points[wide], whole)]
    pairs = (row for ones in combinations(BOX, 2) for row in over(ones, points[wide], whole))
    tables["Over two"] = [row for row in pairs if row["all hold"]]

    def again(name: str, places: Sequence[int], apart: int, replicates: int) -> Verdicts:
        design = replace(PILOT, name=name, claims=STUDY.claims, experiments=STUDY.experiments, replicates=replicates)
        played = play(study_of([points[place] for place in places], design), result.seed + apart * APART)
        return np.array([held(played, number) for number in range(replicates)])

    if near := nearest(points[wide], verdicts[wide]):
        fresh = again("near", near, 1, FRESH).sum(axis=0).tolist()
        tables["Nearest again"] = [{"point": at, **dict(zip(claims.tolist(), own, strict=True))}
                                   for at, own in zip(near, fresh, strict=True)]  # fmt: skip
    if robots := np.flatnonzero(verdicts[wide, 0])[:ROBOTS].tolist():
        tables["Check"] = [accepted(verdicts[wide], robots, again("robots", robots, 2, 1)[0])]
    return tables
