"""The judges of the robot's claims: what they test, how many trials they take, what decided."""

import pytest

from experiments.bench.sources.judge import flaws
from experiments.bench.sources.judge import judge as outcome
from experiments.bench.stats.claim import DSNN, claims_on
from experiments.claims.robot import VARIANTS
from tests.bench.robot.test_claims import depth, rows

CLAIMS = claims_on("robot")

T = 0.2
STEPS = dict(zip(range(2, 11), (0, 20, 40, 50, 60, 55, 50, 47, 45), strict=True))
SPEEDS = dict(zip((2, 4, 6, 10), (0, 40, 60, 45), strict=True))
ANGLES = dict(zip((-30, -15, 0, 15, 30), (11, 8, 0, 2, 8), strict=True))


def crossing(way, n, **values):
    usual = {"peak_hs": 0.5, "trough_hs": -0.01} if way == "rightward" else {"peak_hs": 0.01, "trough_hs": -0.5}
    return rows({6: [9] * n}, "speed_cm_s", way, **{**usual, **values})


def ensemble(n, **curves):
    """Crossings of the DSNN and of its variants: a label's values of ``column`` by speed, the DSNN's elsewhere."""
    column = curves.pop("column")
    usual = dict(zip((2, 4, 6, 8, 10, 15, 20), (0.1, 0.3, 0.5, 0.6, 0.7, 0.8, 0.7), strict=True))
    trials = []
    for label in (DSNN, *VARIANTS):
        values = {**{s: v * (1.0 if label == DSNN else 0.2) for s, v in usual.items()}, **curves.get(label, {})}
        for speed, value in values.items():
            crossings = rows({speed: [0] * n}, "speed_cm_s", model=label, **{column: value})
            trials += [row | {"trial": 100 * speed + index} for index, row in enumerate(crossings)]
    return trials


FASTER = {"dsnn:d=2": {20: 0.9}, "dsnn:n_con=1": {8: 0.9}, "dsnn:n_con=2": {8: 0.9}, "dsnn:n_con=4": {10: 0.9}}
"""Peaks: 20 cm/s at d = 2; 8, 8, 10, 15 over N_con."""


def enough(claim, n):
    """Trials on which a claim holds, ``n`` of each condition."""
    return {
        "C13": depth("approach", {0: [0] * n}) + depth("recession", {0: [0] * n}),
        "C14": crossing("rightward", n) + crossing("leftward", n),
        "C15": rows({speed: [m] * n for speed, m in SPEEDS.items()}, "speed_cm_s"),
        "C16": rows({5: [60] * n, 10: [40] * n, 15: [30] * n}, "distance_cm"),
        "C17": depth("approach", {a: [m] * n for a, m in ANGLES.items()}),
        "C18": depth("approach", {a: [m] * n for a, m in ANGLES.items()}),
        "C19": depth("recession", {a: [m] * n for a, m in ANGLES.items()}),
        "C20": depth("recession", {-a: [m] * n for a, m in ANGLES.items()}),
        "C24": ensemble(n, column="peak_hs"),
        "C25": ensemble(n, column="mean_hs_near_axis"),
        "C31": rows({speed: [m] * n for speed, m in STEPS.items()}, "speed_cm_s"),
        "C29": rows({speed: [m] * n for speed, m in SPEEDS.items()}, "speed_cm_s"),
        "C30": ensemble(n, column="mean_hs_near_axis", **FASTER),
        "C21": depth("approach", {a: [20 - m] * n for a, m in ANGLES.items()}),
    }[claim]


@pytest.mark.parametrize("claim", CLAIMS)
def test_every_claim_has_a_least_number_of_trials(claim):
    least = CLAIMS[claim].least
    assert CLAIMS[claim].conditions["motion"] and CLAIMS[claim].reads
    assert outcome(claim, enough(claim, least), T).verdict == "holds"
    for n in range(1, least):
        few = outcome(claim, enough(claim, n), T)
        assert few.verdict == "not shown" and few.decided == ""
        assert few.least == least and few.measured.startswith(
            f"needs at least {least} trials of each condition (has {n})"
        )


