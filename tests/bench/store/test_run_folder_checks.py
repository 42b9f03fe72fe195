"""Going on with a folder in which something was changed: refused in one line, or mended, never two runs in a table."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pyarrow.parquet as pq
import pytest

from experiments.bench.cli import entry
from tests.conftest import Colias
from tests.helpers.damages import DAMAGES, FRAMES, RECORDINGS, TABLES, TRIALS, Damage

EXPERIMENT = """
from experiments.bench.clips.experiment import Clip, OfflineExperiment

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
ADVICE = "repeat the first command's options, or choose another --out"
ROBOT = ("run", "speed", "--set", "experiment.speeds_cm_s=20,30", "--repeats", "1", "--workers", "0")


def write_files(folder: Path) -> None:
    for name, text in {"mine.py": EXPERIMENT, "tiny.py": MODEL, "gains.py": GAINS}.items():
        (folder / name).write_text(text)


def at_two_seeds(folder: Path, arguments: tuple[str, ...], kind: str) -> Path:
    write_files(folder)
    for seed, name in (("0", "whole"), ("7", "other")):
        done = Colias(folder)(*arguments, "--seed", seed, "--out", f"{kind}-{name}", "-q")
        assert (done.returncode, done.stderr) == (0, "")
    return folder


def tables(folder: Path):
    """What a run comes to, times aside."""
    trials = pq.read_table(folder / TRIALS).drop_columns(["wall_s"])
    return trials, pq.read_table(folder / FRAMES), (folder / "claims.json").read_text()


@pytest.fixture(scope="module")
def base(tmp_path_factory):
    """Runs of one's own off-line experiment and model at two seeds."""
    return at_two_seeds(tmp_path_factory.mktemp("base"), ARGUMENTS, "clips")


@pytest.fixture(scope="module")
def robot(tmp_path_factory):
    """The same of the robot's trials."""
    return at_two_seeds(tmp_path_factory.mktemp("robot"), ROBOT, "robot")


def goes_on(monkeypatch, capsys, folder: Path, *arguments: str) -> tuple[int, str]:
    """The command line in this process: exit status, and what it says on stderr; a traceback would be raised."""
    monkeypatch.chdir(folder)
    monkeypatch.setattr(sys, "argv", ["colias", *arguments])
    with pytest.raises(SystemExit) as ended:
        entry.run()
    return ended.value.code or 0, capsys.readouterr().err


def check_end(damage: Damage, base: Path, kind: str, folder: Path, code: int, message: str) -> None:
    assert "Traceback" not in message and damage.is_told(message), message
    if damage.ends == "refused":
        assert (code, message.count("\n")) == (2, 1), message
        assert message.startswith("colias: ")
        return
    assert code == 0, message
    for mine, whole in zip(tables(folder), tables(base / f"{kind}-whole"), strict=True):
        assert mine == whole
    recordings = [sorted(path.name for path in (run_folder / "recordings").glob("*.rrd")) for run_folder in
                  (folder, base / f"{kind}-whole")]  # fmt: skip
    assert recordings[0] == recordings[1]
    assert all(path.stat().st_size > 1000 for path in (folder / "recordings").glob("*.rrd"))


def damaged(damage: Damage, base: Path, kind: str, folder: Path) -> None:
    shutil.copytree(base / f"{kind}-whole", folder)
    damage.do(folder, base / f"{kind}-other")


@pytest.mark.parametrize("damage", DAMAGES, ids=str)
def test_a_damaged_folder_is_refused_or_mended(damage, base, monkeypatch, capsys):
    folder = base / f"clips-{DAMAGES.index(damage)}"
    damaged(damage, base, "clips", folder)
    code, message = goes_on(monkeypatch, capsys, base, *ARGUMENTS, "--out", folder.name, "-q")
    check_end(damage, base, "clips", folder, code, message)


CHOSEN = ("a row of another seed added", "trial null", "a trial's frames of another seed", "a recording deleted")


@pytest.mark.parametrize("damage", [d for d in (*TABLES, *RECORDINGS) if d.name in CHOSEN], ids=str)
def test_a_damaged_folder_of_the_robot_s_trials(damage, robot):
    """In a process of its own, as a user does."""
    folder = robot / f"robot-{DAMAGES.index(damage)}"
    damaged(damage, robot, "robot", folder)
    done = Colias(robot)(*ROBOT, "--out", folder.name, "-q")
    check_end(damage, robot, "robot", folder, done.returncode, done.stderr)


