"""Replicates of a reproduction: what each claim comes to in them, of a silent model too."""

import dataclasses

import pytest

from experiments import Outcome
from experiments.declare.claim import POTENTIALS, Claim, texts
from experiments.declare.conditions import CONDITION_COLUMNS
from experiments.judge.judge import SIGNED
from experiments.judge.replicates import Replicate, of_model, of_models
from experiments.judge.verdict import Count
from experiments.kinds.registry import claims_on, find_claim
from experiments.paper import reproduce
from tests.experiments.judge.test_judges import enough as trials_of, outcome
from tests.helpers import clip_rows
from tests.helpers.clip_rows import enough
from tests.helpers.paper import design, every

CLAIMS = claims_on("robot")
HOLDS = Outcome("holds", "as measured")

T, T_CLIPS = 0.2, {"dsnn": 0.16, "dsn2017": 0.16, "emd": None, "dsnn-on-blocked": 0.16, "dsnn-off-blocked": 0.16}


# Silence.


def silent_trials(claim):
    silent = {"peak_hs": 0.0, "trough_hs": 0.0, **dict.fromkeys(CLAIMS[claim].reads, 0), "spikes": 0}
    return [{**row, **silent} for row in trials_of(claim, 10)]


def translation(spikes):
    return {**dict.fromkeys(CONDITION_COLUMNS), **trials_of("C14", 1)[0], "spikes": spikes}


@pytest.mark.parametrize("claim", CLAIMS)
def test_no_claim_about_the_robot_holds_of_a_network_that_never_answers(claim):
    silent = silent_trials(claim)
    judged = outcome(claim, silent, T, all_rows=[*silent, translation(0)])
    assert judged.verdict == ("silent model" if CLAIMS[claim].silent_passes else "fails"), judged.measured


@pytest.mark.parametrize("claim", claims_on("clips"))
def test_no_claim_about_clips_holds_of_a_network_that_never_answers(claim):
    """The other models of a claim answer as they do; only the DSNN is silent."""

    def silent(row):
        if row["model"] != "dsnn":
            return row
        answers = {name for name in row if name.startswith("hs_") and row[name] is not None}
        return {**row, **dict.fromkeys({*POTENTIALS, *answers}, 0.0)}

    rows = [silent(row) for row in enough(claim)]
    moving = silent({**enough("C1")[0], "motion": "rightward"})
    judged = clip_rows.judge(claim, rows, T_CLIPS, [*rows, moving])
    assert judged.verdict == ("silent model" if find_claim(claim, "clips").silent_passes else "fails"), judged.measured


def crossings(**spikes):
    """Crossings at 8 cm: a speed's name -> the counts of its trials."""
    return [
        {**translation(count), "speed_cm_s": float(name.removeprefix("at_"))}
        for name, counts in spikes.items()
        for count in counts
    ]


@pytest.mark.parametrize(
    ("shown", "verdict"),
    [
        (crossings(at_4=[5, 5], at_6=[5, 5], at_10=[5, 5]), "holds"),
        (crossings(at_2=[0, 0], at_4=[5, 5], at_6=[5, 5], at_10=[5, 5]), "holds"),  # of 2 cm/s the paper says nothing
        (crossings(at_4=[5, 0], at_6=[5, 5], at_10=[5, 5]), "holds"),  # half of the trials
        (crossings(at_4=[5, 0, 0], at_6=[5, 5], at_10=[5, 5]), "silent model"),
        (crossings(at_4=[0, 0], at_6=[0, 0], at_10=[5, 5]), "silent model"),  # one speed of three is not the paper's
        (crossings(at_15=[5, 5], at_4=[0], at_6=[0], at_10=[0]), "silent model"),  # nor another
        (crossings(at_6=[5, 0]), "holds"),  # what was not shown is not asked
        (crossings(at_15=[5, 0, 0]), "silent model"),  # of others where none of these was shown
        (crossings(at_15=[5, 0]), "holds"),
        ([], "holds"),  # not checked where nothing moves across
    ],
)
def test_c13_is_kept_by_a_silent_model_unless_it_answers_at_the_paper_s_own_speeds(shown, verdict):
    silent = silent_trials("C13")
    judged = outcome("C13", silent, T, all_rows=[*silent, *shown])
    assert judged.verdict == verdict and ("not checked" in judged.measured) == (not shown)
    assert judged.decided.endswith("answered") == (verdict == "silent model")
    spiking = outcome("C13", [{**row, "spikes": 1} for row in silent], T, all_rows=shown)
    assert spiking.verdict == "fails", "what does not hold fails"


