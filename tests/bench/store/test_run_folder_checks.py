"""Going on with a folder: refused in one line where settings, code or versions are others than the run's."""

import json
import shutil
import sys
from pathlib import Path

import polars as pl
import pytest

from experiments.bench.cli import entry
from experiments.bench.run import provenance
from tests.conftest import Colias

TRIALS, FRAMES = "trials.parquet", "frames.parquet"

EXPERIMENT = """
from experiments.bench.sources.clips import Clip
from experiments.bench.sources.clips import OfflineExperiment

SMALL = (("rows", 60), ("columns", 80), ("width", 20), ("height", 30), ("speed", 240.0))
EXPERIMENT = OfflineExperiment(
    name="mine", summary="small crossings before a trembling camera", models=("tiny.py",), claims=("C2",), repeats=2,
    clips=(Clip("right", "plain", SMALL, 0.5), Clip("left", "plain", (*SMALL, ("motion", "leftward")), 0.5)),
)
"""
MODEL = """
from dataclasses import dataclass
from dsnn import ModelEntry, Response
from gains import GAIN

@dataclass(frozen=True)
class Parameters:
    t_sp: float = 0.2

class Tiny:
    def __init__(self, shape, parameters):
        self.last = None

    def reset(self):
        self.last = None

    def step(self, frame, *, channels="grey", maps=False):
        mean, last = float(frame.mean()), self.last
        self.last = mean
        return Response(0.0 if last is None else GAIN * (mean - last), 0.0, 0, 0)

MODEL = ModelEntry("tiny", "the change of the mean", Tiny, Parameters())
"""
GAINS = "GAIN = 0.01\n"
ARGUMENTS = ("run", "mine.py", "--model", "emd", "--workers", "0")
ADVICE = "use the first command's options, or choose another --out"
ROBOT = ("run", "speed", "--set", "experiment.speeds_cm_s=30", "--repeats", "1", "--workers", "0")


def write_files(folder: Path) -> None:
    for name, text in {"mine.py": EXPERIMENT, "tiny.py": MODEL, "gains.py": GAINS}.items():
        (folder / name).write_text(text)


@pytest.fixture(scope="module")
def base(tmp_path_factory):
    """A run of one's own off-line experiment and model."""
    folder = tmp_path_factory.mktemp("base")
    write_files(folder)
    done = Colias(folder)(*ARGUMENTS, "--out", "whole", "-q")
    assert (done.returncode, done.stderr) == (0, "")
    return folder


def goes_on(monkeypatch, capsys, folder: Path, *arguments: str) -> tuple[int, str]:
    """The command line in this process: exit status, and what it says on stderr; a traceback would be raised."""
    monkeypatch.chdir(folder)
    monkeypatch.setattr(sys, "argv", ["colias", *arguments])
    with pytest.raises(SystemExit) as ended:
        entry.run()
    return ended.value.code or 0, capsys.readouterr().err


def test_recordings_are_asked_for_once_and_for_all(base, monkeypatch, capsys):
    code, message = goes_on(monkeypatch, capsys, base, *ARGUMENTS, "--out", "whole", "--no-recordings")
    assert (code, message) == (2, f"error: whole: recordings is true there and false now: {ADVICE}\n")


# What computes: the user's files, the project's own.

BEHAVIOUR = """
from experiments import Behaviour
from gains import GAIN

BEHAVIOUR = Behaviour.oracle("slow", "crawls", "colias_sim/Optomotor-v0", lambda state: (GAIN, GAIN))
"""
KINDS = {
    "clips": ("run", "mine.py", "--no-recordings", "--workers", "0"),
    "robot": (*ROBOT, "--model", "tiny.py", "--no-recordings"),
    "behave": ("behave", "slow.py", "--episodes", "1", "--no-baselines", "--no-recordings", "--workers", "0",
               "--set", "robots=1"),
}  # fmt: skip


def drop_first_trial(folder: Path) -> None:
    pl.read_parquet(folder / TRIALS).filter(pl.col("trial") != 0).write_parquet(folder / TRIALS)


@pytest.mark.parametrize("kind", KINDS)
def test_an_edited_file_of_one_s_own_is_refused(colias, kind):
    """The edited file is a module that the named one imports; its size and, to the second, its time stay."""
    write_files(colias.folder)
    (colias.folder / "slow.py").write_text(BEHAVIOUR)
    arguments = (*KINDS[kind], "--out", "out", "-q")
    done = colias(*arguments)
    assert done.returncode == 0, done.stderr
    before = {path.name: path.read_bytes() for path in (colias.folder / "out").iterdir() if path.is_file()}
    edited = {"gains.py": "GAIN = 0.02\n"}
    if kind == "clips":
        edited |= {"mine.py": f"{EXPERIMENT}# more\n", "tiny.py": f"{MODEL}# more\n"}
    for name, text in edited.items():
        there = (colias.folder / name).read_text()
        (colias.folder / name).write_text(text)
        other = colias(*arguments)
        assert (other.returncode, other.stderr.count("\n")) == (2, 1), other.stderr
        assert f"{name} has changed; --other-code resumes all the same" in other.stderr
        (colias.folder / name).write_text(there)
    assert {path.name: path.read_bytes() for path in (colias.folder / "out").iterdir() if path.is_file()} == before


