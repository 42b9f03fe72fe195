"""Runs cut short, resumed, or refused in one line where settings, code or versions are others than the run's."""

import dataclasses
import json
import re
import shutil
import sys
from pathlib import Path

import polars as pl
import pytest
from filelock import FileLock

import experiments
from colias_sim import reference
from experiments.base.errors import UsageError
from experiments.kinds import registry
from experiments.store import provenance
from experiments.store.folder import has_tables, read_table
from tests.conftest import Colias
from tests.helpers.answering import write_model
from tests.helpers.plans import planned
from tests.helpers.processes import CLI, members, start, wait_until

ROOT = Path(__file__).parents[3]
RUN = ("run", "speed", "--set", "experiment.speeds_cm_s=20,30", "--no-recordings", "--repeats", "1", "--workers", "0")
SLOW = ("run", "speed", "--set", "experiment.speeds_cm_s=9,10", "--repeats", "2", "--workers")
TRIALS = 4
"""Trials of `SLOW`: enough, and long enough, on any machine, for a run to be caught in the middle."""


def trials(folder: Path) -> pl.DataFrame:
    """What is there of a run, whole or in parts."""
    return read_table(folder, "trials").drop("wall_s")


def described(folder: Path) -> dict:
    return json.loads((folder / "run.json").read_text())


def test_a_killed_driver_leaves_no_workers_and_resumes(colias, tmp_path):
    """The trials that were finished stay, each once, with their frames and recordings."""
    assert colias(*SLOW, "0", "--no-recordings", "--out", "whole", "-q").returncode == 0
    process = start(tmp_path, *CLI, *SLOW, "2", "--out", "out", PYTHONPATH=str(ROOT))
    assert wait_until(lambda: has_tables(tmp_path / "out")) and len(members(process.pid)) > 2
    process.kill()
    process.communicate(timeout=60)  # its pipes are open as long as a worker is there
    assert wait_until(lambda: not members(process.pid))
    left = trials(tmp_path / "out")["trial"].to_list()
    assert 1 <= len(left) < TRIALS and left == sorted(set(left))
    recordings = [tmp_path / "out" / "recordings" / f"trial-{number:04d}.rrd" for number in left]
    assert all(path.read_bytes()[-12:].startswith(b"RRF2FOOT") for path in recordings), "whole"
    resumed = colias(*SLOW, "0", "--out", "out")
    assert resumed.returncode == 0 and f"{len(left)} of them done already" in resumed.stderr
    assert trials(tmp_path / "out").equals(trials(tmp_path / "whole")), "the values of an undisturbed run"


@pytest.fixture(scope="module")
def small(tmp_path_factory):
    """A folder of a short run; it is not written to."""
    colias = Colias(tmp_path_factory.mktemp("small"))
    assert colias(*RUN, "--out", "out", "-q").returncode == 0
    return colias.folder / "out"


@pytest.fixture
def out(small, colias):
    """A copy of it."""
    return shutil.copytree(small, colias.folder / "out")


def test_other_parameters_are_refused_and_named(colias, out):
    for change, says in {
        ("--seed", "7"): "seed is 0 there and 7 now",
        ("--repeats", "2"): "repeats is 1 there and 2 now",
        ("--set", "camera.read_noise=0"): "camera.read_noise is 0.64 there and 0.0 now",
    }.items():
        done = colias(*RUN, *change, "--out", "out")
        assert (done.returncode, done.stderr.count("\n")) == (2, 1) and says in done.stderr, done.stderr
    for command in (("run", "distance"), ("tune",), ("behave", "still")):
        done = colias(*command, "--out", "out", "--workers", "0")
        assert done.returncode == 2 and "experiment is 'speed' there and " in done.stderr, done.stderr


def test_a_finished_run_is_complete_and_a_run_that_is_written_is_left_alone(colias, out):
    before = (out / "trials.parquet").read_bytes()
    done = colias(*RUN, "--out", "out")
    assert done.returncode == 0 and "complete: all 2 of them done already, in out" in done.stderr
    assert (out / "trials.parquet").read_bytes() == before
    with FileLock(out / ".lock"):
        second = colias(*RUN, "--out", "out")
    assert second.returncode == 2 and "another process is writing" in second.stderr


def test_a_folder_that_does_not_say_what_it_is_is_left_as_it_is(colias, out):
    (out / "run.json").unlink()
    before = {path: path.read_bytes() for path in out.iterdir()}
    assert colias(*RUN, "--out", "out").returncode == 2
    assert {path: path.read_bytes() for path in before} == before


