"""Full disks: nothing cut has a final name, no row is lost for its recording, and one line says where there is no room.

The disk is a limit on the size of a file here (tests/helpers/disks.py). On small disks that are mounted: tests/attack.
"""

from __future__ import annotations

import contextlib
import importlib.util
import json
import os
import shutil
import signal
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
import rerun as rr
import rerun.blueprint as rrb
from matplotlib.figure import Figure

from experiments.bench.cli import entry
from experiments.bench.closed_loop import policy_file
from experiments.bench.closed_loop.policy import About, Policy
from experiments.bench.figures import plotting
from experiments.bench.firmware import export, settings
from experiments.bench.recording import recorded
from experiments.bench.store import tables
from experiments.bench.training import evaluate
from tests.attack.commands import EXPERIMENT, film
from tests.helpers.disks import file_limit, small_disk, whole_recording

Command = Callable[..., tuple[int, str]]
LESS = 1000
"""Bytes: the sizes of Rerun's files vary by some 150 from run to run."""


@pytest.fixture
def command(monkeypatch, capsys, tmp_path) -> Command:
    """The command line in this process, in a folder of its own: exit status, and stderr. A traceback is raised."""

    def run(*arguments: str, limit: int | None = None) -> tuple[int, str]:
        monkeypatch.chdir(tmp_path)
        monkeypatch.setattr(sys, "argv", ["colias", *arguments])
        with pytest.raises(SystemExit) as ended:
            if limit is None:
                entry.run()
            else:
                with file_limit(limit):
                    entry.run()
        return ended.value.code or 0, capsys.readouterr().err

    return run


def test_a_recording_is_made_without_a_disk():
    """No file can be written at all, in TMPDIR or elsewhere."""
    pixels = np.random.default_rng(0).integers(0, 255, (40, 3000), dtype=np.uint8)

    def write(stream: rr.RecordingStream) -> None:
        times = [rr.TimeColumn("frame", sequence=np.arange(40))]
        stream.send_columns("noise", times, rr.EncodedImage.columns(blob=[row.tobytes() for row in pixels]))

    with file_limit(0):
        data = recorded(write, rrb.Blueprint(rrb.Spatial2DView(origin="noise")), "noise")
    assert len(data) > pixels.size and data[-12:].startswith(b"RRF2FOOT")


