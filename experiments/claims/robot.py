"""The paper's claims about the robot, C13 to C21, C24, C25 and C29 to C31. Their words are in ``claims.toml``.

A judge tests its claim on every condition that the words cover among the trials it is given. Its docstring says how the
words are read where they leave room.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np

from experiments.bench.sources.judge import Row, Rows, paper_trials
from experiments.bench.stats.checks import Check, exceeds, is_number
from experiments.bench.stats.claim import DSNN
from experiments.bench.stats.claim import shipped as claim
from experiments.bench.stats.tests import contrast, paired, proportion_interval, summarise, trend
from experiments.bench.stats.verdict import Outcome

ByLevel = Mapping[float, Sequence[float]]
"""Level of a condition -> a value of each of its trials."""
Curve = Mapping[float, Mapping[int, float]]
"""Speed, cm/s -> trial -> its value."""

ACROSS = {"motion": ("translation",)}
APPROACH = {"motion": ("approach",)}
RECESSION = {"motion": ("recession",)}
DEPTH = {"motion": ("approach", "recession")}
"""Conditions: crossings of the view, and motions along a line to the camera."""
ANGLES = (-30.0, -15.0, 0.0, 15.0, 30.0)
"""Of the paper's angular tests, degrees."""
ROBOT_SPEEDS = (2.0, 4.0, 6.0, 10.0)
"""Those of the paper's robot tests."""
POTENTIAL = "mean_hs_near_axis"
"""The column of mean HS near the axis, which is the same stretch of path at every speed."""

CONNECTIONS = {1: "dsnn:n_con=1", 2: "dsnn:n_con=2", 4: "dsnn:n_con=4", 8: DSNN}
"""N_con -> label."""
FIXED = {delay: f"dsnn:tau_s={delay},{delay}" for delay in (10, 50, 100, 200)}
"""The one delay of all pairs, ms -> label."""
FALLING = "dsnn:tau_s=200,10"
"""Delays that fall with spacing: the other reading of "a linearly decaying function"."""
WIDER = "dsnn:d=2"
"""Twice the sampling distance."""
PER_CORRELATOR = {n: f"{CONNECTIONS[n]},k_sig={0.01 * n / 8:g}" for n in (1, 2)}
"""N_con -> label of fewer connections read as means per correlator, beside the eight of the DSNN: a sum over n counts
8 / n times, ahead of the sigmoid."""
VARIANTS = (*(CONNECTIONS[n] for n in (1, 2, 4)), WIDER, *FIXED.values(), FALLING, *PER_CORRELATOR.values())
"""Every variant that a claim names, to be shown beside the DSNN."""


# --- what judges share ------------------------------------------------------------------------------------------------


def by_level(rows: Rows, column: str, measured: str = "spikes", **fixed: Any) -> dict[float, list[float]]:
    """Return level of a ``column`` -> what was ``measured`` in each of the paper's trials with the ``fixed`` values."""
    trials = paper_trials(rows, **fixed)
    levels = sorted({row[column] for row in trials})
    return {level: [row[measured] for row in trials if row[column] == level] for level in levels}


def at_8_cm(rows: Rows, measured: str = "spikes") -> dict[float, list[float]]:
    """Return speed -> what was ``measured`` in each rightward crossing at 8 cm, as the paper's are."""
    return by_level(rows, "speed_cm_s", measured, motion="translation", distance_cm=8.0, direction="rightward")


def crossings_needed(speeds: Iterable[float]) -> Outcome:
    """Return the outcome of a claim about crossings at 8 cm that were not shown at all of these speeds."""
    return Outcome.unjudged(f"needs rightward translations at 8 cm, {', '.join(f'{speed:g}' for speed in speeds)} cm/s")


def means(groups: ByLevel) -> dict[float, float]:
    """Return level -> mean."""
    return {level: float(np.mean(values)) for level, values in groups.items()}


