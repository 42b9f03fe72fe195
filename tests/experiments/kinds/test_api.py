"""`experiments` from Python: its names, equal rows from anywhere, what a run has, comparisons of runs."""

import ast
import datetime
import json
import os
import subprocess
import sys
from pathlib import Path

import polars as pl
import pytest

import experiments
from tests.conftest import Colias

PACKAGE = Path(experiments.__file__).parent
ENVIRONMENT = {**os.environ, "PYTHONPATH": str(PACKAGE.parent)}
QUICK = {"repeats": 2, "recordings": False, "quiet": True, "workers": 0}
FAST = {"experiment.speeds_cm_s": [20, 30]}


def test_every_public_name_is_offered_before_it_is_looked_up():
    assert set(experiments.__all__) <= set(dir(experiments))


def test_declarations_import_the_public_names_alone():
    """They are what a person copies. One may import another, which is copied with it. (`wiring` joins packages.)"""
    declarations = {path.stem: path for path in PACKAGE.glob("*.py") if path.stem not in ("__init__", "wiring")}
    public = {"__future__", "experiments", *(f"experiments.{name}" for name in declarations)}
    for path in declarations.values():
        body = ast.parse(path.read_text()).body
        assert {node.module for node in body if isinstance(node, ast.ImportFrom)} <= public, path


SCRIPT = """
with open("began.txt", "a") as file:
    file.write("once\\n")

from experiments import Clip, OfflineExperiment, run

CLIP = Clip("way", "plain", {"rows": 24, "columns": 32, "duration_s": 0.2})
EXPERIMENT = OfflineExperiment("mine", "mine", [CLIP], ["dsnn"], claims=("C2",), repeats=2)
made = run(EXPERIMENT, models=["emd"], settings={"dsnn.n_con": 6}, seed=3, workers=1, out="out", recordings=False)
"""
OF_COLIAS = ("--model", "emd", "--set", "dsnn.n_con=6", "--seed", "3", "--no-recordings", "--quiet")
KERNEL = """
import sys, types
sys.modules["__main__"] = types.ModuleType("__main__")  # as a notebook's kernel has: of no file
exec(compile(open("cell.txt").read(), "<cell 1>", "exec"), sys.modules["__main__"].__dict__)
"""
WAYS = {"a plain script": ["mine.py"], "standard input": ["-"], "a notebook": ["-c", KERNEL]}


@pytest.fixture(scope="module")
def by_command(tmp_path_factory):
    folder = tmp_path_factory.mktemp("command")
    (folder / "mine.py").write_text(SCRIPT.partition("made =")[0])
    assert Colias(folder)("run", "mine.py", *OF_COLIAS, "--out", "out").returncode == 0
    return experiments.load(folder / "out").trials.drop("wall_s")


