"""Grids of parameters from the command line."""

import csv

import pyarrow.parquet as pq
import pytest

from tests.conftest import Colias


def test_sweeps_share_stimuli_and_tabulate_the_grid(tmp_path):
    colias = Colias(tmp_path)
    quick = ("--set", "experiment.speeds_cm_s=20,30", "--repeats", "2", "-q")
    over = ("--over", "dsnn.n_con=4,8", "--over", "camera.read_noise=0,0.64")
    done = colias("sweep", "speed", *quick, *over, "--out", "out")
    assert done.returncode == 0, done.stderr
    with (tmp_path / "out" / "sweep.csv").open() as file:
        rows = list(csv.DictReader(file))
    grid = {(row["dsnn.n_con"], row["camera.read_noise"], row["speed_cm_s"]) for row in rows}
    assert len(rows) == len(grid) == 8
    assert (tmp_path / "out" / "figure.svg").exists()
    alone = colias(
        "run", "speed", *quick, "--set", "dsnn.n_con=4", "--no-recordings", "--workers", "0", "--out", "alone"
    )
    assert alone.returncode == 0
    trials = pq.read_table(tmp_path / "alone" / "trials.parquet").to_pylist()
    mean = sum(row["spikes"] for row in trials if row["speed_cm_s"] == 20.0) / 2
    (point,) = [r for r in rows if (r["dsnn.n_con"], r["camera.read_noise"], r["speed_cm_s"]) == ("4", "0.64", "20")]
    assert float(point["spikes_mean"]) == mean


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (("--over", "dsnn.n_con"), "SECTION.NAME=VALUE"),
        (("--over", "dsnn.n_con=4,4"), "twice"),
        (("--over", "dsnn.n_con=4,8", "--over", "dsnn.n_con=6"), "twice"),
        (("--over", "dsnn.n_con=4,8", "--set", "dsnn.n_con=6"), "--set dsnn.n_con=6: --over dsnn.n_con=4,8 sets that"),
        (("--over", "camera.fps=20,40", "--set", "camera.fps=60"), "--set camera.fps=60: --over camera.fps=20,40 sets"),
        (("--over", "dsnn.n_con=4,8", "--model", "dsnn:n_con=6", "--only"), "--model dsnn:n_con=6 has settled that"),
        (("--over", "si-lgmd1.preset=paper", "--model", "si-lgmd1"), "a preset of a model is not varied"),
        (("--over", "dsnn.n_kon=4,8"), "no parameter 'dsnn.n_kon'"),
        (("--over", "dsnn.n_con=4,99"), "from 1 to 64"),
        (("--over", "scene.arena=bright,brigth"), "nearest: bright"),
    ],
)
def test_wrong_grids_end_in_one_line(colias_here, arguments, says):
    done = colias_here("sweep", "speed", *arguments, "--out", "out")
    assert (done.returncode, done.stderr.count("\n")) == (2, 1), done.stderr
    assert says in done.stderr
    assert not (colias_here.folder / "out").exists()


def table(folder):
    with (folder / "sweep.csv").open() as file:
        return list(csv.DictReader(file))


def test_the_grid_may_move_what_the_experiment_varies(colias):
    over = ("--over", "experiment.speeds_cm_s=20,30", "--over", "dsnn.d=1,2", "--workers", "0")
    done = colias("sweep", "speed", *over, "--repeats", "1", "--out", "out")
    assert done.returncode == 0, done.stderr
    rows = table(colias.folder / "out")
    assert [(row["experiment.speeds_cm_s"], row["speed_cm_s"]) for row in rows] == [
        ("20", "20"), ("20", "20"), ("30", "30"), ("30", "30"),
    ]  # fmt: skip


def test_directions_are_told_apart(colias):
    arguments = ("--over", "dsnn.n_con=6,8", "--set", "experiment.speeds_cm_s=20", "--repeats", "1", "--workers", "0")
    done = colias("sweep", "speed", *arguments, "--set", "experiment.direction=both", "--out", "out")
    assert done.returncode == 0, done.stderr
    assert len(table(colias.folder / "out")) == 4
    printed = [line.split() for line in done.stdout.splitlines()]
    assert [line[:2] for line in printed if line[1:2] in (["rightward"], ["leftward"])] == [
        ["6", "rightward"], ["8", "rightward"], ["6", "leftward"], ["8", "leftward"],
    ]  # fmt: skip
    assert "leftward" in (colias.folder / "out" / "figure.svg").read_text()


def test_a_sweep_begun_goes_on_in_its_folder(colias):
    arguments = ("--over", "camera.read_noise=0,0.64", "--set", "experiment.speeds_cm_s=20", "--repeats", "1",
                 "--workers", "0")  # fmt: skip
    assert colias("sweep", "speed", *arguments, "--out", "out").returncode == 0
    whole = (colias.folder / "out" / "sweep.csv").read_bytes()
    again = colias("sweep", "speed", *arguments, "--out", "out")
    assert (again.returncode, again.stderr.count("\n")) == (2, 1) and "already holds a sweep" in again.stderr
    (colias.folder / "out" / "sweep.csv").unlink()
    done = colias("sweep", "speed", *arguments, "--out", "out")
    assert done.returncode == 0 and done.stderr.count("1 of them done already") == 2
    assert (colias.folder / "out" / "sweep.csv").read_bytes() == whole