def test_rows_of_other_code_are_marked_where_that_is_asked_for(base, monkeypatch, capsys, tmp_path):
    folder = shutil.copytree(base / "whole", tmp_path / "out")
    (first,) = {row["code"] for row in pl.read_parquet(folder / TRIALS).to_dicts()}
    drop_first_trial(folder)
    (base / "gains.py").write_text("GAIN = 0.02\n")
    code, message = goes_on(monkeypatch, capsys, base, *ARGUMENTS, "--out", str(folder), "-q", "--other-code")
    (base / "gains.py").write_text(GAINS)
    assert code == 0 and "rows of 2 codes" in message
    described = json.loads((folder / "run.json").read_text())
    (second,) = [resumption["code"] for resumption in described["resumed_with"]]
    assert described["code"] == first != second
    rows = pl.read_parquet(folder / TRIALS).to_dicts()
    assert all(row["code"] == (first if row["trial"] else second) for row in rows)
    claims = json.loads((folder / "claims.json").read_text())["claims"]
    assert claims and all("rows of 2 codes" in claim["outcome"]["measured"] for claim in claims)


def test_other_claims_are_judged_on_the_trials_that_are_done(monkeypatch, capsys, tmp_path):
    write_files(tmp_path)
    out, arguments = tmp_path / "out", (*ARGUMENTS, "--no-recordings", "--out", "out", "-q")
    assert goes_on(monkeypatch, capsys, tmp_path, *arguments) == (0, "")
    rows = pl.read_parquet(out / TRIALS)
    changed = EXPERIMENT.replace('("C2",)', '("C2", "C3")')
    (tmp_path / "mine.py").write_text(changed)
    code, message = goes_on(monkeypatch, capsys, tmp_path, *arguments)
    assert (code, message.count("\n")) == (2, 1) and "experiment.claims is" in message
    code, _ = goes_on(monkeypatch, capsys, tmp_path, *arguments, "--other-code")
    assert code == 0 and pl.read_parquet(out / TRIALS).equals(rows)
    judged = {claim["id"] for claim in json.loads((out / "claims.json").read_text())["claims"]}
    assert judged == {"C2", "C3"}
    (tmp_path / "mine.py").write_text(changed.replace("240.0", "120.0"))  # what the clips show is another matter
    code, message = goes_on(monkeypatch, capsys, tmp_path, *arguments, "--other-code")
    assert (code, message.count("\n")) == (2, 1) and "choose another --out" in message


def test_other_source_of_the_project_is_refused_or_marked(base, monkeypatch, capsys, tmp_path):
    """The source is digested by names and contents of its files, wherever they are."""
    out = shutil.copytree(base / "whole", tmp_path / "out")
    described = json.loads((out / "run.json").read_text())
    root = Path(entry.__file__).parents[3]
    folders = {name: tmp_path / "copy" / name for name in provenance.package_folders()}
    for name, folder in folders.items():
        shutil.copytree(root / name, folder, ignore=shutil.ignore_patterns("__pycache__"))
    with monkeypatch.context() as patched:
        patched.setattr(provenance, "package_folders", lambda: folders)
        assert provenance.digest.__wrapped__() == described["source"]["digest"]
        with (folders["dsnn"] / "emd.py").open("a") as file:
            file.write("# a line more\n")
        other = provenance.digest.__wrapped__()
    monkeypatch.setattr(provenance, "digest", lambda: other)
    drop_first_trial(out)
    arguments = (base, *ARGUMENTS, "--out", str(out), "-q")
    code, message = goes_on(monkeypatch, capsys, *arguments)
    assert (code, message.count("\n")) == (2, 1) and "colias-sim's own source has changed" in message, message
    code, message = goes_on(monkeypatch, capsys, *arguments, "--other-code")
    assert code == 0 and "rows of 2 codes" in message
    (more,) = json.loads((out / "run.json").read_text())["resumed_with"]
    assert more["source"]["digest"] == other != described["source"]["digest"]
    assert goes_on(monkeypatch, capsys, *arguments)[0] == 0, "both codes are known by now"


def test_other_versions_are_refused_unless_asked_for(base, monkeypatch, capsys, tmp_path):
    shutil.copytree(base / "whole", tmp_path / "out")
    file = tmp_path / "out" / "run.json"
    described = json.loads(file.read_text())
    described["versions"] |= {"numpy": "1.0", "python": "3.0"}
    file.write_text(json.dumps(described))
    out = str(tmp_path / "out")
    code, message = goes_on(monkeypatch, capsys, base, *ARGUMENTS, "--out", out)
    assert code == 2 and 'versions.numpy is "1.0" there' in message and "--other-code" in message
    code, message = goes_on(monkeypatch, capsys, base, *ARGUMENTS, "--out", out, "--other-code", "-q")
    assert code == 0, message
