"""What the verdicts of several replicates come to, and in which words: nobody can read them the wrong way round."""

import dataclasses
import itertools
import re

import pytest

from experiments import Claim, Outcome
from experiments.bench.clips import claims as clips_claims
from experiments.bench.clips.judging import SIGNED
from experiments.bench.engine.terminal import show_verdict
from experiments.bench.judging.claim_files import PAPER, claim_ids
from experiments.bench.judging.claims import used_to_choose
from experiments.bench.judging.overall import MEANINGS, SIGNS, grouped, totals
from experiments.bench.judging.replicates import Replicates, counted
from experiments.bench.judging.statistics import proportion_interval
from experiments.bench.judging.verdict import Verdict, together
from experiments.bench.public.result import CLAIM_SCHEMA
from experiments.bench.reproduction import claims, robustness
from experiments.bench.reproduction.table import show_claims
from experiments.bench.robot.claims import judge, paper_claims
from experiments.bench.robot.experiment import CONDITION_COLUMNS
from tests.bench.clips.test_clip_judges import enough
from tests.bench.robot.test_judges import enough as trials_of
from tests.helpers.paper import design, every

CLAIMS = paper_claims()

T, T_CLIPS = 0.2, {"dsnn": 0.16, "dsn2017": 0.16, "emd": None, "dsnn-on-blocked": 0.16, "dsnn-off-blocked": 0.16}


@pytest.mark.parametrize(
    ("held", "failed", "standing", "words"),
    [
        (20, 0, "robust", "held in 20 of 20 replicates: robust"),
        (18, 2, "robust", "held in 18 of 20 replicates: robust"),
        (17, 3, "fragile", "held in 17 of 20 replicates: fragile"),
        (0, 20, "never held", "held in 0 of 20 replicates: it never held"),
        (19, 0, "so far", "held in 19 of 19 replicates so far"),
        (4, 1, "so far", "held in 4 of 5 replicates so far"),
        (1, 0, "so far", "held in 1 of 1 replicate so far"),
        (36, 4, "robust", "held in 36 of 40 replicates: robust"),
        (35, 5, "fragile", "held in 35 of 40 replicates: fragile"),
    ],
)
def test_standing(held, failed, standing, words):
    found = Replicates(held, failed)
    assert (found.standing, str(found)) == (standing, words)


def test_what_could_not_be_judged_and_what_was_vacuous_did_not_hold():
    assert str(Replicates(17, untested=3)) == "held in 17 of 20 replicates: fragile; not judged in 3"
    assert str(Replicates(3, vacuous=2)) == "held in 3 of 5 replicates so far; vacuous in 2"
    assert str(Replicates(0, untested=5)) == "could not be judged in any of 5 replicates"
    assert Replicates(0, untested=20).standing == "unjudged"
    assert str(Replicates(1, random=False)).startswith("held in 1 of 1 replicate; nothing in it is random")
    assert str(Replicates(18, untestable=2)) == "held in 18 of 20 replicates: robust; untestable in 2"
    assert str(Replicates(2, name="short replicate")) == "held in 2 of 2 short replicates so far"


def test_a_claim_that_hangs_on_unknown_constants_is_not_counted_as_one_that_failed():
    """However many replicates there are: what it comes to is not known, robust or fragile."""
    for failed in (0, 5):
        found = Replicates(0, failed, untestable=20 - failed)
        assert found.standing == "untestable" and found.of == 20
        assert str(found).startswith(f"untestable in {20 - failed} of 20 replicates: another model's constants")
        assert str(found).endswith("held in 0 of the other 5") == bool(failed)
    assert Replicates(0, untested=2, untestable=1).standing == "untestable"
    assert counted(["untestable", "holds", "fails"]).fields()["replicates_untestable"] == 1


def test_the_worst_of_several_verdicts_comes_first():
    words = ["fails", "untested", "untestable", "vacuous", "holds"]
    for place, word in enumerate(words):
        assert together(words[place:]) == word


def test_every_sentence_begins_with_what_held():
    """Whatever the counts, the first number is that of the replicates that held, of all there are."""
    for counts in itertools.product(range(0, 23, 2), repeat=4):
        if not sum(counts):
            continue
        found = Replicates(*counts)
        said = str(found)
        assert "fail" not in said and "hold " not in said
        if found.standing == "unjudged":
            assert "held" not in said
        else:
            assert re.match(rf"held in {found.held} of {sum(counts)} replicates?\b", said)
        assert (found.standing == "robust") == (sum(counts) >= 20 and 10 * found.held >= 9 * sum(counts))


