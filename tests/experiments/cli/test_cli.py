"""The command line: what a run leaves behind, its repetition, wrong uses, and the end of a process."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from PIL import Image

import experiments
from experiments.draw import style
from tests.conftest import Colias
from tests.helpers import user_files
from tests.helpers.inside import inside
from tests.helpers.processes import CLI

RENDERED = True

REPOSITORY = Path(__file__).parents[3]
QUICK = ("--set", "experiment.speeds_cm_s=20,30", "--repeats", "2")


def test_figures_note_the_code_of_their_run_and_are_drawn_again(tmp_path):
    folder = tmp_path / "out"
    script = [sys.executable, str(REPOSITORY / "experiments" / "speed.py"), *QUICK]
    command = [*script, "--out", str(folder), "--workers", "0"]
    subprocess.run(command, cwd=tmp_path, capture_output=True, timeout=300, check=True)
    description = json.loads((folder / "run.json").read_text())
    with Image.open(folder / "figure.png") as picture:
        noted = picture.info["Source"]
    assert description["code"] in noted and (description["source"]["commit"] or "unknown")[:12] in noted
    assert noted in (folder / "figure.svg").read_text()
    shutil.copy(folder / "run.json", tmp_path)
    style.save(experiments.load(folder).figure(), tmp_path / "figure")
    for name in ("figure.svg", "figure.png"):
        assert (tmp_path / name).read_bytes() == (folder / name).read_bytes()


EXPERIMENT = """
from experiments import Clip, OfflineExperiment

EXPERIMENT = OfflineExperiment(
    name="mine", summary="a crossing", models=["my_model.py:gain=0.001"],
    clips=[Clip("crossing", "plain", {"rows": 20, "columns": 32})],
)
"""


@pytest.fixture
def mine(tmp_path):
    """A folder with a run of one's own experiment and model."""
    (tmp_path / "mine.py").write_text(EXPERIMENT)
    (tmp_path / "my_model.py").write_text(user_files.MODEL)
    done = Colias(tmp_path)("run", "mine.py", "--model=my_model.py:gain=0.003", "--out", "run", "-q", "--seed", "5")
    assert done.returncode == 0, done.stderr
    return tmp_path


def again(folder: Path):
    """Repeat the run from another folder than its own."""
    (folder / "elsewhere").mkdir()
    return Colias(folder / "elsewhere")("run", "--again", "../run", "--out", "again", "-q")


def test_a_repetition_takes_no_other_settings(mine):
    for more in (["mine.py"], ["--seed", "5"], ["--model", "emd"]):
        assert Colias(mine)("run", *more, "--again", "run", "--out", "other").returncode == 2
    assert not (mine / "other").exists()


UNREPEATABLE = {
    "unfinished": {"trials": 3, "ended": None},
    "of a script's own experiment": {"asked": {"kind": "clips"}},
    "of a script's own study": {"kind": "sweep", "asked": {"kind": "sweep"}},
    "of a script's own fit": {"kind": "fit", "asked": {"kind": "fit"}},
}


@pytest.mark.parametrize("changes", UNREPEATABLE.values(), ids=UNREPEATABLE)
def test_what_cannot_be_repeated_is_refused(mine, changes):
    file = mine / "run" / "run.json"
    there = {**json.loads(file.read_text()), **changes}
    file.write_text(json.dumps({name: value for name, value in there.items() if value is not None}))
    assert again(mine).returncode == 2 and not (mine / "elsewhere" / "again").exists()


def test_a_folder_of_runs_is_not_repeated(mine):
    assert Colias(mine)("run", "--again", ".", "--out", "again").returncode == 2 and not (mine / "again").exists()


WRONG = {
    "number": (("run", "speed", "--repeats", "two"), "--repeats"),
    "folder": (("run", "speed", "--out", "/dev/null/x"), "/dev/null/x"),
    "wall": (("run", "distance", "--set", "camera.hfov_deg=150"), "45"),
    "view": (("view", "absent", "--web"), "absent"),
    "screen": (("view", "bright"), "needs a screen"),
    "command": (("rum",), "run"),
    "a kind of list": (("list", "modls"), "models"),
}


@pytest.mark.parametrize("case", WRONG)
def test_wrong_uses_end_in_one_line(tmp_path, case):
    arguments, says = WRONG[case]
    done = inside(tmp_path, arguments)
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1), done.stderr
    assert says in done.stderr and not (tmp_path / "runs").exists()


def test_what_draws_is_looked_for_before_the_first_trial(tmp_path):
    taken = ("DISPLAY", "MUJOCO_GL", "PYOPENGL_PLATFORM")
    environment = {name: value for name, value in os.environ.items() if name not in taken}
    environment |= {"MUJOCO_EGL_DEVICE_ID": "77", "PYTHONPATH": str(REPOSITORY)}
    asked = [*CLI, "run", "speed", "--repeats", "1", "--workers", "1", "--out", "out"]
    done = subprocess.run(asked, cwd=tmp_path, env=environment, capture_output=True, text=True, timeout=120)
    assert done.returncode == 2 and "MUJOCO_EGL_DEVICE_ID=77" in done.stderr and "Traceback" not in done.stderr
    assert not list(tmp_path.iterdir()), "no run is begun"


def test_a_reader_that_ends_early_is_no_failure():
    """As ``colias list | head -1``: silent, with the status of a closed pipe."""
    reading, writing = os.pipe()
    os.close(reading)
    done = subprocess.run([*CLI, "list"], stdout=writing, stderr=subprocess.PIPE, check=False)
    os.close(writing)
    assert (done.returncode, done.stderr) == (141, b"")


def test_closed_streams_and_an_unknown_width_are_no_hindrance(mine):
    """As a daemon or a pipeline starts a command: with no stream at all, and with COLUMNS=0."""
    asked = [*CLI, "run", "mine.py", "--workers", "1", "--no-recordings", "--out", "daemon"]
    whole = os.environ | {"PYTHONPATH": str(REPOSITORY)}
    closed = ["sh", "-c", 'exec "$@" <&- >&- 2>&-', "sh", *asked]
    assert subprocess.run(closed, cwd=mine, env=whole).returncode == 0
    done = subprocess.run(asked, cwd=mine, env=whole | {"COLUMNS": "0"}, capture_output=True, text=True)
    assert done.returncode == 0 and "crossing" in done.stdout, done.stderr
