"""What a folder, a log or the current folder holds is never run: only what a person names is."""

from __future__ import annotations

import csv
import importlib.util
import json
import os
import shlex
import shutil
import subprocess
import sys
import threading
from pathlib import Path

import pytest

import experiments
from experiments.bench.cli import main, viewer
from experiments.bench.doctor import picture
from experiments.bench.engine import terminal
from experiments.bench.engine.errors import UsageError
from experiments.bench.engine.pool import open_pool
from experiments.bench.engine.workers.local import without_folder
from experiments.bench.firmware import toolchain
from experiments.bench.robot.trial import forget_simulations

CANARY = """
open(__file__.rpartition("/")[0] + "/ran", "w").close()
"""
MODEL = (
    CANARY
    + """
from dataclasses import dataclass
from dsnn import ModelEntry, Response

@dataclass(frozen=True)
class Parameters:
    limit: float = 0.25
    gain: float = 0.01

class Tiny:
    def __init__(self, shape, parameters):
        self.parameters, self.last = parameters, None

    def reset(self):
        self.last = None

    def step(self, frame, *, channels="grey", maps=False):
        mean, last = float(frame.mean()), self.last
        self.last = mean
        hs = 0.0 if last is None else self.parameters.gain * (mean - last)
        return Response(hs, 0.0, int(abs(hs) > self.parameters.limit), 0, azimuth=0.5)

MODEL = ModelEntry("tiny", "the change of the mean", Tiny, Parameters(), channels=("hs", "azimuth"),
                   thresholds={"hs": "limit"})
"""
)
CLIPS = """
from experiments.bench.clips.experiment import Clip, OfflineExperiment

SMALL = (("rows", 48), ("columns", 64), ("width", 12.0), ("height", 20.0), ("speed", 240.0))
EXPERIMENT = OfflineExperiment(
    name="clips", summary="one crossing", models=("tiny.py",), clips=(Clip("right", "plain", SMALL),), recorded=False,
)
"""
OWN = (
    CANARY
    + """
from experiments import Experiment, Translation

EXPERIMENT = Experiment("fast", "a fast crossing", Translation((30,), (6,)), varies="speed_cm_s", claims=())
"""
)


def colias(*arguments: object) -> int:
    return main.command([str(argument) for argument in arguments])


def canary(folder: Path, name: str = "evil.py") -> Path:
    (folder / name).parent.mkdir(parents=True, exist_ok=True)
    (folder / name).write_text(CANARY)
    return folder / name


def ran(folder: Path) -> list[str]:
    """Where under a folder a canary has run."""
    return sorted(str(path.relative_to(folder)) for path in folder.rglob("ran"))


def own_runs(folder: Path) -> dict[str, experiments.Run]:
    """Runs of one's own model and experiments; their files are gone on with as if by another person afterwards."""
    for name, text in {"tiny.py": MODEL, "clips.py": CLIPS, "fast.py": OWN}.items():
        (folder / name).write_text(text)
    quick = {"repeats": 1, "recordings": False, "quiet": True, "workers": 0, "only": True}
    tiny = str(folder / "tiny.py")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        runs = {
            "robot": experiments.run("fast.py", models=tiny, out=folder / "robot", **quick),
            "clips": experiments.run("clips.py", models=tiny, out=folder / "clips", **quick),
        }
    assert ran(folder) == ["ran"]
    (folder / "ran").unlink()
    forget(folder)
    return runs


def forget(folder: Path) -> None:
    """Let this process know no more of the files in a folder than another one would."""
    for name, module in list(sys.modules.items()):
        if str(getattr(module, "__file__", "")).startswith(str(folder)):
            del sys.modules[name]


@pytest.fixture(scope="module")
def user_runs(tmp_path_factory):
    try:
        yield own_runs(tmp_path_factory.mktemp("own"))
    finally:
        forget_simulations()


CELLS = ("evil.py", "sub/evil.py", "./evil.py", "evil.py:gain=1", "evil.py@true", "sub/evil")