def mean_text(values: Sequence[float], digits: int = 1, lowest: float = -math.inf) -> str:
    """Return a mean with its 95 % interval, if there is one, in words; it does not go below ``lowest``."""
    summary = summarise(values, lowest)
    low, high = f"{summary.ci_low:.{digits}f}", f"{summary.ci_high:.{digits}f}"
    return f"{summary.mean:.{digits}f}" + (f" [{low}, {high}]" if is_number(summary.ci_low) else "")


def means_text(groups: ByLevel, unit: str) -> str:
    """Return mean spikes of each group with its 95 % interval, and how many trials each mean is of, in words."""
    texts = [f"{level:g} {unit}: {mean_text(spikes, lowest=0.0)}" for level, spikes in groups.items()]
    counts = sorted({len(spikes) for spikes in groups.values()})
    return f"mean spikes at {', '.join(texts)} (n = {'..'.join(map(str, counts))} each)"


def more_spikes(mean: Mapping[float, float], pairs: Iterable[tuple[float, float]], unit: str) -> list[Check]:
    """Return the checks that mean spikes at the first level of each pair are above those at the second."""
    return [
        exceeds(f"{mean[more]:.1f} spikes at {more:g} {unit}", mean[more], mean[less], f"at {less:g}", "spikes")
        for more, less in pairs
    ]


def outcome_of(checks: Sequence[Check], groups: Mapping[Any, Sequence[float]], measured: str, effect: str) -> Outcome:
    """Return the outcome of checks on ``groups``, a value of each trial by condition."""
    counts = [len(values) for values in groups.values()]
    return Outcome.of(checks, measured, effect, sum(counts), min(counts))


def at_every_speed(
    rows: Rows, motion: str, checks: Callable[[ByLevel], list[Check]], effect: Callable[[ByLevel], str]
) -> Outcome:
    """Return the outcome of ``checks`` at each speed at which the motion was shown along all `ANGLES`."""
    speeds = sorted({row["speed_cm_s"] for row in paper_trials(rows, motion=motion)})
    by_speed = {speed: by_level(rows, "angle_deg", motion=motion, speed_cm_s=speed) for speed in speeds}
    whole = {
        speed: {a: groups[a] for a in ANGLES} for speed, groups in by_speed.items() if set(ANGLES) <= groups.keys()
    }
    if not whole:
        return Outcome.unjudged(f"needs {motion} at -30, -15, 0, 15 and 30 degrees")
    every, measured, effects = [], [], []
    conditions: dict[str, Sequence[float]] = {}
    for speed, groups in whole.items():
        which = f"{speed:g} cm/s: " if len(whole) > 1 else ""
        every += [replace(check, says=f"{which}{check.says}") for check in checks(groups)]
        measured.append(f"{which}{means_text(groups, 'degrees')}")
        effects.append(f"{which}{effect(groups)}")
        conditions |= {f"{which}{angle}": spikes for angle, spikes in groups.items()}
    return outcome_of(every, conditions, "; ".join(measured), "; ".join(effects))


def of_pairs(rows: Rows, motion: str, pairs: Sequence[tuple[float, float]]) -> Outcome:
    """Return the outcome of more spikes at the first angle of each pair than at the second, at every speed shown."""

    def effect(groups: ByLevel) -> str:
        return f"against |angle|: {trend([(abs(angle), groups[angle]) for angle in sorted(groups, key=abs)])}"

    return at_every_speed(rows, motion, lambda groups: more_spikes(means(groups), pairs, "degrees"), effect)


FEWEST_AHEAD = (*((angle, 0.0) for angle in ANGLES if angle), (-30.0, -15.0), (30.0, 15.0))
"""Pairs of angles: fewest spikes at 0 degrees, and more at 30 than at 15 on each side."""


def more_on_one_side(rows: Rows, motion: str, more: float, name: str) -> Outcome:
    """Return the outcome of more spikes on the side of the sign ``more``, at 15 and 30 degrees together."""

    def split(groups: ByLevel) -> tuple[list[float], list[float]]:
        here, there = ([n for a in (15.0, 30.0) for n in groups[side * a]] for side in (more, -more))
        return here, there

    def checks(groups: ByLevel) -> list[Check]:
        here, there = (float(np.mean(side)) for side in split(groups))
        return [exceeds(f"{name}: {here:.1f} spikes a trial", here, there, "on the other side", "spikes")]

    def effect(groups: ByLevel) -> str:
        here, there = split(groups)
        here_text, there_text = mean_text(here, lowest=0.0), mean_text(there, lowest=0.0)
        return f"{name}: {here_text} and {there_text} spikes a trial, {contrast(here, there)}"

    return at_every_speed(rows, motion, checks, effect)


