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
from experiments.bench.statistics import contrast, proportion_interval, summarise, trend

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
    model: str
    says: str
    source: str
    verdict: Literal["holds", "fails", "untested"]
    measured: str
    effect: str
    n: int


def judge(claim: str, rows: Rows, threshold: float | None, model: str = "dsnn") -> Verdict:
    """The verdict of one claim on one model's trials; ``threshold`` is that model's spiking threshold, if any."""
    says, source = claim_texts()[claim]
    if claim not in JUDGES:
        outcome = Outcome("untested", "no judge for this claim yet")
    elif threshold is None:
        outcome = Outcome("untested", "this model does not spike")
    else:
        outcome = JUDGES[claim](rows, threshold)
    wrong = flaws([row for row in rows if row["motion"] in MOTIONS.get(claim, ())])
    if outcome.verdict != "untested" and wrong:
        outcome = replace(outcome, verdict="untested", measured=f"{wrong}; measured: {outcome.measured}")
    return Verdict(claim, model, says, source, outcome.verdict, outcome.measured, outcome.effect, outcome.n)


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


DEFAULTS: Mapping[str, Any] = {
    "shell_grey": None, "wall_contrast": None, "observer_speed_cm_s": 0.0, "observer_turn_deg_s": 0.0,
}  # fmt: skip
"""What the paper's trials leave as it is: those of other experiments do not count."""


def _chosen(rows: Rows, **fixed: Any) -> list[Mapping[str, Any]]:
    """The paper's own trials with the ``fixed`` values."""
    return [row for row in rows if all(row[name] == value for name, value in {**DEFAULTS, **fixed}.items())]


def _mean_spikes(rows: Rows, column: str, **fixed: Any) -> dict[float, list[int]]:
    """Spike counts per level of ``column`` in the rows where the ``fixed`` columns have the given values."""
    chosen = _chosen(rows, **fixed)
    levels = sorted({row[column] for row in chosen})
    return {level: [row["spikes"] for row in chosen if row[column] == level] for level in levels}


def _listed(groups: Mapping[float, Sequence[float]], unit: str) -> str:
    """Mean spikes of each group with its 95 % bootstrap interval, and how many trials each mean is of."""
    said = []
    for level, spikes in groups.items():
        said.append(f"{level:g} {unit}: {_mean(spikes)}")
    counts = sorted({len(spikes) for spikes in groups.values()})
    return f"mean spikes at {', '.join(said)} (n = {'..'.join(map(str, counts))} each)"


def _mean(values: Sequence[float], digits: int = 1) -> str:
    """A mean with its 95 % bootstrap interval."""
    summary = summarise(values)
    low, high = f"{summary.ci_low:.{digits}f}", f"{summary.ci_high:.{digits}f}"
    return f"{summary.mean:.{digits}f}" + (f" [{low}, {high}]" if summary.n > 1 else "")


def _count(groups: Mapping[float, Sequence[float]]) -> int:
    return sum(map(len, groups.values()))


def _c13(rows: Rows, threshold: float) -> Outcome:
    kinds = {kind: _chosen(rows, motion=kind, angle_deg=0.0) for kind in ("approach", "recession")}
    tested = {kind: chosen for kind, chosen in kinds.items() if chosen}
    if not tested:
        return Outcome("untested", "needs straight approach and recession")
    parts = []
    for kind, chosen in tested.items():
        firing = sum(row["spikes"] > 0 for row in chosen)
        peak = max(max(row["peak_hs"], -row["trough_hs"]) for row in chosen)
        share = " [{:.0%}, {:.0%}]".format(*proportion_interval(firing, len(chosen)))
        parts.append(f"{kind}: spikes in {firing} of {len(chosen)} trials{share}, |HS| up to {peak:.2f}")
    measured = f"{'; '.join(parts)} (T = {threshold:g})"
    every = [row for chosen in tested.values() for row in chosen]
    firing = sum(row["spikes"] > 0 for row in every)
    effect = f"{_mean([row['spikes'] for row in every])} spikes a trial"
    if firing:
        return Outcome("fails", measured, effect, len(every))
    if len(tested) < len(kinds):
        return Outcome("untested", f"{measured}; the other motion was not run", effect, len(every))
    return Outcome("holds", measured, effect, len(every))


