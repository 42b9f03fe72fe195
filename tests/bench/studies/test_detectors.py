"""C21 of every looming detector: what is counted, what the row of a detector says, and the presets."""

import json
import subprocess
import sys

import numpy as np
import pytest
from experiments.bench.reproduction.detectors.causes import explained
from experiments.bench.reproduction.detectors.measure import EDGE, EDGE_LEVELS, THRESHOLDS, collisions, moving_edge
from experiments.bench.reproduction.detectors.panel import PANEL, Detector, spikes_in_a_row
from experiments.bench.reproduction.detectors.rows import detector_row, edge_row, shown_in
from experiments.bench.reproduction.detectors.summary import with_detectors

from dsnn import MODELS
from experiments.bench import registry
from experiments.bench.engine.batch import Resources
from experiments.bench.engine.errors import UsageError
from experiments.bench.judging.verdict import Verdict
from experiments.bench.reproduction import chapters, robustness
from experiments.bench.reproduction.detectors import panel, study
from experiments.bench.robot.plan import plan
from tests.bench.judging.test_replicates import rows_of


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
        said = [(model.step(frame).looming_spikes, model.collision) for frame in frames]
        own = collisions(np.array([spikes for spikes, _ in said]), spikes_in_a_row(entry.robot))
        assert own == sum(collision for _, collision in said), name


def test_moving_edge_is_what_changes_by_more_than_noise_does():
    still = np.full((4, 5, 6), 100, np.uint8)
    assert moving_edge(still).tolist() == [0, 0, 0]
    still[2, 1, 1], still[2, 2, 2] = 100 + EDGE, 100 - EDGE - 1
    assert moving_edge(still).tolist() == [0, 1, 1], "there, and back"


def test_every_entry_of_the_panel_is_a_looming_detector_under_its_own_constants():
    labels = [detector.label for detector in PANEL]
    models = plan(registry.load(panel.EXPERIMENT), labels, (), 1, 0).settings.models
    assert [model.label for model in models] == labels
    assert {label.partition(":")[0] for label in labels} == {
        name for name, entry in MODELS.items() if "looming" in entry.channels
    }
    by_label = {model.label: model for model in models}
    values = {label: (model.thresholds["looming"], spikes_in_a_row(model.network)) for label, model in by_label.items()}
    published = {
        "lgmd1": (0.78, 5), "lgmd1:preset=firmware": (0.72, 4), "lgmd1:preset=arena": (0.65, 4),
        "lgmd2": (0.78, 8), "lgmd2:preset=firmware": (0.63, 8),
        "si-lgmd1": (0.72, 4), "si-lgmd1:preset=arena": (0.65, 4),
        "si-lgmd2": (0.64, 4), "hybrid": (0.78, 5),
    }  # fmt: skip
    assert {label: values[label] for label in published} == published
    assert by_label["si-lgmd1:preset=paper"].network == type(by_label["si-lgmd1"].network).paper()


@pytest.mark.parametrize("name", ["lgmd1", "lgmd2", "si-lgmd1", "si-lgmd2"])
def test_the_default_is_one_of_the_presets(name):
    assert MODELS[name].robot in MODELS[name].robot.presets().values()


def test_a_preset_that_there_is_not_is_refused_with_those_there_are():
    experiment = registry.load(panel.EXPERIMENT)
    with pytest.raises(UsageError, match="--model lgmd1:preset=robot: preset=robot: legal is paper, firmware, arena"):
        plan(experiment, ["lgmd1:preset=robot"], (), 1, 0)
    with pytest.raises(UsageError, match="lplc2 has no parameter 'preset'"):
        plan(experiment, ["lplc2:preset=paper"], (), 1, 0)


def test_the_study_has_the_trials_of_the_reproduction():
    bright, dim = study.cases(10, 3)
    (own,) = robustness.replicate_cases([3], 10)
    ours = [spec for spec in own.specs if spec.experiment == panel.EXPERIMENT]
    for case, arena in ((bright, "bright"), (dim, "dim")):
        assert [spec.seed for spec in case.specs] == [spec.seed for spec in ours]
        assert {spec.settings.scene.arena for spec in case.specs} == {arena}
    assert bright.specs[0].settings.scene == ours[0].settings.scene
    lgmd1 = [model for model in bright.specs[0].settings.models if model.label == "lgmd1"]
    assert lgmd1 == [model for model in ours[0].settings.models if model.label == "lgmd1"]


COUNTS = {0.0: 9, 15.0: 6, 30.0: 3}
"""Spikes by angle of a detector that keeps C21."""


