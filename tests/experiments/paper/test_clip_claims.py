"""Laws of the paper's claims about clips, on made-up tables on which each holds and on tables that break one thing."""

import dataclasses
import random

import pytest

from experiments.declare.claim import POTENTIALS, texts
from experiments.kinds import registry
from experiments.kinds.registry import claims_on
from experiments.kinds.tables import OFFLINE
from experiments.paper.claims.clips import ASSUMED, MATCHED
from experiments.paper.claims.robot import CONNECTIONS
from experiments.settings.settings import watchers
from experiments.show.clips import ClipTrial
from experiments.show.play import show
from tests.helpers.clip_rows import (
    FEWER,
    WITHOUT,
    T,
    alone,
    blocked,
    edges,
    enough,
    ensembles,
    greys,
    grid,
    judge,
    speed_responses,
    street,
    strokes,
)

CLAIMS = claims_on("clips")
COMPARING = [claim for claim, clip_claim in CLAIMS.items() if clip_claim.equal_terms]
CLIP = {clip.name: clip for clip in registry.find("clean").clips}["dark rightward"]


def at_best(claim):
    """What a claim comes to of which everything is as it says: one about unknown constants cannot be judged."""
    return "unknown constants" if "of_dsnn" in texts()[claim] else "holds"


def changed(rows, change, **where):
    """The rows, with the columns of ``change`` in the first one that has the values of ``where``."""
    index = next(i for i, one in enumerate(rows) if all(one[name] == value for name, value in where.items()))
    return [*rows[:index], {**rows[index], **change}, *rows[index + 1 :]]


def without(rows, **values):
    return [one for one in rows if any(one[name] != value for name, value in values.items())]


# Of every claim.


@pytest.mark.parametrize("claim", CLAIMS)
def test_a_table_on_which_everything_is_as_the_words_say_satisfies(claim):
    outcome = judge(claim, enough(claim), T)
    assert outcome.verdict == at_best(claim) and outcome.settled().verdict == "holds"
    assert outcome.decided and outcome.n > 0 and all(check.slack >= 0 for check in outcome.checks)


@pytest.mark.parametrize("claim", CLAIMS)
def test_the_order_of_rows_changes_nothing_and_the_sign_of_the_slack_is_the_verdict(claim):
    rng = random.Random(claim)
    for _ in range(12):
        rows = [
            {**one, **{name: one[name] + rng.choice((0.0, 0.0, rng.gauss(0.0, 0.05))) for name in POTENTIALS}}
            for one in enough(claim)
        ]
        outcome = judge(claim, rows, T)
        passing = []
        for check in outcome.checks:
            passing.append(check.slack > 0 or (check.slack == 0 and check.needs in ("at least", "at most", "within")))
        assert [check.passes for check in outcome.checks] == passing
        if not CLAIMS[claim].silent_passes:
            assert outcome.settled().verdict == ("holds" if all(passing) else "fails")
        again = judge(claim, rng.sample(rows, len(rows)), T)
        assert (again.verdict, again.n) == (outcome.verdict, outcome.n)
        assert sorted(map(repr, again.checks)) == sorted(map(repr, outcome.checks))


@pytest.mark.parametrize("claim", CLAIMS)
def test_a_clip_that_a_model_lost_or_has_no_number_for_leaves_the_claim_unjudged(claim):
    rows = enough(claim)
    for model in CLAIMS[claim].models:
        assert judge(claim, without(rows, model=model), T).verdict == "not shown"
        if len(CLAIMS[claim].models) > 1:
            lost = next(one["clip"] for one in rows if one["model"] == model)
            assert judge(claim, without(rows, model=model, clip=lost), T).verdict == "not shown"
    for column in POTENTIALS:
        for nothing in (None, float("nan")):
            assert judge(claim, [*rows[:-1], {**rows[-1], column: nothing}], T).verdict == "not shown"


LACKING = {
    "C1": {"motion": "upward", "grey": 255.0}, "C2": {"grey": 0.0}, "C3": {"motion": "receding", "grey": 0.0},
    "C4": {"motion": "upward"}, "C5": {"motion": "looming"}, "C7": {"speed": 80.0, "background_speed": -6.0},
    "C8": {"speed": 120.0, "background_speed": -2.0, "grey": 255.0}, "C9": {"speed": 100.0, "grey": 64.0},
    "C10": {"grey": 64.0}, "C11": {"object": "absent"}, "C22": {"polarity": "on", "motion": "leftward"},
    "C23": {"polarity": "off-on"}, "C24": {"grey": 64.0}, "C26": {"speed": 100.0, "grey": 64.0},
    "C27": {"background_speed": -6.0}, "C28": {"object": "absent"},
}  # fmt: skip


