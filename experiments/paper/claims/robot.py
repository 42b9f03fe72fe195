"""The paper's claims about the robot, C13 to C21, C24, C25 and C29 to C32. Their words are in ``claims.toml``.

A judge tests its claim on every condition that the words cover among the trials it is given. Its docstring says how the
words are read where they leave room.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from itertools import pairwise
from statistics import fmean
from typing import Any

from experiments.declare.claim import DSNN, shipped as claim
from experiments.declare.outcome import Check, Needs, Outcome, exceeds, is_number
from experiments.judge.judge import Row, Rows, paper_trials
from experiments.judge.tests import contrast, paired, summarise, trend
from experiments.store.tables import group

ByLevel = Mapping[float, Sequence[float]]
"""Level of a condition -> a value of each of its trials."""
Curves = Mapping[str, Mapping[float, Mapping[int, float]]]
"""Name of a model -> speed, cm/s -> trial -> its value."""

ACROSS = {"motion": ("translation",)}
APPROACH = {"motion": ("approach",)}
RECESSION = {"motion": ("recession",)}
DEPTH = {"motion": ("approach", "recession")}
"""Conditions: crossings of the view, and motions along a line to the camera."""
ANGLES = (-30.0, -15.0, 0.0, 15.0, 30.0)
"""Angles of the paper's angular tests, degrees."""
STRAIGHT = ("general", "angular-approach", "angular-recession")
"""Experiments with motions along the optical axis: those of a replicate are judged together."""
LEAST_STRAIGHT = 10
"""Trials of either motion from which nine tenths are not all of them."""
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
    return {level: fmean(values) for level, values in groups.items()}


def means_text(groups: ByLevel, unit: str) -> str:
    """Return the mean of each group with its 95 % interval, if there is one, in words."""
    texts = []
    for level, values in groups.items():
        mean = summarise(values, 0.0)
        interval = f" [{mean.low:.1f}, {mean.high:.1f}]" if is_number(mean.low) else ""
        texts.append(f"{level:g} {unit}: {mean.value:.1f}{interval}")
    return f"mean spikes at {', '.join(texts)}"


def more_spikes(mean: Mapping[float, float], pairs: Iterable[tuple[float, float]], unit: str) -> list[Check]:
    """Return the checks that mean spikes at the first level of each pair are above those at the second."""
    return [
        exceeds(f"{mean[more]:.1f} spikes at {more:g} {unit}", mean[more], mean[less], f"at {less:g}", "spikes")
        for more, less in pairs
    ]


def outcome_of(checks: Sequence[Check], groups: Iterable[Sequence[Any]], measured: str, effect: str) -> Outcome:
    """Return the outcome of checks on ``groups``, the trials of each condition."""
    counts = [len(trials) for trials in groups]
    return Outcome.of(checks, measured, effect, sum(counts), min(counts))


def at_every_speed(
    rows: Rows, motion: str, judge: Callable[[Mapping[float, list[float]]], tuple[list[Check], str]]
) -> Outcome:
    """Return the outcome of what ``judge`` asks at each speed at which the motion was shown along all `ANGLES`."""
    every, measured, effects = [], [], []
    conditions: list[list[float]] = []
    for speed in sorted({row["speed_cm_s"] for row in paper_trials(rows, motion=motion)}):
        groups = by_level(rows, "angle_deg", motion=motion, speed_cm_s=speed)
        if set(ANGLES) <= groups.keys():
            groups = {angle: groups[angle] for angle in ANGLES}
            checks, effect = judge(groups)
            every += [replace(check, says=f"{speed:g} cm/s: {check.says}") for check in checks]
            measured.append(f"{speed:g} cm/s: {means_text(groups, 'degrees')}")
            effects.append(f"{speed:g} cm/s: {effect}")
            conditions += groups.values()
    if not every:
        return Outcome.unjudged(f"needs {motion} at -30, -15, 0, 15 and 30 degrees")
    return outcome_of(every, conditions, "; ".join(measured), "; ".join(effects))


