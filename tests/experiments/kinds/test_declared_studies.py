"""The studies that ship: what moves at each of their points, and their further tables."""

import dataclasses

import numpy as np
import polars as pl
import pytest

from dsnn import MODELS
from experiments.base.errors import UsageError
from experiments.declare.claim import texts
from experiments.judge.replicates import EVERY_MODEL, MODEL, replicate
from experiments.judge.sweep import read
from experiments.kinds import registry, sweep
from experiments.kinds.registry import shipped_study
from experiments.paper import reproduce
from experiments.paper.clips import FASTER as SPEEDS
from experiments.paper.page import FULL, USUAL
from experiments.paper.studies import onboard
from experiments.paper.studies.clips import BACKGROUND, BEHIND, at_speed
from experiments.paper.studies.detectors import EDGE, PANEL, THRESHOLDS, collisions, moving_edge, spikes_in_a_row
from experiments.paper.studies.onboard import BEST, FORMATS, HS, SPIKES, distance
from experiments.paper.studies.robot import APPARATUS, DEFAULTS, EYES, NETWORK, READINGS
from experiments.store.asked import Asked
from experiments.store.workers import Workers
from tests.experiments.judge.test_replicates import rows_of
from tests.helpers.clip_rows import T, judge, row
from tests.helpers.paper import design


def planned(name, seed=0, **changes):
    study = dataclasses.replace(shipped_study(name), **changes)
    return sweep.plan(Asked(kind="sweep", declared=study, seed=seed)).declared


def reproduction(scale, seed=0):
    """The plans of a reproduction's parts with the robot."""
    asked = Asked(kind="reproduction", declared=scale, seed=seed, options={"robot_only": True})
    return reproduce.plan(asked).parts


def trials(plan, point, model="dsnn", judged=None):
    """The trials of a point before one model, each with that model's network. ``judged``: whose, if another's."""
    found = []
    for name in plan.experiments:
        numbers, models = plan.shares[point, model if judged is None else judged, name, 0]
        for number in numbers:
            spec = plan.specs[number]
            settings = dataclasses.replace(spec.settings, models=())
            found.append((dataclasses.replace(spec, index=0, settings=settings), models[model].network))
    return found


def points_in(plan):
    return list(dict.fromkeys(point for point, _ in plan.judged))


def changed(one, other):
    return {f.name for f in dataclasses.fields(one) if getattr(one, f.name) != getattr(other, f.name)}


def test_moves_change_what_they_name_and_nothing_else():
    """Each point of the study of sensitivity differs from the defaults in its own parameter, and in no seed."""
    plan = planned("sensitivity", repeats=1)
    points = {point[0][1]: point for point in points_in(plan)}
    assert list(points) == [DEFAULTS, *NETWORK, *READINGS, *APPARATUS]
    for model in ("dsnn", "dsnn-onboard"):
        defaults = trials(plan, points[DEFAULTS], model)
        for label, text in (NETWORK if model == "dsnn-onboard" else NETWORK | READINGS).items():
            for (spec, network), (plain, base) in zip(trials(plan, points[label], model), defaults, strict=True):
                assert spec == plain and changed(base, network) == {text.partition("=")[0]}
    defaults = trials(plan, points[DEFAULTS])
    for name in APPARATUS:
        moved = trials(plan, points[name])
        assert [(s.experiment, s.seed, n) for s, n in moved] == [(s.experiment, s.seed, n) for s, n in defaults]
        assert any(spec != plain for (spec, _), (plain, _) in zip(moved, defaults, strict=True))
    onboard_too = {point for point, model in plan.judged if model == "dsnn-onboard"}
    assert {point[0][1] for point in set(points_in(plan)) - onboard_too} == {*READINGS, *APPARATUS}


def test_with_nothing_moved_each_claim_comes_to_what_it_does_in_replicate_0():
    """The first row of the table of sensitivity, of trials whose responses differ with their seeds."""
    plans = reproduction(dataclasses.replace(USUAL, repeats=5), 3)

    def answers(specs):
        rows = zip(rows_of(specs), (spec for spec in specs for _ in spec.settings.models), strict=True)
        return [{**row, "spikes": row["spikes"] * (spec.seed % 7), "peak_hs": spec.seed % 5 / 20} for row, spec in rows]

    paper = [plans[name].trials for name in registry.paper_experiments()]
    first = replicate([spec for specs in paper for spec in specs], [row for specs in paper for row in answers(specs)])
    plan = plans["sensitivity"].declared
    result = read(plan, answers(plan.specs))
    for claim, _ in plan.claims:
        assert result.outcomes[(("moved", DEFAULTS),), "dsnn", claim.id] == (reproduce.judge(claim.id, first),)


