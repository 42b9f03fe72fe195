"""The command line through real processes, and what it leaves behind."""

import csv
import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import polars as pl
import pytest
import rerun as rr
from PIL import Image

from experiments.bench.run.provenance import rows_hash
from experiments.bench.sources.rows import FRAME_SCHEMA, TRIAL_SCHEMA
from tests.helpers import user_files
from tests.helpers.inside import inside
from tests.helpers.processes import CLI, WITHOUT_GL

RENDERED = True

REPOSITORY = Path(__file__).parents[3]
QUICK = ("--set", "experiment.speeds_cm_s=20,30", "--repeats", "2")
RERUN = [sys.executable, "-m", "rerun"]


def verify(*recordings: Path) -> None:
    subprocess.run([*RERUN, "rrd", "verify", *map(str, recordings)], check=True, capture_output=True, timeout=60)


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, str]:
    """One small run with recordings, both directions, and what it printed."""
    folder = tmp_path_factory.mktemp("run")
    command = [sys.executable, str(REPOSITORY / "experiments" / "speed.py"), *QUICK, "--out", "out", "--seed", "3"]
    command += ["--set", "experiment.direction=both", "--workers", "0"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=300, check=True)
    return folder / "out", done.stdout


def test_a_run_prints_conditions_verdicts_and_paths(finished):
    _, printed = finished
    assert "rightward" in printed and "leftward" in printed
    assert "C15 not judged" in printed
    assert "figure.png" in printed and "colias view" in printed


def test_tables_hold_every_trial_and_frame(finished):
    folder, _ = finished
    trials, frames = pl.read_parquet(folder / "trials.parquet"), pl.read_parquet(folder / "frames.parquet")
    set_otherwise = pl.Schema({f"experiment.{name}": str for name in ("speeds_cm_s", "direction")})
    assert (trials.schema, frames.schema) == (TRIAL_SCHEMA | set_otherwise, FRAME_SCHEMA)
    assert trials["trial"].to_list() == list(range(8))
    assert frames.height == sum(trials["frames"].to_list())
    for row in trials.to_dicts():
        mine = frames.filter(trial=row["trial"])
        assert mine["frame"].to_list() == list(range(row["frames"]))
        assert row["spikes"] == np.abs(mine["hs_spikes"]).sum()
        assert row["peak_hs"] == mine["hs"].max()
        assert row["achieved_speed_cm_s"] == pytest.approx(row["speed_cm_s"], rel=0.02)
        assert row["path_error_mm"] < 1


def test_summary_agrees_with_the_trials(finished):
    folder, _ = finished
    trials = pl.read_parquet(folder / "trials.parquet").to_dicts()
    with (folder / "summary.csv").open() as file:
        rows = [row for row in csv.DictReader(file) if row["quantity"] == "spikes"]
    assert len(rows) == 4
    for row in rows:
        spikes = [
            t["spikes"]
            for t in trials
            if (t["direction"], t["speed_cm_s"]) == (row["direction"], float(row["speed_cm_s"]))
        ]
        assert (int(row["n"]), float(row["mean"])) == (2, np.mean(spikes))
        assert row["ci_low"] == row["ci_high"] == "", "two trials have no interval"


def test_experiment_json_holds_every_parameter(finished):
    folder, _ = finished
    description = json.loads((folder / "run.json").read_text())
    assert (description["seed"], description["repeats"], description["trials"]) == (3, 2, 8)
    assert description["settings"]["models"][0]["network"]["tau_s"] == [10.0, 200.0]
    assert description["settings"]["camera"]["read_noise"] == 0.64
    assert description["experiment"]["design"]["direction"] == "both"
    assert {"mujoco", "numpy", "colias-sim"} <= description["versions"].keys()


def test_figures_note_the_rows_that_they_are_drawn_from_and_the_commit(finished):
    folder, _ = finished
    with Image.open(folder / "figure.png") as picture:
        noted = picture.info["Source"]
    assert noted.startswith(f"rows {rows_hash(folder / 'trials.parquet')} of trials.parquet, commit ")
    commit = json.loads((folder / "run.json").read_text())["source"]["commit"]
    assert (commit or "unknown")[:12] in noted and noted in (folder / "figure.svg").read_text()


def entity(recording: Path, path: str):
    """The temporal rows of one entity, read back from disk."""
    store = rr.chunk.RrdReader(recording).stream().filter(content=path, is_static=False)
    return [chunk.to_record_batch() for chunk in store.to_chunks()]


