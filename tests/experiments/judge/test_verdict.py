"""What parts of a claim come to together, and what a verdict over several replicates is made of."""

import itertools

from experiments import Outcome
from experiments.declare.outcome import REASONS, together
from experiments.judge.verdict import Count, verdict_of
from experiments.kinds.registry import find_claim


def test_parts_come_to_the_same_in_every_order():
    """A part that fails fails the whole; else a part that cannot be judged leaves the whole so; else it holds."""
    words = ("holds", "fails", *REASONS)
    for parts in itertools.chain.from_iterable(itertools.product(words, repeat=number) for number in (1, 2, 3)):
        reasons = [reason for reason in REASONS if reason in parts]
        expected = "fails" if "fails" in parts else reasons[0] if reasons else "holds"
        for order in itertools.permutations(parts):
            assert together(order) == expected
            outcomes = {f"part {place}": Outcome(word, "m", n=place) for place, word in enumerate(order)}
            assert Outcome.together(outcomes).verdict == expected


def test_a_verdict_has_the_first_outcome_and_the_count_of_all():
    outcomes = [Outcome("fails", "first", decided="d"), Outcome("holds", "second"), Outcome.unjudged("third")]
    verdict = verdict_of(find_claim("C1", "clips"), outcomes, model="dsnn")
    assert verdict.outcome is outcomes[0]
    assert verdict.count == Count(1, 1, {"not shown": 1})
    broken = Outcome("not shown", "m", trouble="line 3")
    assert verdict_of(find_claim("C1", "clips"), [outcomes[1], broken]).trouble == "line 3"