def of_pairs(rows: Rows, motion: str, pairs: Sequence[tuple[float, float]]) -> Outcome:
    """Return the outcome of more spikes at the first angle of each pair than at the second, at every speed shown."""

    def judge(groups: Mapping[float, list[float]]) -> tuple[list[Check], str]:
        test = trend([(abs(angle), groups[angle]) for angle in sorted(groups, key=abs)])
        return more_spikes(means(groups), pairs, "degrees"), f"against |angle|: {test}"

    return at_every_speed(rows, motion, judge)


FEWEST_AHEAD = (*((angle, 0.0) for angle in ANGLES if angle), (-30.0, -15.0), (30.0, 15.0))
"""Pairs of angles: fewest spikes at 0 degrees, and more at 30 than at 15 on each side."""


def more_on_one_side(rows: Rows, motion: str, more: float, name: str) -> Outcome:
    """Return the outcome of more spikes on the side of the sign ``more``, at 15 and 30 degrees together."""

    def judge(groups: Mapping[float, list[float]]) -> tuple[list[Check], str]:
        here, there = (groups[side * 15.0] + groups[side * 30.0] for side in (more, -more))
        text = f"{name}: {fmean(here):.1f} spikes a trial"
        check = exceeds(text, fmean(here), fmean(there), "on the other side", "spikes")
        return [check], f"{name}: {contrast(here, there)}"

    return at_every_speed(rows, motion, judge)


def of_each_trial(checks: Sequence[Check], groups: Sequence[Rows], broken: int, threshold: float) -> Outcome:
    """Return the outcome of a claim about every trial of two motions; of one alone it cannot hold."""
    tested = [trials for trials in groups if trials]
    outcome = outcome_of(checks, tested, "", "").noting(f"T = {threshold:g}")
    outcome = replace(outcome, broken=broken, effect=f"{broken} of {outcome.n} trials break it")
    whole = len(tested) == len(groups) or outcome.verdict == "fails"
    return outcome if whole else outcome.withheld("the other motion was not run")


def curves_of(rows: Rows, labels: Mapping[str, str], column: str) -> Curves:
    """Return a column's values in rightward crossings at 8 cm, by name of a model, at the speeds that all have."""
    trials = paper_trials(rows, motion="translation", direction="rightward", distance_cm=8.0)
    found: dict[str, dict[float, dict[int, float]]] = {name: {} for name in labels}
    for name, label in labels.items():
        for row in (row for row in trials if row["model"] == label):
            found[name].setdefault(row["speed_cm_s"], {})[row["trial"]] = row[column]
    speeds = sorted(set.intersection(*map(set, found.values())))
    return {name: {speed: curve[speed] for speed in speeds} for name, curve in found.items()}


def mean_curves(curves: Curves) -> dict[str, dict[float, float]]:
    """Return name -> speed -> mean over trials."""
    return {name: {speed: fmean(at.values()) for speed, at in curve.items()} for name, curve in curves.items()}


def higher(curves: Curves, one: str, others: Iterable[str], what: str) -> list[Check]:
    """Return the checks that a mean potential of ``one`` is above that of each of the ``others`` at every speed."""
    mean = mean_curves(curves)
    return [
        exceeds(f"{what} of {one} {value:.3f} at {speed:g} cm/s", value, mean[other][speed], f"of {other}", "potential")
        for other in others
        for speed, value in mean[one].items()
    ]


def of_curves(checks: Sequence[Check], curves: Curves, what: str, first: str, others: Iterable[str]) -> Outcome:
    """Return the outcome of checks on ``curves``, with a paired test of the first against each other over all speeds.

    A trial in which several models were judged counts once.
    """
    trials = [at for curve in curves.values() for at in curve.values()]
    texts = [
        f"{name}: {', '.join(f'{value:.2f} at {speed:g}' for speed, value in curve.items())} cm/s"
        for name, curve in mean_curves(curves).items()
    ]
    effects = []
    for other in others:
        pairs = [(value, curves[other][speed][trial]) for speed, at in curves[first].items()
                 for trial, value in at.items() if trial in curves[other][speed]]  # fmt: skip
        effects.append(f"{first} against {other}: {paired(*zip(*pairs, strict=True))}" if pairs else "")
    measured = f"rightward at 8 cm, {what}: {'; '.join(texts)}"
    n, fewest = len({trial for at in trials for trial in at}), min(map(len, trials))
    return Outcome.of(checks, measured, "; ".join(filter(None, effects)), n, fewest)