class Curves(dict[str, Curve]):
    """Values of a column in rightward crossings at 8 cm: name of a model -> speed -> trial -> value."""

    def __init__(self, rows: Rows, labels: Mapping[str, str], column: str) -> None:
        trials = paper_trials(rows, motion="translation", direction="rightward", distance_cm=8.0)
        for name, label in labels.items():
            values: dict[float, dict[int, float]] = {}
            for row in (row for row in trials if row["model"] == label):
                values.setdefault(row["speed_cm_s"], {})[row["trial"]] = float(row[column])
            self[name] = values
        self.speeds = sorted(set.intersection(*map(set, self.values())))
        """The speeds at which every model has a value."""

    def only(self, speeds: Sequence[float]) -> dict[str, dict[float, float]]:
        """Keep these speeds, and return the means over trials: name -> speed -> mean."""
        for name, curve in self.items():
            self[name] = {speed: curve[speed] for speed in speeds}
        self.speeds = list(speeds)
        return {name: {s: float(np.mean(list(curve[s].values()))) for s in speeds} for name, curve in self.items()}

    def paired(self, first: str, second: str) -> str:
        """Return a paired test over all speeds, in words: the models saw the same frames."""
        pairs = [(value, self[second][speed][trial]) for speed in self.speeds
                 for trial, value in self[first][speed].items() if trial in self[second][speed]]  # fmt: skip
        return str(paired([a for a, _ in pairs], [b for _, b in pairs]))

    def outcome(self, checks: Sequence[Check], measured: str, effect: str) -> Outcome:
        """Return the outcome; n counts the trials in which any of the models was judged, once each."""
        trials = [curve[speed] for curve in self.values() for speed in self.speeds]
        n, fewest = len({trial for values in trials for trial in values}), min(map(len, trials))
        return Outcome.of(checks, measured, effect, n, fewest)


def higher(mean: Mapping[str, Mapping[float, float]], one: str, others: Iterable[str], what: str) -> list[Check]:
    """Return the checks that a mean potential of ``one`` is above that of each of the ``others`` at every speed."""
    return [
        exceeds(f"{what} of {one} {value:.3f} at {speed:g} cm/s", value, mean[other][speed], f"of {other}", "potential")
        for other in others
        for speed, value in mean[one].items()
    ]


def potentials_text(mean: Mapping[str, Mapping[float, float]]) -> str:
    """Return mean potentials by name and speed, in words."""
    return "; ".join(
        f"{name}: {', '.join(f'{value:.2f} at {speed:g}' for speed, value in curve.items())} cm/s"
        for name, curve in mean.items()
    )


# --- the judges -------------------------------------------------------------------------------------------------------


@claim(
    "C13",
    conditions=DEPTH,
    reads=("spikes", "peak_hs", "trough_hs"),
    of_each=True,
    pools=("general", "angular-approach", "angular-recession"),
    silent_passes=True,
)
def c13(rows: Rows, threshold: float) -> Outcome:
    """Judge motion along the optical axis, at any speed: every such trial of a replicate, of all its experiments.

    Of motions without a spike, the higher potential decides.
    """
    kinds = {kind: paper_trials(rows, motion=kind, angle_deg=0.0) for kind in DEPTH["motion"]}
    tested = {kind: trials for kind, trials in kinds.items() if trials}
    if not tested:
        return Outcome.unjudged("needs straight approach and recession")
    parts = []
    checks: list[tuple[float, Check]] = []
    for kind, trials in tested.items():
        firing = sum(row["spikes"] > 0 for row in trials)
        peak = max(max(row["peak_hs"], -row["trough_hs"]) for row in trials)
        share = "[{:.0%}, {:.0%}]".format(*proportion_interval(firing, len(trials)))
        parts.append(f"{kind}: spikes in {firing} of {len(trials)} trials {share}, |HS| up to {peak:.2f}")
        text = f"{kind}: spikes in {firing} of {len(trials)} trials"
        checks.append((peak, Check(text, float(firing), 0.0, "at most", unit="trials", asks="0")))
    spikes = {kind: [row["spikes"] for row in trials] for kind, trials in tested.items()}
    counts = [count for of_kind in spikes.values() for count in of_kind]
    measured = f"{'; '.join(parts)} (T = {threshold:g})"
    highest_first = [check for _, check in sorted(checks, key=lambda pair: -pair[0])]
    outcome = outcome_of(highest_first, spikes, measured, f"{mean_text(counts, lowest=0.0)} spikes a trial")
    outcome = replace(outcome, broken=sum(count > 0 for count in counts))
    if outcome.verdict == "holds" and len(tested) < len(kinds):
        return outcome.withheld("the other motion was not run")
    return outcome


