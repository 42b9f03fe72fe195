"""Claims over formats of numbers: the same trials, exact counts, and errors against the float network."""

import dataclasses
import json
import math

import pytest
from experiments.bench.reproduction.onboard import series, study
from experiments.bench.reproduction.onboard.formats import BEST, CLAIMS, FLOAT, FORMATS, Format
from experiments.bench.reproduction.onboard.rows import FILE, error_row, tabled
from experiments.bench.reproduction.onboard.table import survival

from experiments.bench.engine.batch import Resources
from experiments.bench.engine.models import choose
from experiments.bench.reproduction import chapters, reproduce, robustness
from experiments.bench.reproduction.plan import FULL, QUICK, USUAL, planned
from experiments.bench.reproduction.replicates import of_model, replicate
from experiments.bench.robot.trial import run_trial
from tests.bench.judging.test_replicates import rows_of


def answered(specs, spikes):
    """A replicate of planned trials in which each format spikes in every crossing as ``spikes`` says, by label."""
    rows = [row | {"seed": row["trial"]} for row in rows_of(specs)]
    for row in rows:
        row["spikes"] = spikes[row["model"]] * (row["motion"] == "translation")
    return replicate(specs, rows)


def test_the_float_column_is_that_of_the_reproduction():
    """The same trials, the same network, the same judge."""
    own = study.case(10, 4)
    (ours,) = robustness.replicate_cases([4], 10, (FLOAT,))
    names = {robustness.judged_in()[claim] for claim in CLAIMS}
    wanted = [spec for spec in ours.specs if spec.experiment in names]

    def bare(specs):
        found = {}
        for spec in specs:
            models = tuple(model for model in spec.settings.models if model.label == FLOAT)
            settings = dataclasses.replace(spec.settings, models=models)
            found[spec.experiment, spec.index] = dataclasses.replace(spec, settings=settings)
        return found

    assert bare(own.specs) == bare(wanted)
    specs = robustness.numbered([own])
    table = tabled([answered(specs, {each.label: 5 for each in FORMATS})], 10, 4)
    alone = answered(specs, {each.label: 5 for each in FORMATS})
    for claim in CLAIMS:
        row, found = table.row(claim, FLOAT), of_model(claim, alone, FLOAT)
        assert (row.held, row.untested, row.decided) == (found.verdict == "holds", 0, found.decided)


def test_what_is_lost_and_gained_is_counted_by_replicate():
    specs = [robustness.numbered([study.case(5, seed)]) for seed in range(3)]
    labels = [each.label for each in FORMATS]
    silent = dict.fromkeys(labels, 5) | {BEST.label: 0}
    firing = dict.fromkeys(labels, 5)
    every = [answered(own, spikes) for own, spikes in zip(specs, (firing, silent, silent), strict=True)]
    table = tabled(every, 5, 0)
    c13, best = table.row("C13", FLOAT), table.row("C13", BEST.label)
    assert (c13.held, c13.lost, c13.gained) == (3, 0, 0)
    assert (best.held, best.vacuous, best.lost, best.gained) == (1, 2, 2, 0), "silent: vacuous, which is not held"
    assert best.standing == "so far" and table.broken() == [], "three replicates say neither robust nor fragile"
    with_plan = [*every, *(every[1],) * 17]
    assert survival(table) == "which claims survive takes 20 replicates"
    whole = tabled(with_plan, 5, 0)
    assert whole.broken() == ["C13"] and survival(whole) == f"do not survive in {BEST.label}: C13"
    never = tabled([every[1]] * 20, 5, 0)
    assert never.row("C13", BEST.label).standing == "never held" and never.broken() == ["C13"]