@pytest.mark.parametrize("claim", LACKING)
def test_a_claim_needs_every_clip_that_its_words_name(claim):
    outcome = judge(claim, without(enough(claim), **LACKING[claim]), T)
    assert outcome.verdict == "not shown" and outcome.measured.startswith("needs ")


@pytest.mark.parametrize("claim", ["C5", "C6", "C7", "C8", "C9", "C10", "C11", "C24", "C26", "C27"])
def test_clips_that_the_words_are_not_about_do_not_count(claim):
    """Before a background that shifts otherwise, whatever is answered there."""
    rows = enough(claim)
    wild = {"background_speed": -33.0, "peak_vs": 0.9, "peak_hs": 0.01}
    elsewhere = [{**one, "clip": f"else {one['clip']}", **wild} for one in rows]
    outcome = judge(claim, rows + elsewhere, T)
    assert (outcome.verdict, outcome.n) == (at_best(claim), judge(claim, rows, T).n)
    assert judge(claim, elsewhere, T).verdict == "not shown"


def test_one_clip_refutes_a_claim_about_every_clip_whichever_others_are_missing():
    (one,) = changed(enough("C1")[:1], {"peak_hs": 0.1})
    assert judge("C1", [one], T).verdict == "fails"
    assert judge("C1", enough("C1")[:1], T).verdict == "not shown"


# One thing broken.

VALLEY, RISING = enough("C10"), greys(lambda g, s: (abs(g - 128) + 10) * s / 1e5)
FAILING = {
    "C1, leftward too weak": ("C1", changed(enough("C1"), {"trough_hs": -0.15}, motion="leftward")),
    "C1, the wrong way": ("C1", changed(enough("C1"), {"trough_vs": 0.2, "peak_vs": 0.3}, motion="upward")),
    "C2, aside": ("C2", changed(enough("C2"), {"trough_vs": -0.17}, motion="rightward")),
    "C3, receding": ("C3", changed(enough("C3"), {"trough_vs": -0.17}, motion="receding")),
    "C4, a third": ("C4", blocked(0.07, 0.13)),
    "C4, more than the whole": ("C4", blocked(0.1, 0.11)),
    "C4, less than the whole": ("C4", blocked(0.1, 0.09)),
    "C4, of nothing": ("C4", blocked(0.0, 0.0, whole=0.0)),
    "C5, the DSNN": ("C5", changed(enough("C5"), {"peak_vs": 0.17}, model="dsnn")),
    "C6, HS": ("C6", changed(enough("C6"), {"peak_hs": 0.1}, model="dsnn")),
    "C6, VS": ("C6", changed(enough("C6"), {"trough_vs": -0.17}, model="dsnn")),
    "C7, one step": ("C7", changed(enough("C7"), {"peak_hs": 0.9}, model="dsnn", speed=80.0)),
    "C8, at T": ("C8", changed(enough("C8"), {"trough_vs": -0.16})),
    "C9, two speeds swapped": ("C9", changed(RISING, {"peak_hs": 1.0}, grey=64.0, speed=100.0)),
    "C10, two greys swapped": ("C10", changed(VALLEY, {"peak_hs": 0.9}, grey=64.0, speed=60.0)),
    "C10, lowest beside": ("C10", greys(lambda g, s: abs(g - 64) + s)),
    "C11, the DSNN": ("C11", changed(enough("C11"), {"peak_hs": 0.9}, model="dsnn", object="absent")),
    "C22, the driven": ("C22", edges(driven=0.0101)),
    "C22, the other": ("C22", edges(other=0.189)),
    "C22, exchanged": ("C22", edges(driven=0.2, other=0.0)),
    "C22, of nothing": ("C22", edges(whole=0.0, driven=0.0, other=0.0)),
    "C23, a tenth": ("C23", strokes(opposite=0.021)),
    "C23, against": ("C23", strokes(on_off_leftward={"trough_hs": -0.03})),
    "C23, the wrong way": ("C23", strokes(on_on_leftward={"peak_hs": 0.2, "trough_hs": -0.19})),
    "C23, the weaker of both": ("C23", strokes(off_off_rightward={"peak_hs": 0.05})),
    "C23, of nothing": ("C23", strokes(same=0.0, opposite=0.0)),
    "C24, alike": ("C24", ensembles(1.0)),
    "C24, one clip": ("C24", changed(ensembles(), {"peak_hs": 0.9}, model=FEWER[0], clip="128.0 40.0")),
    "C24, none past T": ("C24", [{**one, "peak_hs": min(one["peak_hs"], 0.15)} for one in ensembles()]),
    "C26, one grey": ("C26", changed(enough("C26"), {"peak_hs": 0.9}, model="dsnn", grey=64.0, speed=60.0)),
    "C27, below twice": ("C27", alone(1.99)),
    "C27, one filter": ("C27", changed(alone(), {"peak_hs": 0.0}, model=WITHOUT[1])),
    "C27, of nothing": ("C27", [{**one, "peak_hs": 0.0, "trough_vs": 0.0} for one in alone()]),
    "C28, too weak": ("C28", street(one_leftward={"hs_leftward": -0.16})),
    "C28, the wrong way": ("C28", street(one_leftward={"hs_leftward": 0.3})),
    "C28, the second": ("C28", street(opposite_leftward={"hs_rightward": 0.0})),
    "C28, against": ("C28", street(group_rightward={"hs_against": 0.2})),
    "C28, VS": ("C28", street(group_leftward={"trough_vs": -0.17})),
    "C28, foliage": ("C28", street(alone={"trough_hs": -0.17})),
}