def crossing_clip(level, stimulus="plain", motion="rightward", **changes):
    """A crossing of which the potential of its direction goes so far, to its side."""
    column, sign = SIGNED[motion]
    zero = dict.fromkeys(POTENTIALS, 0.0)
    more = {"speed": 120.0, "background_speed": -8.0 if stimulus == "cluttered" else None}
    return {**enough("C1")[0], **zero, "stimulus": stimulus, "motion": motion, column: sign * level, **more, **changes}


@pytest.mark.parametrize("claim", ["C2", "C3", "C5", "C8"])
@pytest.mark.parametrize(
    ("shown", "answers"),
    [
        ([crossing_clip(0.17, motion="upward")], True),
        ([crossing_clip(0.17, motion="leftward")], True),
        ([crossing_clip(0.16)], False),
        ([crossing_clip(-0.3, motion="leftward")], False),  # to the other side
        ([crossing_clip(0.2), crossing_clip(0.0)], True),  # half of them
        ([crossing_clip(0.2), crossing_clip(0.0), crossing_clip(0.0)], False),
        ([crossing_clip(0.2), crossing_clip(0.0, "cluttered")], False),  # each kind by itself
        ([crossing_clip(0.2), crossing_clip(0.0, "cluttered", speed=40.0)], True),  # which the paper only ranks
        ([crossing_clip(0.2), crossing_clip(0.0, "cluttered", grey=128.0)], True),
        ([crossing_clip(0.0), crossing_clip(0.9, "cluttered", speed=300.0)], False),
        ([crossing_clip(0.2), *[crossing_clip(0.0, speed_unit="px/frame")] * 2], True),  # at 120 px a second
        ([crossing_clip(0.2), *[crossing_clip(0.0, object="absent")] * 2], True),  # nothing crosses
        ([crossing_clip(0.2, speed=33.0), crossing_clip(0.0, speed=33.0)], True),  # none of the paper's was shown
        ([crossing_clip(0.2, speed=33.0), *[crossing_clip(0.0, speed=33.0)] * 2], False),
    ],
)
def test_a_claim_about_clips_needs_answers_at_the_paper_s_own_speeds(claim, shown, answers):
    rows = [row for row in enough(claim) if row["motion"] not in SIGNED] if claim in ("C3", "C5") else enough(claim)
    best = "unknown constants" if "of_dsnn" in texts()[claim] else "holds"
    assert clip_rows.judge(claim, rows, T_CLIPS, shown).verdict == (best if answers else "silent model")
    other = {**crossing_clip(0.9), "model": "dsn2017"}
    judged = clip_rows.judge(claim, rows, T_CLIPS, [other])
    assert judged.verdict == best and "not checked against translation" in judged.measured


# Replicates of a reproduction.


def rows_of(specs, **changes):
    """Rows of planned trials, as a model that spikes in every crossing and nowhere else answers them."""
    return [
        {
            "trial": spec.index, "experiment": spec.experiment, "model": model.label, "path_error_mm": 0.1,
            **dataclasses.asdict(spec.condition), "achieved_speed_cm_s": spec.condition.speed_cm_s,
            "spikes": 5 * (spec.condition.motion == "translation"), "peak_hs": 0.1, "trough_hs": -0.1, **changes,
        }
        for spec in specs
        for model in spec.settings.models
    ]  # fmt: skip


def planned_rows(count, repeats=5):
    plan = design(count, repeats)
    return plan, rows_of(plan.specs)


def test_the_count_has_replicate_0_and_the_rate_all_trials():
    cases, rows = planned_rows(3)
    one = next(row for row in rows if row["experiment"] == "general" and row["angle_deg"] == 0.0)
    one["spikes"] = 2  # in replicate 0
    verdicts = {claim.id: claim for claim in reproduce.verdicts(every(cases, rows), [])}
    c13, whole = verdicts["C13"], reproduce.pooled(every(cases, rows))
    assert (c13.outcome.verdict, c13.count) == ("fails", Count(2, 1))
    assert (whole["C13"].verdict, whole["C13"].broken, whole["C13"].n) == ("fails", 1, 60)
    assert c13.outcome.n == 20, "the straight trials of replicate 0, of three experiments"
    assert c13.experiment == "general, angular-approach, angular-recession"
    assert all(claim.count.replicates == 3 for claim in verdicts.values() if claim.experiment)
    assert set(whole) == {claim.id for claim in verdicts.values() if claim.experiment}
    assert "lgmd1" in verdicts["C21"].outcome.measured


