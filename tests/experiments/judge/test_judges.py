"""The judges of the robot's claims: what they test, how many trials they take, and what leaves them unjudged."""

import re

import pytest

from experiments.declare.claim import DSNN
from experiments.ensembles import MODELS
from experiments.judge.judge import flaws, judge
from experiments.kinds.registry import claims_on

CLAIMS = claims_on("robot")

T = 0.2


def outcome(claim, trials, threshold, all_rows=None):
    """What a claim of the registry about the robot comes to."""
    return judge(CLAIMS[claim], trials, threshold, all_rows)


def rows(spikes_by, column, direction="rightward", achieved=1.0, **fixed):
    return [
        {"motion": "translation", "direction": direction, "speed_cm_s": 6.0, "distance_cm": 8.0, "peak_hs": 0.5,
         "trough_hs": -0.01, "path_error_mm": 0.1, "shell_grey": None, "wall_contrast": None,
         "observer_speed_cm_s": 0.0, "observer_turn_deg_s": 0.0, "angle_deg": None, "mean_hs_near_axis": 0.4,
         **fixed, column: float(level), "spikes": count, "spikes_in_window": count, "spikes_in_inner_window": count}
        | {"achieved_speed_cm_s": (float(level) if column == "speed_cm_s" else 6.0) * achieved}
        for level, counts in spikes_by.items()
        for count in counts
    ]  # fmt: skip


def depth(motion, spikes_by_angle, **changed):
    return rows(spikes_by_angle, "angle_deg", "straight", motion=motion, **changed)


def crossing(way, n, **values):
    usual = {"peak_hs": 0.5, "trough_hs": -0.01} if way == "rightward" else {"peak_hs": 0.01, "trough_hs": -0.5}
    return rows({6: [9] * n}, "speed_cm_s", way, **{**usual, **values})


def ensemble(n, **curves):
    """Crossings of the DSNN and of its variants: a label's values of ``column`` by speed, the DSNN's elsewhere."""
    column = curves.pop("column")
    usual = dict(zip((2, 4, 6, 8, 10, 15, 20), (0.1, 0.3, 0.5, 0.6, 0.7, 0.8, 0.7), strict=True))
    trials = []
    for label in MODELS:
        values = {**{s: v * (1.0 if label == DSNN else 0.2) for s, v in usual.items()}, **curves.get(label, {})}
        for speed, value in values.items():
            crossings = rows({speed: [0] * n}, "speed_cm_s", model=label, **{column: value})
            trials += [row | {"trial": 100 * speed + index} for index, row in enumerate(crossings)]
    return trials


FASTER = {"dsnn:d=2": {20: 0.9}, "dsnn:n_con=1": {8: 0.9}, "dsnn:n_con=2": {8: 0.9}, "dsnn:n_con=4": {10: 0.9}}
"""Peaks: 20 cm/s at d = 2; 8, 8, 10, 15 over N_con."""


def enough(claim, n):
    """Trials on which a claim holds, ``n`` of each condition."""
    if claim in ORDERS:
        return ordered(claim, ORDERS[claim][0], n)
    return {
        "C13": depth("approach", {0: [0] * n}) + depth("recession", {0: [0] * n}),
        "C14": crossing("rightward", n) + crossing("leftward", n),
        "C32": depth("approach", {0: [0] * n}) + depth("recession", {0: [0] * n}),
        "C24": ensemble(n, column="peak_hs"),
        "C25": ensemble(n, column="mean_hs_near_axis"),
        "C29": rows({2: [0] * n, 4: [40] * n, 6: [60] * n, 10: [45] * n}, "speed_cm_s"),
        "C30": ensemble(n, column="mean_hs_near_axis", **FASTER),
    }[claim]


@pytest.mark.parametrize("claim", CLAIMS)
def test_every_claim_has_a_least_number_of_trials(claim):
    least = CLAIMS[claim].least
    assert CLAIMS[claim].conditions["motion"] and CLAIMS[claim].reads
    assert outcome(claim, enough(claim, least), T).verdict == "holds"
    for n in range(1, least):
        few = outcome(claim, enough(claim, n), T)
        assert (few.verdict, few.decided) == ("not shown", "") and str(least) in few.deciding
    assert outcome(claim, [], T).verdict == "not shown"