# --- the judges -------------------------------------------------------------------------------------------------------


@claim(
    "C13", conditions=DEPTH, reads=("spikes", "peak_hs", "trough_hs"), of_each=True, pools=STRAIGHT, silent_passes=True
)
def c13(rows: Rows, threshold: float) -> Outcome:
    """Judge motion along the optical axis, at any speed: every such trial of a replicate, of all its experiments.

    Of motions without a spike, the higher potential decides.
    """
    kinds = {kind: paper_trials(rows, motion=kind, angle_deg=0.0) for kind in DEPTH["motion"]}
    checks = {}
    for kind, trials in kinds.items():
        if trials:
            firing = sum(row["spikes"] > 0 for row in trials)
            peak = max(max(row["peak_hs"], -row["trough_hs"]) for row in trials)
            text = f"{kind}: spikes in {firing} of {len(trials)} trials, |HS| up to {peak:.2f}"
            checks[kind] = peak, Check(text, firing, 0.0, "at most", unit="trials")
    if not checks:
        return Outcome.unjudged("needs straight approach and recession")
    highest_first = [check for _, check in sorted(checks.values(), key=lambda pair: -pair[0])]
    broken = sum(int(check.reading) for check in highest_first)
    return of_each_trial(highest_first, [*kinds.values()], broken, threshold)


@claim("C32", conditions=DEPTH, pools=STRAIGHT, silent_passes=True, least=LEAST_STRAIGHT)
def c32(rows: Rows, threshold: float) -> Outcome:
    """Judge motion along the optical axis as `c13` does, but by the share of trials without a spike."""
    kinds = [(kind, paper_trials(rows, motion=kind, angle_deg=0.0)) for kind in DEPTH["motion"]]
    if not all(trials for _, trials in kinds):
        return Outcome.unjudged("needs straight approach and recession")
    checks = []
    for kind, trials in kinds:
        firing = sum(row["spikes"] > 0 for row in trials)
        text = f"{kind}: spikes in {firing} of {len(trials)} trials"
        checks.append(Check(text, firing, len(trials) / 10, "at most", unit="trials"))
    return outcome_of(checks, [trials for _, trials in kinds], "", "")


DIRECTION_OF = {1.0: "rightward", -1.0: "leftward"}
"""Sign of HS -> direction of the motion."""