@pytest.mark.parametrize(("column", "value"), [("speed_cm_s", 6.0), ("angle_deg", 3.0), ("motion", "approach")])
def test_a_condition_that_is_not_the_plan_s_is_refused(robot, column, value, monkeypatch, capsys, tmp_path):
    shutil.copytree(robot / "robot-whole", tmp_path / "out")
    rows = pq.read_table(tmp_path / "out" / TRIALS)
    changed = [{**row, column: value} if row["trial"] == 1 else row for row in rows.to_pylist()]
    pq.write_table(type(rows).from_pylist(changed, rows.schema), tmp_path / "out" / TRIALS)
    code, message = goes_on(monkeypatch, capsys, tmp_path, *ROBOT, "--out", "out")
    assert (code, message.count("\n")) == (2, 1)
    assert f"out: trials.parquet: trial 1: {column} is {value!r}, the plan says" in message


@pytest.mark.parametrize(("kind", "arguments"), [("clips", ARGUMENTS), ("robot", ROBOT)])
def test_recordings_are_asked_for_once_and_for_all(base, robot, kind, arguments, monkeypatch, capsys):
    folder = robot if kind == "robot" else base
    code, message = goes_on(monkeypatch, capsys, folder, *arguments, "--out", f"{kind}-whole", "--no-recordings")
    assert (code, message) == (2, f"colias: {kind}-whole: --recordings is true there and false now: {ADVICE}\n")


def test_a_row_made_again_with_other_numbers_is_told(base, monkeypatch, capsys, tmp_path):
    """Its frames have to be other ones too, or they would be refused."""
    shutil.copytree(base / "clips-whole", tmp_path / "out")
    for name, column in ((TRIALS, "peak_hs"), (FRAMES, "hs")):
        table = pq.read_table(tmp_path / "out" / name)
        rows = table.to_pylist()
        chosen = [row for row in rows if (row["trial"], row["model"]) == (0, "tiny")]
        highest = max(chosen, key=lambda row: row[column])
        highest[column] += 1.0
        pq.write_table(type(table).from_pylist(rows, table.schema), tmp_path / "out" / name)
    (tmp_path / "out" / "recordings" / "trial-0000.rrd").unlink()
    monkeypatch.chdir(base)
    code, message = goes_on(monkeypatch, capsys, base, *ARGUMENTS, "--out", str(tmp_path / "out"), "-q")
    assert code == 0 and "done again with other numbers than before: trials 0\n" in message
    assert tables(tmp_path / "out")[0] == tables(base / "clips-whole")[0]


# What computes: the user's files, the project's own.

BEHAVIOUR = """
from experiments.bench.closed_loop.find import Behaviour
from gains import GAIN

BEHAVIOUR = Behaviour.oracle("slow", "crawls", "colias_sim/Optomotor-v0", lambda state: (GAIN, GAIN))
"""
KINDS = {
    "clips": ("run", "mine.py", "--no-recordings", "--workers", "0"),
    "robot": (*ROBOT, "--model", "tiny.py", "--no-recordings"),
    "tune": ("tune", "--only", "--model", "tiny.py", "--model", "emd", "--curve", "contrast", "--workers", "0"),
    "behave": ("behave", "slow.py", "--episodes", "2", "--no-baselines", "--no-recordings", "--workers", "0",
               "--set", "robots=1"),
    "map": ("map", *ROBOT[1:], "--model", "tiny.py", "--measure", "spikes", "--over", "tiny.t_sp=0.1,0.3"),
}  # fmt: skip


def drop_first_trial(folder: Path) -> None:
    table = pq.read_table(folder / TRIALS)
    pq.write_table(type(table).from_pylist([r for r in table.to_pylist() if r["trial"]], table.schema), folder / TRIALS)


@pytest.mark.parametrize("kind", KINDS)
def test_an_edited_file_of_one_s_own_is_refused_or_marked(colias, kind):
    """The edited file is a module that the named one imports; its size and, to the second, its time stay."""
    arguments = KINDS[kind]
    write_files(colias.folder)
    (colias.folder / "slow.py").write_text(BEHAVIOUR)
    done = colias(*arguments, "--out", "out", "-q")
    assert done.returncode == 0, done.stderr
    folder = colias.folder / "out"
    (first,) = {row["code"] for row in pq.read_table(folder / TRIALS).to_pylist()}
    assert str(colias.folder / "gains.py") in json.loads((folder / "experiment.json").read_text())["files"]
    drop_first_trial(folder)
    before = {path.name: path.read_bytes() for path in folder.iterdir() if path.is_file()}

    (colias.folder / "gains.py").write_text("GAIN = 0.02\n")
    other = colias(*arguments, "--out", "out", "-q")
    assert (other.returncode, other.stderr.count("\n")) == (2, 1), other.stderr
    assert "gains.py has changed; --other-code goes on all the same" in other.stderr
    assert {path.name: path.read_bytes() for path in folder.iterdir() if path.is_file()} == before

    asked = colias(*arguments, "--out", "out", "-q", "--other-code")
    assert asked.returncode == 0, asked.stderr
    assert "rows of 2 codes" in asked.stderr
    rows = pq.read_table(folder / TRIALS).to_pylist()
    described = json.loads((folder / "experiment.json").read_text())
    (second,) = [resumption["code"] for resumption in described["resumed_with"]]
    assert described["code"] == first != second
    assert all(row["code"] == (first if row["trial"] else second) for row in rows)
    if kind in ("clips", "robot"):
        claims = json.loads((folder / "claims.json").read_text())["claims"]
        assert claims and all("rows of 2 codes" in claim["outcome"]["measured"] for claim in claims)