# What each tests.


@pytest.mark.parametrize(
    "weak",
    [
        crossing("rightward", 1, peak_hs=0.19),
        crossing("leftward", 1, trough_hs=-0.19),
        crossing("leftward", 1, peak_hs=0.8),  # it passes the threshold of either direction
        rows({2: [0]}, "speed_cm_s", peak_hs=0.1),  # not of those at 6 cm/s and the nearest distance alone
        rows({15: [0]}, "distance_cm", peak_hs=0.1),
    ],
)
def test_c14_is_of_every_crossing(weak):
    assert outcome("C14", enough("C14", 5) + weak, T).verdict == "fails"
    assert outcome("C14", crossing("rightward", 5), T).verdict == "not shown", "it needs both directions"


def test_c13_counts_every_spike():
    silent = depth("approach", {0: [0] * 5}) + depth("recession", {0: [0] * 5})
    assert outcome("C13", silent, 0.2).verdict == "holds"
    assert outcome("C13", silent + depth("recession", {0: [1]}), 0.2).verdict == "fails"
    assert outcome("C13", depth("approach", {0: [0]}), 0.2).verdict == "not shown"
    assert outcome("C13", depth("approach", {0: [3]}), 0.2).verdict == "fails", "one motion is enough to fail"


@pytest.mark.parametrize("motion", ["approach", "recession"])
def test_c32_is_of_nine_tenths_of_each_motion(motion):
    other = {"approach": "recession", "recession": "approach"}[motion]

    def of(firing, silent):
        rows_of = depth(motion, {0: [5] * firing + [0] * silent}) + depth(other, {0: [0] * 10})
        return outcome("C32", rows_of + depth(motion, {15: [9] * 10}), T).verdict

    assert [of(1, 9), of(2, 18), of(2, 17), of(2, 8)] == ["holds", "holds", "fails", "fails"]
    assert outcome("C32", depth(motion, {0: [0] * 20}), T).verdict == "not shown", "it needs both motions"


def test_the_angular_claims_are_of_every_speed():
    """Along all five angles at another speed they are judged there; at two, at both."""
    fast = [row | {"speed_cm_s": 10.0, "achieved_speed_cm_s": 10.0} for row in enough("C17", 4)]
    assert outcome("C17", fast, T).verdict == "holds"
    flat = [row | {"spikes": 3} for row in fast]
    assert outcome("C17", enough("C17", 4) + flat, T).verdict == "fails"


def fewest_ahead(m):
    return min(m[-30] - m[-15], m[30] - m[15], m[-15] - m[0], m[15] - m[0])


def to_the_left(m):
    return (m[-30] + m[-15] - m[15] - m[30]) / 2


MANY = 70
"""Mean spikes at a level that no words name."""
FEWEST, LEFT = {-30: 2, -15: 1, 0: 0, 15: 1, 30: 2}, {-30: 2, -15: 1, 0: 0, 15: 0, 30: 1}
ORDERS = {
    "C15": ({2: 39, 4: 40, 6: 41, 10: 40, 8: MANY, 15: MANY}, lambda m: min(m[4] - m[2], m[6] - m[4], m[6] - m[10])),
    "C16": ({5: 5, 10: 4, 15: 2.5}, lambda m: min(m[5] - m[10], m[10] - m[15], 1 + m[5] / 2 - m[15])),
    "C17": (FEWEST, fewest_ahead), "C19": (FEWEST, fewest_ahead),
    "C18": (LEFT, to_the_left), "C20": ({-a: m for a, m in LEFT.items()}, lambda m: -to_the_left(m)),
    "C21": ({-30: 1, -15: 1, 0: 2, 15: 1, 30: 1}, lambda m: m[0] - max(m[-30], m[-15], m[15], m[30])),
    "C31": ({**dict.fromkeys(range(2, 11), 8), 6: 9, 15: MANY},
            lambda m: max(m[5], m[6], m[7]) - max(m[speed] for speed in (2, 3, 4, 8, 9, 10))),
}  # fmt: skip
"""Claim -> mean spikes by level on which it just holds, and the least of the differences that its words ask for."""


