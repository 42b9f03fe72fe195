"""The one counter: which word follows from which counts, and that no sentence can be read the wrong way round."""

import itertools

import pytest

from experiments.declare.outcome import REASONS
from experiments.judge.tests import proportion_interval
from experiments.judge.verdict import Count, count
from experiments.paper.page import totals


@pytest.mark.parametrize(
    ("holds", "fails", "word"),
    [(40, 0, "holds"), (44, 4, "holds"), (38, 2, "holds"), (37, 3, "sometimes"), (20, 0, "holds"), (19, 1, "sometimes"),
     (19, 0, ""), (3, 37, "sometimes"), (2, 38, "fails"), (4, 44, "fails"), (0, 20, "fails"), (1, 0, ""), (4, 1, "")],
)  # fmt: skip
def test_the_word_of_the_rule_in_claims_toml(holds, fails, word):
    """Its own examples: 38 of 40 and 20 of 20 hold, 37 of 40 do not; 2 of 40 fails, 3 of 40 does not."""
    assert Count(holds, fails).word == word


def test_the_word_follows_from_the_exact_interval_of_the_judged_alone():
    for holds, fails, unjudged in itertools.product(range(0, 45, 4), range(0, 45, 4), (0, 3, 30)):
        if not holds + fails + unjudged:
            continue
        tally = Count(holds, fails, {"not shown": unjudged})
        assert tally.word == (Count(holds, fails).word if holds + fails else "")
        assert tally.replicates == holds + fails + unjudged and tally.judged == holds + fails
        assert tally.interval == (proportion_interval(holds, holds + fails) if holds + fails else None)
        assert tally.state == (Count(holds, fails).state if holds + fails else "unjudged")


def test_where_nothing_is_random_one_replicate_says_all():
    assert (Count(1, random=False).word, Count(0, 1, random=False).word) == ("holds", "fails")
    assert Count(1, random=False).interval is None and "nothing in it is random" in Count(0, 1, random=False).sentence()
    assert Count(0, 0, {"not shown": 1}, random=False).state == "unjudged"


def test_outcomes_are_counted_each_once():
    texts = ["holds", "fails", *REASONS, "holds", "silent model"]
    tally = count(texts)
    assert (tally.holds, tally.fails, tally.replicates) == (2, 1, len(texts))
    assert tally.unjudged == {"judge failed": 1, "not shown": 1, "silent model": 2, "unknown constants": 1}


@pytest.mark.parametrize(
    ("held", "failed", "word", "half"),
    [(40, 0, "", "holds"), (35, 5, "", "sometimes"), (15, 5, "", "sometimes"), (4, 1, "", "4 of 5"),
     (2, 38, "fails", "fails"), (10, 30, "", "sometimes")],
)  # fmt: skip
def test_a_claim_about_unknown_constants_has_the_word_of_the_dsnns_half_where_that_fails_and_else_none(
    held, failed, word, half
):
    """Replicates in which the half holds leave the count, so those that are left would all fail."""
    tally = Count(0, failed, {"unknown constants": held})
    assert tally.word == word and tally.half.label == half and (tally.half.holds, tally.half.fails) == (held, failed)
    assert tally.state == (word or "unjudged") and (tally.label == "not judged") == (not word)
    assert f"the DSNN's half holds in {held} of {held + failed} replicates" in tally.sentence()
    (phrase,) = [text for text in totals([("C26", tally)]) if "C26" in text]
    assert f"C26 (the DSNN's half: {half})" in phrase or word == "fails"
    assert Count(0, failed or 1).half is None and Count(3, unjudged={"not shown": 1}).half is None