def _c14(rows: Rows, threshold: float) -> Outcome:
    """At 6 cm/s and the nearest tested distance: slow or far crossings stay under the threshold in the paper too."""
    chosen = _chosen(rows, motion="translation", speed_cm_s=6.0)
    if not chosen:
        return Outcome("untested", "needs translations at 6 cm/s")
    ways = [{row["distance_cm"] for row in chosen if row["direction"] == way} for way in ("rightward", "leftward")]
    near = min(ways[0] & ways[1] or ways[0] | ways[1])  # the nearest tested both ways
    right, left = (
        [row for row in chosen if row["direction"] == way and row["distance_cm"] == near]
        for way in ("rightward", "leftward")
    )
    parts, good = [], []
    if right:
        good += [row["peak_hs"] > threshold and row["trough_hs"] >= -threshold for row in right]
        peaks = [row["peak_hs"] for row in right]
        parts.append(f"rightward HS peaks {min(peaks):.2f} or higher, mean {_mean(peaks, 2)}")
    if left:
        good += [row["trough_hs"] < -threshold and row["peak_hs"] <= threshold for row in left]
        troughs = [row["trough_hs"] for row in left]
        parts.append(f"leftward HS troughs {max(troughs):.2f} or lower, mean {_mean(troughs, 2)}")
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


ANGLES = (-30.0, -15.0, 0.0, 15.0, 30.0)


def _angles(rows: Rows, motion: str) -> dict[float, list[int]]:
    groups = _mean_spikes(rows, "angle_deg", motion=motion, speed_cm_s=6.0)
    return {angle: groups[angle] for angle in ANGLES} if set(ANGLES) <= groups.keys() else {}


def _fewest_ahead(rows: Rows, motion: str) -> Outcome:
    """Fewest spikes at 0 degrees, more at 30 than at 15 on each side."""
    groups = _angles(rows, motion)
    if not groups:
        return Outcome("untested", f"needs {motion} at -30, -15, 0, 15 and 30 degrees, 6 cm/s")
    mean = {angle: float(np.mean(spikes)) for angle, spikes in groups.items()}
    holds = all(mean[0.0] < mean[a] for a in mean if a) and mean[-30.0] > mean[-15.0] and mean[30.0] > mean[15.0]
    size = trend([(abs(a), groups[a]) for a in sorted(groups, key=abs)])
    measured = _listed(groups, "degrees")
    return Outcome("holds" if holds else "fails", measured, f"against |angle|: {size}", _count(groups))


def _most_ahead(rows: Rows) -> Outcome:
    """A looming detector's: more spikes at 0 degrees than at any other angle."""
    groups = _angles(rows, "approach")
    if not groups:
        return Outcome("untested", "needs approach at -30, -15, 0, 15 and 30 degrees, 6 cm/s")
    mean = {angle: float(np.mean(spikes)) for angle, spikes in groups.items()}
    size = trend([(abs(a), groups[a]) for a in sorted(groups, key=abs)])
    holds = all(mean[0.0] > mean[angle] for angle in mean if angle)
    return Outcome(
        "holds" if holds else "fails", _listed(groups, "degrees"), f"against |angle|: {size}", _count(groups)
    )


def _sides(rows: Rows, motion: str, more: float, name: str) -> Outcome:
    """More spikes on the side of the sign ``more`` than at the same angles on the other."""
    groups = _angles(rows, motion)
    if not groups:
        return Outcome("untested", f"needs {motion} at -30, -15, 0, 15 and 30 degrees, 6 cm/s")
    here, there = ([n for a in (15.0, 30.0) for n in groups[side * a]] for side in (more, -more))
    measured = f"{name}: {_mean(here)} against {_mean(there)} spikes a trial; {_listed(groups, 'degrees')}"
    holds = np.mean(here) > np.mean(there)
    return Outcome("holds" if holds else "fails", measured, str(contrast(here, there)), len(here) + len(there))


_DEPTH, _ACROSS = ("approach", "recession"), ("translation",)
MOTIONS: Mapping[str, tuple[str, ...]] = {
    "C13": _DEPTH, "C14": _ACROSS, "C15": _ACROSS, "C16": _ACROSS,
    "C17": _DEPTH[:1], "C18": _DEPTH[:1], "C19": _DEPTH[1:], "C20": _DEPTH[1:], "C21": _DEPTH[:1],
}  # fmt: skip
"""Claim -> the motions it is judged on: flaws of other trials do not touch it."""

JUDGES: Mapping[str, Callable[[Rows, float], Outcome]] = {
    "C13": _c13,
    "C14": _c14,
    "C15": _c15,
    "C16": _c16,
    "C17": lambda rows, threshold: _fewest_ahead(rows, "approach"),
    "C18": lambda rows, threshold: _sides(rows, "approach", -1.0, "from the left against from the right"),
    "C19": lambda rows, threshold: _fewest_ahead(rows, "recession"),
    "C20": lambda rows, threshold: _sides(rows, "recession", 1.0, "to the right against to the left"),
    "C21": lambda rows, threshold: _most_ahead(rows),
}

LOOMING_CLAIMS = frozenset({"C21"})
"""Those about looming detectors; the others are about models of direction."""


def concerns(claim: str, channels: Sequence[str]) -> bool:
    """Whether a claim is about models that answer by ``channels``."""
    return (claim in LOOMING_CLAIMS) != ("hs" in channels)