WAYS = {1.0: "rightward", -1.0: "leftward"}
"""Sign of HS -> direction of the motion."""


@claim("C14", conditions=ACROSS, reads=("peak_hs", "trough_hs"), of_each=True)
def c14(rows: Rows, threshold: float) -> Outcome:
    """Judge every crossing of the trials given, at whatever speed and distance.

    A trial passes if HS goes past the threshold of its own direction and not past that of the other: a potential
    that passes both tells no direction.
    """
    crossings = paper_trials(rows, motion="translation")
    ways = {sign: [row for row in crossings if row["direction"] == way] for sign, way in WAYS.items()}
    tested = {sign: trials for sign, trials in ways.items() if trials}
    if not tested:
        return Outcome.unjudged("needs translations")
    parts, checks = [], []
    conditions: dict[str, list[float]] = {}
    for sign, trials in tested.items():
        right, wrong = ([_reached(row, end * sign) for row in trials] for end in (1.0, -1.0))
        weak, stray = trials[int(np.argmin(right))], trials[int(np.argmax(wrong))]
        reaches = f"HS reaches {sign * min(right):+.3f} at {_where(weak)}"
        strays = f"the other way it reaches {-sign * max(wrong):+.3f} at {_where(stray)}"
        way, mean = WAYS[sign], mean_text([sign * value for value in right], 2)
        parts.append(f"{way}, worst of {len(trials)}: {reaches}, mean {mean}; {strays}")
        passes, strays_not = f"to pass {sign * threshold:+g}", f"not to pass {-sign * threshold:+g}"
        checks += [
            Check(f"{way}: {reaches}", min(right), threshold, asks=passes),
            Check(f"{way}: {strays}", max(wrong), threshold, "at most", asks=strays_not),
        ]
        for row, value in zip(trials, right, strict=True):
            conditions.setdefault(f"{way}, {_where(row)}", []).append(value)
    good = sum(
        _reached(row, sign) > threshold and _reached(row, -sign) <= threshold for sign in tested for row in tested[sign]
    )
    effect = f"{good} of {sum(map(len, tested.values()))} trials pass"
    outcome = outcome_of(checks, conditions, f"{'; '.join(parts)} (T = {threshold:g})", effect)
    outcome = replace(outcome, broken=outcome.n - good)
    if outcome.verdict == "holds" and len(tested) < len(ways):
        return outcome.withheld("the other direction was not run")
    return outcome


def _reached(row: Row, sign: float) -> float:
    """Return how far HS goes from 0 to the side of ``sign``."""
    return float(row["peak_hs"] if sign > 0 else -row["trough_hs"])


def _where(row: Row) -> str:
    return f"{row['speed_cm_s']:g} cm/s, {row['distance_cm']:g} cm"


PAIRS = ((4.0, 2.0), (6.0, 4.0), (6.0, 10.0))
"""Speeds in cm/s: more spikes are asked for at the first than at the second."""


PAIRS = ((4.0, 2.0), (6.0, 4.0), (6.0, 10.0))
"""Speeds in cm/s: more spikes are asked for at the first than at the second."""


