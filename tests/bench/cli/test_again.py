"""`colias run --again` repeats a run from the files at their places, and names the first row that differs."""

import json
import re
from pathlib import Path

import polars as pl
import pytest

import experiments
from tests.conftest import Colias

MODEL = """
from dataclasses import dataclass
from dsnn import ModelEntry, Response
from helper import GAIN

@dataclass(frozen=True)
class Parameters:
    gain: float = 1.0

class Mean:
    def __init__(self, shape, parameters):
        self.gain = GAIN * parameters.gain
    def reset(self):
        pass
    def step(self, frame, *, channels="grey", maps=False):
        return Response(self.gain * float(frame.mean()), 0.0, 0, 0)

MODEL = ModelEntry("mean", "mean brightness", Mean, Parameters())
"""
EXPERIMENT = """
from experiments import Clip, OfflineExperiment

EXPERIMENT = OfflineExperiment(
    name="mine", summary="a crossing", models=["mean.py:gain=2.0"],
    clips=[Clip("crossing", "plain", {"rows": 20, "columns": 32})],
)
"""


@pytest.fixture
def folder(tmp_path):
    """A folder with a run of one's own experiment, model and helper."""
    for name, text in {"helper.py": "GAIN = 0.03\n", "mean.py": MODEL, "mine.py": EXPERIMENT}.items():
        (tmp_path / name).write_text(text)
    done = Colias(tmp_path)(
        "run", "mine.py", "--model=mean.py:gain=3.0", "--out", "run", "-q", "--seed", "5", "--workers", "0"
    )
    assert done.returncode == 0, done.stderr
    return tmp_path


def rerun(folder: Path):
    """Repeat the run from another folder than its own."""
    (folder / "elsewhere").mkdir()
    return Colias(folder / "elsewhere")("run", "--again", "../run", "--out", "again", "-q", "--workers", "0")


def test_a_run_is_repeated_from_the_files_at_their_places(folder):
    again = rerun(folder)
    assert (again.returncode, again.stdout.split(":")[0]) == (0, "equal"), again.stderr
    first, second = (
        pl.read_parquet(run / "frames.parquet") for run in (folder / "run", folder / "elsewhere" / "again")
    )
    assert first.height and first.equals(second)


def test_an_edited_file_is_named_and_so_is_the_first_row_that_differs(folder):
    (folder / "helper.py").write_text("GAIN = 0.04\n")
    again = rerun(folder)
    assert again.returncode == 1 and "helper.py has changed" in again.stderr
    assert re.match(r"differs: \w+\.parquet, trial 0, model mean:gain=.*: .* is .+ there and .+ here", again.stdout)


@pytest.mark.parametrize("changes", [{"trials": 3, "ended": None}, {"command": {"line": ["train", "Optomotor"]}},
                                     {"resumed_with": [{"code": "0123456789ab"}]}])  # fmt: skip
def test_what_cannot_be_repeated_is_refused(folder, changes):
    file = folder / "run" / "run.json"
    there = {**json.loads(file.read_text()), **changes}
    file.write_text(json.dumps({name: value for name, value in there.items() if value is not None}))
    assert rerun(folder).returncode == 2 and not (folder / "elsewhere" / "again").exists()


def test_a_repetition_takes_no_other_settings(folder):
    for more in (["mine.py"], ["--seed", "5"], ["--model", "emd"]):
        again = Colias(folder)("run", *more, "--again", "run", "--out", "again", "-q", "--workers", "0")
        assert again.returncode == 2 and not (folder / "again").exists()


def test_a_call_from_python_is_repeated_in_its_folder(folder, monkeypatch):
    monkeypatch.chdir(folder)
    (folder / "run").rename(folder / "other")
    experiments.run("mine.py", seed=2, settings={"mean.gain": 6}, out="run", workers=0, quiet=True)
    note = json.loads(Path("run/run.json").read_text())
    assert (note["command"]["call"], note["command"]["arguments"]["seed"]) == ("experiments.run", 2)
    again = rerun(folder)
    assert (again.returncode, again.stdout.split(":")[0]) == (0, "equal"), again.stderr