@pytest.mark.parametrize("what", FAILING)
def test_one_broken_part_fails_the_claim_and_decides(what):
    claim, rows = FAILING[what]
    outcome = judge(claim, rows, T)
    assert outcome.verdict == "fails"
    broken = [check for check in outcome.checks if not check.passes]
    assert broken and outcome.decided in [check.text for check in broken]


ON_THE_BOUND = {
    "C4": blocked(0.081, 0.119), "C22": edges(driven=0.0099), "C23": strokes(opposite=0.0199), "C24": ensembles(0.5),
    "C27": alone(2.0),
    "C28": street(alone={"peak_hs": 0.16}, group_rightward={"hs_against": 0.16, "trough_vs": -0.16}),
}  # fmt: skip


@pytest.mark.parametrize("claim", ON_THE_BOUND)
def test_what_lies_inside_its_bound_however_closely_satisfies(claim):
    assert judge(claim, ON_THE_BOUND[claim], T).verdict == "holds"


# Models whose constants are not known.

STEADY, FLAT = grid("dsnn", lambda s, b: s / 400 - b / 1000), grid("dsn2017", lambda s, b: 1.0)
OF_OTHERS = {
    "C5, the other too is silent": ("C5", changed(enough("C5"), {"trough_vs": -0.15}, model="dsn2017")),
    "C6, the other too is silent": ("C6", changed(enough("C6"), {"peak_vs": 0.15}, model="dsn2017")),
    "C7, the other varies less": ("C7", STEADY + FLAT),
    "C11, the other tells them too": ("C11", changed(enough("C11"), {"peak_hs": 0.001}, model="emd", object="absent")),
    "C26, for all greys": ("C26", speed_responses(middle=lambda s: 0.3 + s / 1e4)),
    "C26, for none": ("C26", speed_responses(ends=lambda s: 0.3)),
}


@pytest.mark.parametrize("what", OF_OTHERS)
def test_what_fails_by_the_other_model_alone_is_not_judged_and_fails_with_the_constants_assumed(what):
    claim, rows = OF_OTHERS[what]
    outcome = judge(claim, rows, T)
    assert (outcome.verdict, outcome.settled().verdict) == ("unknown constants", "fails")
    assert CLAIMS[claim].models & set(ASSUMED)


@pytest.mark.parametrize(
    "middle", [lambda s: 0.3 - s / 1e4, lambda s: 0.3 + s / 2e4, lambda s: 0.3 + min(s, 100) / 1e4]
)
def test_the_emd_may_rise_for_other_greys_by_less_than_the_margin_or_not_at_every_step(middle):
    assert judge("C26", speed_responses(middle=middle), T).settled().verdict == "holds"


def test_the_spread_is_meaned_over_objects_and_speeds():
    """One series that varies much among many that hardly do is less than a little of each."""
    steady = {(80.0, -10.0): 0.09}
    rows = grid("dsnn", lambda s, b: s / 400 + steady.get((s, b), 0.0)) + grid("dsn2017", lambda s, b: -b / 200)
    assert judge("C7", rows, T).checks[-1].reading == pytest.approx(0.04 - 0.03)