# What each tests.


def test_c14_is_of_every_crossing():
    """Not of those at 6 cm/s and the nearest distance alone."""
    near = enough("C14", 5)
    assert outcome("C14", near, T).verdict == "holds"
    for way, column, value in (("rightward", "peak_hs", 0.1), ("leftward", "trough_hs", -0.1)):
        for weak in (
            rows({2: [0] * 5}, "speed_cm_s", way, **{"peak_hs": 0.0, "trough_hs": 0.0, column: value}),
            rows({15: [0] * 5}, "distance_cm", way, **{"peak_hs": 0.0, "trough_hs": 0.0, column: value}),
        ):
            verdict = outcome("C14", near + weak, T)
            assert verdict.verdict == "fails" and verdict.n == 15
            where = f"{weak[0]['speed_cm_s']:g} cm/s, {weak[0]['distance_cm']:g} cm"
            assert f"{way}: HS reaches {value:+.3f} at {where}" in verdict.decided


def test_the_angular_claims_are_of_every_speed():
    """Along all five angles at another speed they are judged there; at two, at both."""
    fast = depth("approach", {a: [m] * 4 for a, m in ANGLES.items()}, speed_cm_s=10.0, achieved_speed_cm_s=10.0)
    fast = [row | {"achieved_speed_cm_s": 10.0} for row in fast]
    assert outcome("C17", fast, T).verdict == "holds"
    flat = [row | {"spikes": 3} for row in fast]
    verdict = outcome("C17", enough("C17", 4) + flat, T)
    assert verdict.verdict == "fails" and verdict.decided.startswith("10 cm/s: 3.0 spikes at -30 degrees")


def test_c15_is_of_the_papers_four_speeds_alone():
    assert outcome("C15", enough("C15", 4) + rows({8: [70] * 4, 15: [70] * 4}, "speed_cm_s"), T).verdict == "holds"


@pytest.mark.parametrize(
    ("changes", "verdict"),
    [({}, "holds"), ({5: 61}, "holds"), ({7: 61}, "holds"), ({4: 61}, "fails"), ({8: 60}, "fails"), ({9: 70}, "fails"),
     ({8: 59}, "holds"), ({8: 59.5}, "fails")],
)  # fmt: skip
def test_c31_is_of_every_speed_from_2_to_10(changes, verdict):
    def trials(counts):
        return rows({speed: [m] * 4 for speed, m in counts.items()}, "speed_cm_s")

    assert outcome("C31", trials({**STEPS, **changes}), T).verdict == verdict
    beyond = trials({**STEPS, **changes, 15: 99})
    assert outcome("C31", beyond, T).verdict == verdict, "its words go to 10 cm/s"
    lacking = {speed: m for speed, m in STEPS.items() if speed != 7}
    assert outcome("C31", trials(lacking), T).verdict == "not shown"


@pytest.mark.parametrize(
    ("claim", "column", "least"),
    [
        ("C15", "speed_cm_s", {2: 39.0, 4: 40.0, 6: 41.0, 10: 40.0}),
        ("C16", "distance_cm", {5: 3.0, 10: 2.0, 15: 1.0}),
        ("C17", "angle_deg", {-30: 2.0, -15: 1.0, 0: 0.0, 15: 1.0, 30: 2.0}),
        ("C19", "angle_deg", {-30: 2.0, -15: 1.0, 0: 0.0, 15: 1.0, 30: 2.0}),
        ("C18", "angle_deg", {-30: 2.0, -15: 2.0, 0: 0.0, 15: 1.0, 30: 1.0}),
        ("C20", "angle_deg", {-30: 1.0, -15: 1.0, 0: 0.0, 15: 2.0, 30: 2.0}),
        ("C21", "angle_deg", {-30: 1.0, -15: 1.0, 0: 2.0, 15: 1.0, 30: 1.0}),
    ],
)
def test_a_difference_of_counts_below_a_spike_a_trial_is_none(claim, column, least):
    """At the margin a claim holds; with all differences three tenths of it, it does not."""

    def trials(counts):
        if column == "angle_deg":
            kind = "recession" if claim in ("C19", "C20") else "approach"
            return depth(kind, {level: [mean] * 4 for level, mean in counts.items()})
        return rows({level: [mean] * 4 for level, mean in counts.items()}, column)

    assert outcome(claim, trials(least), T).verdict == "holds"
    judged = outcome(claim, trials({level: 0.3 * mean for level, mean in least.items()}), T)
    assert judged.verdict == "fails" and "+0.3 against" in judged.decided and "(needs +1 or more)" in judged.decided
    assert min(check.reading for check in judged.checks if check.asks == "+1 or more") == pytest.approx(0.3)