def ordered(claim, means, n=4):
    spikes = {level: [mean] * n for level, mean in means.items()}
    if claim in ("C15", "C16", "C31"):
        return rows(spikes, "distance_cm" if claim == "C16" else "speed_cm_s")
    return depth("recession" if claim in ("C19", "C20") else "approach", spikes)


@pytest.mark.parametrize("claim", ORDERS)
def test_an_order_of_counts_holds_where_each_of_its_differences_is_a_spike_a_trial(claim):
    """With the mean of one level higher or lower by a part of a spike, and without the level."""
    just, least = ORDERS[claim]
    assert outcome(claim, ordered(claim, just), T).verdict == "holds" and least(just) == 1
    for level in just:
        for change in (-0.7, -0.3, 0.3, 0.7):
            means = {**just, level: just[level] + change}
            verdict = outcome(claim, ordered(claim, means), T).verdict
            assert verdict == ("holds" if least(means) >= 1 else "fails"), (level, change)
        means = {other: mean for other, mean in just.items() if other != level}
        verdict = outcome(claim, ordered(claim, means), T).verdict
        assert verdict == ("not shown" if just[level] < MANY else "holds"), level


def test_trials_of_another_direction_or_experiment_do_not_count():
    others = rows({6: [0] * 9}, "speed_cm_s", observer_turn_deg_s=5.0)
    assert outcome("C15", enough("C15", 4) + others, T).verdict == "holds"
    leftward = [row | {"direction": "leftward"} for row in enough("C15", 4)]
    assert outcome("C15", leftward, T).verdict == "not shown"


# What is flawed, or no number.


@pytest.mark.parametrize("drive", ["feedback", "open"])
def test_a_trial_that_was_not_what_it_says_leaves_its_claim_unjudged(drive):
    """One driven open loop is judged by what it did, where that was measured."""
    untold = (float("nan"), None, float("inf"))
    for column, near, far in (("achieved_speed_cm_s", 2.03, 2.06), ("path_error_mm", 0.9, 1.5)):
        for value in (near, far, *untold):
            first, *others = enough("C15", 4)
            trials = [{**first, column: value, "drive": drive}, *others]
            sound = value == near or (value == far and drive == "open")
            assert outcome("C15", trials, T).verdict == ("holds" if sound else "not shown"), (column, value)
            assert (flaws(trials) == "") == sound
    elsewhere = depth("approach", {0: [1]}, path_error_mm=1.5)
    assert outcome("C15", enough("C15", 4) + elsewhere, T).verdict == "holds", "another motion's flaw"


@pytest.mark.parametrize("claim", CLAIMS)
@pytest.mark.parametrize("nothing", [float("nan"), None])
def test_a_trial_without_a_number_is_not_judged(claim, nothing):
    for column in CLAIMS[claim].reads:
        trials = enough(claim, 5)
        trials[0] = trials[0] | {column: nothing}
        verdict = outcome(claim, trials, T)
        assert verdict.verdict == "not shown" and " have no number in " + column in verdict.measured


EFFECTS = {
    "C15": [1.0, -1.0], "C16": [-1.0], "C17": [1.0], "C18": [0.75], "C19": [1.0], "C20": [0.75], "C21": [-0.71],
    "C29": [-1.0, -1.0], "C31": [1.0],
}  # fmt: skip
"""Effect sizes of `enough`: of four pairs of angles three are in order, and one is equal."""


@pytest.mark.parametrize("claim", EFFECTS)
def test_effects_have_the_sign_of_what_they_compare(claim):
    effects = re.findall(r"(?:tau|delta) (\S+),", outcome(claim, enough(claim, 5), T).effect)
    assert list(map(float, effects)) == EFFECTS[claim]


# Claims that compare models.