@pytest.mark.parametrize("wrong", [(-1, 2), (0, 0)])
def test_counts_that_cannot_be(wrong):
    with pytest.raises(ValueError, match="legal is"):
        Replicates(*wrong)


def verdict(first, others, **more):
    return Verdict(
        "C13", "straight is silent", "robot-general-tests", first, "as measured", experiment="general",
        **counted([first, *others]).fields(), **more,
    )  # fmt: skip


@pytest.mark.parametrize("word", ["holds", "fails", "vacuous", "untestable", "untested"])
def test_a_verdict_that_its_counts_contradict_is_refused(word):
    """Replicate 0 is one of the replicates: a claim that fails there cannot have held in all of them."""
    for other in {"holds", "fails", "vacuous", "untestable", "untested"} - {word}:
        with pytest.raises(ValueError, match=f"{word} in replicate 0, and in 0 of 20"):
            dataclasses.replace(verdict(other, [other] * 19), verdict=word)
    with pytest.raises(ValueError, match="do not add up"):
        dataclasses.replace(verdict(word, [word] * 19), replicates=21)
    assert verdict(word, ["holds"] * 19).verdict == word


def test_no_page_or_table_puts_a_count_of_what_held_behind_the_word_fails(capsys):
    """Earlier pages said "fails at 20 of 20 seeds" of a claim that held in all of them."""
    for held, word in itertools.product(range(20), ("holds", "fails", "vacuous", "untested")):
        one = verdict(word, ["holds"] * held + ["fails"] * (19 - held))
        show_verdict(one, model=True)
        show_claims([one])
        said = " ".join(capsys.readouterr().out.split())
        in_all = held + (word == "holds")
        assert f"held in {in_all} of 20 replicates" in said
        for other in (word, "fails", "untested"):
            assert not re.search(rf"{other}\W+(at|in) \d+ of", said)


def test_the_terminal_s_columns_stand_under_their_names(capsys):
    show_claims([verdict("fails", ["holds"] * 4)])
    names, row, *_ = capsys.readouterr().out.splitlines()
    for name, cell in (
        ("claim", "C13"),
        ("verdict", "mixed"),
        ("all replicates", "held in 4 of 5"),
        ("replicate 0", "fails"),
    ):
        assert names.index(name) == row.index(cell)


@pytest.mark.parametrize(
    ("word", "counts"),
    [
        ("holds", {"held": 18, "failed": 2}),
        ("holds", {"held": 1, "random": False}),
        ("holds", {"held": 5}),
        ("fragile", {"held": 17, "failed": 3}),
        ("fragile", {"held": 1, "failed": 19}),
        ("mixed", {"held": 4, "failed": 1}),
        ("mixed", {"held": 18, "failed": 1}),
        ("fails", {"held": 0, "failed": 20}),
        ("fails", {"held": 0, "failed": 1, "vacuous": 4}),
        ("fails", {"held": 0, "failed": 1, "random": False}),
        ("vacuous", {"held": 0, "vacuous": 5}),
        ("untestable", {"held": 2, "untestable": 3}),
        ("holds", {"held": 18, "untestable": 2}),
        ("untested", {"held": 0, "untested": 20}),
    ],
)
def test_one_word_says_what_all_replicates_come_to(word, counts):
    found = Replicates(**counts)
    assert found.overall == word == found.fields()["overall"]


def test_totals_name_every_claim_once_and_those_that_hold_first():
    words = [(f"C{place}", word) for place, word in enumerate([*MEANINGS, "fails"], start=1)]
    assert [claim for ids in grouped(words).values() for claim in ids] == [*(f"C{i}" for i in range(1, 5)), "C8", "C5",
                                                                          "C6", "C7"]  # fmt: skip
    assert totals(words)[0] == "1 of 8 claims holds"
    assert "2 fail: C4, C8" in totals(words) and len(totals(words)) == len(MEANINGS)
    assert len(set(SIGNS.values())) == len(MEANINGS) == len(SIGNS), "a sign of its own for each"
    with pytest.raises(ValueError, match="C1: overall='robust': legal is holds, fragile"):
        grouped([("C1", "robust")])