def test_what_drew_is_noted_and_refuses_nothing(colias, out):
    """The same run, begun where something else draws other pixels."""
    first = described(out)
    ((drew, (pixels,)),) = first["renderers"].items()
    assert re.fullmatch(r".+, OpenGL \d.+, by (egl|osmesa|glfw|cgl)", drew)
    assert pixels == reference.digest(reference.reference_frame())
    rows = pl.read_parquet(out / "trials.parquet")
    (out / "run.json").write_text(json.dumps(first | {"renderers": {"another": ["0123456789ab"]}, "cpus": ["NEON"]}))
    rows.slice(1).write_parquet(out / "trials.parquet")
    again = colias(*RUN, "--out", "out", "-q")
    assert again.returncode == 0 and f"reference frames 0123456789ab, {pixels}" in again.stderr
    both = {"renderers": {"another": ["0123456789ab"], drew: [pixels]}, "cpus": ["NEON", *first["cpus"]]}
    after = described(out)
    assert after == first | both | {"ended": after["ended"]}
    assert trials(out).equals(rows.drop("wall_s")), "the code that marks the rows too"


# --- what computes: the user's files, the project's own, libraries ---------------------------------------------------

EXPERIMENT = """
from experiments import Clip, OfflineExperiment

SMALL = {"rows": 60, "columns": 80, "width": 20, "height": 30, "speed": 240.0}
EXPERIMENT = OfflineExperiment(
    name="mine", summary="small crossings before a trembling camera", models=("tiny.py",), claims=("C2",), repeats=2,
    clips=(Clip("right", "plain", SMALL, 0.5), Clip("left", "plain", {**SMALL, "motion": "leftward"}, 0.5)),
)
"""
BEHAVIOUR = """
from experiments import Behaviour
from gains import GAIN

BEHAVIOUR = Behaviour("slow", "crawls", "colias_sim/Optomotor-v0", lambda rng: lambda _: (GAIN, GAIN), senses="state")
"""
MINE = ("run", "mine.py", "--model", "emd", "--no-recordings", "--workers", "0", "--out", "out", "-q")
KINDS = {
    "clips": MINE,
    "robot": (*RUN, "--model", "tiny.py", "--out", "out", "-q"),
    "behave": ("behave", "slow.py", "--episodes", "1", "--no-baselines", "--no-recordings", "--workers", "0",
               "--set", "robots=1", "--out", "out", "-q"),
}  # fmt: skip


@pytest.fixture
def mine(colias):
    files = {"mine.py": EXPERIMENT, "gains.py": "GAIN = 0.01\n", "slow.py": BEHAVIOUR}
    for name, text in files.items():
        (colias.folder / name).write_text(text)
    write_model(colias.folder, "tiny", "Response(GAIN * float(frame.mean()))", imports="from gains import GAIN")
    return colias


def refused(done, says: str) -> bool:
    return (done.returncode, done.stderr.count("\n")) == (2, 1) and says in done.stderr


@pytest.mark.parametrize(("kind", "missing"), [("clips", False), *((kind, True) for kind in KINDS)])
def test_an_edited_file_of_one_s_own_is_refused(mine, kind, missing):
    """The edited file is a module that the named one imports; its size and, to the second, its time stay."""
    assert mine(*KINDS[kind]).returncode == 0
    table = mine.folder / "out" / "trials.parquet"
    whole = pl.read_parquet(table)
    if missing:
        whole.clear().write_parquet(table)
    files = ("gains.py", *(("mine.py", "tiny.py") if kind == "clips" else ()))
    for name in files:
        there = (mine.folder / name).read_text()
        (mine.folder / name).write_text("GAIN = 0.02\n" if name == "gains.py" else f"{there}# more\n")
        before = (table.read_bytes(), described(mine.folder / "out"))
        assert refused(mine(*KINDS[kind]), name)
        assert (table.read_bytes(), described(mine.folder / "out")) == before, "what is there stays as it was"
        (mine.folder / name).write_text(there)
    for name in files:
        (mine.folder / name).write_text((mine.folder / name).read_text() + "# more\n")
    done = mine(*KINDS[kind])
    assert all(refused(done, name) for name in files)


