"""Claims over formats of numbers: the same trials, exact counts, and errors against the float network."""

import dataclasses

import pytest

from experiments.bench import reproduce
from experiments.bench.reproduce import FULL, QUICK, USUAL, planned
from experiments.bench.studies import run
from experiments.bench.studies.counts import Counts
from experiments.bench.studies.grid import Point
from experiments.bench.studies.plan import EVERY_MODEL
from experiments.bench.studies.replicates import MODEL, Replicate
from experiments.studies.onboard import BEST, FORMATS, HS, SPIKES, STUDY, error_row, lost_and_gained, series
from tests.bench.stats.test_replicates import rows_of
from tests.helpers.paper import design
from tests.helpers.played import Played

LABELS = [form.label for form in FORMATS]


def plan_of(replicates=1, repeats=5, seed=0):
    return run.planned(dataclasses.replace(STUDY, replicates=replicates, repeats=repeats), seed)


def answered(plan, spikes):
    """Counts of planned trials in which each format spikes in every crossing as ``spikes`` says, by replicate."""
    rows = [row | {"seed": row["trial"]} for row in rows_of(plan.specs)]
    size = len(plan.specs) // plan.replicates
    for row in rows:
        row["spikes"] = spikes[row["trial"] // size][row["model"]] * (row["motion"] == "translation")
    return Counts(plan, rows)


def test_the_float_column_is_that_of_the_reproduction():
    """The same trials, and the same network."""
    ours = {(spec.experiment, spec.seed): spec for spec in design(1, 10, 4).specs}
    for spec in plan_of(1, 10, 4).specs:
        paper_spec = ours[spec.experiment, spec.seed]
        assert paper_spec.condition == spec.condition and paper_spec.settings.models[0] == spec.settings.models[0]
        assert dataclasses.replace(paper_spec.settings, models=()) == dataclasses.replace(spec.settings, models=())


def test_what_is_lost_and_gained_is_counted_by_replicate():
    firing = dict.fromkeys(LABELS, 5)
    counts = answered(plan_of(3), (firing, firing | {BEST.label: 0}, firing | {BEST.label: 0}))
    float_, best = counts.cell("C13", MODEL).count, counts.cell("C13", BEST.label).count
    assert (float_.holds, best.holds, best.unjudged) == (3, 1, {"silent model": 2}), "silent: kept, which is not held"
    row = lost_and_gained(counts, "C13", BEST.label, MODEL)
    assert (row["lost"], row["gained"], row["survives"]) == (2, 0, "-"), "three replicates have no word"


def replicate_of(label, hs, spikes):
    rows = () if hs is None else ({"model": label, "experiment": "speed", "seed": 7, HS: hs, SPIKES: spikes},)
    return [Replicate(rows, {}, {label: 0.2})]


def test_a_spike_of_the_other_sign_is_one_lost_and_one_gained():
    floats = replicate_of(MODEL, [0.5, -0.5, 0.1, 0.0], [1, -2, 0, 1])
    ours = replicate_of(BEST.label, [0.5, 0.5, 0.2, -0.4], [1, 1, 1, 0])
    row = error_row(BEST.label, ours, floats)
    assert [row[name] for name in ("frames", "trials", "spikes in float", "lost", "gained")] == [4, 1, 4, 3, 2]
    assert row["worst"] == pytest.approx(1.0) and row["median of |HS error|"] == pytest.approx(0.25)
    same = error_row(MODEL, floats, floats)
    assert (same["worst"], same["lost"], same["gained"]) == (0.0, 0, 0)
    assert error_row(BEST.label, replicate_of(BEST.label, None, None), floats)["worst"] is None


def test_series_are_those_of_the_trial():
    spec = plan_of(1, 1).specs[-1]
    spec = dataclasses.replace(spec, settings=dataclasses.replace(spec.settings, models=spec.settings.models[:2]))
    record = series(spec, labels=(BEST.label,))
    assert record.renderer and len(record.pixels) == 12, "what drew is noted, as of every trial"
    plain, best = record.rows
    assert plain[HS] is None and plain[SPIKES] is None
    answer = Played(spec).answers[1]
    assert best[HS] == answer.series.hs.tolist() and max(best[HS]) == best["peak_hs"]
    assert sum(map(abs, best[SPIKES])) == best["spikes"] == answer.spikes


def test_the_full_scale_shows_it_beside_the_float_network_and_changes_no_other_trial():
    full_plan = planned(FULL, 0)
    for spec in full_plan.studies["replicates"].specs:
        labels = [model.label for model in spec.settings.models]
        assert (BEST.label in labels) == (spec.experiment in reproduce.single_model_experiments())
    compared_labels = {model.label for run_plan in full_plan.robot for model in run_plan.settings.models}
    assert BEST.label not in compared_labels, "comparisons of replicate 0 are of as many models as before"
    for scale in (QUICK, USUAL):
        labels = {model.label for s in planned(scale, 0).studies["replicates"].specs for model in s.settings.models}
        assert BEST.label not in labels


def test_a_reproduction_s_table_takes_replicate_0_from_the_moves():
    whole_plan = planned(dataclasses.replace(FULL, replicates=2, repeats=5), 0, robot_only=True)
    rows = [{**row, HS: None, SPIKES: None} for row in rows_of(whole_plan.studies["replicates"].specs)]
    (second,) = Counts(whole_plan.studies["replicates"], rows).replicates(Point(), EVERY_MODEL)
    moved = Counts(
        whole_plan.studies["sensitivity"],
        [{**row, HS: None, SPIKES: None} for row in rows_of(whole_plan.studies["sensitivity"].specs)],
    )
    counts = reproduce.onboard(whole_plan, [second, second], moved)
    assert [model for _, model in counts.plan.judged] == [MODEL, BEST.label]
    best = counts.cell("C13", BEST.label).count
    assert (best.holds, best.replicates) == (2, 2)