@pytest.mark.parametrize("experiment", ["general", "angular-approach", "angular-recession"])
def test_c13_is_of_every_straight_trial_of_a_replicate(experiment):
    """One spike in any of its experiments refutes it, one in an oblique trial does not; one lost leaves it unjudged."""
    cases, rows = planned_rows(1)

    def judged(found):
        (c13,) = [claim for claim in reproduce.verdicts(every(cases, found), []) if claim.id == "C13"]
        return c13.outcome.verdict

    for angle, verdict in ((0.0, "fails"), (15.0, "holds")):
        there = [row for row in rows if row["experiment"] == experiment and row["angle_deg"] == angle]
        if there:
            assert judged([{**row, "spikes": 1} if row is there[0] else row for row in rows]) == verdict
    lost = next(row for row in rows if row["experiment"] == experiment and row["model"] == "dsnn")
    assert judged([row for row in rows if row is not lost]) == "not shown"


def test_a_replicate_with_a_trial_missing_is_not_whole():
    """It is not judged in the claims that its experiment answers for, and in no other."""
    cases, rows = planned_rows(2)
    lost = next(row for row in rows if row["experiment"] == "general" and row["motion"] == "translation")
    kept = [row for row in rows if row is not lost]
    whole, part = ({c.id: c for c in reproduce.verdicts(every(cases, r), [])} for r in (rows, kept))
    assert part["C13"].count.unjudged == {"not shown": 1}
    assert part["C13"].count.holds == whole["C13"].count.holds - 1
    assert part["C16"] == whole["C16"]


@pytest.mark.parametrize(("failing", "lost"), [("lgmd1", "lgmd2"), ("lgmd2", "lgmd1")])
def test_a_detector_that_fails_fails_the_claim_of_both_whatever_became_of_the_other(failing, lost):
    cases, rows = planned_rows(1)
    flat = [{**row, "spikes": 1} if row["model"] == failing else row for row in rows if row["model"] != lost]
    (c21,) = [claim for claim in reproduce.verdicts(every(cases, flat), []) if claim.id == "C21"]
    assert c21.outcome.verdict == "fails" and f"{lost} not shown" in c21.outcome.measured


def test_a_looming_claim_of_a_model_that_tells_direction_too_is_judged_by_its_looming_detector():
    asked = []
    claim = Claim(id="mine", says="-", about="looming",
                  judge=lambda rows, threshold: asked.append((rows[0]["spikes"], threshold)) or [])  # fmt: skip
    row = {**translation(99), "model": "both", "experiment": "general", "looming_spikes": 2}
    of_model(claim, Replicate((row,), {}, {"both": {"hs": 0.2, "looming": 0.7}}), "both", "general")
    assert asked == [(2, 0.7)]


def test_a_claim_that_names_its_models_is_asked_about_its_own_experiment_and_trials_lost_are_of_their_model():
    asked = []
    claim = Claim(id="mine", says="-", models={"a", "b"},
                  judge=lambda rows, threshold: asked.append([row["experiment"] for row in rows]) or HOLDS)  # fmt: skip
    both = [{**translation(9), "model": model, "experiment": place} for place in ("speed", "other") for model in "ab"]
    of_lost = [
        of_models(
            dataclasses.replace(claim, least=1),
            Replicate(tuple(both), {("speed", lost): 1}, {"a": {"hs": 0.2}}),
            "speed",
        )
        for lost in "ac"
    ]
    assert asked == [["speed"] * 2] * 2 and [outcome.verdict for outcome in of_lost] == ["not shown", "holds"]
    plan, rows = planned_rows(1)
    gone = next(row for row in rows if row["model"] == "lgmd1")
    (trials,) = every(plan, [row for row in rows if row is not gone])
    assert {key for key, number in trials.lost.items() if number} == {(gone["experiment"], "lgmd1")}


def test_no_two_replicates_share_a_trial_s_seed():
    """That replicate r is the whole design at the seed plus r is a law of sweeps."""
    first, second, third = ({spec.seed for spec in design(1, 5, seed).specs} for seed in range(3))
    assert not first & second and not second & third and not first & third