@pytest.mark.parametrize("name", ["mine.py", "tiny.py"])
def test_an_edited_experiment_or_model_file_is_refused(base, name, colias):
    write_files(colias.folder)
    assert colias(*ARGUMENTS, "--out", "out", "-q").returncode == 0
    (colias.folder / name).write_text((colias.folder / name).read_text() + "# more\n")
    done = colias(*ARGUMENTS, "--out", "out")
    assert (done.returncode, done.stderr.count("\n")) == (2, 1), done.stderr
    assert f"{name} has changed; --other-code" in done.stderr


def test_other_claims_are_judged_on_the_trials_that_are_done(monkeypatch, capsys, tmp_path):
    write_files(tmp_path)
    out, arguments = tmp_path / "out", (*ARGUMENTS, "--no-recordings", "--out", "out", "-q")
    assert goes_on(monkeypatch, capsys, tmp_path, *arguments) == (0, "")
    rows = pq.read_table(out / TRIALS)
    changed = EXPERIMENT.replace('("C2",)', '("C2", "C3")')
    (tmp_path / "mine.py").write_text(changed)
    code, message = goes_on(monkeypatch, capsys, tmp_path, *arguments)
    assert (code, message.count("\n")) == (2, 1) and "--other-code judges the trials that are done" in message
    code, _ = goes_on(monkeypatch, capsys, tmp_path, *arguments, "--other-code")
    assert code == 0 and pq.read_table(out / TRIALS) == rows
    judged = {claim["id"] for claim in json.loads((out / "claims.json").read_text())["claims"]}
    assert judged == {"C2", "C3"}
    (tmp_path / "mine.py").write_text(changed.replace("240.0", "120.0"))  # what the clips show is another matter
    code, message = goes_on(monkeypatch, capsys, tmp_path, *arguments, "--other-code")
    assert (code, message.count("\n")) == (2, 1) and "choose another --out" in message


def test_a_file_edited_while_the_run_goes_on_ends_it(colias):
    """It edits itself, where it is loaded first: its workers then have another one."""
    write_files(colias.folder)
    text = MODEL + (
        "\nimport multiprocessing, pathlib\n"
        "if multiprocessing.parent_process() is None:\n"
        "    pathlib.Path(__file__).write_text(pathlib.Path(__file__).read_text() + '# edited\\n')\n"
    )
    (colias.folder / "tiny.py").write_text(text)
    done = colias("run", "mine.py", "--no-recordings", "--workers", "1", "--out", "out", "-q")
    assert (done.returncode, done.stderr.count("\n")) == (2, 2), done.stderr
    assert done.stderr.startswith("stopped after 0 of 4 clips") and "Traceback" not in done.stderr
    assert "tiny.py: was edited after the run was begun" in done.stderr
    assert not (colias.folder / "out" / TRIALS).exists()


@pytest.fixture
def elsewhere(tmp_path):
    """A copy of the project in no checkout, and what runs its command line."""
    root = Path(entry.__file__).parents[3]
    for package in ("colias_sim", "dsnn", "scenes", "experiments"):
        shutil.copytree(root / package, tmp_path / "copy" / package, ignore=shutil.ignore_patterns("__pycache__"))

    def run(*arguments: str):
        there = Colias(tmp_path)
        path = os.environ.get("PYTHONPATH")
        os.environ["PYTHONPATH"] = str(tmp_path / "copy")
        try:
            return there(*arguments)
        finally:
            os.environ.pop("PYTHONPATH") if path is None else os.environ.update(PYTHONPATH=path)

    return tmp_path, run


def test_other_source_of_the_project_is_refused_or_marked(colias, elsewhere):
    """The same source elsewhere is the same; a line more in it is not, unless that is asked for."""
    folder, run = elsewhere
    write_files(folder)
    assert colias(*ARGUMENTS, "--out", "out", "-q").returncode == 0
    described = json.loads((folder / "out" / "experiment.json").read_text())
    same = run(*ARGUMENTS, "--out", "out", "-q")
    assert (same.returncode, same.stderr) == (0, "")
    with (folder / "copy" / "dsnn" / "emd.py").open("a") as file:
        file.write("# a line more\n")
    other = run(*ARGUMENTS, "--out", "out")
    assert (other.returncode, other.stderr.count("\n")) == (2, 1), other.stderr
    assert "colias-sim's own source has changed" in other.stderr and "--other-code" in other.stderr
    drop_first_trial(folder / "out")
    asked = run(*ARGUMENTS, "--out", "out", "--other-code", "-q")
    assert asked.returncode == 0 and "rows of 2 codes" in asked.stderr
    (more,) = json.loads((folder / "out" / "experiment.json").read_text())["resumed_with"]
    assert more["source"]["digest"] != described["source"]["digest"]
    assert (more["source"]["commit"], more["source"]["dirty"]) == (None, None), "it is in no checkout"
    again = run(*ARGUMENTS, "--out", "out", "-q")
    assert again.returncode == 0, "both codes are known by now"


