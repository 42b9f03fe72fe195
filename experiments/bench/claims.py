"""What the paper reports of the robot, as checks on a run's trials.

The claims' words are those of ``claims.toml`` beside this file. A judge never bends a bound: a claim that misses
it fails, and the verdict says by how much. A new claim is its words there and a judge in `JUDGES`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np

from experiments.bench.paper import claim_texts
from experiments.bench.statistics import contrast, trend

Rows = Sequence[Mapping[str, Any]]

SPEED_TOLERANCE, PATH_TOLERANCE_MM = 0.02, 1.0


@dataclass(frozen=True, slots=True)
class Outcome:
    """What a judge finds: on how many trials, what they measured, and the test with its effect size."""

    verdict: Literal["holds", "fails", "untested"]
    measured: str
    effect: str = ""
    n: int = 0


@dataclass(frozen=True, slots=True)
class Verdict:
    """A claim's answer: ``measured`` says the numbers, ``effect`` the test and its effect size."""

    id: str
    says: str
    source: str
    verdict: Literal["holds", "fails", "untested"]
    measured: str
    effect: str
    n: int


def judge(claim: str, rows: Rows, threshold: float) -> Verdict:
    """The verdict of one claim on the trials given; ``threshold`` is the model's spiking threshold."""
    says, source = claim_texts()[claim]
    outcome = JUDGES.get(claim, _no_judge)(rows, threshold)
    wrong = flaws(rows)
    if outcome.verdict != "untested" and wrong:
        outcome = replace(outcome, verdict="untested", measured=f"{wrong}; measured: {outcome.measured}")
    return Verdict(claim, says, source, outcome.verdict, outcome.measured, outcome.effect, outcome.n)


def flaws(rows: Rows) -> str:
    """What makes trials something other than what their conditions say, in words; empty if nothing does."""
    off = [abs(row["achieved_speed_cm_s"] / row["speed_cm_s"] - 1) for row in rows]
    astray = [row["path_error_mm"] for row in rows]
    found = []
    if any(error > SPEED_TOLERANCE for error in off):
        count = sum(error > SPEED_TOLERANCE for error in off)
        found.append(f"{count} of {len(rows)} trials were off the commanded speed, by up to {max(off):.0%}")
    if any(error > PATH_TOLERANCE_MM for error in astray):
        count = sum(error > PATH_TOLERANCE_MM for error in astray)
        found.append(f"{count} of {len(rows)} trials left their path, by up to {max(astray):.1f} mm")
    return "; ".join(found)


def _no_judge(rows: Rows, threshold: float) -> Outcome:
    return Outcome("untested", "no judge for this claim yet")


def _mean_spikes(rows: Rows, column: str, **fixed: Any) -> dict[float, list[int]]:
    """Spike counts per level of ``column`` in the rows where the ``fixed`` columns have the given values."""
    chosen = [row for row in rows if all(row[name] == value for name, value in fixed.items())]
    levels = sorted({row[column] for row in chosen})
    return {level: [row["spikes"] for row in chosen if row[column] == level] for level in levels}


def _listed(groups: Mapping[float, Sequence[float]], unit: str) -> str:
    means = ", ".join(f"{np.mean(v):.1f}" for v in groups.values())
    counts = sorted({len(v) for v in groups.values()})
    n = f"n = {'..'.join(map(str, counts))} each"
    return f"mean spikes {means} at {', '.join(f'{k:g}' for k in groups)} {unit} ({n})"


def _count(groups: Mapping[float, Sequence[float]]) -> int:
    return sum(map(len, groups.values()))


def _c14(rows: Rows, threshold: float) -> Outcome:
    """At 6 cm/s and the nearest tested distance: slow or far crossings stay under the threshold in the paper too."""
    chosen = [row for row in rows if row["motion"] == "translation" and row["speed_cm_s"] == 6.0]
    if not chosen:
        return Outcome("untested", "needs translations at 6 cm/s")
    near = min(row["distance_cm"] for row in chosen)
    right, left = (
        [row for row in chosen if row["direction"] == way and row["distance_cm"] == near]
        for way in ("rightward", "leftward")
    )
    parts, good = [], []
    if right:
        good += [row["peak_hs"] > threshold and row["trough_hs"] >= -threshold for row in right]
        parts.append(f"rightward HS peaks {min(r['peak_hs'] for r in right):.2f} or higher")
    if left:
        good += [row["trough_hs"] < -threshold and row["peak_hs"] <= threshold for row in left]
        parts.append(f"leftward HS troughs {max(r['trough_hs'] for r in left):.2f} or lower")
    measured = f"{'; '.join(parts)} at 6 cm/s, {near:g} cm (T = {threshold:g})"
    effect = f"{sum(good)} of {len(good)} trials"
    if not all(good):
        return Outcome("fails", measured, effect, len(good))
    if not (right and left):
        return Outcome("untested", f"{measured}; the other direction was not run", effect, len(good))
    return Outcome("holds", measured, effect, len(good))


def _c15(rows: Rows, threshold: float) -> Outcome:
    groups = _mean_spikes(rows, "speed_cm_s", motion="translation", distance_cm=8.0, direction="rightward")
    if not {2.0, 4.0, 6.0, 10.0} <= groups.keys():
        return Outcome("untested", "needs rightward translations at 8 cm, 2, 4, 6 and 10 cm/s")
    mean = {speed: float(np.mean(spikes)) for speed, spikes in groups.items()}
    rising = mean[2.0] < mean[4.0] < mean[6.0]
    falling = mean[10.0] < mean[6.0]
    measured = _listed(groups, "cm/s")
    if not rising:
        measured += "; they do not rise from 2 to 6"
    if not falling:
        measured += f"; at 10 cm/s {mean[10.0] - mean[6.0]:+.1f} against 6"
    rise = trend([(speed, groups[speed]) for speed in (2.0, 4.0, 6.0)])
    effect = f"2 to 6 cm/s: {rise}; 10 against 6: {contrast(groups[10.0], groups[6.0])}"
    return Outcome("holds" if rising and falling else "fails", measured, effect, _count(groups))


def _c16(rows: Rows, threshold: float) -> Outcome:
    groups = _mean_spikes(rows, "distance_cm", motion="translation", speed_cm_s=6.0, direction="rightward")
    if not {5.0, 10.0, 15.0} <= groups.keys():
        return Outcome("untested", "needs rightward translations at 6 cm/s, 5, 10 and 15 cm")
    near, middle, far = (float(np.mean(groups[d])) for d in (5.0, 10.0, 15.0))
    effect = str(trend([(d, groups[d]) for d in (5.0, 10.0, 15.0)]))
    holds = near > middle > far and far <= near / 2
    return Outcome("holds" if holds else "fails", _listed(groups, "cm"), effect, _count(groups))


JUDGES: Mapping[str, Callable[[Rows, float], Outcome]] = {"C14": _c14, "C15": _c15, "C16": _c16}