@pytest.mark.parametrize("claim", [claim for claim in CLAIMS if CLAIMS[claim].models])
def test_a_claim_that_compares_models_needs_all_of_them(claim):
    trials = enough(claim, 4)
    whole = outcome(claim, trials, T)
    assert whole.verdict == "holds"
    speeds = 4 if claim == "C25" else 7
    assert whole.n == 4 * speeds, "a trial counts once, however many models saw it"
    for label in CLAIMS[claim].models:
        few = outcome(claim, [row for row in trials if row["model"] != label], T)
        assert (few.verdict, few.measured) == ("not shown", f"needs {label}")
        once = [row for row in trials if row["model"] != label or row["trial"] % 100 < 3]
        assert "needs at least 4 trials of each condition (has 3)" in outcome(claim, once, T).measured
    stranger = [row | {"model": "emd", "peak_hs": 9.0, "mean_hs_near_axis": 9.0} for row in trials]
    assert outcome(claim, trials + stranger, T) == whole, "other models' trials do not count"


def ensemble_verdict(claim, column, **curves):
    return outcome(claim, ensemble(4, column=column, **curves), T)


def test_c24_is_of_every_speed_and_of_the_threshold():
    assert ensemble_verdict("C24", "peak_hs", **{"dsnn:n_con=2": {15: 0.8}}).verdict == "fails"
    silent = ensemble_verdict("C24", "peak_hs", dsnn={speed: 0.05 for speed in (2, 4, 6, 8, 10, 15, 20)})
    assert silent.verdict == "fails", "higher nowhere"
    as_often = {speed: 0.25 for speed in (4, 6, 8, 10, 15, 20)}
    judged = ensemble_verdict("C24", "peak_hs", **{"dsnn:n_con=1": as_often})
    assert judged.verdict == "fails" and [check.slack for check in judged.checks if check.slack <= 0] == [0]


@pytest.mark.parametrize("delay", [10, 50, 100, 200])
def test_c25_is_of_each_fixed_delay_and_speed(delay):
    for speed, verdict in ((4, "fails"), (10, "fails"), (2, "holds"), (20, "holds")):
        curves = {f"dsnn:tau_s={delay},{delay}": {speed: 0.95}}
        assert ensemble_verdict("C25", "mean_hs_near_axis", **curves).verdict == verdict
    equal = ensemble_verdict("C25", "mean_hs_near_axis", **{f"dsnn:tau_s={delay},{delay}": {6: 0.5}})
    assert equal.verdict == "fails"
    other = ensemble_verdict("C25", "mean_hs_near_axis", **{"dsnn:tau_s=200,10": {6: 0.95}})
    assert other.verdict == "holds", "the other reading decides nothing"


@pytest.mark.parametrize(
    ("peaks", "verdict"),
    [
        ({}, "holds"),
        ({"dsnn:d=2": {15: 0.95}}, "fails"),  # d does not move it
        ({"dsnn:n_con=1": {15: 0.95}, "dsnn:n_con=2": {15: 0.95}, "dsnn:n_con=4": {15: 0.95}}, "fails"),  # N_con not
        ({"dsnn:n_con=1": {20: 0.95}}, "fails"),  # there and back
        ({"dsnn:n_con=1": {20: 0.95}, "dsnn:n_con=2": {20: 0.95}, "dsnn:n_con=4": {20: 0.95}}, "holds"),  # down
    ],
)
def test_c30_asks_for_a_move_with_both(peaks, verdict):
    curves = {label: {**FASTER.get(label, {}), **peaks.get(label, {})} for label in (*FASTER, *peaks)}
    assert ensemble_verdict("C30", "mean_hs_near_axis", **curves).verdict == verdict


@pytest.mark.parametrize("column", ["spikes_in_window", "spikes_in_inner_window"])
def test_c29_holds_if_it_does_in_both_windows(column):
    trials = enough("C29", 4)
    as_many = [row | {column: 60} if row["speed_cm_s"] == 10 else row for row in trials]
    assert outcome("C29", as_many, T).verdict == "fails"
    whole = [row | {"spikes": 0} for row in trials]
    assert outcome("C29", whole, T).verdict == "holds", "not the count of the whole crossing"
