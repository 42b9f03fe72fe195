"""What commands print of verdicts."""

from experiments.declare.claim import Claim
from experiments.declare.outcome import Check, Outcome
from experiments.draw.terminal import not_run
from experiments.judge.verdict import verdict_of


def test_a_verdict_s_row_has_its_number_and_bound_and_those_that_were_not_run_share_a_reason():
    asked = [Claim(id=name, judge=len, says="s") for name in ("N1", "N2", "N3", "N4")]
    kept, broken = (Outcome.of([Check(f"{value} spikes", value, 2.0)]) for value in (3.25, 1.5))
    verdicts = [verdict_of(claim, [outcome]) for claim, outcome in
                zip(asked, (kept, broken, *[Outcome.unjudged("needs more")] * 2), strict=True)]  # fmt: skip
    assert [verdict.numbers for verdict in verdicts] == [
        ("3.25 spikes", "above 2"), ("1.5 spikes", "above 2"), ("", ""), ("", ""),
    ]  # fmt: skip
    assert not_run(verdicts) == "N3, N4 (needs more)"