@pytest.mark.parametrize("way", WAYS)
def test_from_anywhere_the_same_rows(way, tmp_path, by_command):
    """Of a script without ``__main__`` guard, on worker processes; the script itself is run once."""
    for name in ("mine.py", "cell.txt"):
        (tmp_path / name).write_text(SCRIPT)
    command = [sys.executable, *WAYS[way]]
    done = subprocess.run(command, input=SCRIPT, cwd=tmp_path, env=ENVIRONMENT, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "began.txt").read_text() == "once\n"
    assert experiments.load(tmp_path / "out").trials.drop("wall_s").equals(by_command)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Runs of the same trials by defaults and with another gain, a run at another seed, and clips; not written to."""
    folder = tmp_path_factory.mktemp("runs")
    experiments.run("speed", settings=FAST, out=folder / "usual", **QUICK)
    more = {"settings": {**FAST, "dsnn.n_con": 4}, "models": ["dsn2017", "emd"]}
    experiments.run("speed", **more, out=folder / "changed", **QUICK)
    alone = {"models": "dsnn:n_con=4", "only": True, "seed": 1}
    experiments.run("speed", settings=FAST, **alone, out=folder / "part" / "alone", **QUICK)
    experiments.run("clean", out=folder / "clean", **{**QUICK, "repeats": 1})
    return folder


def test_a_run_has_its_tables(folder):
    usual, changed, clean = (experiments.load(folder / name) for name in ("usual", "changed", "clean"))
    assert (usual.name, usual.seed, usual.planned, usual.done, usual.models) == ("speed", 0, 4, 4, ["dsnn"])
    assert (usual.kind, clean.kind, clean.done, clean.planned) == ("trials", "clips", 12, 12)
    assert changed.changed == "dsnn.n_con=4, experiment.speeds_cm_s=20,30"
    assert usual.frames.height == usual.trials["frames"].sum() and usual.failures.is_empty() and not usual.recordings
    assert "dsnn.n_con" not in usual.trials.columns and changed.trials["dsnn.n_con"].to_list()[:3] == [4, None, None]
    row = usual.summary.filter(quantity="spikes").to_dicts()[0]
    assert (row["n"], row["mean"]) == (2, usual.trials.filter(speed_cm_s=row["speed_cm_s"])["spikes"].mean())
    assert row["far_cm"] is None and clean.summary["sd"].dtype == pl.Float64
    assert usual.claims["id"].to_list() == ["C15", "C29"] and set(clean.claims["id"]) == {"C1", "C2", "C3"}
    assert "C15" in usual._repr_html_() and experiments.load(usual.folder) == usual
    assert changed.figure().axes and clean.figure()._repr_png_()


def test_comparisons_pair_the_models_on_equal_trials(folder):
    run = experiments.load(folder / "changed")
    rows = run.comparisons.to_dicts()
    assert [(row["model"], row["against"], row["n"]) for row in rows] == [("dsnn", "dsn2017", 2)] * 2
    for row in rows:
        ours, theirs = (run.trials.filter(model=name, speed_cm_s=row["speed_cm_s"])["spikes"].mean()
                        for name in ("dsnn", "dsn2017"))  # fmt: skip
        assert row["mean_difference"] == pytest.approx(ours - theirs) and 0 < row["p"] <= row["p_holm"] <= 1
    alone = experiments.load(folder / "usual").comparisons
    assert alone.is_empty() and set(run.comparisons.columns) <= set(alone.columns)


def test_runs_are_listed_with_those_of_other_versions(folder, tmp_path, colias):
    table = experiments.runs(folder)
    rows = {Path(row["run"]).name: row for row in table.to_dicts()}
    assert sorted(rows) == ["alone", "changed", "clean", "usual"] and table["trouble"].is_null().all()
    assert (rows["changed"]["seed"], rows["changed"]["done"], rows["changed"]["failures"]) == (0, 4, 0)
    assert rows["usual"]["verdicts"] == "not judged: C15, C29" and rows["alone"]["models"] == "dsnn:n_con=4"
    assert datetime.datetime.now(datetime.UTC) - rows["usual"]["when"] < datetime.timedelta(hours=1)
    older = tmp_path / "older"
    older.mkdir()
    (older / "run.json").write_text(json.dumps({"kind": "trials", "versions": {"colias-sim": "0.1.0"}}))
    with pytest.raises(experiments.UsageError, match=r"colias-sim 0\.1"):
        experiments.load(older)
    assert "0.1" in experiments.runs(tmp_path)["trouble"][0]
    assert [part.name for part in experiments.load(folder).parts] == ["speed", "clean", "speed", "speed"]
    with pytest.raises(experiments.UsageError, match="its parts are: changed, clean, alone, usual"):
        _ = experiments.load(folder).trials


def test_comparing_two_runs(folder):
    parameters, results = experiments.compare(folder / "usual", experiments.load(folder / "changed"))
    assert parameters.rows() == [("models", '["dsnn"]', '["dsnn", "dsn2017", "emd"]'), ("dsnn.n_con", "8", "4")]
    assert results.select("speed_cm_s", "model", "n").rows() == [(20.0, "dsnn", 2), (30.0, "dsnn", 2)]
    for row in results.to_dicts():
        of_condition = {"model": "dsnn", "speed_cm_s": row["speed_cm_s"]}
        means = [experiments.load(folder / name).trials.filter(**of_condition)["spikes"].mean()
                 for name in ("usual", "changed")]  # fmt: skip
        assert (row["mean_first"], row["mean_second"]) == pytest.approx(means)
        assert row["mean_difference"] == pytest.approx(means[0] - means[1]) and row["p"] <= row["p_holm"] <= 1


def test_runs_without_equal_trials_have_no_tests(folder):
    parameters, results = experiments.compare(folder / "usual", folder / "part" / "alone")
    assert {"models", "seed", "dsnn.n_con"} == set(parameters["parameter"]) and results.is_empty()
    assert experiments.compare(folder / "usual", folder / "clean")[1].is_empty()
    same = experiments.compare(folder / "clean", folder / "clean")
    assert same[0].is_empty() and same[1].height == 12


WRONG = {
    "a file that is not there": lambda: experiments.run("no.py"),
    "only": lambda: experiments.run("speed", only=True),
    "a seed": lambda: experiments.run("speed", seed=-1),
    "a seed that no generator takes": lambda: experiments.run("speed", seed=10**30),
    "repeats": lambda: experiments.run("speed", repeats=0),
    "to load nothing": lambda: experiments.load("no"),
    "to list nothing": lambda: experiments.runs("no"),
    "episodes": lambda: experiments.score("fixation", episodes=0),
}


@pytest.mark.parametrize("what", WRONG)
def test_wrong_uses_are_one_line(what, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(experiments.UsageError) as refused:
        WRONG[what]()
    assert "\n" not in str(refused.value)
    assert list(tmp_path.iterdir()) == []