# What is no number.


@pytest.mark.parametrize("nothing", [float("nan"), None, float("inf")])
def test_a_trial_without_a_measured_speed_or_path_is_flawed(nothing):
    for column, says in (("achieved_speed_cm_s", "no measured speed"), ("path_error_mm", "no measured path")):
        trials = enough("C15", 4)
        trials[3] = trials[3] | {column: nothing}
        assert f"1 of 16 trials have {says}" in flaws(trials)
        verdict = outcome("C15", trials, T)
        assert verdict.verdict == "not shown" and says in verdict.measured


@pytest.mark.parametrize("claim", CLAIMS)
@pytest.mark.parametrize("nothing", [float("nan"), None])
def test_a_trial_without_a_number_is_not_judged(claim, nothing):
    for column in CLAIMS[claim].reads:
        trials = enough(claim, 5)
        trials[0] = trials[0] | {column: nothing}
        verdict = outcome(claim, trials, T)
        assert verdict.verdict == "not shown" and " have no number in " + column in verdict.measured


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
    weak = ensemble_verdict("C24", "peak_hs", **{"dsnn:n_con=2": {15: 0.8}})
    assert weak.verdict == "fails"
    assert weak.decided.startswith("peak HS of N_con = 8 0.800 at 15 cm/s, +0.0000 against 0.8000 of N_con = 2 (needs")
    as_often = {speed: 0.05 for speed in (2, 4, 6, 8, 10, 15, 20)}
    silent = outcome("C24", ensemble(4, column="peak_hs", dsnn=as_often), T)
    assert silent.verdict == "fails", "higher nowhere"
    high = ensemble(4, column="peak_hs", **{"dsnn:n_con=1": {s: 0.25 for s in (4, 6, 8, 10, 15, 20)}})
    judged = outcome("C24", high, T)
    assert (
        judged.verdict == "fails" and "passes T = 0.2 at 6 of 7 speeds (needs more than N_con = 1: 6)" in judged.decided
    )


@pytest.mark.parametrize("delay", [10, 50, 100, 200])
def test_c25_is_of_each_fixed_delay_and_speed(delay):
    for speed, verdict in ((4, "fails"), (10, "fails"), (2, "holds"), (20, "holds")):
        curves = {f"dsnn:tau_s={delay},{delay}": {speed: 0.95}}
        assert ensemble_verdict("C25", "mean_hs_near_axis", **curves).verdict == verdict
    equal = ensemble_verdict("C25", "mean_hs_near_axis", **{f"dsnn:tau_s={delay},{delay}": {6: 0.5}})
    assert equal.verdict == "fails" and f"against 0.5000 of {delay} ms" in equal.decided
    other = ensemble_verdict("C25", "mean_hs_near_axis", **{"dsnn:tau_s=200,10": {6: 0.95}})
    assert other.verdict == "holds" and "0.95 at 6" in other.measured, "the other reading decides nothing"


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
    judged = outcome("C29", as_many, T)
    assert judged.verdict == "fails" and "60.0 spikes at 6 cm/s, +0.0 against 60.0 at 10" in judged.decided
    whole = [row | {"spikes": 0} for row in trials]
    assert outcome("C29", whole, T).verdict == "holds", "not the count of the whole crossing"
