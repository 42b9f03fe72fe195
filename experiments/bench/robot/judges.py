"""The judges of the paper's claims about the robot: each takes a model's trials and its threshold.

A judge tests its claim on every condition that the words cover among the trials it is given; where the words leave
room, its docstring says how they are read.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from experiments.bench.judging.numbers import is_number
from experiments.bench.judging.statistics import contrast, proportion_interval, summarise, trend
from experiments.bench.judging.verdict import Check, Outcome, decide

Rows = Sequence[Mapping[str, Any]]
ByLevel = Mapping[float, Sequence[float]]
"""Level of a condition -> a value of each of its trials."""

DEFAULTS: Mapping[str, Any] = {
    "shell_grey": None, "wall_contrast": None, "observer_speed_cm_s": 0.0, "observer_turn_deg_s": 0.0,
}  # fmt: skip
"""What the paper's trials leave as it is: those of other experiments do not count."""

IN_ONE_WINDOW = ("spikes_in_window", "spikes_in_inner_window", "mean_hs_near_axis")
"""Columns: the two windows that C29 is judged by, and the potential, which stands beside."""

ANGLES = (-30.0, -15.0, 0.0, 15.0, 30.0)


def no_spikes_in_depth(rows: Rows, threshold: float) -> Outcome:
    """C13. Straight: along the optical axis, at any speed."""
    kinds = {kind: paper_trials(rows, motion=kind, angle_deg=0.0) for kind in ("approach", "recession")}
    tested = {kind: chosen for kind, chosen in kinds.items() if chosen}
    if not tested:
        return Outcome("untested", "needs straight approach and recession")
    parts, checks = [], []
    for kind, chosen in tested.items():
        firing = sum(row["spikes"] > 0 for row in chosen)
        peak = max(max(row["peak_hs"], -row["trough_hs"]) for row in chosen)
        share = "[{:.0%}, {:.0%}]".format(*proportion_interval(firing, len(chosen)))
        parts.append(f"{kind}: spikes in {firing} of {len(chosen)} trials {share}, |HS| up to {peak:.2f}")
        said = (
            f"{kind}: spikes in {firing} of {len(chosen)} trials (needs 0), |HS| up to {peak:.2f} (T = {threshold:g})"
        )
        # Of motions without a spike, that with the higher potential came nearer to one.
        checks.append(Check(said, -float(firing) if firing else 1.0 / (1.0 + peak)))
    spikes = {kind: [row["spikes"] for row in chosen] for kind, chosen in tested.items()}
    effect = f"{_mean([count for counts in spikes.values() for count in counts])} spikes a trial"
    found = _outcome(checks, spikes, f"{'; '.join(parts)} (T = {threshold:g})", effect)
    found = replace(found, broken=sum(count > 0 for counts in spikes.values() for count in counts))
    if found.verdict == "holds" and len(tested) < len(kinds):
        return found.untested("the other motion was not run")
    return found


def direction_by_sign(rows: Rows, threshold: float) -> Outcome:
    """C14. Every crossing of the trials given, at whatever speed and distance.

    A trial passes if HS goes past the threshold of its own direction and not past that of the other: a potential
    that passes both tells no direction.
    """
    chosen = paper_trials(rows, motion="translation")
    ways = {sign: [row for row in chosen if row["direction"] == way] for sign, way in _WAYS.items()}
    tested = {sign: own for sign, own in ways.items() if own}
    if not tested:
        return Outcome("untested", "needs translations")
    parts, checks = [], []
    conditions: dict[str, list[float]] = {}
    for sign, own in tested.items():
        right, wrong = ([_reached(row, end * sign) for row in own] for end in (1.0, -1.0))
        weak, stray = own[int(np.argmin(right))], own[int(np.argmax(wrong))]
        reaches = f"HS reaches {sign * min(right):+.3f} at {_where(weak)}"
        strays = f"the other way it reaches {-sign * max(wrong):+.3f} at {_where(stray)}"
        way, mean = _WAYS[sign], _mean([sign * value for value in right], 2)
        parts.append(f"{way}, worst of {len(own)}: {reaches}, mean {mean}; {strays}")
        checks += [
            Check(f"{way}: {reaches} (needs to pass {sign * threshold:+g})", min(right) - threshold),
            Check(f"{way}: {strays} (needs not to pass {-sign * threshold:+g})", threshold - max(wrong), strict=False),
        ]
        for row, value in zip(own, right, strict=True):
            conditions.setdefault(f"{way}, {_where(row)}", []).append(value)
    good = sum(
        _reached(row, sign) > threshold and _reached(row, -sign) <= threshold for sign in tested for row in tested[sign]
    )
    effect = f"{good} of {sum(map(len, tested.values()))} trials pass"
    found = _outcome(checks, conditions, f"{'; '.join(parts)} (T = {threshold:g})", effect)
    found = replace(found, broken=found.n - good)
    if found.verdict == "holds" and len(tested) < len(ways):
        return found.untested("the other direction was not run")
    return found


_WAYS = {1.0: "rightward", -1.0: "leftward"}
"""Sign of HS -> direction of the motion."""