def test_a_study_without_models_judges_each_claim_on_those_that_it_is_about():
    """C21 is about looming detectors, C24 compares networks: a study of the DSNN alone refuses both."""
    plan = planned("fidelity", replicates=1, repeats=5, claims=("C14", "C21", "C24"), axes={"eye": EYES})
    table = read(plan, rows_of(plan.specs)).table
    assert set(table["verdict"]) <= {"holds", "fails"} and table.height == 3 * len(points_in(plan))
    (looming,) = table.filter(claim="C21", eye="default")["measured"]
    assert all(model in looming for model in ("lgmd1", "lgmd2"))
    assert set(read(plan, []).table["verdict"]) == {"not shown"}, "without trials"
    for claim in ("C21", "C24"):
        with pytest.raises(UsageError, match=claim):
            planned("fidelity", claims=(claim,), models=("dsnn",))


# --- the background's speed -------------------------------------------------------------------------------------------


def crossings(vs_at, hs=0.2):
    """Clips of C6 and C8 at every speed; VS as a function of it."""
    return [
        row(f"{grey} {speed} {behind}", model, grey=grey, speed=speed, background_speed=-behind, peak_hs=hs,
            peak_vs=0.9 if model == "dsn2017" else vs_at(behind))
        for grey in (0.0, 255.0)
        for speed in (40.0, 80.0, 120.0)
        for behind in SPEEDS
        for model in ("dsnn", "dsn2017")
    ]  # fmt: skip


def judged_at(claim, speed, rows):
    (asked,) = [of_study for of_study in BACKGROUND.claims if of_study.id == claim]
    return judge(at_speed(asked, {BEHIND: f"{speed:g}"}), rows, T)


def test_a_claim_is_judged_at_one_speed_of_the_background_at_a_time():
    for claim in ("C6", "C8"):
        still, faster = crossings(lambda behind: 0.0), crossings(lambda behind: behind / 300.0)
        best = "unknown constants" if "of_dsnn" in texts()[claim] else "holds"
        assert {judged_at(claim, speed, still).verdict for speed in SPEEDS} == {best}
        holds = [speed for speed in SPEEDS if judged_at(claim, speed, faster).verdict == best]
        assert holds == [speed for speed in SPEEDS if speed / 300.0 < 0.16]
        slow = [clip for clip in still if clip["background_speed"] > -300.0]
        assert judged_at(claim, 300.0, slow).verdict == "not shown"
    rows = [{**clip, "peak_hs": clip["speed"] / 1e3} for clip in crossings(lambda behind: 0.0)]
    assert {judged_at("C7-rises", speed, rows).verdict for speed in SPEEDS} == {"holds"}
    flat = [{**clip, "peak_hs": 0.1} if clip["background_speed"] == -300.0 else clip for clip in rows]
    assert [speed for speed in SPEEDS if judged_at("C7-rises", speed, flat).verdict == "fails"] == [300.0]


# --- formats of numbers -----------------------------------------------------------------------------------------------