def test_a_run_s_table_has_every_field():
    assert CLAIM_SCHEMA.names == [field.name for field in dataclasses.fields(Verdict)]
    numbers = [name for name in CLAIM_SCHEMA.names if name.startswith("replicates")]
    assert all(str(CLAIM_SCHEMA.field(name).type) == "int64" for name in numbers)


# Silence.


def silent_trials(claim):
    silent = {"peak_hs": 0.0, "trough_hs": 0.0, **dict.fromkeys(CLAIMS[claim].reads, 0), "spikes": 0}
    return [{**row, **silent} for row in trials_of(claim, 10)]


def translation(spikes):
    return {**dict.fromkeys(CONDITION_COLUMNS), **trials_of("C14", 1)[0], "spikes": spikes}


@pytest.mark.parametrize("claim", CLAIMS)
def test_no_claim_about_the_robot_holds_of_a_network_that_never_answers(claim):
    silent = silent_trials(claim)
    found = judge(claim, silent, T, shown=[*silent, translation(0)])
    assert found.verdict == ("vacuous" if CLAIMS[claim].silent_passes else "fails"), found.measured


@pytest.mark.parametrize("claim", clips_claims.paper_claims())
def test_no_claim_about_clips_holds_of_a_network_that_never_answers(claim):
    """The other models of a claim answer as they do; only the DSNN is silent."""

    def silent(row):
        if row["model"] != "dsnn":
            return row
        answers = {name for name in row if name.startswith("hs_") and row[name] is not None}
        return {**row, **dict.fromkeys({*clips_claims.POTENTIALS, *answers}, 0.0)}

    rows = [silent(row) for row in enough(claim)]
    moving = silent({**enough("C1")[0], "motion": "rightward"})
    found = clips_claims.judge(claim, rows, T_CLIPS, [*rows, moving])
    assert found.verdict == ("vacuous" if clips_claims.find(claim).silent_passes else "fails"), found.measured


def test_c13_is_vacuous_only_where_translations_were_shown_and_none_was_answered():
    silent = silent_trials("C13")
    alone = judge("C13", silent, T)
    assert alone.verdict == "holds" and "not checked against translation" in alone.measured
    answered = judge("C13", silent, T, shown=[*silent, translation(0), translation(3)])
    assert answered.verdict == "holds" and "checked" not in answered.measured
    nothing = judge("C13", [*silent, translation(0)], T)
    assert nothing.verdict == "vacuous" and nothing.decided == "silent in all 1 trials of translation too"
    spiking = judge("C13", [{**row, "spikes": 1} for row in silent], T, shown=[translation(0)])
    assert spiking.verdict == "fails", "what does not hold is not vacuous"


@pytest.mark.parametrize("claim", ["C2", "C3", "C5", "C8"])
def test_a_clip_past_t_in_any_direction_is_an_answer(claim):
    rows = [row for row in enough(claim) if row["motion"] not in SIGNED] if claim in ("C3", "C5") else enough(claim)
    for motion, column, level, verdict in (
        ("upward", "trough_vs", -0.17, "holds"), ("leftward", "trough_hs", -0.17, "holds"),
        ("rightward", "peak_hs", 0.16, "vacuous"),
    ):  # fmt: skip
        zero = dict.fromkeys(clips_claims.POTENTIALS, 0.0)
        moving = {**enough("C1")[0], **zero, "motion": motion, column: level}
        assert clips_claims.judge(claim, rows, T_CLIPS, [moving]).verdict == verdict
    other = {**enough("C1")[0], "model": "dsn2017", "peak_hs": 0.9}
    said = clips_claims.judge(claim, rows, T_CLIPS, [other])
    assert said.verdict == "holds" and "not checked against translation" in said.measured


def test_a_claim_of_one_s_own_may_be_vacuous_too():
    mine = Claim(
        id="mine", says="silent", judge=lambda rows, threshold: Outcome("holds", "0"), silent_passes=True, least=1
    )  # fmt: skip
    assert judge(mine, [translation(0)], T).verdict == "vacuous"
    assert judge(mine, [translation(1)], T).verdict == "holds"


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


def made(count, repeats=5):
    plan = design(count, repeats)
    return plan, rows_of(plan.specs)