def _reached(row: Mapping[str, Any], sign: float) -> float:
    """How far HS goes from 0 to the side of ``sign``."""
    return float(row["peak_hs"] if sign > 0 else -row["trough_hs"])


def _where(row: Mapping[str, Any]) -> str:
    return f"{row['speed_cm_s']:g} cm/s, {row['distance_cm']:g} cm"


def peak_speed(rows: Rows, threshold: float) -> Outcome:
    """C15. Rightward, as in the paper. Near 6 is between 4 and 10: of all speeds shown, the most spikes come there."""
    groups = _spike_counts(rows, "speed_cm_s", motion="translation", distance_cm=8.0, direction="rightward")
    if not {2.0, 4.0, 6.0, 10.0} <= groups.keys():
        return Outcome("untested", "needs rightward translations at 8 cm, 2, 4, 6 and 10 cm/s")
    mean = _means(groups)
    near, far = (
        max((speed for speed in mean if (4.0 < speed < 10.0) == inside), key=lambda speed: mean[speed])
        for inside in (True, False)
    )
    checks = [_more(mean, more, less, "cm/s") for more, less in ((4.0, 2.0), (6.0, 4.0), (6.0, 10.0), (near, far))]
    rise = trend([(speed, groups[speed]) for speed in (2.0, 4.0, 6.0)])
    effect = f"2 to 6 cm/s: {rise}; 10 against 6: {contrast(groups[10.0], groups[6.0])}"
    return _outcome(checks, groups, f"rightward at 8 cm: {_listed(groups, 'cm/s')}", effect)


def peak_speed_in_one_window(rows: Rows, threshold: float) -> Outcome:
    """C29. C15 without the time in view, at the paper's speeds alone.

    The fastest crossing is the paper's, at 10 cm/s. Its length is read both ways: from the first edge in view to the
    last edge out, and from centre in to centre out. The claim holds if it does in both windows, so that what happens
    at the edge of the view decides nothing. The potential stands beside.
    """
    fixed = {"motion": "translation", "distance_cm": 8.0, "direction": "rightward"}
    groups, inner, potential = (_values(rows, "speed_cm_s", column, **fixed) for column in IN_ONE_WINDOW)
    if not {2.0, 4.0, 6.0, 10.0} <= groups.keys():
        return Outcome("untested", "needs rightward translations at 8 cm, 2, 4, 6 and 10 cm/s")
    checks, parts, effects = [], [], []
    for name, counts in (("edge to edge", groups), ("centre to centre", inner)):
        mean = _means(counts)
        made = [_more(mean, more, less, "cm/s") for more, less in ((4.0, 2.0), (6.0, 4.0), (6.0, 10.0))]
        checks += [Check(f"window from {name}: {check.said}", check.slack) for check in made]
        parts.append(f"window from {name}: {_listed(counts, 'cm/s')}")
        effects.append(f"{name}, 10 against 6 cm/s: {contrast(counts[10.0], counts[6.0])}")
    why = ", ".join(f"{speed:g} cm/s: {_mean(values, 2)}" for speed, values in potential.items())
    said = f"rightward at 8 cm, {'; '.join(parts)}; mean HS near the axis at {why}"
    named = {speed: groups[speed] for speed in (2.0, 4.0, 6.0, 10.0)}
    return _outcome(checks, named, said, "; ".join(effects))


def fewer_from_afar(rows: Rows, threshold: float) -> Outcome:
    """C16. Rightward, as in the paper."""
    groups = _spike_counts(rows, "distance_cm", motion="translation", speed_cm_s=6.0, direction="rightward")
    if not {5.0, 10.0, 15.0} <= groups.keys():
        return Outcome("untested", "needs rightward translations at 6 cm/s, 5, 10 and 15 cm")
    mean = _means(groups)
    half = f"{mean[15.0]:.1f} spikes at 15 cm (needs at most half of those at 5: {mean[5.0] / 2:.1f})"
    checks = [
        _more(mean, 5.0, 10.0, "cm"),
        _more(mean, 10.0, 15.0, "cm"),
        Check(half, mean[5.0] / 2 - mean[15.0], strict=False),
    ]
    effect = str(trend([(d, groups[d]) for d in (5.0, 10.0, 15.0)]))
    return _outcome(checks, groups, f"rightward at 6 cm/s: {_listed(groups, 'cm')}", effect)


def fewest_ahead(rows: Rows, motion: str) -> Outcome:
    """C17 and C19. At every speed shown: fewest spikes at 0 degrees, more at 30 than at 15 on each side."""
    pairs = [*((angle, 0.0) for angle in ANGLES if angle), (-30.0, -15.0), (30.0, 15.0)]
    return _at_every_speed(rows, motion, lambda groups: _of_pairs(groups, pairs), _against_angle)


def most_ahead(rows: Rows) -> Outcome:
    """C21. At every speed shown: more spikes at 0 degrees than at any other angle."""
    pairs = [(0.0, angle) for angle in ANGLES if angle]
    return _at_every_speed(rows, "approach", lambda groups: _of_pairs(groups, pairs), _against_angle)