def test_a_spike_of_the_other_sign_is_one_lost_and_one_gained():
    spec = study.case(1, 0, FORMATS[:2]).specs[:1]
    rows = rows_of(spec)
    floats, ours = ([0.5, -0.5, 0.1, 0.0], [1, -2, 0, 1]), ([0.5, 0.5, 0.2, -0.4], [1, 1, 1, 0])
    for row, (hs, spikes) in zip(rows, (floats, ours), strict=True):
        row |= {"seed": 7, series.HS: hs, series.SPIKES: spikes}
    row = error_row(BEST.label, [replicate(spec, rows)])
    assert (row.frames, row.trials, row.spikes, row.lost, row.gained) == (4, 1, 4, 3, 2)
    assert row.worst == pytest.approx(1.0) and row.median == pytest.approx(0.25)
    same = error_row(FLOAT, [replicate(spec, rows)])
    assert (same.worst, same.lost, same.gained) == (0.0, 0, 0)
    rows[1][series.HS] = None
    assert math.isnan(error_row(BEST.label, [replicate(spec, rows)]).worst)


def test_series_are_those_of_the_trial():
    (spec,) = study.case(1, 0, FORMATS[:2]).specs[-1:]
    record = series.work(spec, labels=(BEST.label,))
    assert record.renderer and len(record.pixels) == 12, "what drew is noted, as of every trial"
    plain, best = record.rows
    assert plain[series.HS] is None and plain[series.SPIKES] is None
    answer = run_trial(spec).answers[1]
    assert best[series.HS] == answer.series.hs.tolist() and max(best[series.HS]) == best["peak_hs"]
    assert sum(map(abs, best[series.SPIKES])) == best["spikes"] == answer.spikes


def test_the_full_scale_shows_it_beside_the_float_network_and_changes_no_other_trial():
    made = planned(FULL, 0)
    for case in made.others:
        for spec in case.specs:
            labels = [model.label for model in spec.settings.models]
            assert (BEST.label in labels) == (spec.experiment in robustness.moved())
    shown = {model.label for each in planned(FULL, 0).plans for model in each.settings.models}
    assert BEST.label not in shown, "comparisons of replicate 0 are of as many models as before"
    for scale in (QUICK, USUAL):
        labels = {model.label for case in planned(scale, 0).others for s in case.specs for model in s.settings.models}
        assert BEST.label not in labels


def test_a_reproduction_s_table_takes_replicate_0_from_the_moves(monkeypatch):
    scale = dataclasses.replace(FULL, replicates=2, repeats=5)
    made = planned(scale, 0, robot_only=True)
    specs = robustness.numbered(made.moves)
    every = [answered(robustness.numbered([case]), {m.label: 5 for s in case.specs for m in s.settings.models})
             for case in made.others]  # fmt: skip
    first = answered(made.moves[0].specs, {m.label: 5 for m in made.moves[0].specs[0].settings.models})
    table = reproduce._onboard(made, [first, *every], rows_of(specs))
    assert [each.label for each in table.formats] == [FLOAT, BEST.label]
    assert table.replicates == 2 and table.row("C13", BEST.label).held == 2


def test_it_goes_on_where_it_was_and_the_report_shows_it(tmp_path, monkeypatch):
    monkeypatch.setattr(study, "CLAIMS", ("C16",))
    formats = (FORMATS[0], BEST, Format(f"{BEST.label}:preset=bits16", "16 bits", False))
    seen = []
    resources = Resources(workers=0, quiet=True)
    for _ in range(2):
        study.run(tmp_path, 1, 1, 0, resources, seen.append, formats)
    assert seen[0] == seen[1]
    fine, finer = seen[0].errors
    assert 0.0 < finer.median < fine.median and finer.worst < fine.worst, "more bits, smaller errors"
    assert fine.worst < 0.05 and fine.frames == finer.frames > 100
    assert json.loads((tmp_path / FILE).read_text())["replicates"] == 1
    (chapter,) = chapters.rendered(tmp_path)
    assert chapter.name == "onboard" and chapter.html.count("does not fit") == 1
    assert choose(BEST.label).network.state_bits == 8