def test_rows_outlive_the_recordings_that_a_disk_has_no_room_for(command, tmp_path, monkeypatch):
    (tmp_path / "tiny.py").write_text(EXPERIMENT.format(repeats=2, speeds="(25,)"))
    run = ("run", "tiny.py", "--workers", "0", "-q")
    assert command(*run, "--out", "whole") == (0, "")
    least = min(path.stat().st_size for path in (tmp_path / "whole" / "recordings").iterdir())

    status, message = command(*run, "--out", "out", limit=least // 2)
    recordings = tmp_path / "out" / "recordings"
    lines = message.splitlines()
    assert status == 1 and len(lines) == 2, message
    for trial, line in enumerate(lines):
        assert line.startswith(f"trial {trial} has no recording"), line
        assert (
            str(Path("out/recordings") / f"trial-{trial:04d}.rrd") in line and "MB are free in out/recordings" in line
        )
    assert not list(recordings.iterdir())
    listed = json.loads((tmp_path / "out" / "failures.json").read_text())
    assert [failure["trial"] for failure in listed] == [0, 1]
    timeless = [name for name in pq.read_schema(tmp_path / "out" / "trials.parquet").names if name != "wall_s"]
    there = {
        folder: pq.read_table(tmp_path / folder / "trials.parquet", columns=timeless) for folder in ("whole", "out")
    }
    assert there["out"].equals(there["whole"])
    claims = [(tmp_path / folder / "claims.json").read_text() for folder in ("whole", "out")]
    assert claims[0] == claims[1], "a verdict does not depend on recordings"

    # On a disk that recordings would fill, they leave room for the tables.
    with monkeypatch.context() as patch:
        patch.setattr(shutil, "disk_usage", lambda _: shutil._ntuple_diskusage(2**30, 2**30 - 2**20, 2**20))
        status, message = command(*run, "--out", "narrow")
    assert status == 1 and "the disk is full (1.0 MB are free in narrow/recordings" in message
    assert not list((tmp_path / "narrow" / "recordings").iterdir())

    status, message = command(*run, "--out", "out")
    assert (status, message.count("\n")) == (0, 1) and "done again" in message
    assert all(whole_recording(path) for path in recordings.iterdir()) and len(list(recordings.iterdir())) == 2
    assert json.loads((tmp_path / "out" / "failures.json").read_text()) == []


def test_rows_outlive_a_table_that_a_disk_has_no_room_for(command, tmp_path):
    """The whole table of frames is larger than the limit, its parts are not; with more room the run goes on."""
    (tmp_path / "tiny.py").write_text(EXPERIMENT.format(repeats=16, speeds="(25,)"))
    run = ("run", "tiny.py", "--workers", "0", "-q", "--no-recordings", "--out", "out")
    status, message = command(*run, limit=48_000)
    assert status == 2 and "too large" in message, message
    left = set(tables.read(tmp_path / "out", "trials")["trial"].to_pylist())
    assert left and left <= set(tables.read(tmp_path / "out", "frames")["trial"].to_pylist())
    assert not list((tmp_path / "out").glob("*.part"))
    status, message = command(*run)
    assert status == 0, message
    assert pq.read_table(tmp_path / "out" / "trials.parquet").num_rows == 16
    assert not (tmp_path / "out" / tables.PARTS).exists()


def test_what_is_watched_is_whole_or_does_not_have_its_name(command, tmp_path):
    film(tmp_path / "film.avi", 20)
    watch = ("watch", "film.avi", "--no-view", "--size", "64x48", "--record", "out.rrd", "--table", "out.csv")
    assert command(*watch) == (0, "")
    size = (tmp_path / "out.rrd").stat().st_size
    rows = (tmp_path / "out.csv").read_bytes()
    assert len(rows) < size // 2
    for limit in (0, 100, size // 2, size - LESS):  # of the last one a part of the footer is missing
        for name in ("out.rrd", "out.csv"):
            (tmp_path / name).unlink(missing_ok=True)
        status, message = command(*watch, limit=limit)
        lines = message.splitlines()
        (line,) = (line for line in lines if line.startswith("out.rrd could not be written: "))
        assert status == 1 and "MB are free in ." in line and not (tmp_path / "out.rrd").exists(), limit
        assert line.endswith("; what came before is in out.rrd.part") == (limit > 0), line
        assert (tmp_path / "out.rrd.part").stat().st_size == limit
        if limit > len(rows):
            assert len(lines) == 1 and (tmp_path / "out.csv").read_bytes() == rows
        else:
            assert len(lines) == 2 and any(line.startswith("out.csv could not be written: ") for line in lines)
            assert not (tmp_path / "out.csv").exists()


FORKS = """
import os, signal
from dataclasses import dataclass
from dsnn import ModelEntry, Response

@dataclass(frozen=True)
class Parameters:
    t_sp: float = 0.2

class Model:
    def __init__(self, shape, parameters):
        self.frame = 0
    def reset(self):
        self.frame = 0
    def step(self, frame):
        self.frame += 1
        if self.frame == 4:
            child = os.fork()
            if not child:
                signal.alarm(20)
                signal.pause()
            with open("child", "w") as file:
                file.write(str(child))
        return Response()

MODEL = ModelEntry("forks", "a model that leaves a process", Model, Parameters())
"""


def test_a_recording_of_footage_ends_though_a_model_left_a_process(tmp_path, command):
    """That process holds what this one had open when it was made by fork: the end of a pipe, say."""
    film(tmp_path / "film.avi", 8)
    (tmp_path / "forks.py").write_text(FORKS)
    try:
        status, message = command("watch", "film.avi", "--no-view", "--record", "out.rrd", "--model", "forks.py")
        assert (status, message) == (0, "")
        child = int((tmp_path / "child").read_text())
        assert os.waitpid(child, os.WNOHANG) == (0, 0), "it is there still"
        assert whole_recording(tmp_path / "out.rrd")
    finally:
        with contextlib.suppress(ProcessLookupError):
            os.kill(int((tmp_path / "child").read_text()), signal.SIGKILL)


SMALL = ("plain", "--set", "plain.rows=48", "--set", "plain.columns=64", "--set", "plain.speed=240")


@pytest.fixture(scope="module")
def played(tmp_path_factory) -> Path:
    """The recording of a small clip."""
    folder = tmp_path_factory.mktemp("played")
    with pytest.MonkeyPatch.context() as patch, pytest.raises(SystemExit) as ended:
        patch.setattr(sys, "argv", ["colias", "play", *SMALL, "--no-view", "--record", str(folder / "played.rrd")])
        entry.run()
    assert not ended.value.code
    return folder / "played.rrd"


ENCODED = importlib.util.find_spec("imageio_ffmpeg") is not None
MADE: dict[str, tuple[str, ...]] = {
    "played.rrd": ("play", *SMALL, "--no-view", "--record", "played.rrd"),
    "clip.avi": ("stimulus", *SMALL, "--out", "clip.avi"),
    "strip.png": ("video", "kept.rrd", "--out", "strip.png", "-q", "--size", "700x500"),
    "film.mp4": ("video", "kept.rrd", "--out", "film.mp4", "-q", "--size", "320x200", "--fps", "10"),
    "film.gif": ("video", "kept.rrd", "--out", "film.gif", "-q", "--size", "320x200", "--fps", "5"),
    "frames": ("export", "kept.rrd", "--frames", "frames", "-q"),
    "csv": ("export", "kept.parquet", "--to", "csv", "--out", "csv", "-q"),
    "npz": ("export", "kept.parquet", "--to", "npz", "--out", "npz", "-q"),
    "mat": ("export", "kept.parquet", "--to", "mat", "--out", "mat", "-q"),
}


@pytest.mark.parametrize("name", MADE)
def test_a_file_is_whole_or_not_there(name, command, tmp_path, played):
    if name.startswith("film") and not ENCODED:
        pytest.skip("imageio-ffmpeg is not installed")
    shutil.copy(played, tmp_path / "kept.rrd")
    columns = {"trial": range(400), "hs": np.random.default_rng(0).random(400)}
    pq.write_table(pa.table(columns), tmp_path / "kept.parquet")
    before = {*tmp_path.iterdir()}
    assert command(*MADE[name])[0] == 0
    outputs = {*tmp_path.iterdir()} - before
    assert tmp_path / name in outputs
    files = [path for place in outputs for path in (place, *place.rglob("*")) if path.is_file()]
    size = max(path.stat().st_size for path in files)
    for limit in (0, size // 2, size - LESS):
        for place in outputs & {*tmp_path.iterdir()}:
            shutil.rmtree(place) if place.is_dir() else place.unlink()
        status, message = command(*MADE[name], limit=limit)
        assert status == 2 and message, limit
        line = message.splitlines()[-1]
        assert line.startswith("colias: ") and name.partition(".")[0] in line, (limit, message)
        assert "MB are free in " in line, line
        assert {*tmp_path.iterdir()} == before, limit
    assert command(*MADE[name])[0] == 0


def test_an_export_for_the_chip_is_whole_or_not_there(tmp_path):
    def write() -> None:
        export.export(settings.firmware([]), tmp_path / "chip", [], "nothing was measured")

    write()
    size = (tmp_path / "chip" / "onboard_config.h").stat().st_size
    shutil.rmtree(tmp_path / "chip")
    with file_limit(size - 1), pytest.raises(OSError, match="MB are free in"):
        write()
    assert not list((tmp_path / "chip").iterdir())


def test_a_policy_and_a_figure_are_whole_or_not_there(tmp_path):
    about = About("colias_sim/Fixation-v0", seed=0, steps=100, envs=1)
    policy = Policy(about, [(np.ones(shape, np.float32), np.ones(shape[0], np.float32)) for shape in about.shapes()])
    drawn = Figure()
    drawn.subplots().plot([0, 1])
    curve = [{"steps": k, "episodes": 1, "return": k / 7} for k in range(100)]
    budgets = {
        "policy.npz": lambda: policy_file.save(policy, tmp_path / "policy.npz"),
        "learning.csv": lambda: evaluate.keep(policy, curve, tmp_path),
        "figure.png": lambda: plotting.save(drawn, tmp_path),
    }
    for name, write in budgets.items():
        write()
        size = (tmp_path / name).stat().st_size
        for limit in (0, size - 1):
            for path in tmp_path.iterdir():
                path.unlink()
            with file_limit(limit), pytest.raises(OSError, match="MB are free in"):
                write()
            assert not (tmp_path / name).exists() and not list(tmp_path.glob("*.part*")), (name, limit)
        for path in tmp_path.iterdir():
            path.unlink()


def test_a_disk_without_room_for_a_recording_is_named(command, tmp_path):
    """As on a limited file, on a disk that is really full."""
    film(tmp_path / "film.avi", 60)
    with small_disk(tmp_path / "disk", 64 * 2**10):
        status, message = command("watch", "film.avi", "--no-view", "--record", "disk/out.rrd")
        assert status == 1 and message.startswith("disk/out.rrd could not be written: No space left on device (0.0 MB")
        assert [path.name for path in (tmp_path / "disk").iterdir()] == ["out.rrd.part"]
