"""The paper's claims about the robot, C13 to C21, C24, C25 and C29 to C31. Their words are in ``claims.toml``.

The docstring of a judge says how the words are read where they leave room.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from itertools import pairwise

import numpy as np

from experiments.bench.sources import judging
from experiments.bench.sources.judging import (
    ACROSS,
    ANGLES,
    CONNECTIONS,
    DEPTH,
    DSNN,
    FALLING,
    FIXED,
    PER_CORRELATOR,
    POTENTIAL,
    ROBOT_SPEEDS,
    WIDER,
    Row,
    Rows,
    by_level,
    common_speeds,
    crossings,
    fewest_ahead,
    higher,
    mean_text,
    means,
    means_text,
    more_on_one_side,
    more_spikes,
    of_pairs,
    outcome_of,
    paired_text,
    paper_trials,
)
from experiments.bench.sources.robot_claims import RobotClaim
from experiments.bench.stats.checks import Check, exceeds
from experiments.bench.stats.claim import shipped
from experiments.bench.stats.tests import contrast, proportion_interval, trend
from experiments.bench.stats.verdict import Outcome

claim = partial(shipped, RobotClaim)


@claim(
    "C13",
    motions=DEPTH,
    reads=("spikes", "peak_hs", "trough_hs"),
    of_every_trial=True,
    pools=("general", "angular-approach", "angular-recession"),
    silent_passes=True,
)
def c13(rows: Rows, threshold: float) -> Outcome:
    """Judge motion along the optical axis, at any speed: every such trial of a replicate, of all its experiments.

    Of motions without a spike, the higher potential decides.
    """
    kinds = {kind: paper_trials(rows, motion=kind, angle_deg=0.0) for kind in DEPTH}
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


@claim("C14", motions=ACROSS, reads=("peak_hs", "trough_hs"), of_every_trial=True)
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


@claim("C15", motions=ACROSS)
def c15(rows: Rows, threshold: float) -> Outcome:
    """Judge rightward crossings, as in the paper, at the paper's four speeds; at all from 2 to 10 cm/s C31 does."""
    groups = by_level(rows, "speed_cm_s", motion="translation", distance_cm=8.0, direction="rightward")
    if not {2.0, 4.0, 6.0, 10.0} <= groups.keys():
        return Outcome.unjudged("needs rightward translations at 8 cm, 2, 4, 6 and 10 cm/s")
    mean = means(groups)
    checks = [more_spikes(mean, more, less, "cm/s") for more, less in PAIRS]
    rise = trend([(speed, groups[speed]) for speed in (2.0, 4.0, 6.0)])
    effect = f"2 to 6 cm/s: {rise}; 10 against 6: {contrast(groups[10.0], groups[6.0])}"
    return outcome_of(checks, groups, f"rightward at 8 cm: {means_text(groups, 'cm/s')}", effect)


@claim("C16", motions=ACROSS)
def c16(rows: Rows, threshold: float) -> Outcome:
    """Judge rightward crossings, as in the paper."""
    groups = by_level(rows, "distance_cm", motion="translation", speed_cm_s=6.0, direction="rightward")
    if not {5.0, 10.0, 15.0} <= groups.keys():
        return Outcome.unjudged("needs rightward translations at 6 cm/s, 5, 10 and 15 cm")
    mean = means(groups)
    half = mean[5.0] / 2
    text, asks = f"{mean[15.0]:.1f} spikes at 15 cm", f"at most half of those at 5: {half:.1f}"
    checks = [
        more_spikes(mean, 5.0, 10.0, "cm"),
        more_spikes(mean, 10.0, 15.0, "cm"),
        Check(text, mean[15.0], half, "at most", unit="spikes", asks=asks),
    ]
    effect = str(trend([(d, groups[d]) for d in (5.0, 10.0, 15.0)]))
    return outcome_of(checks, groups, f"rightward at 6 cm/s: {means_text(groups, 'cm')}", effect)


@claim("C17", motions=("approach",))
def c17(rows: Rows, threshold: float) -> Outcome:
    """Judge at every speed shown."""
    return fewest_ahead(rows, "approach")


@claim("C18", motions=("approach",))
def c18(rows: Rows, threshold: float) -> Outcome:
    """Judge at every speed shown, at 15 and 30 degrees together."""
    return more_on_one_side(rows, "approach", more=-1.0, name="from the left against from the right")


@claim("C19", motions=("recession",))
def c19(rows: Rows, threshold: float) -> Outcome:
    """Judge at every speed shown."""
    return fewest_ahead(rows, "recession")