def test_other_claims_are_judged_on_the_trials_that_are_done(mine, monkeypatch):
    assert mine(*MINE).returncode == 0
    monkeypatch.chdir(mine.folder)
    rows = pl.read_parquet("out/trials.parquet")
    given = {"models": ["emd"], "recordings": False, "out": "out", "workers": 0, "quiet": True}
    declared = dataclasses.replace(registry.find("mine.py"), claims=("C2", "C3"))
    assert set(experiments.run(declared, **given).claims["id"]) == {"C2", "C3"}
    assert pl.read_parquet("out/trials.parquet").equals(rows)
    with pytest.raises(UsageError, match="choose another --out"):  # what the clips show is another matter
        experiments.run(dataclasses.replace(declared, clips=declared.clips[:1]), **given)


@pytest.mark.parametrize("missing", [False, True])
def test_other_source_and_versions_are_refused(mine, monkeypatch, missing):
    assert mine(*MINE).returncode == 0
    out = mine.folder / "out"
    rows = pl.read_parquet(out / "trials.parquet")
    rows.filter(pl.col("trial") >= missing).write_parquet(out / "trials.parquet")
    with monkeypatch.context() as patched:
        patched.setattr(provenance, "digest", lambda: "another")
        assert refused(mine(*MINE), "colias-sim's own source")
    there = described(out)
    for name in ("numpy", "python"):
        (out / "run.json").write_text(json.dumps(there | {"versions": there["versions"] | {name: "1.0"}}))
        assert refused(mine(*MINE), "numpy") == (name == "numpy"), "a patch of Python changes no number"


# --- a project's folder that was renamed ------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", [*KINDS, "python", "sweep"])
def test_a_project_whose_folder_was_renamed_resumes_and_is_repeated(kind, mine, tmp_path, monkeypatch):
    """Its files are equal, and their places from the run; absolute paths of its own in the command are those of now."""
    before, after = tmp_path / "before", tmp_path / "after"
    before.mkdir()
    for file in ("mine.py", "tiny.py", "gains.py", "slow.py"):
        (tmp_path / file).rename(before / file)

    def begin(folder):
        given = {"out": "out", "workers": 0, "quiet": True}
        monkeypatch.chdir(folder)
        if kind == "python":
            experiments.run(str(folder / "mine.py"), models=[folder / "tiny.py", "emd"], recordings=False, **given)
        elif kind == "sweep":
            experiments.sweep("speed", ("tiny.t_sp=0.1,0.2",), [folder / "tiny.py"], range(3, 4), measures=["spikes"],
                              repeats=1, **given)  # fmt: skip
        else:
            done = Colias(folder)(*(str(folder / word) if word.endswith(".py") else word for word in KINDS[kind]))
            assert done.returncode == 0, done.stderr

    begin(before)
    whole = pl.read_parquet("out/trials.parquet")
    monkeypatch.chdir(tmp_path)
    before.rename(after)
    sys.modules.pop("gains", None)  # as in a new process
    again = Colias(tmp_path)("run", "--again", "after/out", "--out", "again", "--workers", "0", "-q")
    assert (again.returncode, again.stdout.split(":")[0], again.stderr) == (0, "equal", ""), again.stderr
    last = pl.col("trial") == whole["trial"].max()
    whole.filter(~last).write_parquet(after / "out" / "trials.parquet")
    begin(after)
    resumed = pl.read_parquet("out/trials.parquet")
    assert resumed.drop("wall_s", strict=False).equals(whole.drop("wall_s", strict=False))
    (after / "gains.py").write_text("GAIN = 0.02\n")
    edited = Colias(tmp_path)("run", "--again", "after/out", "--out", "edited", "--workers", "0", "-q")
    assert "gains.py" in edited.stderr and "mine.py" not in edited.stderr


# --- parameters that are not at their defaults are columns -----------------------------------------------------------


def test_changed_parameters_by_set_and_by_model():
    same = planned("speed", settings=["dsnn.n_con=8", "experiment.distances_cm=8"])
    assert same.parameters == {}, "typed, but the same"
    models = ("dsnn", "dsnn:n_con=6", "emd")
    settings = ["dsnn.tau_s=200,10", "camera.read_noise=0.25", "experiment.direction=both"]
    assert planned("speed", models, settings).parameters == {
        "dsnn.tau_s": dict(zip(models, ("200,10", "200,10", None), strict=True)),
        "dsnn.n_con": dict(zip(models, (8, 6, None), strict=True)),
        "camera.read_noise": dict.fromkeys(models, 0.25),
        "experiment.direction": dict.fromkeys(models, "both"),
    }