def test_replicate_r_is_the_whole_design_at_seed_plus_r():
    plan, _ = made(3)
    size = len(plan.specs) // 3
    cases = [plan.specs[size * number : size * (number + 1)] for number in range(3)]
    for seed, case in enumerate(cases):
        assert [spec.seed for spec in case] == [spec.seed for spec in design(1, 5, seed).specs]
        assert {spec.experiment for spec in case} == set(robustness.paper())
    first, second, third = ({spec.seed for spec in case} for case in cases)
    assert not first & second and not second & third
    shown = {spec.experiment: [m.label for m in spec.settings.models] for spec in cases[0]}
    assert shown[robustness.judged_in()["C21"]] == ["dsnn", "lgmd1", "lgmd2"]
    alone = design(1, 1, among=["dsnn", "emd"])
    assert {m.label for spec in alone.specs for m in spec.settings.models} == {"dsnn"}


def test_the_count_has_replicate_0_and_the_rate_all_trials():
    cases, rows = made(3)
    one = next(row for row in rows if row["experiment"] == "general" and row["angle_deg"] == 0.0)
    one["spikes"] = 2  # in replicate 0
    found = {claim.id: claim for claim in claims.verdicts(every(cases, rows), [])}
    c13 = found["C13"]
    assert (c13.verdict, c13.held) == ("fails", "held in 2 of 3 replicates so far")
    low, high = proportion_interval(1, 30)
    assert c13.rate.startswith(f"1 of 30 trials break it, 3.3% (exact 95 % interval {low:.1%} to {high:.1%})")
    assert "fails ever more surely" in c13.rate and c13.pooled.startswith("fails: ")
    assert c13.n == 10, "the numbers of the verdict are those of replicate 0"
    assert not found["C15"].rate, "a claim about means has no such rate"
    assert all(claim.replicates == 3 for claim in found.values() if claim.experiment)
    assert found["C21"].replicates == 3 and "lgmd1" in found["C21"].measured


def test_a_silent_model_s_c13_is_vacuous_in_every_replicate():
    cases, rows = made(2)
    silent = [{**row, "spikes": 0} for row in rows]
    found = {claim.id: claim for claim in claims.verdicts(every(cases, silent), [])}
    assert (found["C13"].verdict, found["C13"].replicates_vacuous) == ("vacuous", 2)
    assert found["C13"].held == "held in 0 of 2 replicates so far; vacuous in 2"


def test_a_replicate_with_a_trial_missing_is_not_whole():
    """It is untested in the claims that its experiment answers for, and in no other."""
    cases, rows = made(2)
    lost = next(row for row in rows if row["experiment"] == "general" and row["motion"] == "translation")
    kept = [row for row in rows if row is not lost]
    whole, part = ({c.id: c for c in claims.verdicts(every(cases, r), [])} for r in (rows, kept))
    assert (part["C13"].verdict, part["C13"].replicates_untested) == ("untested", 1)
    assert "1 trials of general failed" in part["C13"].measured
    assert part["C13"].replicates_held == whole["C13"].replicates_held - 1
    assert part["C16"] == whole["C16"]


@pytest.mark.parametrize(("failing", "lost"), [("lgmd1", "lgmd2"), ("lgmd2", "lgmd1")])
def test_a_detector_that_fails_fails_the_claim_of_both_whatever_became_of_the_other(failing, lost):
    cases, rows = made(1)
    flat = [{**row, "spikes": 1} if row["model"] == failing else row for row in rows if row["model"] != lost]
    (c21,) = [claim for claim in claims.verdicts(every(cases, flat), []) if claim.id == "C21"]
    assert c21.verdict == "fails" and f"{lost} untested" in c21.measured


# Used to choose.


def test_every_claim_says_which_readings_it_was_used_to_choose():
    names = {claim: [reading.name for reading in used_to_choose(claim)] for claim in claim_ids(PAPER)}
    assert names["C15"] == ["half wave rectified F", "tau s rises with spacing"]
    assert names["C6"] == names["C8"] == ["half wave rectified F", "speeds in px per second"]
    assert names["C13"] == names["C19"] == ["half wave rectified F", "start acceleration"]
    assert names["C1"] == ["half wave rectified F"], "what was chosen for all claims"
    cases, rows = made(1)
    for claim in claims.verdicts(every(cases, rows), []):
        assert claim.used_to_choose == "; ".join(names[claim.id])