def shown(counts, edge=(100, 100, 120), seed=0):
    """A replicate in which every detector spikes as ``counts`` say, and never reaches a potential of 0.7."""
    specs = study.cases(4, seed)[0].specs
    cells = dict(zip(COUNTS, edge, strict=True))
    rows = []
    for row in rows_of(specs):
        away = abs(row["angle_deg"])
        spikes = counts[away]
        rows.append(
            row | {
                "spikes": 99, "looming_spikes": spikes, "peak_looming": 0.69, "frames": 100, "drive": "feedback",
                "collision_frames": max(spikes - 4, 0), "edge_cells": cells[away],
                "edge_frames": [cells[away]] * len(EDGE_LEVELS),
                "frames_above": [spikes * (threshold < 0.7) for threshold in THRESHOLDS],
            }
        )  # fmt: skip
    return shown_in(rows, len(specs), specs[0].settings.models)


def row_of(label, replicates):
    detector = next(detector for detector in PANEL if detector.label == label)
    edge = edge_row("bright", label, replicates)
    return explained(detector_row("bright", detector, replicates), edge), edge


def test_a_row_counts_the_replicates_in_which_the_detector_spikes_most_ahead():
    kept, broken = shown(COUNTS), shown({angle: 10 - count for angle, count in COUNTS.items()}, seed=1)
    for label in ("lgmd1", "hybrid"):  # of the hybrid looming is counted, and not what HS does
        row, _ = row_of(label, [kept, broken, kept])
        assert (row.held, row.replicates, row.untested) == (2, 3, 0)
        assert row.low < 2 / 3 < row.high and row.cause
    row, edge = row_of("lgmd1", [kept, kept])
    assert (row.held, row.held_by_collision, row.held_by_peak, row.held_at_best) == (2, 2, 0, 2)
    assert row.cause == "" and row.spikes == (9.0, 6.0, 3.0) and row.best_threshold < 0.7
    assert row.collision_frames == (5.0, 2.0, 0.0) and row.announced == (1.0, 1.0, 0.0)
    assert (edge.cells, edge.held) == ((100.0, 100.0, 120.0), 0)


def test_a_trial_that_failed_leaves_the_replicate_untested():
    whole = shown(COUNTS)
    row, _ = row_of("lgmd2", [shown_in(whole.rows[len(PANEL) :], len(whole.rows) // len(PANEL), whole.models)])
    assert (row.held, row.untested) == (0, 1)


@pytest.mark.parametrize(
    ("counts", "said"),
    [
        ({0.0: 0, 15.0: 0, 30.0: 0}, "silent at every angle: its potential peaks at 0.690"),
        ({0.0: 98, 15.0: 99, 30.0: 100}, "spikes in nearly every frame"),
        (
            {0.0: 5, 15.0: 6, 30.0: 8},
            "8.0 spikes at 30 degrees, 5.0 straight ahead; moving edge there +20.0%",
        ),
    ],
)
def test_a_cause_is_told_in_numbers(counts, said):
    row, _ = row_of("lgmd1", [shown(counts)])
    assert row.held == 0 and row.cause.startswith(said)


def test_it_goes_on_where_it_was_and_the_report_shows_it(tmp_path, monkeypatch):
    monkeypatch.setattr(study, "PANEL", (Detector("lgmd1", "paper", "x"), Detector("hybrid", "robot", "x")))
    resources = Resources(workers=0, quiet=True)
    seen = []
    study.run(tmp_path, 1, 1, 0, resources, seen.append)
    first = (tmp_path / study.FILE).read_bytes()
    trials = tmp_path / study.STUDY / "replicate-0" / "trials.parquet"
    before = trials.read_bytes()
    study.run(tmp_path, 1, 1, 0, resources, seen.append)
    assert (tmp_path / study.FILE).read_bytes() == first and trials.read_bytes() == before
    lgmd1, hybrid = (seen[0].rows[index] for index in (0, 1))
    assert lgmd1.spikes == hybrid.spikes and lgmd1.peak == hybrid.peak, "the hybrid's looming is the LGMD1's"
    assert [(row["arena"], row["label"]) for row in json.loads(first)["rows"]] == [
        (arena, label) for arena in ("bright", "dim") for label in ("lgmd1", "hybrid")
    ]
    (chapter,) = chapters.rendered(tmp_path)
    assert f'id="{chapter.name}"' in chapter.html and chapter.html.count(">hybrid</td>") == 2
    claims = [Verdict(name, "", "", "fails", "", tried="before.") for name in ("C20", "C21")]
    c20, c21 = with_detectors(claims, tmp_path)
    assert c20 == claims[0] and c21.tried.startswith("before. Held, by detector and preset, in the bright arena, of 1")
    assert with_detectors(claims, tmp_path / "none") == claims and chapters.rendered(tmp_path / "none") == []


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--detectors", "--full"], "--detectors: goes with"),
        (["--detectors", "--onboard"], "--detectors and --onboard: give one of them"),
        (["--onboard", "--model", "emd"], "--onboard: goes with"),
    ],
)
def test_options_that_do_not_go_together_are_refused_in_a_line(tmp_path, options, said):
    command = [sys.executable, "-m", "experiments.bench.cli", "reproduce", *options, "--out", str(tmp_path)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 2 and said in done.stderr and "Traceback" not in done.stderr