@claim("C20", motions=("recession",))
def c20(rows: Rows, threshold: float) -> Outcome:
    """Judge at every speed shown, at 15 and 30 degrees together."""
    return more_on_one_side(rows, "recession", more=1.0, name="to the right against to the left")


@claim("C21", about="looming", motions=("approach",))
def c21(rows: Rows, threshold: float) -> Outcome:
    """Judge at every speed shown: more spikes at 0 degrees than at any other angle."""
    return of_pairs(rows, "approach", [(0.0, angle) for angle in ANGLES if angle])


FEWER = (CONNECTIONS[1], CONNECTIONS[2])
"""The DSNN with smaller ensembles, of one and of two connected cells."""
MEANS = {CONNECTIONS[n]: PER_CORRELATOR[n] for n in (1, 2)}
"""The same as means per correlator, beside the sums."""


@claim("C24", motions=ACROSS, reads=("peak_hs",), models={DSNN, *FEWER}, equal_terms=MEANS)
def c24(rows: Rows, threshold: float) -> Outcome:
    """Judge the robot's part: every speed shown counts, not the paper's alone. Of a speed, the mean peak over trials.

    The peak passes T at a speed if its mean does.
    """
    curves = {n: crossings(rows, CONNECTIONS[n], "peak_hs") for n in (1, 2, 8)}
    if not set(ROBOT_SPEEDS) <= set(common_speeds(curves)):
        return Outcome.unjudged("needs rightward translations at 8 cm, 2, 4, 6 and 10 cm/s")
    means = {n: {speed: judging.mean(curves[n][speed]) for speed in common_speeds(curves)} for n in curves}
    past = {n: sum(peak > threshold for peak in mean.values()) for n, mean in means.items()}
    checks = [
        higher(means[8][speed], "N_con = 8", means[n][speed], f"N_con = {n}", speed, "peak HS")
        for n in (1, 2)
        for speed in means[8]
    ]
    for n in (1, 2):
        text = f"N_con = 8 passes T = {threshold:g} at {past[8]} of {len(means[8])} speeds"
        asks = f"more than N_con = {n}: {past[n]}"
        checks.append(Check(text, float(past[8]), float(past[n]), unit="speeds", asks=asks))
    texts = "; ".join(f"N_con = {n}: {judging.potentials_text(mean)}, past T at {past[n]}" for n, mean in means.items())
    effect = "; ".join(f"N_con = 8 against {n}: {paired_text(curves[8], curves[n])}" for n in (1, 2))
    return judging.outcome_of_curves(checks, curves, f"robot, rightward at 8 cm, mean peak HS: {texts}", effect)


DELAY_SPEEDS = (4.0, 6.0, 8.0, 10.0)


@claim("C25", motions=ACROSS, reads=(POTENTIAL,), models={DSNN, FALLING, *FIXED.values()})
def c25(rows: Rows, threshold: float) -> Outcome:
    """Judge mean HS over the frames near the axis. The delays of the DSNN as it is rise with spacing.

    Delays that fall with spacing are the other reading; their numbers stand beside and decide nothing.
    """
    curves = {label: crossings(rows, label, POTENTIAL) for label in (DSNN, FALLING, *FIXED.values())}
    if not set(DELAY_SPEEDS) <= set(common_speeds(curves)):
        return Outcome.unjudged("needs rightward translations at 8 cm, 4, 6, 8 and 10 cm/s")
    named = {label: {speed: curve[speed] for speed in DELAY_SPEEDS} for label, curve in curves.items()}
    means = {label: {speed: judging.mean(values) for speed, values in curve.items()} for label, curve in named.items()}
    checks = [
        higher(means[DSNN][speed], "rising delays", means[label][speed], f"{delay} ms", speed, "mean HS")
        for delay, label in FIXED.items()
        for speed in DELAY_SPEEDS
    ]
    won = sum(check.passes for check in checks)
    labels = {"rising 10..200 ms": DSNN, **{f"{delay} ms": label for delay, label in FIXED.items()}}
    texts = "; ".join(f"{name}: {judging.potentials_text(means[label])}" for name, label in labels.items())
    other = f"the other reading, falling 200..10 ms: {judging.potentials_text(means[FALLING])}"
    effect = "; ".join(
        f"against {delay} ms: {paired_text(named[DSNN], named[label])}" for delay, label in FIXED.items()
    )
    measured = (
        f"higher in {won} of {len(checks)} comparisons; rightward at 8 cm, mean HS near the axis, {texts}; {other}"
    )
    return judging.outcome_of_curves(checks, named, measured, effect)