def test_recordings_verify_and_read_back(finished):
    folder, _ = finished
    recordings = sorted((folder / "recordings").glob("*.rrd"))
    assert len(recordings) == 8
    verify(*recordings)
    frames = pl.read_parquet(folder / "frames.parquet")
    first = frames.filter(trial=0)
    (potential,) = entity(recordings[0], "/models/dsnn/hs")
    column = next(name for name in potential.schema.names if "Scalars" in name)
    np.testing.assert_array_equal(np.concatenate(potential[column].to_pylist()), first["hs"])
    times = potential["time"].cast("int64").to_numpy() / 1e9
    np.testing.assert_allclose(times, first["sim_time_s"], atol=1e-8)
    assert potential["frame"].to_pylist() == list(range(first.height))
    for path in ("world/observer/camera/image", *(f"models/dsnn/maps/{name}" for name in ("p", "la", "f_on", "f_off"))):
        (images,) = entity(recordings[0], f"/{path}")
        buffers = images[next(name for name in images.schema.names if "buffer" in name)].to_pylist()
        assert len(buffers) == first.height
        assert len(np.ravel(buffers[0])) == 72 * 99
    (moving,) = entity(recordings[0], "/world/stimulus")
    places = moving[next(name for name in moving.schema.names if "translation" in name)].to_pylist()
    np.testing.assert_allclose([p[0][0] for p in places], first["stimulus_x_cm"], atol=1e-4)


def test_recordings_stay_small(finished):
    """At most 15 KB a frame over a default run: 0.2 MB a file of layout and scene, the rest images."""
    folder, _ = finished
    frames = pl.read_parquet(folder / "trials.parquet")["frames"].to_list()
    for trial, count in enumerate(frames):
        size = (folder / "recordings" / f"trial-{trial:04d}.rrd").stat().st_size
        assert size < 220_000 + 13_500 * count


def test_equal_seeds_equal_numbers_and_recordings_change_none(finished, colias):
    arguments = (*QUICK, "--set", "experiment.direction=both", "--no-recordings")
    assert colias("run", "speed", *arguments, "--seed", "3", "--out", "again").returncode == 0
    assert colias("run", "speed", *arguments, "--seed", "4", "--workers", "0", "--out", "other").returncode == 0
    folder = finished[0]
    tables = {
        name: pl.read_parquet(path).drop(["wall_s"])
        for name, path in (
            ("first", folder / "trials.parquet"),
            ("again", colias.folder / "again" / "trials.parquet"),
            ("other", colias.folder / "other" / "trials.parquet"),
        )
    }
    assert tables["first"].equals(tables["again"])
    assert not tables["first"].equals(tables["other"])
    assert not list((colias.folder / "again" / "recordings").iterdir())
    assert (folder / "figure.svg").read_bytes() == (colias.folder / "again" / "figure.svg").read_bytes()


WRONG = {
    "experiment": (("run", "spede"), "nearest: speed"),
    "key": (("run", "speed", "--set", "dsnn.n_kon=3"), "nearest: dsnn.n_con"),
    "range": (("run", "speed", "--set", "dsnn.n_con=0"), "between 1 and 64"),
    "speed": (("run", "speed", "--set", "experiment.speeds_cm_s=-2"), "between 0.5 and 35"),
    "repeats": (("run", "speed", "--repeats", "0"), "between 1 and 25000"),
    "number": (("run", "speed", "--repeats", "two"), "--repeats"),
    "seed": (("run", "speed", "--seed", "-1"), "between 0 and 4"),
    "model": (("run", "speed", "--model", "dsn"), "nearest: dsnn"),
    "folder": (("run", "speed", "--out", "/dev/null/x"), "/dev/null/x"),
    "twice": (("run", "speed", "--set", "experiment.speeds_cm_s=6,6"), "is there twice"),
    "top speed": (("run", "speed", "--set", "robot.max_speed_cm_s=10"), "at most 9.5"),
    "touch": (("run", "distance", "--set", "experiment.distances_cm=3", "--set", "camera.forward_cm=0.5"), "touch"),
    "wall": (("run", "distance", "--set", "camera.hfov_deg=150"), "arena ends"),
    "file": (("run", "absent.py"), "no such file"),
    "view": (("view", "absent"), "absent"),
    "screen": (("view", "bright"), "needs a screen"),
    "command": (("rum",), "run"),
}


@pytest.mark.parametrize("case", WRONG)
def test_wrong_uses_end_in_one_line(tmp_path, monkeypatch, case):
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    arguments, says = WRONG[case]
    done = inside(tmp_path, arguments)
    assert done.returncode == 2
    assert done.stdout == ""
    assert done.stderr.count("\n") == 1, done.stderr
    assert says in done.stderr
    assert not (tmp_path / "runs").exists()


def test_an_experiment_file_of_one_s_own_runs_by_path(colias):
    """The example of docs/your-own-experiment.md, as pasted."""
    (colias.folder / "my_experiment.py").write_text(user_files.EXPERIMENT)
    done = colias("run", "my_experiment.py", "--repeats", "1", "--no-recordings", "--out", "out")
    assert done.returncode == 0, done.stderr
    trials = pl.read_parquet(colias.folder / "out" / "trials.parquet")
    assert set(trials["experiment"].to_list()) == {"my_experiment"}


