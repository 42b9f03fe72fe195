"""Verdicts in files: what is written is read back, and files of the version before are read with today's words."""

import json
import math

import pytest

from experiments import Check, Outcome
from experiments.bench.judging.count import REASONS, Count
from experiments.bench.judging.stored import VERSION, document, verdicts
from experiments.bench.judging.verdict import Verdict

CHECKS = (Check("3 spikes", 3.0, 2.0, unit="spikes"), Check("no number", math.nan, (0.4, 0.6), "within", scale=0.1))
OUTCOMES = {
    "many": [Outcome("holds", "3 spikes", "delta 1", 9, "3 (needs 2)", 3, 0, checks=CHECKS)] * 20,
    "mixed": [
        Outcome("fails", "m"),
        Outcome("holds", "m"),
        *(Outcome.unjudged("w", reason=reason) for reason in REASONS),
    ],
    "on equal terms": [Outcome("fails", "m", equal=Outcome("holds", "again", checks=CHECKS)), Outcome("holds", "m")],
    "broken": [Outcome("not shown", "its judge failed", trouble="line 3")],
}


@pytest.mark.parametrize("name", OUTCOMES)
@pytest.mark.parametrize("random", [True, False])
def test_what_is_written_is_read_back(name, random):
    verdict = Verdict.of(("C1", "says", "source"), OUTCOMES[name], random=random, model="dsnn", experiment="speed")
    content = json.loads(json.dumps(document([verdict, verdict]), allow_nan=False))
    assert content["version"] == VERSION and len(content["claims"]) == 2
    assert content["claims"][0]["word"] == verdict.count.word
    first, second = verdicts(content)
    for again in (first, second):
        assert str(again) == str(verdict), "NaN is not equal to itself"
    if name == "on equal terms":
        assert verdict.equal == Count(1, 0, {"not shown": 1}, random)


BEFORE = {
    "id": "C17", "says": "approach: fewest spikes at 0", "source": "robot-sys-ar", "verdict": "holds",
    "measured": "mean spikes at -30 degrees: 14.0 [13.2, 14.8]", "effect": "against |angle|: tau +0.83", "n": 25,
    "decided": "1.0 spikes at 15 degrees (needs more than at 0: 0.0)", "model": "", "experiment": "angular-approach",
    "replicates": 2, "replicates_held": 2, "replicates_failed": 0, "replicates_vacuous": 0,
    "replicates_untestable": 0, "replicates_untested": 0, "standing": "so far",
    "held": "held in 2 of 2 short replicates so far", "overall": "holds",
    "interval": "16% to 100% of replicates (exact 95 % interval of the share in which it holds)", "rate": "",
    "pooled": "holds: mean spikes", "tried": "", "used_to_choose": "half wave rectified F",
    "mechanism": "its own figure", "other_reading": "", "assumed": "", "provenance": "", "trouble": "",
}  # fmt: skip
"""A verdict as the version before wrote it into the folder of a reproduction."""
COUNTED = tuple(f"replicates{name}" for name in ("", "_held", "_failed", "_vacuous", "_untestable", "_untested"))
OF_A_RUN = {
    "verdict": "untested", "measured": "needs at least 4 trials of each condition (has 1); measured: 0.0",
    "decided": "", "model": "dsnn", "experiment": "", "standing": "", "held": "", "overall": "",
    **dict.fromkeys(COUNTED),
}  # fmt: skip
"""What differs in the folder of a run, where replicates were not counted."""
NOT_HELD = {"verdict": "vacuous", "replicates": 5, "replicates_held": 1, "replicates_failed": 1,
            "replicates_vacuous": 1, "replicates_untestable": 1, "replicates_untested": 1}  # fmt: skip


@pytest.mark.parametrize(
    ("changes", "first", "count"),
    [
        ({}, "holds", Count(2)),
        (OF_A_RUN, "not shown", Count(0, 0, {"not shown": 1})),
        (NOT_HELD, "silent model", Count(1, 1, dict.fromkeys(["not shown", "silent model", "unknown constants"], 1))),
        ({"verdict": "untestable", "replicates_held": 0, "replicates_untestable": 2, "standing": "untestable"},
         "unknown constants", Count(0, 0, {"unknown constants": 2})),
        ({"replicates": 1, "replicates_held": 1, "standing": "deterministic"}, "holds", Count(1, random=False)),
        ({"replicates": 20, "replicates_held": 18, "replicates_failed": 2, "standing": "robust"}, "holds",
         Count(18, 2)),
    ],
)  # fmt: skip
def test_a_file_of_the_version_before_is_read_with_todays_words(changes, first, count):
    (verdict,) = verdicts(json.loads(json.dumps([{**BEFORE, **changes}])))
    assert (verdict.outcome.verdict, verdict.count, verdict.count.word) == (first, count, count.word)
    assert verdict.outcome.n == 25 and (verdict.id, verdict.source) == ("C17", "robot-sys-ar")


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (3, "no object"), ([3], "no object"), ({"claims": []}, "version=None: legal is 2"),
        ({"version": 3, "claims": []}, "version=3: legal is 2"), ({"version": 2, "claims": [{"id": "C1"}]}, "claim C1"),
        ([{"id": "C1"}], "claim C1: a field lacks"), ([{**BEFORE, "verdict": "perhaps"}], "verdict='perhaps'"),
        ([{**BEFORE, "replicates_held": -1}], "legal is 0 or more"),
    ],
)  # fmt: skip
def test_what_is_no_file_of_verdicts_is_refused_in_one_line(content, message):
    with pytest.raises(ValueError, match=message) as refused:
        verdicts(content)
    assert "\n" not in str(refused.value)