def test_other_versions_are_refused_unless_asked_for(base, monkeypatch, capsys, tmp_path):
    shutil.copytree(base / "clips-whole", tmp_path / "out")
    file = tmp_path / "out" / "experiment.json"
    described = json.loads(file.read_text())
    described["versions"] |= {"numpy": "1.0", "python": "3.0"}
    file.write_text(json.dumps(described))
    out = str(tmp_path / "out")
    code, message = goes_on(monkeypatch, capsys, base, *ARGUMENTS, "--out", out)
    assert code == 2 and 'versions.numpy is "1.0" there' in message and "--other-code" in message
    code, message = goes_on(monkeypatch, capsys, base, *ARGUMENTS, "--out", out, "--other-code", "-q")
    assert code == 0, message


# A folder that a run is begun in.

KILLED = """
import resource, signal, sys
from experiments.bench.cli import entry
from experiments.bench.robot import table as robot_table
from experiments.bench.clips import figure as clips_figure
from experiments.bench.clips import run as clips_run
signal.signal(signal.SIGXFSZ, getattr(signal, sys.argv[1]))
resource.setrlimit(resource.RLIMIT_FSIZE, (500, 500))
sys.argv[:2] = ["colias"]
entry.run()
"""


@pytest.mark.parametrize("how", ["SIG_DFL", "SIG_IGN"])
def test_a_kill_while_the_description_is_written_costs_nothing(colias, how):
    """No file may grow past 500 bytes: the process is killed there, or the disk is full."""
    write_files(colias.folder)
    command = [sys.executable, "-c", KILLED, how, *ARGUMENTS, "--out", "out", "-q"]
    done = subprocess.run(command, cwd=colias.folder, capture_output=True, text=True, timeout=200)
    assert done.returncode == (-25 if how == "SIG_DFL" else 2), done.stderr
    assert not (colias.folder / "out" / "experiment.json").exists()
    again = colias(*ARGUMENTS, "--out", "out", "-q")
    assert (again.returncode, again.stderr) == (0, "")
    json.loads((colias.folder / "out" / "experiment.json").read_text())


@pytest.mark.parametrize("name", [TRIALS, FRAMES, "failures.json", "recordings/trial-0000.rrd"])
def test_what_a_run_left_without_its_description_is_not_taken_for_nothing(base, name, monkeypatch, capsys, tmp_path):
    (tmp_path / "out" / "recordings").mkdir(parents=True)
    (tmp_path / "out" / name).write_bytes(b"x")
    code, message = goes_on(monkeypatch, capsys, base, *ARGUMENTS, "--out", str(tmp_path / "out"))
    assert (code, message.count("\n")) == (2, 1) and "already holds a run" in message
    assert (tmp_path / "out" / name).read_bytes() == b"x"


@pytest.mark.parametrize("text", [100_000 * "[", "[]", "null", '"x"', '{"experiment": "tuning", "seed": 0', ""])
def test_every_command_reads_a_description_alike(base, text, monkeypatch, capsys, tmp_path):
    (tmp_path / "experiment.json").write_text(text)
    out = str(tmp_path)
    for command in (
        ("tune", "--model", "emd", "--curve", "contrast", "--out", out),
        ("behave", "still", "--episodes", "1", "--no-baselines", "--out", out),
        ("map", *ROBOT[1:], "--measure", "spikes", "--over", "dsnn.n_con=4,6", "--out", out),
        ("study", "fidelity", "--out", out),
        (*ARGUMENTS, "--out", out),
    ):
        code, message = goes_on(monkeypatch, capsys, base, *command)
        assert code == 2, message
        assert "experiment.json cannot be read" in message.splitlines()[-1]


def test_a_folder_of_leftovers_is_tuned_into(base, monkeypatch, capsys, tmp_path):
    (tmp_path / "recordings").mkdir()
    for name in (".lock", "experiment.json.77.part"):
        (tmp_path / name).touch()
    arguments = ("tune", "--only", "--model", "emd", "--curve", "contrast", "--workers", "0", "-q")
    assert goes_on(monkeypatch, capsys, base, *arguments, "--out", str(tmp_path)) == (0, "")