@claim("C15", conditions=ACROSS)
def c15(rows: Rows, threshold: float) -> Outcome:
    """Judge rightward crossings, as in the paper, at the paper's four speeds; at all from 2 to 10 cm/s C31 does."""
    groups = at_8_cm(rows)
    if not set(ROBOT_SPEEDS) <= groups.keys():
        return crossings_needed(ROBOT_SPEEDS)
    rise = trend([(speed, groups[speed]) for speed in (2.0, 4.0, 6.0)])
    effect = f"2 to 6 cm/s: {rise}; 10 against 6: {contrast(groups[10.0], groups[6.0])}"
    checks = more_spikes(means(groups), PAIRS, "cm/s")
    return outcome_of(checks, groups, f"rightward at 8 cm: {means_text(groups, 'cm/s')}", effect)


@claim("C16", conditions=ACROSS)
def c16(rows: Rows, threshold: float) -> Outcome:
    """Judge rightward crossings, as in the paper."""
    groups = by_level(rows, "distance_cm", motion="translation", speed_cm_s=6.0, direction="rightward")
    if not {5.0, 10.0, 15.0} <= groups.keys():
        return Outcome.unjudged("needs rightward translations at 6 cm/s, 5, 10 and 15 cm")
    mean = means(groups)
    half = mean[5.0] / 2
    text, asks = f"{mean[15.0]:.1f} spikes at 15 cm", f"at most half of those at 5: {half:.1f}"
    checks = [
        *more_spikes(mean, ((5.0, 10.0), (10.0, 15.0)), "cm"),
        Check(text, mean[15.0], half, "at most", unit="spikes", asks=asks),
    ]
    effect = str(trend([(d, groups[d]) for d in (5.0, 10.0, 15.0)]))
    return outcome_of(checks, groups, f"rightward at 6 cm/s: {means_text(groups, 'cm')}", effect)


@claim("C17", conditions=APPROACH)
def c17(rows: Rows, threshold: float) -> Outcome:
    """Judge at every speed shown."""
    return of_pairs(rows, "approach", FEWEST_AHEAD)


@claim("C18", conditions=APPROACH)
def c18(rows: Rows, threshold: float) -> Outcome:
    """Judge at every speed shown, at 15 and 30 degrees together."""
    return more_on_one_side(rows, "approach", more=-1.0, name="from the left against from the right")


@claim("C19", conditions=RECESSION)
def c19(rows: Rows, threshold: float) -> Outcome:
    """Judge at every speed shown."""
    return of_pairs(rows, "recession", FEWEST_AHEAD)


@claim("C20", conditions=RECESSION)
def c20(rows: Rows, threshold: float) -> Outcome:
    """Judge at every speed shown, at 15 and 30 degrees together."""
    return more_on_one_side(rows, "recession", more=1.0, name="to the right against to the left")


@claim("C21", about="looming", conditions=APPROACH)
def c21(rows: Rows, threshold: float) -> Outcome:
    """Judge at every speed shown: more spikes at 0 degrees than at any other angle."""
    return of_pairs(rows, "approach", [(0.0, angle) for angle in ANGLES if angle])


FEWER = (CONNECTIONS[1], CONNECTIONS[2])
"""The DSNN with smaller ensembles, of one and of two connected cells."""
MEANS = {CONNECTIONS[n]: PER_CORRELATOR[n] for n in (1, 2)}
"""The same as means per correlator, beside the sums."""