@claim("C14", conditions=ACROSS, reads=("peak_hs", "trough_hs"), of_each=True)
def c14(rows: Rows, threshold: float) -> Outcome:
    """Judge every crossing of the trials given, at whatever speed and distance.

    A trial passes if HS goes past the threshold of its own direction and not past that of the other: a potential
    that passes both tells no direction.
    """

    def reached(sign: float, row: Row) -> float:
        return float(row["peak_hs"] if sign > 0 else -row["trough_hs"])

    ways = {sign: paper_trials(rows, motion="translation", direction=way) for sign, way in DIRECTION_OF.items()}
    checks = []
    for sign, trials in ways.items():
        sides: tuple[tuple[float, Needs, Any], ...] = ((sign, "above", min), (-sign, "at most", max))
        for side, needs, extreme in sides if trials else ():
            row = extreme(trials, key=partial(reached, side))
            where = f"{row['speed_cm_s']:g} cm/s, {row['distance_cm']:g} cm"
            text = f"{DIRECTION_OF[sign]}: HS reaches {side * reached(side, row):+.3f} at {where}"
            asks = f"{'to' if side == sign else 'not to'} pass {side * threshold:+g}"
            checks.append(Check(text, reached(side, row), threshold, needs, asks=asks))
    if not checks:
        return Outcome.unjudged("needs translations")
    good = sum(reached(sign, row) > threshold >= reached(-sign, row) for sign, trials in ways.items() for row in trials)
    broken = sum(map(len, ways.values())) - good
    outcome = of_each_trial(checks, [*ways.values()], broken, threshold)
    conditions = group([row for trials in ways.values() for row in trials], "direction", "speed_cm_s", "distance_cm")
    return replace(outcome, fewest=min(map(len, conditions.values())))


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
    return outcome_of(checks, groups.values(), f"rightward at 8 cm: {means_text(groups, 'cm/s')}", effect)


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
    effect = str(trend([(distance, groups[distance]) for distance in (5.0, 10.0, 15.0)]))
    return outcome_of(checks, groups.values(), f"rightward at 6 cm/s: {means_text(groups, 'cm')}", effect)


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
    curves = curves_of(rows, {f"N_con = {n}": CONNECTIONS[n] for n in (1, 2, 8)}, "peak_hs")
    *fewer, usual = curves
    if not set(ROBOT_SPEEDS) <= curves[usual].keys():
        return crossings_needed(ROBOT_SPEEDS)
    past = {name: sum(peak > threshold for peak in curve.values()) for name, curve in mean_curves(curves).items()}
    text = f"{usual} passes T = {threshold:g} at {past[usual]} of {len(curves[usual])} speeds"
    checks = higher(curves, usual, fewer, "peak HS")
    checks += [Check(text, past[usual], past[n], unit="speeds", asks=f"more than {n}: {past[n]}") for n in fewer]
    return of_curves(checks, curves, "mean peak HS", usual, fewer)


DELAY_SPEEDS = (4.0, 6.0, 8.0, 10.0)


@claim("C25", conditions=ACROSS, reads=(POTENTIAL,), models={DSNN, FALLING, *FIXED.values()})
def c25(rows: Rows, threshold: float) -> Outcome:
    """Judge mean HS over the frames near the axis. The delays of the DSNN as it is rise with spacing.

    Delays that fall with spacing are the other reading; their numbers stand beside and decide nothing.
    """
    fixed = {f"{delay} ms": label for delay, label in FIXED.items()}
    labels = {"rising delays": DSNN, **fixed, "falling delays, the other reading": FALLING}
    curves = curves_of([row for row in rows if row["speed_cm_s"] in DELAY_SPEEDS], labels, POTENTIAL)
    if set(DELAY_SPEEDS) != curves["rising delays"].keys():
        return crossings_needed(DELAY_SPEEDS)
    checks = higher(curves, "rising delays", fixed, "mean HS")
    return of_curves(checks, curves, "mean HS near the axis", "rising delays", fixed)


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
    measured, effects = ["rightward at 8 cm"], []
    checks: list[Check] = []
    for name, counts in (("edge to edge", groups), ("centre to centre", inner)):
        steps = more_spikes(means(counts), PAIRS, "cm/s")
        checks += [replace(check, says=f"window from {name}: {check.says}") for check in steps]
        measured.append(f"window from {name}: {means_text(counts, 'cm/s')}")
        effects.append(f"{name}, 10 against 6 cm/s: {contrast(counts[10.0], counts[6.0])}")
    near = ", ".join(f"{speed:g} cm/s: {value:.2f}" for speed, value in means(potential).items())
    measured.append(f"mean HS near the axis at {near}")
    return outcome_of(checks, [groups[speed] for speed in ROBOT_SPEEDS], "; ".join(measured), "; ".join(effects))


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
    curves = curves_of(rows, labels, POTENTIAL)
    if not set(ROBOT_SPEEDS) < curves[USUAL].keys():
        return crossings_needed(ROBOT_SPEEDS)
    means = mean_curves(curves)
    top = {name: max(mean, key=mean.__getitem__) for name, mean in means.items()}
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
    return of_curves(checks, curves, "mean HS near the axis", USUAL, ())


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
    return outcome_of(checks, named.values(), f"rightward at 8 cm: {means_text(named, 'cm/s')}", effect)
