"""What the paper reports of the robot, as checks on a run's trials.

The claims' words are those of ``claims.toml`` beside this file. A judge never bends a bound: a claim that misses
it fails, and the verdict says by how much. A new claim is its words there and a judge in `JUDGES`.
"""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import Any, Literal

import numpy as np

from experiments.bench.statistics import contrast, trend

Rows = Sequence[Mapping[str, Any]]
Outcome = tuple[Literal["holds", "fails", "untested"], str, str]


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


@cache
def claim_texts() -> Mapping[str, tuple[str, str]]:
    """Claim id -> (what the paper says, the label of its figure)."""
    table = tomllib.loads(files("experiments.bench").joinpath("claims.toml").read_text(encoding="utf-8"))
    parts = [part for room in table.values() for part in room.values()]
    return {claim["id"]: (claim["says"], part["source"]) for part in parts for claim in part["claims"]}


def judge(claim: str, rows: Rows, threshold: float) -> Verdict:
    """The verdict of one claim on the trials given; ``threshold`` is the model's spiking threshold."""
    says, source = claim_texts()[claim]
    judged = JUDGES.get(claim)
    outcome: Outcome = judged(rows, threshold) if judged else ("untested", "no judge for this claim yet", "")
    return Verdict(claim, says, source, *outcome, n=len(rows))


def _mean_spikes(rows: Rows, column: str, **fixed: Any) -> dict[float, list[int]]:
    """Spike counts per level of ``column`` in the rows where the ``fixed`` columns have the given values."""
    chosen = [row for row in rows if all(row[name] == value for name, value in fixed.items())]
    levels = sorted({row[column] for row in chosen})
    return {level: [row["spikes"] for row in chosen if row[column] == level] for level in levels}


def _listed(groups: Mapping[float, Sequence[float]], unit: str) -> str:
    means = ", ".join(f"{np.mean(v):.1f}" for v in groups.values())
    return f"mean spikes {means} at {', '.join(f'{k:g}' for k in groups)} {unit}"


def _c14(rows: Rows, threshold: float) -> Outcome:
    """At 6 cm/s and the nearest tested distance: slow or far crossings stay under the threshold in the paper too."""
    chosen = [row for row in rows if row["motion"] == "translation" and row["speed_cm_s"] == 6.0]
    if not chosen:
        return "untested", "needs translations at 6 cm/s", ""
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
    if not all(good):
        return "fails", measured, f"{sum(good)} of {len(good)} trials"
    both = right and left
    return (
        "holds" if both else "untested",
        measured + ("" if both else "; the other direction was not run"),
        (f"{sum(good)} of {len(good)} trials"),
    )


def _c15(rows: Rows, threshold: float) -> Outcome:
    groups = _mean_spikes(rows, "speed_cm_s", motion="translation", distance_cm=8.0, direction="rightward")
    if not {2.0, 4.0, 6.0, 10.0} <= groups.keys():
        return "untested", "needs rightward translations at 8 cm, 2, 4, 6 and 10 cm/s", ""
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
    return "holds" if rising and falling else "fails", measured, effect


def _c16(rows: Rows, threshold: float) -> Outcome:
    groups = _mean_spikes(rows, "distance_cm", motion="translation", speed_cm_s=6.0, direction="rightward")
    if not {5.0, 10.0, 15.0} <= groups.keys():
        return "untested", "needs rightward translations at 6 cm/s, 5, 10 and 15 cm", ""
    near, middle, far = (float(np.mean(groups[d])) for d in (5.0, 10.0, 15.0))
    effect = str(trend([(d, groups[d]) for d in (5.0, 10.0, 15.0)]))
    holds = near > middle > far and far <= near / 2
    return "holds" if holds else "fails", _listed(groups, "cm"), effect


JUDGES: Mapping[str, Callable[[Rows, float], Outcome]] = {"C14": _c14, "C15": _c15, "C16": _c16}
