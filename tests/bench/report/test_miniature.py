"""A claim's picture has a mark for each replicate, on its check's side of the line, and is drawn from a file too."""

import dataclasses
import json
import math
import random
import re
import xml.etree.ElementTree as ElementTree

import pytest

from experiments import Check, Outcome
from experiments.bench.reproduction.page.miniature import HEIGHT, WIDTH, described, miniature
from experiments.bench.stats import stored
from experiments.bench.stats.checks import weakest
from experiments.bench.stats.verdict import Decision, Verdict

BOUNDS = {"above": 0.16, "at least": 1.0, "below": -0.16, "at most": 32.5, "within": (0.4, 0.6)}


def decisions(needs, bound, seed=0, count=40):
    """Readings about a bound, each judged by its check alone."""
    rng = random.Random(seed)
    middle = sum(bound) / 2 if isinstance(bound, tuple) else bound
    checks = [Check("reading", rng.gauss(middle, 0.2), bound, needs, unit="spikes") for _ in range(count)]
    return tuple(Decision("holds" if check.passes else "fails", check) for check in checks)


def drawn(svg):
    """(verdict's class, x, y) of each mark, the tinted stretch, and the lines' places."""
    root = ElementTree.fromstring(svg)
    marks = []
    for element in root:
        kind = element.get("class")
        if kind in ("held", "left"):
            marks.append((kind, float(element.get("cx")), float(element.get("cy"))))
        elif kind == "failed":
            x, y = map(float, re.match(r"M([\d.-]+) ([\d.-]+)l([\d.-]+)", element.get("d")).groups()[:2])
            arm = float(re.search(r"l([\d.-]+)", element.get("d"))[1]) / 2
            marks.append((kind, x + arm, y + arm))
    (kept,) = [element for element in root if element.get("class") == "kept"]
    begin = float(kept.get("x"))
    lines = [float(element.get("d").split()[0][1:]) for element in root if element.get("class") == "bound"]
    return marks, (begin, begin + float(kept.get("width"))), lines


@pytest.mark.parametrize("needs", BOUNDS)
def test_a_reading_that_keeps_its_bound_stands_in_the_tinted_stretch(needs):
    """To the width of a column: marks that would cover each other share one."""
    listed = decisions(needs, BOUNDS[needs])
    marks, (begin, end), lines = drawn(miniature(listed))
    kinds = [kind for kind, _, _ in marks]
    assert kinds.count("held") == sum(decision.verdict == "holds" for decision in listed) > 5
    assert kinds.count("failed") == sum(decision.verdict == "fails" for decision in listed) > 5
    assert len(lines) == (2 if needs == "within" else 1)
    for kind, x, y in marks:
        assert 0 < x < WIDTH and 0 < y < HEIGHT
        if min(abs(x - line) for line in lines) > 3:
            assert (begin < x < end) == (kind == "held")


@pytest.mark.parametrize("needs", BOUNDS)
def test_readings_of_one_replicate_stand_where_the_axis_has_them(needs):
    bound = BOUNDS[needs]
    (mark,), stretch, _ = drawn(miniature(decisions(needs, bound, seed=2, count=1)))
    assert (stretch[0] < mark[1] < stretch[1]) == (mark[0] == "held")


def test_bounds_that_differ_are_drawn_as_one_line_at_no_slack():
    """In the unit where there is one; in parts of the scale, each end in its own unit, where the units differ."""
    checks = [Check("a", 5.0, 3.0, unit="spikes"), Check("b", 1.0, 2.0, unit="spikes")]
    one = [Decision("holds" if check.passes else "fails", check) for check in checks]
    marks, (begin, end), (line,) = drawn(miniature(one))
    assert [x > line for _, x, _ in marks] == [True, False] and (begin, end) == (pytest.approx(line, abs=0.1), WIDTH)
    assert "+2 spikes" in miniature(one) and "\N{MINUS SIGN}1 spikes" in miniature(one)
    other = [*one, Decision("fails", Check("c", 0.08, 0.16, unit="", scale=0.16))]
    assert described(other).endswith("deciding reading \N{MINUS SIGN}1 spikes to +2 spikes; slack, bound 0")
    marks, _, (line,) = drawn(miniature(other))
    by_slack = [line - x for _, x, _ in marks]
    assert by_slack[2] == pytest.approx(by_slack[1] / 2, abs=0.1), "half a scale outside, beside a whole one"


def test_what_has_no_number_is_counted_and_not_drawn():
    checks = (Check("nan", math.nan, 0.2), Check("infinite", math.inf, 0.2), Check("one", 0.3, 0.2))
    listed = [*(Decision("holds", check) for check in checks), Decision("not shown")]
    marks, _, _ = drawn(miniature(listed))
    assert len(marks) == 1
    assert described(listed) == "holds in 3, not judged in 1; deciding reading 0.3; bound 0.2; 3 without a number"
    assert miniature(listed[3:]) == miniature(()) == "" and described(listed[3:]) == "not judged in 1; no reading"


def test_a_replicate_that_could_not_be_judged_has_a_ring():
    silent = Decision("silent model", Check("0 of 40", 0.0, 0.0, "at most"))
    marks, _, (line,) = drawn(miniature([silent] * 3))
    assert {x for _, x, _ in marks} == {line}
    assert [kind for kind, _, _ in marks] == ["left"] * 3
    assert len({y for _, _, y in marks}) == 3, "equal readings stand in a column"


def test_a_hundred_equal_readings_stay_in_the_picture():
    marks, _, _ = drawn(miniature([Decision("holds", Check("r", 0.3, 0.2))] * 100))
    assert len(marks) == 100 and all(0 < y < HEIGHT for _, _, y in marks)


def test_the_picture_is_of_the_weakest_check_of_each_outcome_and_is_read_off_a_file():
    """`colias reproduce` draws, and so does whoever reads its claims.json."""
    strong, weak = Check("strong", 9.0, 1.0), Check("weak & <near>", 1.5, 1.0, unit="spikes & <more>")
    outcomes = [Outcome.of([strong, weak]), Outcome.of([dataclasses.replace(weak, reading=0.5), strong])]
    verdict = Verdict.of(("C1", "says", "source"), outcomes)
    assert [decision.check for decision in verdict.decisions] == [weakest(outcome.checks) for outcome in outcomes]
    (again,) = stored.verdicts(json.loads(json.dumps(stored.document([verdict]))))
    assert miniature(again.decisions) == miniature(verdict.decisions)
    assert "1.5" in miniature(verdict.decisions) and ">9<" not in miniature(verdict.decisions)
