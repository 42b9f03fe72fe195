"""Claims under the robot's true eye and wheels: cells differ in these alone, and it goes on where it was."""

import dataclasses
import json
import subprocess
import sys

import pytest
from experiments.bench.reproduction.eye import fidelity
from experiments.bench.reproduction.eye import figure as fidelity_figure
from experiments.bench.reproduction.eye.fidelity import CELLS, CLAIMS, Cell, cases, run

from colias_sim.config import CameraConfig, RobotConfig
from experiments.bench.engine.batch import Resources
from experiments.bench.reproduction import robustness

APPARATUS = {"camera": CameraConfig(), "robot": RobotConfig()}


def bare(spec):
    """A trial without what a cell may change."""
    return dataclasses.replace(spec, settings=dataclasses.replace(spec.settings, **APPARATUS))


def test_cells_differ_in_eye_and_wheels_alone():
    first, *others = cases(10, 3)
    assert [case.name for case in (first, *others)] == [cell.name for cell in CELLS]
    for case in others:
        assert [bare(spec) for spec in case.specs] == list(first.specs)
    eyes = {(s.settings.camera, s.settings.robot) for case in cases(1, 0) for s in case.specs}
    assert eyes == {
        (camera, robot)
        for camera in (CameraConfig(), CameraConfig.preset("ov7670"))
        for robot in (RobotConfig(), RobotConfig.preset("colias4"))
    }


def test_the_first_cell_is_the_reproduction_s_own_replicate():
    (own,) = robustness.replicate_cases([3], 10, (robustness.MODEL,))
    names = {robustness.judged_in()[claim] for claim in CLAIMS}
    assert [spec for spec in own.specs if spec.experiment in names] == list(cases(10, 3)[0].specs)


@pytest.fixture
def resources():
    return Resources(workers=0, quiet=True)


def test_it_is_shown_after_every_replicate_and_goes_on_where_it_was(tmp_path, monkeypatch, resources):
    monkeypatch.setattr(fidelity, "CLAIMS", ("C16",))
    seen = []
    first = run(tmp_path, 1, 1, 0, resources, seen.append)
    trials = (tmp_path / "replicate-0" / "trials.parquet").read_bytes()
    whole = run(tmp_path, 2, 1, 0, resources, seen.append)
    assert [table.replicates for table in seen] == [1, 1, 2]
    assert (tmp_path / "replicate-0" / "trials.parquet").read_bytes() == trials, "nothing was run again"
    for cell in CELLS:
        assert whole.outcomes[cell, "C16"][0] == first.outcomes[cell, "C16"][0]
        assert whole.driven[cell].trials == 2 * 3
    loop = {cell.drive: whole.driven[cell] for cell in CELLS if cell.eye == "default"}
    assert loop["pose feedback"].speed_error < 0.005 and loop["pose feedback"].path_error_mm < 0.5
    assert loop["open loop"].path_error_mm > 0.5, "nothing corrects the drift"
    rows = json.loads((tmp_path / "fidelity.json").read_text())
    assert [(row["eye"], row["drive"]) for row in rows] == [(cell.eye, cell.drive) for cell in CELLS]
    assert {row["replicates"] for row in rows} == {2} and {row["untested"] for row in rows} == {2}
    texts = [text.get_text() for text in fidelity_figure.draw(dataclasses.replace(whole)).axes[0].texts]
    assert len(texts) == len(CELLS)


def test_a_cell_is_named_by_its_eye_and_its_drive():
    assert Cell("ov7670", "open loop").assignments == ("camera.preset=ov7670", "robot.preset=colias4")


@pytest.mark.parametrize("other", [["--full"], ["--model", "emd"], ["--robot-only"]])
def test_options_that_do_not_go_with_it_are_refused_in_a_line(tmp_path, other):
    command = [sys.executable, "-m", "experiments.bench.cli", "reproduce", "--fidelity", *other, "--out", str(tmp_path)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 2 and "--fidelity: goes with" in done.stderr and "Traceback" not in done.stderr