def more_on_one_side(rows: Rows, motion: str, more: float, name: str) -> Outcome:
    """C18 and C20. At every speed: more on the side of the sign ``more``, at 15 and 30 degrees together."""

    def split(groups: ByLevel) -> tuple[list[float], list[float]]:
        here, there = ([n for a in (15.0, 30.0) for n in groups[side * a]] for side in (more, -more))
        return here, there

    def checks(groups: ByLevel) -> list[Check]:
        here, there = (float(np.mean(side)) for side in split(groups))
        return [Check(f"{name}: {here:.1f} spikes a trial (needs more than {there:.1f})", here - there)]

    def effect(groups: ByLevel) -> str:
        here, there = split(groups)
        return f"{name}: {_mean(here)} and {_mean(there)} spikes a trial, {contrast(here, there)}"

    return _at_every_speed(rows, motion, checks, effect)


def _at_every_speed(
    rows: Rows, motion: str, checks: Callable[[ByLevel], list[Check]], effect: Callable[[ByLevel], str]
) -> Outcome:
    """The outcome of ``checks`` at each speed at which the motion was shown along all `ANGLES`."""
    speeds = sorted({row["speed_cm_s"] for row in paper_trials(rows, motion=motion)})
    by_speed = {speed: _spike_counts(rows, "angle_deg", motion=motion, speed_cm_s=speed) for speed in speeds}
    whole = {speed: {a: own[a] for a in ANGLES} for speed, own in by_speed.items() if set(ANGLES) <= own.keys()}
    if not whole:
        return Outcome("untested", f"needs {motion} at -30, -15, 0, 15 and 30 degrees")
    made, measured, effects = [], [], []
    conditions: dict[str, Sequence[float]] = {}
    for speed, own in whole.items():
        which = f"{speed:g} cm/s: " if len(whole) > 1 else ""
        made += [Check(f"{which}{each.said}", each.slack, each.strict) for each in checks(own)]
        measured.append(f"{which}{_listed(own, 'degrees')}")
        effects.append(f"{which}{effect(own)}")
        conditions |= {f"{which}{angle}": spikes for angle, spikes in own.items()}
    return _outcome(made, conditions, "; ".join(measured), "; ".join(effects))


def _of_pairs(groups: ByLevel, pairs: Sequence[tuple[float, float]]) -> list[Check]:
    mean = _means(groups)
    return [_more(mean, more, less, "degrees") for more, less in pairs]


def _against_angle(groups: ByLevel) -> str:
    return f"against |angle|: {trend([(abs(a), groups[a]) for a in sorted(groups, key=abs)])}"


def _outcome(checks: Sequence[Check], groups: Mapping[Any, Sequence[float]], measured: str, effect: str) -> Outcome:
    """The outcome of checks on ``groups``, a value of each trial by condition."""
    holds, decided = decide(checks)
    counts = [len(values) for values in groups.values()]
    return Outcome("holds" if holds else "fails", measured, effect, sum(counts), decided, min(counts))


def _more(mean: Mapping[float, float], more: float, less: float, unit: str) -> Check:
    """More spikes at level ``more`` than at ``less``."""
    said = f"{mean[more]:.1f} spikes at {more:g} {unit} (needs more than at {less:g}: {mean[less]:.1f})"
    return Check(said, mean[more] - mean[less])


def paper_trials(rows: Rows, **fixed: Any) -> list[Mapping[str, Any]]:
    """The paper's own trials with the ``fixed`` values."""
    return [row for row in rows if all(row[name] == value for name, value in {**DEFAULTS, **fixed}.items())]


def _spike_counts(rows: Rows, column: str, **fixed: Any) -> dict[float, list[float]]:
    """Spike counts per level of ``column`` in the rows where the ``fixed`` columns have the given values."""
    return _values(rows, column, "spikes", **fixed)


def _values(rows: Rows, column: str, measured: str, **fixed: Any) -> dict[float, list[float]]:
    """The ``measured`` column per level of another, in the rows where the ``fixed`` columns have the given values."""
    chosen = paper_trials(rows, **fixed)
    levels = sorted({row[column] for row in chosen})
    return {level: [row[measured] for row in chosen if row[column] == level] for level in levels}


def _means(groups: ByLevel) -> dict[float, float]:
    return {level: float(np.mean(spikes)) for level, spikes in groups.items()}


def _listed(groups: ByLevel, unit: str) -> str:
    """Mean spikes of each group with its 95 % interval, and how many trials each mean is of."""
    said = [f"{level:g} {unit}: {_mean(spikes)}" for level, spikes in groups.items()]
    counts = sorted({len(spikes) for spikes in groups.values()})
    return f"mean spikes at {', '.join(said)} (n = {'..'.join(map(str, counts))} each)"


def _mean(values: Sequence[float], digits: int = 1) -> str:
    """A mean with its 95 % interval, if there is one."""
    summary = summarise(values)
    low, high = f"{summary.ci_low:.{digits}f}", f"{summary.ci_high:.{digits}f}"
    return f"{summary.mean:.{digits}f}" + (f" [{low}, {high}]" if is_number(summary.ci_low) else "")
