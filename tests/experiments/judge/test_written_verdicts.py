"""Verdicts in files: what is written is read back."""

import json
import math

import pytest

from experiments import Check, Outcome
from experiments.declare.outcome import REASONS
from experiments.judge.verdict import Count, document, verdict_of, verdicts
from experiments.kinds.registry import find_claim

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
    verdict = verdict_of(find_claim("C1", "clips"), OUTCOMES[name], random=random, model="dsnn", experiment="speed")
    content = json.loads(json.dumps(document([verdict, verdict]), allow_nan=False))
    assert len(content["claims"]) == 2
    assert content["claims"][0]["word"] == verdict.count.word
    first, second = verdicts(content)
    for again in (first, second):
        assert str(again) == str(verdict), "NaN is not equal to itself"
    if name == "on equal terms":
        assert verdict.equal == Count(1, 0, {"not shown": 1}, random)