def test_c11_asks_the_emd_about_slow_objects_and_the_dsnn_about_all():
    slow = [
        {**one, "peak_hs": 0.4} if (one["model"], one["object"]) == ("emd", "present") and one["speed"] < 70 else one
        for one in enough("C11")
    ]
    assert judge("C11", slow, T).settled().verdict == "fails", "though the EMD misses fast ones"
    missed = changed(enough("C11"), {"peak_hs": 0.0}, model="dsnn", speed=120.0)
    assert judge("C11", missed, T).verdict == "fails"


def test_c28_of_other_foliage_or_without_a_number_is_not_judged():
    still = [{**one, "clip": f"still {one['clip']}", "foliage": "none", "peak_vs": 0.9} for one in street()]
    assert judge("C28", [*street(), *still], T).verdict == "holds" and judge("C28", still, T).verdict == "not shown"
    assert judge("C28", street(opposite_leftward={"hs_rightward": None}), T).verdict == "not shown"


def test_c23_compares_clips_of_one_delay_in_whatever_order_they_are():
    strong = [{**one, "clip": f"{one['clip']} 1"} for one in strokes()]
    weak = [{**one, "clip": f"{one['clip']} 2"} for one in strokes(same=0.05, opposite=0.004)]
    opposite = [one for one in (*weak, *strong) if one["polarity"] == "on-off"]
    rows = [*opposite, *(one for one in (*strong, *weak) if one not in opposite)]
    assert judge("C23", rows, T).verdict == "holds"


def test_c23_needs_as_many_clips_of_every_pair():
    assert judge("C23", [*strokes(), {**strokes()[0], "clip": "more"}], T).verdict == "not shown"


# Equal terms.


def on_both(claim, factor=1.0, equal=1.0):
    """Rows on which a claim is at its best, with its rivals times a factor, and a tenth of them on equal terms."""
    rows, terms = enough(claim), CLAIMS[claim].equal_terms
    rivals = [one for one in rows if one["model"] in terms]
    return [
        *(one for one in rows if one["model"] not in terms),
        *({**one, **{name: factor * one[name] for name in POTENTIALS}} for one in rivals),
        *({**one, "model": terms[one["model"]], **{name: 0.1 * equal * one[name] for name in POTENTIALS}}
          for one in rivals),
    ]  # fmt: skip


@pytest.mark.parametrize("claim", COMPARING)
def test_a_rival_on_equal_terms_is_judged_beside_and_whatever_is_known_of_it(claim):
    """Its gain changes the plain numbers alone, and the plain numbers are as without it."""
    first, second = (judge(claim, on_both(claim, factor), T) for factor in (1.0, 2.0))
    assert set(CLAIMS[claim].equal_terms) == CLAIMS[claim].models - {"dsnn"}
    assert first.equal.judged and first.equal.equal is None and first.equal == second.equal
    assert first.checks != second.checks
    assert judge(claim, on_both(claim, 1.0, equal=2.0), T).equal.checks != first.equal.checks
    assert dataclasses.replace(first, equal=None) == judge(claim, enough(claim), T)


def test_each_rival_with_its_gain_matched_answers_the_named_crossing_as_the_dsnn_does():
    models = watchers(("dsnn", *MATCHED.values()))
    dsnn, *rivals = (
        float(series.hs.max()) for _, series in show(ClipTrial("x", 0, 0, 0, CLIP, tuple(models)))[0].series()
    )
    assert rivals == pytest.approx([dsnn] * len(rivals), rel=1e-3)


def test_the_mean_per_correlator_counts_each_sum_by_how_many_it_is_of():
    """N_con = 8 is left as it is; a sum over n correlators counts 8 / n times ahead of the sigmoid."""
    assert [model.network.n_con for model in watchers([*CONNECTIONS.values()])] == [*CONNECTIONS]
    for n in (1, 2):
        plain, equal = watchers((CONNECTIONS[n], CLAIMS["C24"].equal_terms[CONNECTIONS[n]]))
        assert equal.network.n_con == n
        assert plain.network.k_sig / equal.network.k_sig == pytest.approx(8 / n)


def test_all_off_line_claims_are_judged_once():
    judged = [claim for name in OFFLINE for claim in registry.find(name).claims if isinstance(claim, str)]
    assert sorted(judged) == sorted(CLAIMS)
