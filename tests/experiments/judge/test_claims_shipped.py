"""The claims that ship: each has its words and a judge of each kind, and experiments declare what can be judged."""

from dataclasses import replace

import pytest

from experiments.base.errors import UsageError
from experiments.declare.claim import BEHAVIOURS, PAPER, claim_ids, texts
from experiments.kinds import registry
from experiments.kinds.registry import claims_on, find_claim
from experiments.kinds.tables import NAMES, OFFLINE

KINDS = ("clips", "robot", "footage", "behaviours")
WORDS = ("says", "source", "title")


def test_every_claim_has_its_words_and_a_judge():
    assert claim_ids(PAPER) == tuple(f"C{number}" for number in range(1, 33))
    assert claim_ids() == (*claim_ids(PAPER), *(f"B{number}" for number in range(1, 5)))
    judged = [claim for kind in KINDS for claim in claims_on(kind)]
    assert sorted(judged) == sorted((*claim_ids(), "C24")), "C24 is judged on clips and on the robot"


@pytest.mark.parametrize("claim", claim_ids())
def test_the_words_of_a_claim_are_complete(claim):
    told = texts()[claim]
    assert told["says"] and 0 < len(told["title"]) <= 40 and "\n" not in repr(told)
    assert claim in claim_ids(BEHAVIOURS) or told["source"].startswith(("Fig. ", "Eq. ")), "a place in the paper"
    if experiment := told.get("mechanism"):
        assert experiment in (*NAMES, *OFFLINE) and texts()["mechanisms"][experiment]
    assert ("tried" in told) == ("cause" in told), "why it fails is told where it is told what was tried"
    for kind in KINDS:
        for declared in [claims_on(kind)[claim]] if claim in claims_on(kind) else []:
            assert [getattr(declared, name) for name in WORDS] == [told.get(name, "") for name in WORDS]
            assert declared.judge.__doc__.startswith("Judge") and not declared.own, "how the words are read"


def test_a_claim_is_found_by_its_kind_alone():
    assert find_claim("C24", "clips").judge is not find_claim("C24", "robot").judge
    with pytest.raises(KeyError):
        find_claim("C1", "robot")


@pytest.mark.parametrize(("name", "claim"), [("speed", "C1"), ("clean", "C15"), ("clean", "B1"), ("speed", "C77")])
def test_a_claim_that_trials_of_that_kind_cannot_answer_for_is_refused(name, claim):
    experiment = replace(registry.find(name), claims=(claim,))
    with pytest.raises(UsageError, match=f"claim '{claim}'"):
        registry.check_claims(experiment, "mine.py")
