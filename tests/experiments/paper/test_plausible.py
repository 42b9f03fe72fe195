"""The plausible set: draws over the box, shares, and what its check accepts."""

import dataclasses

import numpy as np
import pytest
from scipy.stats import binom

import experiments
from experiments.judge.sweep import read
from experiments.judge.tests import proportion_interval
from experiments.kinds import sweep, sweep_plan
from experiments.paper.studies import plausible
from experiments.settings.settings import with_values
from experiments.store.asked import Asked
from tests.experiments.judge.test_replicates import rows_of


def test_draws_are_even_over_each_range_and_narrow_ones_over_half_of_it_about_the_evidence():
    wide, narrow = (plausible.sample(4000, 7, narrow=narrow) for narrow in (False, True))
    for one in plausible.BOX:
        drawn, near = ([point[one.name] for point in points] for points in (wide, narrow))
        if one.scale == "one of":
            number = len(one.values)
            for values, weight in ((drawn, 1.0), (near, 1.5)):
                share = weight / (number - 1 + weight)
                assert values.count(str(one.evidence)) / 4000 == pytest.approx(share, abs=0.03)
        else:
            for values, length in ((drawn, 1.0), (near, 0.5)):
                places = np.sort([one.place(value) for value in values])
                assert np.ptp(places) == pytest.approx(length, abs=0.01) and places[0] > -1e-5 and places[-1] < 1 + 1e-5
                assert np.abs(np.diff(np.histogram(places, 4)[0])).max() < 150
            assert min(places) <= one.place(one.evidence) <= max(places)
    assert plausible.sample(3, 7) == plausible.sample(3, 7) != plausible.sample(3, 8)
    assert {one.part(str(one.evidence)) for one in plausible.BOX if one.scale != "one of"} <= {
        "lower", "middle", "upper"
    }  # fmt: skip


def test_every_value_of_the_box_is_legal():
    """The ends of each range, and each of several values."""
    base = sweep.plan(Asked(kind="sweep", what=("plausible-pilot",), options={"replicates": 1})).declared
    assert len(base.specs) == plausible.PAIRS * 210
    spec = base.specs[0]
    sections = {"camera": spec.settings.camera, "scene": spec.settings.scene, "processor": spec.models[0].processor,
                "dsnn": spec.models[0].network, "experiment": experiments.Translation((2,), (8,))}  # fmt: skip
    for one in plausible.BOX:
        section, _, name = one.key.partition(".")
        ends = [one.at(share, False) for share in (0.0, 1.0 - 1e-9)]
        if section != "experiment":
            assert len({with_values(section, sections[section], {name: end}) for end in ends}) == 2, one.name


def answers(specs, weak=()):
    """Rows of a network that keeps C14 and C32, but for those of ``weak`` points, which are silent."""
    found = []
    for row in rows_of(specs):
        across, silent = row["motion"] == "translation", row["model"] in weak
        high, low = (0.1 if silent or row["direction"] == way else 0.5 for way in ("leftward", "rightward"))
        found.append(row | {"spikes": int(across and not silent), "peak_hs": high * across, "trough_hs": -low * across})
    return found


def test_the_run_judges_the_sample_then_the_nearest_then_the_robots(monkeypatch):
    few = dataclasses.replace(plausible.STUDY, claims=("C14", "C32"), experiments=("general",), repeats=10)
    monkeypatch.setattr(plausible, "STUDY", few)
    monkeypatch.setattr(plausible, "POINTS", 12)
    asked, played = Asked(kind="sweep", what=("plausible",), seed=5), []
    plan = sweep.shipped(sweep.PLANS["studies"])["plausible"](few, asked).declared
    assert len(plan.judged) == 24

    def play(study, seed):
        follows = sweep_plan.sweep_of(study, seed)
        played.append((study.name, len(follows.judged), study.replicates, study.repeats, seed))
        return read(follows, answers(follows.specs, {"0"}))

    tables = plan.then(read(plan, answers(plan.specs, {"0", "1", "2"})), play)
    assert [one[:4] for one in played] == [("near", 9, 3, 10), ("robots", 9, 1, 10)]  # all that keep both claims
    assert len({5, *(seed for *_, seed in played)}) == 3
    whole = tables["Share in which all hold"][0]
    assert (whole["points"], whole["all hold"]) == (12, 9)
    assert (whole["low"], whole["high"]) == pytest.approx(proportion_interval(9, 12))
    parts = [row for row in tables["Over one unknown"] if row["unknown"] == "gamma"]
    assert sum(row["points"] for row in parts) == 12 and sum(row["all hold"] for row in parts) == 9
    again = tables["Nearest again"]
    assert [row["C14"] for row in again] == [0, *[3] * 8] and {row["point"] for row in again} == set(range(3, 12))
    (check,) = tables["Check"]
    assert (check["robots"], check["accepted"], check["passes"]) == (9, 8, False)


def test_the_bound_is_the_quantile_of_what_two_designs_of_an_apparatus_agree_in(monkeypatch):
    same, other, far = (True,) * 8, (False,) + (True,) * 7, (False,) * 2 + (True,) * 6
    designs = [same] * 10, [same] * 4 + [other] * 4 + [far] * 2
    monkeypatch.setattr(plausible, "held", lambda _, number=0: np.array(designs[number]))
    (told,) = plausible.bound(None)["Bound"]
    low = proportion_interval(8, 10)[0]
    assert (told["agree"], told["p"]) == (8, low) and told["least accepted"] == binom.ppf(0.05, 20, low)
    assert told["weak"] == (told["least accepted"] < 10)


def test_a_robot_accepts_the_points_that_differ_in_one_verdict_at_most(monkeypatch):
    points = [(True,) * 8, (True,) * 7 + (False,), (False,) * 8]
    monkeypatch.setattr(plausible, "LEAST_ACCEPTED", 1)
    told = plausible.accepted(np.array(points), [0, 2], np.array([(True,) * 8] * 2))
    assert told["accepted"] == 1 and told["median share"] == pytest.approx(2 / 3)
    assert told["passes"] is False


def test_the_nearest_keep_most_claims_and_lie_nearest_to_the_evidence():
    evidence = {one.name: str(one.evidence) for one in plausible.BOX}
    away = evidence | {"low-pass": "backward-euler"}
    points = [away, evidence, evidence, away]
    held = [(True, True), (True, False), (False, False), (True, True)]
    assert plausible.nearest([*points, evidence], np.array([*held, (True, True)])) == [4, 0, 3, 1]
