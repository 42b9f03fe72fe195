"""C21 of every looming detector: what is counted, what the row of a detector says, and the presets."""

import dataclasses
import json

import numpy as np
import pytest

from dsnn import MODELS
from experiments.bench import registry
from experiments.bench.run.runs import Resources
from experiments.bench.studies import run
from experiments.bench.studies.counts import Counts
from experiments.bench.studies.stored import studies
from experiments.bench.trials import plan
from experiments.studies.detectors import (
    EDGE,
    EDGE_LEVELS,
    PANEL,
    STUDY,
    THRESHOLDS,
    collisions,
    moving_edge,
    spikes_in_a_row,
)
from tests.bench.stats.test_replicates import rows_of
from tests.helpers.paper import design


@pytest.mark.parametrize(
    ("spikes", "in_a_row", "frames"),
    [([1, 1, 1, 0, 1], 3, 1), ([1, 1, 0, 1, 1], 3, 0), ([2, 2, 0, 5], 4, 2), ([0, 0], 1, 0), ([1, 1, 1, 1], 1, 4)],
)
def test_a_collision_is_announced_by_spikes_without_a_silent_frame_between_them(spikes, in_a_row, frames):
    assert collisions(np.array(spikes), in_a_row) == frames


def test_the_rule_is_the_detectors_own():
    """Frames counted from the spikes are those in which the detector itself says ``collision``."""
    rng = np.random.default_rng(1)
    frames = rng.integers(0, 256, (40, 18, 27)).astype(np.uint8)
    frames[10:14] = frames[10]  # nothing moves
    for name in ("lgmd1", "si-lgmd1", "lplc2-gf"):
        entry = MODELS[name]
        model = entry.build((18, 27), entry.robot)
        answers = [(model.step(frame).looming_spikes, model.collision) for frame in frames]
        count = collisions(np.array([spikes for spikes, _ in answers]), spikes_in_a_row(entry.robot))
        assert count == sum(collision for _, collision in answers), name


def test_moving_edge_is_what_changes_by_more_than_noise_does():
    still = np.full((4, 5, 6), 100, np.uint8)
    assert moving_edge(still).tolist() == [0, 0, 0]
    still[2, 1, 1], still[2, 2, 2] = 100 + EDGE, 100 - EDGE - 1
    assert moving_edge(still).tolist() == [0, 1, 1], "there, and back"


def test_every_entry_of_the_panel_is_a_looming_detector_under_its_own_constants():
    labels = [detector.label for detector in PANEL]
    models = plan(registry.load("angular-approach"), labels, (), 1, 0).settings.models
    assert [model.label for model in models] == labels
    assert {label.partition(":")[0] for label in labels} == {
        name for name, entry in MODELS.items() if "looming" in entry.channels
    }
    by_label = {model.label: model for model in models}
    values = {label: (model.thresholds["looming"], spikes_in_a_row(model.network)) for label, model in by_label.items()}
    published = {
        "lgmd1": (0.78, 5), "lgmd1:preset=firmware": (0.72, 4), "lgmd1:preset=arena": (0.65, 4),
        "lgmd2": (0.78, 8), "lgmd2:preset=firmware": (0.63, 8),
        "si-lgmd1": (0.72, 4), "si-lgmd1:preset=firmware": (0.72, 4), "si-lgmd1:preset=arena": (0.65, 4),
        "si-lgmd2": (0.64, 4), "hybrid": (0.78, 5),
    }  # fmt: skip
    assert {label: values[label] for label in published} == published
    kind = type(by_label["si-lgmd1"].network)
    assert (
        by_label["si-lgmd1"].network == kind.paper() != kind.firmware() == by_label["si-lgmd1:preset=firmware"].network
    )


@pytest.mark.parametrize("name", ["lgmd1", "lgmd2", "si-lgmd1", "si-lgmd2"])
def test_the_default_is_one_of_the_presets(name):
    assert MODELS[name].robot in MODELS[name].robot.presets().values()


def plan_of(repeats=4, seed=0, replicates=1):
    return run.planned(dataclasses.replace(STUDY, repeats=repeats, replicates=replicates), seed)