COLUMNS = ("spikes_in_window", "spikes_in_inner_window", "mean_hs_near_axis")
"""The two windows that it is judged by, and the potential, which stands beside."""


@claim("C29", motions=ACROSS, reads=COLUMNS)
def c29(rows: Rows, threshold: float) -> Outcome:
    """Judge C15 without the time in view, at the paper's speeds alone.

    The fastest crossing is the paper's, at 10 cm/s. Its length is read both ways: from the first edge in view to the
    last edge out, and from centre in to centre out. The claim holds if it does in both windows, so that what happens
    at the edge of the view decides nothing. The potential stands beside.
    """
    fixed = {"motion": "translation", "distance_cm": 8.0, "direction": "rightward"}
    groups, inner, potential = (by_level(rows, "speed_cm_s", column, **fixed) for column in COLUMNS)
    if not {2.0, 4.0, 6.0, 10.0} <= groups.keys():
        return Outcome.unjudged("needs rightward translations at 8 cm, 2, 4, 6 and 10 cm/s")
    parts, effects = [], []
    checks: list[Check] = []
    for name, counts in (("edge to edge", groups), ("centre to centre", inner)):
        mean = means(counts)
        steps = [more_spikes(mean, more, less, "cm/s") for more, less in ((4.0, 2.0), (6.0, 4.0), (6.0, 10.0))]
        checks += [replace(check, says=f"window from {name}: {check.says}") for check in steps]
        parts.append(f"window from {name}: {means_text(counts, 'cm/s')}")
        effects.append(f"{name}, 10 against 6 cm/s: {contrast(counts[10.0], counts[6.0])}")
    why = ", ".join(f"{speed:g} cm/s: {mean_text(values, 2)}" for speed, values in potential.items())
    measured = f"rightward at 8 cm, {'; '.join(parts)}; mean HS near the axis at {why}"
    named = {speed: groups[speed] for speed in (2.0, 4.0, 6.0, 10.0)}
    return outcome_of(checks, named, measured, "; ".join(effects))


USUAL = "d = 1, N_con = 8"
"""The DSNN as it is."""


@claim("C30", motions=ACROSS, reads=(POTENTIAL,), models={WIDER, *CONNECTIONS.values()})
def c30(rows: Rows, threshold: float) -> Outcome:
    """Judge the speed, of all those shown, at which mean HS near the axis is largest.

    It moves with d if it is another at d = 2 than at d = 1. It moves with N_con if over N_con = 1, 2, 4, 8 it goes
    one way, up or down, and ends elsewhere than it began. The paper's text gives neither a direction nor an amount.
    Of two speeds each has to be that of a larger potential in its own case, by the margin of potentials.
    """
    labels = {USUAL: DSNN, "d = 2": WIDER, **{f"N_con = {n}": CONNECTIONS[n] for n in (1, 2, 4)}}
    curves = {name: crossings(rows, label, POTENTIAL) for name, label in labels.items()}
    speeds = common_speeds(curves)
    if not set(ROBOT_SPEEDS) < set(speeds):
        return Outcome.unjudged("needs rightward translations at 8 cm, 2, 4, 6, 10 cm/s and others")
    means = {name: {speed: judging.mean(curve[speed]) for speed in speeds} for name, curve in curves.items()}
    top = {name: judging.peak(mean).speed for name, mean in means.items()}
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
    measured = f"rightward at 8 cm, {', '.join(f'{speed:g}' for speed in speeds)} cm/s, mean HS near the axis, {texts}"
    return judging.outcome_of_curves(checks, curves, measured, "")


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


@claim("C31", motions=ACROSS)
def c31(rows: Rows, threshold: float) -> Outcome:
    """Judge rightward crossings, as in the paper: the most spikes near the peak against those at every other speed."""
    groups = by_level(rows, "speed_cm_s", motion="translation", distance_cm=8.0, direction="rightward")
    if not set(EVERY_SPEED) <= groups.keys():
        return Outcome.unjudged("needs rightward translations at 8 cm, at 2 to 10 cm/s in steps of 1")
    named = {speed: groups[speed] for speed in EVERY_SPEED}
    mean = means(named)
    top = max(NEAR, key=lambda speed: mean[speed])
    others = [speed for speed in EVERY_SPEED if speed not in NEAR]
    checks = [more_spikes(mean, top, speed, "cm/s") for speed in others]
    second = max(others, key=lambda speed: mean[speed])
    effect = f"{top:g} against {second:g} cm/s: {contrast(named[top], named[second])}"
    return outcome_of(checks, named, f"rightward at 8 cm: {means_text(named, 'cm/s')}", effect)