PLAIN_DESIGN = """from __future__ import annotations
from dataclasses import dataclass
from beside import SPEED
from experiments.bench.sources.conditions import Condition
from experiments.bench.sources.experiment import Experiment

@dataclass(frozen=True)
class Fast:
    count: int = 1
    pose_sd_mm: float = 1.0
    heading_sd_deg: float = 1.0

    def conditions(self):
        return tuple(Condition("translation", "rightward", SPEED - i, 8.0) for i in range(self.count))

EXPERIMENT = Experiment("mine", "fast", Fast(), "speed_cm_s", repeats=1)
"""


def test_a_design_of_one_s_own_may_be_a_plain_dataclass(colias):
    """Beside another module of the user's; in a folder whose name looks like markup."""
    (colias.folder / "beside.py").write_text("SPEED = 30.0\n")
    (colias.folder / "mine.py").write_text(PLAIN_DESIGN)
    done = colias("run", "mine.py", "--set", "experiment.count=2", "--no-recordings", "--out", "[b]out")
    assert done.returncode == 0, done.stderr
    assert "[b]out: figure.png" in done.stdout
    assert pl.read_parquet(colias.folder / "[b]out" / "trials.parquet", glob=False)["speed_cm_s"].to_list() == [
        30.0,
        29.0,
    ]
    wrong = colias("run", "mine.py", "--set", "experiment.count=two")
    assert (wrong.returncode, wrong.stderr.count("\n")) == (2, 1)
    assert "count must be a whole number" in wrong.stderr


def test_a_run_is_never_overwritten(finished, colias):
    """Not by other options, and not where nothing tells any more which run it was."""
    copy = colias.folder / "copy"
    shutil.copytree(finished[0], copy)

    def files() -> dict[Path, bytes]:
        return {path: path.read_bytes() for path in copy.rglob("*") if path.is_file() and path.name != ".lock"}

    before = files()
    other = colias("run", "speed", *QUICK, "--out", "copy")
    assert (other.returncode, other.stderr.count("\n")) == (2, 1)
    assert "seed is 3 there and 0 now" in other.stderr and "choose another --out" in other.stderr
    assert files() == before
    del before[copy / "run.json"]
    (copy / "run.json").unlink()
    nameless = colias("run", "speed", *QUICK, "--out", "copy")
    assert (nameless.returncode, nameless.stderr.count("\n")) == (2, 1)
    assert "holds other files" in nameless.stderr
    assert files() == before


RUN_WITHOUT_GL = (
    WITHOUT_GL
    + """
import sys
sys.argv = ["colias", *sys.argv[1:]]
from experiments.bench.cli.entry import run as main
main()
"""
)


def test_missing_opengl_names_the_package(tmp_path):
    environment = {k: v for k, v in os.environ.items() if k not in ("DISPLAY", "MUJOCO_GL")}
    command = [sys.executable, "-c", RUN_WITHOUT_GL, "run", "speed", "--repeats", "1"]
    done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, timeout=120)
    assert done.returncode == 2
    assert "apt-get install libegl1 libgl1" in done.stderr
    assert "Traceback" not in done.stderr


@pytest.mark.parametrize(
    "variables",
    [
        {"MUJOCO_EGL_DEVICE_ID": "77"},
        {"__EGL_VENDOR_LIBRARY_FILENAMES": "/nonexistent"},
    ],
    ids=str,
)
def test_variables_by_which_nothing_can_be_drawn_are_named_before_the_first_trial(tmp_path, variables):
    environment = {name: value for name, value in os.environ.items() if name not in ("DISPLAY", "MUJOCO_GL")}
    environment.pop("PYOPENGL_PLATFORM", None)  # MuJoCo sets it when this process has drawn
    command = [*CLI, "run", "speed", "--repeats", "1", "--workers", "1", "--out", "out"]
    done = subprocess.run(
        command,
        cwd=tmp_path,
        env=environment | variables | {"PYTHONPATH": str(Path(__file__).parents[3])},
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.returncode, done.stderr.count("\n")) == (2, 1), done.stderr
    assert all(f"{name}={value}" in done.stderr for name, value in variables.items())
    assert not list(tmp_path.iterdir()), "no run is begun"


def test_a_reader_that_ends_early_is_no_failure():
    """As ``colias list | head -1``: silent, with the status of a closed pipe."""
    reading, writing = os.pipe()
    os.close(reading)
    command = [sys.executable, "-m", "experiments.bench.cli", "list"]
    done = subprocess.run(command, stdout=writing, stderr=subprocess.PIPE, check=False)
    os.close(writing)
    assert (done.returncode, done.stderr) == (141, b"")


def test_lists(colias):
    listed = colias("list").stdout
    assert all(name in listed for name in ("speed", "distance", "dsnn", "bright", "plain", "dim"))
    assert "dsnn.n_con=8" in colias("list", "parameters").stdout
