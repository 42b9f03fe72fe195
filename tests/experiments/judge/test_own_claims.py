"""Claims of a person's own: judged as they say, refused in one line, and never the end of a run."""

import pytest

from experiments import Check, Claim, Clip, Experiment, OfflineExperiment, Outcome, Translation, decide
from experiments.declare.outcome import strength
from experiments.judge.judge import judge
from tests.experiments.judge.test_judges import rows as judged_rows

HOLDS = Outcome("holds", "as measured")
ANSWERED = dict.fromkeys(("peak_hs", "trough_hs", "peak_vs", "trough_vs"), 0.5)


def rows(number, **changes):
    """Trials of a crossing with nine spikes each."""
    whole = {"far_cm": None, "acceleration_cm_s2": 100.0}
    return [{**whole, **row} for row in judged_rows({6: [9] * number}, "speed_cm_s", **changes)]


def claim(outcome=HOLDS, **changes):
    return Claim(**{"id": "mine", "says": "as I say", "judge": lambda rows, threshold: outcome, **changes})


def experiment(*claims):
    return Experiment("mine", "mine", Translation((30.0,), (8.0,)), "speed_cm_s", claims=claims)


def clips(*claims):
    return OfflineExperiment("mine", "mine", (Clip("right", "plain"),), ("dsnn",), claims)


WRONG = {
    "the paper's id": lambda: claim(id="C13"),
    "the paper's id for clips": lambda: claim(on="clips", id="C1"),
    "no words": lambda: claim(says=""),
    "an id with blanks": lambda: claim(id="my claim"),
    "no judge": lambda: claim(judge="mine"),
    "models as a text": lambda: claim(on="clips", models="dsnn"),
    "a value alone": lambda: claim(on="clips", conditions={"motion": "rightward"}),
    "twice": lambda: experiment(claim(), claim()),
    "one alone": lambda: Experiment("mine", "", Translation((30.0,), (8.0,)), "speed_cm_s", claims=claim()),
    "no verdict": lambda: Outcome("yes", ""),
    "a side that there is not": lambda: Check("3 spikes", 3, 2, "over"),
    "one bound in place of two": lambda: Check("3 spikes", 3, 2, "within"),
    "two bounds in place of one": lambda: Check("3 spikes", 3, (2, 4)),
}


@pytest.mark.parametrize("what", WRONG)
def test_what_is_no_claim(what):
    with pytest.raises(ValueError) as refused:
        WRONG[what]()
    assert "\n" not in str(refused.value)


def test_a_judge_decides():
    def faster(claim_rows, threshold):
        mean = sum(row["spikes"] for row in claim_rows) / len(claim_rows)
        return Outcome.of([Check(f"{mean} spikes", mean, 1)])

    whole = rows(4) + rows(3, far_cm=1.0)
    told = judge(claim(judge=faster, least=3), whole, 0.2)
    assert (told.verdict, told.n, told.decided) == ("holds", 7, "9.0 spikes (needs above 1)")
    few = judge(claim(judge=faster), whole, 0.2)
    assert few.verdict == "not shown" and "needs at least 4 trials of each condition (has 3)" in few.measured
    of_two = [{**row, "model": name} for name in ("dsnn", "emd") for row in rows(3)]
    assert judge(claim(judge=faster, models={"dsnn", "emd"}), of_two, 0.2).verdict == "not shown", "3 of each model"


def test_what_has_no_number_decides_last_of_the_checks_that_fail():
    nothing, little, far = (Check(f"{reading}", reading, 5) for reading in (float("nan"), 4.0, 1.0))
    assert sorted([nothing, little, Check("9", 9, 5), far], key=strength)[:3] == [far, little, nothing]
    assert decide([Check("9", 9, 5), nothing]) == (False, nothing.text)


def broken(claim_rows, threshold):
    return claim_rows[0]["no such column"]


ANSWERS = {
    "an exception": (broken, "no such column"),
    "a text": (lambda claim_rows, threshold: "holds", "'holds'"),
    "another verdict": (lambda claim_rows, threshold: Outcome("perhaps", ""), "perhaps"),
}


@pytest.mark.parametrize("what", ANSWERS)
def test_a_judge_that_breaks_leaves_its_claim_unjudged(what):
    failing_judge, message = ANSWERS[what]
    verdict = judge(claim(judge=failing_judge), rows(5), 0.2)
    assert verdict.verdict == "judge failed" and message in verdict.trouble
    clip_rows = [{"model": "dsnn", "clip": "a", "object": "present", "motion": "rightward", **ANSWERED}]
    assert message in judge(claim(on="clips", judge=failing_judge), clip_rows, 0.1).trouble


def test_a_judge_is_not_asked_about_nothing():
    """Every trial of a model may fail; a judge that takes the largest of its rows has none then."""
    broken = judge(claim(judge=lambda rows, threshold: max(row["spikes"] for row in rows)), [], 0.2)
    assert broken.verdict == "not shown" and "nothing to judge it on was shown" in broken.measured


def test_what_a_judge_changes_of_its_rows_is_its_own():
    def greedy(trials, threshold):
        found = min(row.pop("spikes") for row in trials)
        return [Check("spikes", found, 0)]

    whole = rows(5)
    assert judge(claim(judge=greedy), whole, 0.2).verdict == "holds"
    assert judge(claim(judge=greedy), whole, 0.2).verdict == "holds"


def test_columns_that_there_are_not():
    assert judge(claim(reads=("spike",)), rows(5), 0.2).verdict == "not shown"
    clip_rows = [{"model": "dsnn", "clip": "a", "object": "present"}]
    assert judge(claim(on="clips", conditions={"speed_px": (1.0,)}), clip_rows, 0.1).verdict == "not shown"


def test_clips_that_a_claim_is_about():
    asked = []
    looks = {"background_mean": 90.0, **ANSWERED}
    clip_rows = [{"model": model, "clip": clip, "object": clip, "motion": clip, "grey": grey, **looks}
             for model in ("emd", "dsnn") for clip, grey in (("absent", 0.0), ("present", 255.0))]  # fmt: skip

    def heed(claim_rows, threshold):
        asked.append(([(row["model"], row["clip"]) for row in claim_rows], threshold))
        return HOLDS

    assert judge(claim(on="clips", judge=heed), clip_rows, 0.1).verdict == "holds"
    of_emd = claim(on="clips", judge=heed, models={"emd"}, conditions={"shade": ("light",)})
    assert judge(of_emd, clip_rows, 0.3).verdict == "holds"
    assert asked == [([("dsnn", "absent"), ("dsnn", "present")], 0.1), ([("emd", "present")], 0.3)]
    assert judge(claim(on="clips", models=("flow",)), clip_rows, 0.1).measured == "needs flow"
