"""The one counter: which word follows from which counts, and that no sentence can be read the wrong way round."""

import itertools
import re

import pytest

from experiments.bench.engine.terminal import show_verdict
from experiments.bench.judging.count import MEANINGS, REASONS, SIGNS, Count, count, totals
from experiments.bench.judging.statistics import proportion_interval
from experiments.bench.judging.verdict import Outcome, Verdict
from experiments.bench.reproduction.table import show_claims


@pytest.mark.parametrize(
    ("holds", "fails", "word"),
    [(40, 0, "holds"), (38, 2, "holds"), (37, 3, "sometimes"), (20, 0, "holds"), (19, 1, "sometimes"), (19, 0, ""),
     (3, 37, "sometimes"), (2, 38, "fails"), (0, 20, "fails"), (1, 0, ""), (4, 1, "")],
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
        if holds + fails:
            low, high = proportion_interval(holds, holds + fails)
            assert tally.interval == (low, high)
            expected = "holds" if low >= 0.8 else "fails" if high <= 0.2 else "sometimes"
            assert tally.word == (expected if tally.judged >= 20 else "")
        else:
            assert tally.interval is None and tally.kind == "unjudged"


def test_where_nothing_is_random_one_replicate_says_all():
    assert (Count(1, random=False).word, Count(0, 1, random=False).word) == ("holds", "fails")
    assert Count(1, random=False).interval is None and "nothing in it is random" in Count(0, 1, random=False).sentence()
    assert Count(0, 0, {"not shown": 1}, random=False).kind == "unjudged"


@pytest.mark.parametrize(
    ("made", "message"),
    [(lambda: Count(-1, 2), "holds=-1: legal is 0 or more"), (lambda: Count(0), "legal is one or more"),
     (lambda: Count(1, unjudged={"untested": 1}), "legal reasons are judge failed, not shown, silent model"),
     (lambda: count([]), "legal is one or more"), (lambda: count(["holds", "vacuous"]), "legal reasons are")],
)  # fmt: skip
def test_counts_that_cannot_be(made, message):
    with pytest.raises(ValueError, match=message):
        made()


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
    assert tally.kind == (word or "unjudged") and (tally.label == "not judged") == (not word)
    assert f"the DSNN's half held in {held} of {held + failed} replicates" in tally.sentence()
    (phrase,) = [text for text in totals([("C26", tally)]) if "C26" in text]
    assert f"C26 (the DSNN's half: {half})" in phrase or word == "fails"
    assert Count(0, failed or 1).half is None and Count(3, unjudged={"not shown": 1}).half is None


def test_every_kind_has_a_sign_and_a_meaning():
    assert set(SIGNS) == set(MEANINGS) and len(set(SIGNS.values())) == len(MEANINGS)


def test_a_sentence_says_first_in_how_many_of_the_judged_it_held():
    for holds, fails, unjudged in itertools.product(range(0, 23, 2), repeat=3):
        if not holds + fails + unjudged:
            continue
        tally = Count(holds, fails, {"silent model": unjudged})
        text = tally.sentence("short replicate")
        if holds + fails:
            assert re.match(rf"held in {holds} of {holds + fails} short replicates?\b", text)
            assert tally.label == (tally.word or f"{holds} of {holds + fails}")
        else:
            assert text.startswith("not judged") and tally.label == "not judged"
        assert (REASONS["silent model"] in text) == bool(unjudged)
        assert "fail" not in text


def test_totals_name_every_claim_that_does_not_hold_everywhere():
    counts = {"C1": Count(40), "C2": Count(20, 20), "C3": Count(0, 40), "C4": Count(5), "C5": Count(2, 3),
              "C6": Count(0, 5), "C7": Count(0, 0, {"not shown": 5}), "C8": Count(1, random=False)}  # fmt: skip
    assert totals(counts.items()) == [
        "2 of 8 claims hold", "1 holds sometimes: C2", "1 fails: C3",
        "3 have too few replicates for a word: 1 held in all, 1 in some (C5), 1 in none (C6)",
        "1 was not judged: C7",
    ]  # fmt: skip
    assert totals([("C5", Count(2, 3)), ("C6", Count(0, 5))])[1].endswith("1 held in some (C5), 1 in none (C6)")
    assert totals([("C4", Count(5))])[1] == "1 has too few replicates for a word: 1 held in all"


def verdict(first, others, **more):
    return Verdict.of(
        ("C13", "straight is silent", "robot-general-tests"),
        [Outcome(word, "as measured") for word in (first, *others)], experiment="general", **more,
    )  # fmt: skip


def test_no_page_or_table_shows_replicate_0_as_the_claim_s_verdict(capsys):
    """A claim that fails in replicate 0 and holds in most others is nowhere said to fail."""
    for held, first in itertools.product(range(20), ("holds", "fails", "silent model", "not shown")):
        one = verdict(first, ["holds"] * held + ["fails"] * (19 - held))
        show_verdict(one, model=True)
        show_claims([one], {})
        text = " ".join(capsys.readouterr().out.split())
        total = held + (first == "holds")
        judged = 19 + (first in ("holds", "fails"))
        assert f"held in {total} of {judged} replicates" in text
        assert text.startswith(f"C13 {one.count.word or 'held in'}")


def test_the_terminal_s_columns_stand_under_their_names(capsys):
    show_claims([verdict("fails", ["holds"] * 4), verdict("holds", ["holds"] * 19)], {})
    names, *lines = capsys.readouterr().out.splitlines()
    first, second = (line for line in lines if line.startswith("C13"))
    for name, cells in (("claim", ("C13", "C13")), ("word", ("-", "holds")),
                        ("all replicates", ("held in 4 of 5", "held in 20 of 20"))):  # fmt: skip
        assert [names.index(name)] * 2 == [row.index(cell) for row, cell in zip((first, second), cells, strict=True)]