@claim("C24", conditions=ACROSS, reads=("peak_hs",), models={DSNN, *FEWER}, equal_terms=MEANS)
def c24(rows: Rows, threshold: float) -> Outcome:
    """Judge the robot's part: every speed shown counts, not the paper's alone. Of a speed, the mean peak over trials.

    The peak passes T at a speed if its mean does.
    """
    curves = Curves(rows, {f"N_con = {n}": CONNECTIONS[n] for n in (1, 2, 8)}, "peak_hs")
    if not set(ROBOT_SPEEDS) <= set(curves.speeds):
        return crossings_needed(ROBOT_SPEEDS)
    *fewer, usual = curves
    mean = curves.only(curves.speeds)
    past = {name: sum(peak > threshold for peak in curve.values()) for name, curve in mean.items()}
    text = f"{usual} passes T = {threshold:g} at {past[usual]} of {len(mean[usual])} speeds"
    checks = higher(mean, usual, fewer, "peak HS")
    checks += [
        Check(text, float(past[usual]), float(past[n]), unit="speeds", asks=f"more than {n}: {past[n]}") for n in fewer
    ]
    effect = "; ".join(f"{usual} against {n}: {curves.paired(usual, n)}" for n in fewer)
    passing = ", ".join(f"{number} of {name}" for name, number in past.items())
    measured = f"robot, rightward at 8 cm, mean peak HS: {potentials_text(mean)}; past T at {passing}"
    return curves.outcome(checks, measured, effect)


DELAY_SPEEDS = (4.0, 6.0, 8.0, 10.0)


@claim("C25", conditions=ACROSS, reads=(POTENTIAL,), models={DSNN, FALLING, *FIXED.values()})
def c25(rows: Rows, threshold: float) -> Outcome:
    """Judge mean HS over the frames near the axis. The delays of the DSNN as it is rise with spacing.

    Delays that fall with spacing are the other reading; their numbers stand beside and decide nothing.
    """
    rising, falling = "rising delays", "falling delays, the other reading"
    fixed = {f"{delay} ms": label for delay, label in FIXED.items()}
    curves = Curves(rows, {rising: DSNN, **fixed, falling: FALLING}, POTENTIAL)
    if not set(DELAY_SPEEDS) <= set(curves.speeds):
        return crossings_needed(DELAY_SPEEDS)
    mean = curves.only(DELAY_SPEEDS)
    checks = higher(mean, rising, fixed, "mean HS")
    won = sum(check.passes for check in checks)
    effect = "; ".join(f"against {delay}: {curves.paired(rising, delay)}" for delay in fixed)
    where = f"higher in {won} of {len(checks)} comparisons; rightward at 8 cm, mean HS near the axis"
    return curves.outcome(checks, f"{where}, {potentials_text(mean)}", effect)


COLUMNS = ("spikes_in_window", "spikes_in_inner_window", "mean_hs_near_axis")
"""The two windows that it is judged by, and the potential, which stands beside."""


@claim("C29", conditions=ACROSS, reads=COLUMNS)
def c29(rows: Rows, threshold: float) -> Outcome:
    """Judge C15 without the time in view, at the paper's speeds alone.

    The fastest crossing is the paper's, at 10 cm/s. Its length is read both ways: from the first edge in view to the
    last edge out, and from centre in to centre out. The claim holds if it does in both windows, so that what happens
    at the edge of the view decides nothing. The potential stands beside.
    """
    groups, inner, potential = (at_8_cm(rows, column) for column in COLUMNS)
    if not set(ROBOT_SPEEDS) <= groups.keys():
        return crossings_needed(ROBOT_SPEEDS)
    parts, effects = [], []
    checks: list[Check] = []
    for name, counts in (("edge to edge", groups), ("centre to centre", inner)):
        steps = more_spikes(means(counts), PAIRS, "cm/s")
        checks += [replace(check, says=f"window from {name}: {check.says}") for check in steps]
        parts.append(f"window from {name}: {means_text(counts, 'cm/s')}")
        effects.append(f"{name}, 10 against 6 cm/s: {contrast(counts[10.0], counts[6.0])}")
    why = ", ".join(f"{speed:g} cm/s: {mean_text(values, 2)}" for speed, values in potential.items())
    measured = f"rightward at 8 cm, {'; '.join(parts)}; mean HS near the axis at {why}"
    return outcome_of(checks, {speed: groups[speed] for speed in ROBOT_SPEEDS}, measured, "; ".join(effects))


USUAL = "d = 1, N_con = 8"
"""The DSNN as it is."""