@pytest.mark.parametrize("cell", CELLS)
def test_a_log_s_cell_is_not_run(cell, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    canary(tmp_path), canary(tmp_path, "sub/evil.py"), canary(tmp_path, "sub/evil")
    with (tmp_path / "log.csv").open("w", newline="") as file:
        lines = csv.writer(file)
        lines.writerow(["trial", "model", "speed_cm_s", "time_s", "hs", "hs_spikes"])
        lines.writerows([0, cell, 10, (i + 1) / 30, 0.1, 0] for i in range(5))
    with pytest.raises(UsageError, match=r"^log\.csv, line 2: model=.*--ran") as refused:
        colias("import", "log.csv", "--out", "run", "--quiet")
    assert cell in str(refused.value) and "\n" not in str(refused.value)
    assert ran(tmp_path) == [] and not (tmp_path / "run").exists()


def test_a_log_s_model_is_run_where_it_is_named(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "tiny.py").write_text(MODEL)
    with (tmp_path / "log.csv").open("w", newline="") as file:
        lines = csv.writer(file)
        lines.writerow(["trial", "model", "speed_cm_s", "time_s", "hs", "hs_spikes"])
        lines.writerows([0, "tiny.py", 10, (i + 1) / 30, 0.1, 0] for i in range(5))
    assert colias("import", "log.csv", "--out", "run", "--quiet", "--no-recordings", "--ran", "tiny.py") == 0
    assert ran(tmp_path) == ["ran"]


def test_readers_of_a_run_take_a_model_s_words_from_the_run(user_runs, tmp_path, capsys):
    """Thresholds and channels of one's own model are in the folder: its figure and its log need no file of code."""
    for name, run in user_runs.items():
        assert json.loads((run.folder / "experiment.json").read_text())["thresholds"] == {
            "tiny": {"hs": 0.25, "azimuth": None}
        }, name
        drawn = experiments.load(run.folder).figure()
        heights = {round(float(line.get_ydata()[0]), 6) for axes in drawn.axes for line in axes.lines}
        assert 0.25 in heights, name
    assert colias("export", user_runs["robot"].folder, "--to", "log", "--out", tmp_path / "log") == 0
    with (tmp_path / "log" / "log.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert {row["azimuth"] for row in rows} == {"0.5"} and "vs" not in rows[0]
    _, _, printed = " ".join(capsys.readouterr().out.split()).partition("import by ")
    words = shlex.split(printed)
    folder = user_runs["robot"].folder.parent
    assert words[words.index("--experiment") + 1] == str(folder / "fast.py")
    assert words[words.index("--ran") + 1] == str(folder / "tiny.py")
    assert ran(folder) == []


@pytest.mark.parametrize("kind", ["robot", "clips"])
@pytest.mark.parametrize("older", [False, True], ids=["now", "older"])
def test_what_a_folder_names_is_not_run(user_runs, kind, older, tmp_path, capsys):
    """A folder that was handed over, whose texts name files of code; one of an older version lacks the thresholds."""
    evil = canary(tmp_path / "evil")
    folder = tmp_path / "run"
    shutil.copytree(user_runs[kind].folder, folder)
    there = json.loads((folder / "experiment.json").read_text())
    listed = there["settings"]["models"] if kind == "robot" else there["models"]
    for model in listed:
        model["source"] = str(evil)
    there["files"] = {str(evil): "0" * 64}
    if older:
        del there["thresholds"]
    (folder / "experiment.json").write_text(json.dumps(there))
    run = experiments.load(folder)
    run.figure()
    message = capsys.readouterr().err
    assert (message.count("\n"), "threshold" in message and str(folder) in message) == (
        (1, True) if older else (0, False)
    )
    if kind == "robot":
        assert colias("export", folder, "--to", "log", "--out", tmp_path / "log", "--quiet") == 0
        message = capsys.readouterr().err
        assert (message.count("\n"), "channels" in message) == ((1, True) if older else (0, False))
        header = (tmp_path / "log" / "log.csv").read_text().splitlines()[0].split(",")
        assert ("azimuth" in header) is not older and "hs" in header and "vs" not in header
    experiments.compare(folder, user_runs[kind].folder)
    experiments.runs(tmp_path)
    assert ran(tmp_path) == []


STANDARD = ("json", "random", "multiprocessing", "signal", "threading", "socket", "base64", "subprocess", "types")
"""Modules that Python, or what starts in it first, imports."""


@pytest.fixture
def trapped(tmp_path, monkeypatch):
    """The current folder, with canaries called as the standard library's modules are."""
    for name in STANDARD:
        (tmp_path / f"{name}.py").write_text(CANARY.replace("/ran", f"/ran-{name}") + "raise SystemExit(3)\n")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def traps(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.glob("ran-*"))


def test_the_traps_are_sprung_by_python_s_own_ways(trapped):
    """That the tests below can fail at all."""
    subprocess.run([sys.executable, "-c", "import random"], check=False)
    assert traps(trapped) == ["ran-random"]


def test_workers_look_for_no_module_in_the_current_folder(trapped):
    with open_pool(1, None) as pool:
        environment = pool.executor.submit(os.getenv, "PYTHONSAFEPATH").result(60)
    assert traps(trapped) == []
    assert environment == os.environ.get("PYTHONSAFEPATH", "")


def test_the_environment_can_be_copied_while_workers_start():
    """The driver copies it for git while a thread starts workers: no variable may vanish between the two."""

    def start() -> None:
        for _ in range(20_000):
            with without_folder():
                pass

    starting = threading.Thread(target=start)
    starting.start()
    while starting.is_alive():
        dict(os.environ)
    starting.join()


def test_programs_of_python_look_for_no_module_in_the_current_folder(trapped, monkeypatch):
    """What `colias doctor`, the firmware's compiler and the viewer start: by options that leave that folder out."""
    started: list[list[str]] = []

    def start(command, **options):
        started.append([*command])
        return subprocess.CompletedProcess(command, 1, "", "")

    with monkeypatch.context() as patch:
        patch.setattr(subprocess, "run", start)
        picture.drawing()
        patch.setattr(importlib.util, "find_spec", lambda name: sys)
        started.append([*toolchain.compiler("zig").command])
        patch.setattr(importlib.util, "find_spec", lambda name: None)
        started.append(terminal.program())
    assert len(started) == 4 and all(command[0] == sys.executable for command in started)
    for flags in {tuple(command[1 : command.index("-m")]) for command in started}:
        subprocess.run([sys.executable, *flags, "-c", "import random"], check=True)
    assert traps(trapped) == []


def test_the_name_of_a_recording_is_no_option_of_the_viewer(tmp_path, monkeypatch):
    """``--save=FILE.rrd`` would write that file."""
    started = []
    monkeypatch.setattr(viewer, "_attend", lambda command, output: started.append(command) or 0)
    monkeypatch.chdir(tmp_path)
    for name in ("--save=other.rrd", "a.rrd"):
        Path(name).write_bytes(b"")
    assert main.command(["view", ".", "--web"]) == 0
    (command,) = started
    assert command[-2:] == [str(tmp_path / name) for name in ("--save=other.rrd", "a.rrd")]