def test_what_a_format_loses_and_gains_is_counted_by_replicate():
    plan = planned("onboard", 4, replicates=3, repeats=5)
    ours = {(spec.experiment, spec.seed): spec for spec in design(3, 5, 4).specs}
    assert all(ours[spec.experiment, spec.seed].settings.models[0] == spec.settings.models[0] for spec in plan.specs)
    firing = dict.fromkeys(FORMATS, 5)
    spikes = (firing, firing | {BEST: 0}, firing | {BEST: 0})
    size = len(plan.specs) // plan.study.replicates
    rows = [
        {**row, "seed": row["trial"], HS: [0.0], SPIKES: [0],
         "spikes": spikes[row["trial"] // size][row["model"]] * (row["motion"] == "translation")}
        for row in rows_of(plan.specs)
    ]  # fmt: skip
    result = read(plan, rows)
    counts = {row["model"]: row for row in result.counts.filter(claim="C13").iter_rows(named=True)}
    assert (counts[MODEL]["holds"], counts[BEST]["holds"], counts[BEST]["silent model"]) == (3, 1, 2)
    compared = result.tables["Claims lost and gained against the float network"]
    (row,) = [row for row in compared if (row["claim"], row["format"]) == ("C13", BEST)]
    assert (row["lost"], row["gained"]) == (2, 0)


def series(hs, spikes):
    return pl.DataFrame({"replicate": [0], "experiment": ["speed"], "seed": [7], HS: [hs], SPIKES: [spikes]})


def test_a_spike_of_the_other_sign_is_one_lost_and_one_gained():
    floats = series([0.5, -0.5, 0.1, 0.0], [1, -2, 0, 1])
    row = distance(series([0.5, 0.5, 0.2, -0.4], [1, 1, 1, 0]), floats)
    assert [row[name] for name in ("frames", "trials", "spikes in float", "lost", "gained")] == [4, 1, 4, 3, 2]
    assert row["worst"] == pytest.approx(1.0) and row["median of |HS error|"] == pytest.approx(0.25)
    same = distance(floats, floats)
    assert (same["worst"], same["lost"], same["gained"]) == (0.0, 0, 0)
    assert distance(series(None, None), floats)["worst"] is None


def test_a_probe_keeps_the_series_of_the_models_it_names(tmp_path):
    study = dataclasses.replace(onboard.STUDY, claims=("C14",), models=(MODEL, BEST), replicates=1, repeats=1)
    plan = sweep.plan_of(study, Asked(kind="sweep"), probe=onboard.probe_of(BEST))
    with Workers(0, quiet=True).running() as pool:
        result = sweep.played(plan, tmp_path / "out", pool)
    rows = [row for every in result.replicates.values() for part in every for row in part.rows]
    for found in rows:
        if found["model"] == BEST:
            assert max(found[HS]) == pytest.approx(found["peak_hs"], abs=1e-6) and len(found[HS]) == found["frames"]
            assert sum(map(abs, found[SPIKES])) == found["spikes"]
        else:
            assert found[HS] is None and found[SPIKES] is None


def test_a_reproduction_s_table_of_formats_takes_replicate_0_from_the_moves():
    whole = reproduction(dataclasses.replace(FULL, replicates=2, repeats=5))
    replicates, moves = whole["replicates"].declared, whole["sensitivity"].declared
    for spec in replicates.specs:
        shows = BEST in {model.label for model in spec.settings.models}
        assert shows == (len(registry.load(spec.experiment).models) == 1)
    second, moved = (
        read(plan, [{**row, HS: [0.0], SPIKES: [0]} for row in rows_of(plan.specs)]) for plan in (replicates, moves)
    )
    (second,) = second.replicates[(), EVERY_MODEL]
    result = reproduce.onboard([second, second], moved)
    (best,) = result.counts.filter(claim="C13", model=BEST).iter_rows(named=True)
    assert set(result.counts["model"]) == {MODEL, BEST} and (best["holds"], best["replicates"]) == (2, 2)


# --- looming detectors ------------------------------------------------------------------------------------------------


def test_a_collision_is_announced_by_spikes_without_a_silent_frame_between_them():
    assert [collisions(np.array(spikes), 3) for spikes in ([1, 1, 1, 0, 1], [1, 1, 0, 1, 1], [2, 2, 0, 5])] == [1, 0, 2]


def test_the_rule_is_the_detectors_own_and_moving_edge_is_what_changes_by_more_than_noise_does():
    rng = np.random.default_rng(1)
    frames = rng.integers(0, 256, (40, 18, 27)).astype(np.uint8)
    frames[10:14] = frames[10]  # nothing moves
    for name in ("lgmd1", "si-lgmd1", "lplc2-gf"):
        entry = MODELS[name]
        model = entry.build((18, 27), entry.robot)
        responses = [(model.step(frame).looming_spikes, model.collision) for frame in frames]
        count = collisions(np.array([spikes for spikes, _ in responses]), spikes_in_a_row(entry.robot))
        assert count == sum(collision for _, collision in responses), name
    still = np.full((4, 5, 6), 100, np.uint8)
    assert moving_edge(still).tolist() == [0, 0, 0]
    still[2, 1, 1], still[2, 2, 2] = 100 + EDGE, 100 - EDGE - 1
    assert moving_edge(still).tolist() == [0, 1, 1], "there, and back"


def test_every_looming_model_is_in_the_panel():
    assert {label.partition(":")[0] for label in PANEL} == {n for n, e in MODELS.items() if "looming" in e.channels}


COUNTS = {0.0: 9, 15.0: 6, 30.0: 3}
"""Spikes by angle of a detector that satisfies C21."""


def detected(plan, *counts, edge=(100, 100, 120)):
    """Rows of replicates in which every detector spikes as ``counts`` say, and never reaches a potential of 0.7."""
    cells, size = dict(zip(COUNTS, edge, strict=True)), len(plan.specs) // plan.study.replicates
    for found in rows_of(plan.specs):
        away = abs(found["angle_deg"])
        spikes = counts[found["trial"] // size][away]
        yield found | {
            "spikes": 99, "looming_spikes": spikes, "peak_looming": 0.69, "frames": 100, "drive": "feedback",
            "collision_frames": max(spikes - 4, 0), "edge_cells": cells[away],
            "frames_above": [spikes * (threshold < 0.7) for threshold in THRESHOLDS],
        }  # fmt: skip


def test_a_row_counts_the_replicates_in_which_the_detector_spikes_most_ahead():
    broken = {angle: 10 - count for angle, count in COUNTS.items()}
    plan = planned("detectors", repeats=4, replicates=3)
    counts = read(plan, list(detected(plan, COUNTS, broken, COUNTS))).counts.filter(arena="bright")
    for label in ("lgmd1", "hybrid"):  # of the hybrid looming is counted, and not what HS does
        assert counts.filter(model=label).select("holds", "fails", "replicates").rows() == [(2, 1, 3)]
    plan = planned("detectors", repeats=4, replicates=2)
    tables = read(plan, list(detected(plan, COUNTS, COUNTS))).tables
    (found,) = [row for row in tables["Detectors"] if (row["arena"], row["detector"]) == ("bright", "lgmd1")]
    assert [found[name] for name in ("held", "held by the rule", "held there")] == [2, 2, 2]
    assert found["spikes at 0, 15, 30"] == (9.0, 6.0, 3.0) and found["best threshold"] < 0.7
    edge = tables["Moving edge, counted as if it were a detector"][0]
    assert (edge["cells at 0, 15, 30"], edge["held"]) == ((100.0, 100.0, 120.0), 0)