@claim("C30", conditions=ACROSS, reads=(POTENTIAL,), models={WIDER, *CONNECTIONS.values()})
def c30(rows: Rows, threshold: float) -> Outcome:
    """Judge the speed, of all those shown, at which mean HS near the axis is largest.

    It moves with d if it is another at d = 2 than at d = 1. It moves with N_con if over N_con = 1, 2, 4, 8 it goes
    one way, up or down, and ends elsewhere than it began. The paper's text gives neither a direction nor an amount.
    Of two speeds each has to be that of a larger potential in its own case, by the margin of potentials.
    """
    labels = {USUAL: DSNN, "d = 2": WIDER, **{f"N_con = {n}": CONNECTIONS[n] for n in (1, 2, 4)}}
    curves = Curves(rows, labels, POTENTIAL)
    if not set(ROBOT_SPEEDS) < set(curves.speeds):
        return crossings_needed(ROBOT_SPEEDS).noting(["and at others"])
    means = curves.only(curves.speeds)
    top = {name: max(mean, key=lambda speed: mean[speed]) for name, mean in means.items()}
    usual, wide = top[USUAL], top["d = 2"]
    over = [*(top[f"N_con = {n}"] for n in (1, 2, 4)), usual]
    steps = [after - before for before, after in pairwise(over)]
    one_way = all(step >= 0 for step in steps) or all(step <= 0 for step in steps)
    moved = abs(over[-1] - over[0]) if one_way else -min(max(steps), -min(steps))
    tops = ", ".join(f"{speed:g}" for speed in over)
    wider, connected = f"largest potential at {wide:g} cm/s at d = 2", f"largest potential at {tops} cm/s"
    checks = [
        Check(wider, abs(wide - usual), 0.0, unit="cm/s", asks=f"another than at d = 1: {usual:g}"),
        Check(f"{connected} over N_con = 1, 2, 4, 8", moved, 0.0, unit="cm/s",
              asks="to go one way, and to end elsewhere"),
        *(_leads(means, top, *pair) for pair in (("d = 2", USUAL), ("N_con = 1", USUAL)) if top[pair[0]] != usual),
    ]  # fmt: skip
    texts = "; ".join(
        f"{name}: largest at {top[name]:g} cm/s ({mean[top[name]]:.2f}), at 6 cm/s {mean[6.0]:.2f}"
        for name, mean in means.items()
    )
    measured = (
        f"rightward at 8 cm, {', '.join(f'{speed:g}' for speed in curves.speeds)} cm/s, mean HS near the axis, {texts}"
    )
    return curves.outcome(checks, measured, "")


def _leads(means: Mapping[str, Mapping[float, float]], top: Mapping[str, float], one: str, other: str) -> Check:
    """Return the check that both potentials are larger at their own speed than at the other's, the lesser lead."""
    ways = ((one, other), (other, one))
    pairs = [(means[name][top[name]], means[name][top[than]], name, than) for name, than in ways]
    value, less, name, than = min(pairs, key=lambda pair: pair[0] - pair[1])
    text = f"{name}: mean HS {value:.4f} at {top[name]:g} cm/s"
    return exceeds(text, value, less, f"at {top[than]:g}, the speed at {than}", "potential")


EVERY_SPEED = tuple(float(speed) for speed in range(2, 11))
"""Every speed that the words name, cm/s."""
NEAR = (5.0, 6.0, 7.0)
"""Where they put the peak, cm/s."""


@claim("C31", conditions=ACROSS)
def c31(rows: Rows, threshold: float) -> Outcome:
    """Judge rightward crossings, as in the paper: the most spikes near the peak against those at every other speed."""
    groups = at_8_cm(rows)
    if not set(EVERY_SPEED) <= groups.keys():
        return crossings_needed(EVERY_SPEED)
    named = {speed: groups[speed] for speed in EVERY_SPEED}
    mean = means(named)
    top = max(NEAR, key=lambda speed: mean[speed])
    others = [speed for speed in EVERY_SPEED if speed not in NEAR]
    second = max(others, key=lambda speed: mean[speed])
    checks = more_spikes(mean, [(top, speed) for speed in others], "cm/s")
    effect = f"{top:g} against {second:g} cm/s: {contrast(named[top], named[second])}"
    return outcome_of(checks, named, f"rightward at 8 cm: {means_text(named, 'cm/s')}", effect)
