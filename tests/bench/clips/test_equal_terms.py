"""Rivals on equal terms: the rule that matches a gain, and the second judgement of a claim."""

import dataclasses

import pytest

from experiments import NAMES, OFFLINE
from experiments.bench import registry
from experiments.bench.clips.claims import judge, paper_claims
from experiments.bench.clips.equal_terms import MATCHED, answer, crossing, matched_gain
from experiments.bench.robot.mechanism.variants import CONNECTIONS
from experiments.bench.run.models import choose
from experiments.bench.run.settings import watchers
from experiments.bench.sources.clips import Clip
from experiments.bench.stats.claims import declared
from tests.bench.clips.test_clip_judges import enough
from tests.bench.clips.test_offline import T

CLAIMS = paper_claims()
TWICE = {"k_sig": 0.5, "gain": 2.0}
"""Parameter of a gain -> what to multiply it by for twice the gain."""


def configured_models(*labels):
    models, _ = watchers(labels, ())
    return models


def test_each_rival_with_its_gain_matched_answers_the_named_crossing_as_the_dsnn_does():
    clip = crossing()
    dsnn, *rivals = configured_models("dsnn", *MATCHED.values())
    target = answer(dsnn, clip)
    for rival in rivals:
        assert answer(rival, clip) == pytest.approx(target, rel=1e-3), rival.label


@pytest.mark.parametrize(("rival", "name"), [("dsn2017:k_sig=100", "k_sig"), ("emd", "gain")])
def test_twice_a_rival_s_gain_changes_its_answers_and_not_the_gain_that_is_matched(rival, name):
    changes = {"rows": 60, "columns": 80, "width": 20.0, "height": 30.0, "speed": 240.0}
    clip = Clip("small", "plain", changes).open(0)
    target = answer(choose("dsnn", "offline"), clip)
    (plain,) = configured_models(rival)
    changed = getattr(plain.network, name) * TWICE[name]
    twice = dataclasses.replace(plain, network=dataclasses.replace(plain.network, **{name: changed}))
    assert answer(twice, clip) > 1.2 * answer(plain, clip)
    gains = [matched_gain(model, target, clip) for model in (plain, twice)]
    assert gains[0] == pytest.approx(gains[1], rel=1e-4)


def on_both(claim, factor=1.0, equal=1.0):
    """Rows on which a claim is at its best, with those of its rivals times a factor, and on equal terms times another.

    On equal terms a rival answers a tenth of what it does otherwise.
    """
    rows, terms = enough(claim), CLAIMS[claim].equal_terms
    columns = ("peak_hs", "trough_hs", "peak_vs", "trough_vs")
    kept = [row for row in rows if row["model"] not in terms]
    rivals = [row for row in rows if row["model"] in terms]
    return [
        *kept,
        *({**row, **{name: factor * row[name] for name in columns}} for row in rivals),
        *({**row, "model": terms[row["model"]], **{name: 0.1 * equal * row[name] for name in columns}}
          for row in rivals),
    ]  # fmt: skip


COMPARING = [claim for claim, clip_claim in CLAIMS.items() if clip_claim.equal_terms]


def test_the_claims_that_compare_with_a_rival_are_judged_on_equal_terms_too():
    assert COMPARING == ["C5", "C6", "C7", "C11", "C24", "C26", "C27"]
    for claim in COMPARING:
        assert set(CLAIMS[claim].equal_terms) == CLAIMS[claim].models - {"dsnn"}


@pytest.mark.parametrize("claim", COMPARING)
def test_a_rival_s_gain_changes_the_plain_numbers_alone(claim):
    first, second = (judge(claim, on_both(claim, factor), T) for factor in (1.0, 2.0))
    assert first.equal is not None and first.equal == second.equal
    assert first.checks != second.checks
    assert judge(claim, on_both(claim, 1.0, equal=2.0), T).equal.checks != first.equal.checks


@pytest.mark.parametrize("claim", COMPARING)
def test_on_equal_terms_a_claim_is_judged_whatever_is_known_of_the_rival(claim):
    """The gain is the one constant that the rule sets; the plain comparison is not touched by it."""
    outcome = judge(claim, on_both(claim), T)
    assert outcome.equal.judged and outcome.equal.equal is None
    without = judge(claim, enough(claim), T)
    assert dataclasses.replace(outcome, equal=None) == without, (
        "the rival on equal terms is no part of the first number"
    )


def test_without_the_rival_on_equal_terms_there_is_no_second_number():
    for claim in COMPARING:
        assert judge(claim, enough(claim), T).equal is None


def test_the_experiments_show_the_rivals_that_their_claims_name_on_equal_terms():
    for name in (*NAMES, *OFFLINE):
        experiment = registry.find(name)
        for claim in experiment.claims:
            for clip_claim in declared(claim):
                assert set(clip_claim.equal_terms.values()) <= set(experiment.models), (name, claim)


def test_the_mean_per_correlator_counts_each_sum_by_how_many_it_is_of():
    """N_con = 8 is left as it is; a sum over n correlators counts 8 / n times ahead of the sigmoid."""
    for n in (1, 2):
        plain, equal = configured_models(CONNECTIONS[n], CLAIMS["C24"].equal_terms[CONNECTIONS[n]])
        assert equal.network.n_con == plain.network.n_con == n
        assert plain.network.k_sig / equal.network.k_sig == pytest.approx(8 / n)