def test_the_study_has_the_trials_of_the_reproduction():
    plan = plan_of(10, 3)
    ours = {spec.seed: spec for spec in design(1, 10, 3).specs if spec.experiment == "angular-approach"}
    for arena in ("bright", "dim"):
        specs = [spec for spec in plan.specs if spec.settings.scene.arena == arena]
        assert [spec.seed for spec in specs] == list(ours)
    bright = plan.specs[0]
    assert bright.settings.scene == ours[bright.seed].settings.scene
    watcher = plan.shares[plan.points[0], "lgmd1", "angular-approach", 0].watchers[0]
    (network,) = [model.network for model in bright.settings.models if model.label == watcher.label]
    (plain,) = [model.network for model in ours[bright.seed].settings.models if model.label == "lgmd1"]
    assert network == plain


COUNTS = {0.0: 9, 15.0: 6, 30.0: 3}
"""Spikes by angle of a detector that keeps C21."""


def rows_in(plan, *counts, edge=(100, 100, 120)):
    """The rows of replicates in which every detector spikes as ``counts`` say, and never reaches a potential of 0.7."""
    cells, size = dict(zip(COUNTS, edge, strict=True)), len(plan.specs) // plan.replicates
    rows = []
    for row in rows_of(plan.specs):
        away = abs(row["angle_deg"])
        spikes = counts[row["trial"] // size][away]
        rows.append(
            row | {
                "spikes": 99, "looming_spikes": spikes, "peak_looming": 0.69, "frames": 100, "drive": "feedback",
                "collision_frames": max(spikes - 4, 0), "edge_cells": cells[away],
                "edge_frames": [cells[away]] * len(EDGE_LEVELS),
                "frames_above": [spikes * (threshold < 0.7) for threshold in THRESHOLDS],
            }
        )  # fmt: skip
    return rows


def table_of(counts, label):
    """The row of a detector in the bright arena, and that of the edge there."""
    tables = counts.tables
    row = next(row for row in tables["Detectors"] if (row["arena"], row["detector"]) == ("bright", label))
    return row, tables["Moving edge, counted as if it were a detector"][0]


def test_a_row_counts_the_replicates_in_which_the_detector_spikes_most_ahead():
    broken = {angle: 10 - count for angle, count in COUNTS.items()}
    plan = plan_of(replicates=3)
    counts = Counts(plan, rows_in(plan, COUNTS, broken, COUNTS))
    for label in ("lgmd1", "hybrid"):  # of the hybrid looming is counted, and not what HS does
        count = counts.cell("C21", label, arena="bright").count
        assert (count.holds, count.fails, count.replicates) == (2, 1, 3)
        assert count.interval[0] < 2 / 3 < count.interval[1] and table_of(counts, label)[0]["why it fails"]
    plan = plan_of(replicates=2)
    row, edge = table_of(Counts(plan, rows_in(plan, COUNTS, COUNTS)), "lgmd1")
    assert [row[name] for name in ("held", "held by the rule", "held by the peak", "held there")] == [2, 2, 0, 2]
    assert row["why it fails"] == "" and row["spikes at 0, 15, 30"] == (9.0, 6.0, 3.0) and row["best threshold"] < 0.7
    assert row["frames announced"] == (5.0, 2.0, 0.0) and row["share announced"] == (1.0, 1.0, 0.0)
    assert (edge["cells at 0, 15, 30"], edge["held"]) == ((100.0, 100.0, 120.0), 0)


def test_a_trial_that_failed_leaves_the_replicate_unjudged():
    plan = plan_of()
    rows = [row for row in rows_in(plan, COUNTS) if row["trial"] > 0]
    assert Counts(plan, rows).cell("C21", "lgmd2", arena="bright").count.unjudged == {"not shown": 1}


def test_it_goes_on_where_it_was_and_the_report_shows_it(tmp_path):
    study = dataclasses.replace(STUDY, models=("lgmd1", "hybrid"), replicates=1, repeats=1)
    resources, folder = Resources(workers=0, quiet=True), tmp_path / "detectors"
    first = run.run(run.planned(study), folder, resources)
    before = (folder / "detectors.json").read_bytes()
    run.run(run.planned(study), folder, resources)
    assert (folder / "detectors.json").read_bytes() == before
    lgmd1, hybrid = first.tables["Detectors"][:2]
    assert lgmd1["spikes at 0, 15, 30"] == hybrid["spikes at 0, 15, 30"], "the hybrid's looming is the LGMD1's"
    assert lgmd1["peak potential"] == hybrid["peak potential"]
    assert studies(tmp_path)["detectors"]["tables"] == json.loads(before)["tables"]
