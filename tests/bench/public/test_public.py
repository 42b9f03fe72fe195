"""`experiments` from Python: the same rows as the command line, in a script, a notebook and standard input."""

from __future__ import annotations

import ast
import dataclasses
import importlib
import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import polars as pl
import pytest

import experiments
from experiments.bench.report import style
from experiments.bench.store.files import drawn_from
from experiments.bench.store.kinds import CLIPS
from tests.conftest import Colias

PACKAGE = Path(experiments.__file__).parent
ENVIRONMENT = {**os.environ, "PYTHONPATH": str(PACKAGE.parent)}
QUICK = {"repeats": 2, "recordings": False, "quiet": True, "workers": 0}
FAST = {"experiment.speeds_cm_s": [20, 30]}


# --- what is public --------------------------------------------------------------------------------------------------


def test_a_bare_import_loads_nothing_heavy():
    code = "import sys; before = set(sys.modules); import experiments; print(sorted(set(sys.modules) - before))"
    done = subprocess.run(
        [sys.executable, "-c", code], env=ENVIRONMENT, capture_output=True, text=True, check=True, timeout=60
    )
    loaded = {name.partition(".")[0] for name in ast.literal_eval(done.stdout)}
    assert loaded <= {"experiments", *sys.stdlib_module_names}


def test_the_stub_says_what_is_there():
    stub = ast.parse((PACKAGE / "__init__.pyi").read_text())
    imports = [node for node in stub.body if isinstance(node, ast.ImportFrom)]
    names = {alias.name for node in imports for alias in node.names}
    assert names | {"NAMES", "OFFLINE"} == set(experiments.__all__)
    (listed,) = [node.value for node in stub.body if isinstance(node, ast.Assign)]
    assert sorted(ast.literal_eval(listed)) == sorted(experiments.__all__)
    for node in imports:
        module = importlib.import_module(f".{node.module}", "experiments")
        for alias in node.names:
            assert alias.name == alias.asname  # lazy_loader knows no alias
            assert getattr(experiments, alias.name) is getattr(module, alias.name)


def test_every_name_is_documented_and_listed():
    assert set(experiments.__all__) <= set(dir(experiments))
    for name in set(experiments.__all__) - {"NAMES", "OFFLINE", "Wheels", "__version__"}:
        assert len(getattr(experiments, name).__doc__.strip()) > 10, name
    with pytest.raises(AttributeError, match="No experiments attribute speeds"):
        _ = experiments.speeds


def test_declarations_import_the_public_names_alone():
    """They are what a person copies. (`behaviours` is a registry, `wiring` joins packages.)"""
    for path in PACKAGE.glob("*.py"):
        if path.stem in ("__init__", "behaviours", "wiring"):
            continue
        body = [node for node in ast.parse(path.read_text()).body if isinstance(node, ast.ImportFrom)]
        assert all(".bench" not in str(node.module) for node in body), path


# --- the same as the command line ------------------------------------------------------------------------------------

SCRIPT = """
with open("began.txt", "a") as file:
    file.write("once\\n")

from experiments import Clip, OfflineExperiment, run

CLIP = Clip("way", "plain", {"rows": 24, "columns": 32, "duration_s": 0.2})
EXPERIMENT = OfflineExperiment("mine", "mine", [CLIP], ["dsnn"], claims=("C2",), repeats=2)
made = run(EXPERIMENT, models=["emd"], settings={"dsnn.n_con": 6}, seed=3, workers=1, out="out", recordings=False)
print(made)
"""
OF_COLIAS = ("--model", "emd", "--set", "dsnn.n_con=6", "--seed", "3", "--no-recordings", "--quiet")


def rows_of(folder):
    return [{k: v for k, v in row.items() if k != "wall_s"} for row in experiments.load(folder).trials.to_dicts()]


@pytest.fixture(scope="module")
def by_command(tmp_path_factory):
    folder = tmp_path_factory.mktemp("command")
    (folder / "mine.py").write_text(SCRIPT.partition("made =")[0])
    assert Colias(folder)("run", "mine.py", *OF_COLIAS, "--out", "out").returncode == 0
    return [{k: v for k, v in row.items() if k != "code"} for row in rows_of(folder / "out")]


KERNEL = """
import sys, types
sys.modules["__main__"] = types.ModuleType("__main__")  # as a notebook's kernel has: of no file
exec(compile(open("cell.txt").read(), "<cell 1>", "exec"), sys.modules["__main__"].__dict__)
"""
WAYS = {"a plain script": ["mine.py"], "standard input": ["-"], "a notebook": ["-c", KERNEL]}


@pytest.mark.parametrize("way", WAYS)
def test_from_anywhere_the_same_rows(way, tmp_path, by_command):
    """Of a script without ``__main__`` guard, on worker processes."""
    for name in ("mine.py", "cell.txt"):
        (tmp_path / name).write_text(SCRIPT)
    done = subprocess.run(
        [sys.executable, *WAYS[way]], input=SCRIPT, cwd=tmp_path, env=ENVIRONMENT, capture_output=True, text=True,
        timeout=300,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("out: mine, seed 3; dsnn.n_con=6; ") and done.stdout.endswith("2 of 2 trials\n")
    assert "on 1 worker, into out" in done.stderr
    assert (tmp_path / "began.txt").read_text() == "once\n"
    assert [{k: v for k, v in row.items() if k != "code"} for row in rows_of(tmp_path / "out")] == by_command


@pytest.fixture(scope="module")
def speed(tmp_path_factory):
    folder = tmp_path_factory.mktemp("speed")
    usual = experiments.run("speed", settings=FAST, out=folder / "usual", **QUICK)
    changed = experiments.run(
        "speed", settings={**FAST, "dsnn.n_con": 6}, models="emd", out=folder / "changed", **QUICK
    )
    return usual, changed


@pytest.fixture(scope="module")
def clean(tmp_path_factory):
    return experiments.run("clean", out=tmp_path_factory.mktemp("clean") / "out", **{**QUICK, "repeats": 1})


# --- what a run is ---------------------------------------------------------------------------------------------------


def test_a_runs_tables(speed):
    usual, changed = speed
    assert (usual.name, usual.seed, usual.planned, usual.done, usual.models) == ("speed", 0, 4, 4, ["dsnn"])
    assert changed.models == ["dsnn", "emd"] and changed.changed == "dsnn.n_con=6, experiment.speeds_cm_s=20,30"
    for table in (usual.trials, usual.frames, usual.summary, usual.claims, usual.failures):
        assert isinstance(table, pl.DataFrame)
    assert usual.trials.height == 4 and usual.frames.height == sum(usual.trials["frames"].to_list())
    joined, speeds = usual.frames_with_conditions(), dict(usual.trials.select("trial", "speed_cm_s").iter_rows())
    assert joined.select(usual.frames.columns).equals(usual.frames)
    assert joined["speed_cm_s"].to_list() == [speeds[trial] for trial in usual.frames["trial"]]
    assert "dsnn.n_con" not in usual.trials.columns
    assert changed.trials["dsnn.n_con"].to_list() == [6, None] * 4
    row = next(row for row in usual.summary.to_dicts() if row["quantity"] == "spikes")
    spikes = [t["spikes"] for t in usual.trials.to_dicts() if t["speed_cm_s"] == row["speed_cm_s"]]
    assert row["n"] == 2 and row["mean"] == sum(spikes) / 2 and row["far_cm"] is None
    assert usual.claims.to_dicts()[0]["id"] == "C15" and usual.verdicts == "not judged: C15, C29"
    assert usual.failures.height == 0 and usual.recordings == []
    text = "speed, seed 0; experiment.speeds_cm_s=20,30; not judged: C15, C29; 4 of 4 trials"
    assert repr(usual) == f"<Run {usual.folder}: {text}>"
    assert "<td>C15</td>" in usual._repr_html_()
    assert experiments.load(usual.folder) == usual


def test_a_runs_figure_is_drawn_again(speed, clean, tmp_path):
    for run in (speed[1], clean):
        drawn = run.figure()
        copy = shutil.copytree(run.folder, tmp_path / run.kind.name)
        (copy / "figure.svg").unlink()
        style.save(drawn, copy / "figure", drawn_from([copy / "trials.parquet"]))
        assert (copy / "figure.svg").read_bytes() == (run.folder / "figure.svg").read_bytes()
        assert drawn._repr_png_().startswith(b"\x89PNG")


def test_comparisons_pair_the_models_on_equal_trials(speed, clean, tmp_path):
    run = experiments.run("speed", models=["dsn2017"], settings=FAST, out=tmp_path / "out", **QUICK)
    trials, rows = run.trials.to_dicts(), run.comparisons.to_dicts()
    assert [(row["model"], row["against"], row["n"]) for row in rows] == [("dsnn", "dsn2017", 2)] * 2
    for row in rows:
        spikes = {name: [trial["spikes"] for trial in trials
                         if (trial["model"], trial["speed_cm_s"]) == (name, row["speed_cm_s"])]
                  for name in ("dsnn", "dsn2017")}  # fmt: skip
        assert row["mean_difference"] == pytest.approx((sum(spikes["dsnn"]) - sum(spikes["dsn2017"])) / 2)
        assert 0 < row["p"] <= row["p_holm"] <= 1 and row["far_cm"] is None
    for other in speed:  # of one model, and of one that does not spike beside it
        assert other.comparisons.height == 0 and other.comparisons.schema == run.comparisons.schema
    with pytest.raises(experiments.UsageError, match="clips that models are shown has no comparisons"):
        clean.comparisons  # noqa: B018
    (run.folder / "comparisons.csv").write_text("a\nb,c\n")
    with pytest.raises(experiments.UsageError, match=r"comparisons.csv cannot be read"):
        experiments.load(run.folder).comparisons  # noqa: B018


def test_clips(clean):
    assert clean.kind is CLIPS and clean.done == clean.planned == 12
    row = clean.summary.to_dicts()[0]
    assert [row[name] for name in ("model", "clip", "quantity", "n")] == ["dsnn", "dark rightward", "spikes", 1]
    assert row["sd"] is None
    assert set(clean.claims["id"].to_list()) == {"C1", "C2", "C3"}


def test_going_on(speed, tmp_path):
    usual, _ = speed
    with pytest.raises(ValueError, match="repeats is 2 there and 3 now"):
        experiments.run("speed", settings=FAST, out=usual.folder, **{**QUICK, "repeats": 3})
    again = experiments.run("speed", settings=FAST, out=usual.folder, **QUICK)
    assert again.trials.equals(usual.trials)
    with pytest.raises(ValueError, match="seed is 0 there and 1 now"):
        experiments.run("speed", settings=FAST, out=usual.folder, seed=1, **QUICK)


def test_going_on_without_the_first_options_names_them(speed):
    _, changed = speed
    with pytest.raises(experiments.UsageError) as refused:
        experiments.run("speed", out=changed.folder, **{**QUICK, "repeats": None})
    message = str(refused.value)
    assert message == (
        f"{changed.folder}: --set experiment.speeds_cm_s is 20, 30 there and 2, 4, 6, 10 now; --repeats is 2 there and"
        " 10 now; --model is dsnn, emd there and dsnn now; 1 more differ: repeat the first command's options, or choose"
        " another --out"
    )
    with pytest.raises(experiments.UsageError, match=r"^[^;]* --set dsnn\.n_con is 6 there and 8 now: repeat the"):
        experiments.run("speed", settings=FAST, models="emd", out=changed.folder, **QUICK)
    with pytest.raises(
        experiments.UsageError, match=r'the experiment is "speed" there and "distance" now: choose another --out$'
    ):
        experiments.run("distance", out=changed.folder, **QUICK)


WRONG = {
    "an experiment": lambda: experiments.run("sped"),
    "a file that is not there": lambda: experiments.run("no.py"),
    "a model": lambda: experiments.run("speed", models=["dsn"]),
    "only": lambda: experiments.run("speed", only=True),
    "a key": lambda: experiments.run("speed", settings={"dsnn.ncon": 6}),
    "a value": lambda: experiments.run("speed", settings={"dsnn.n_con": -1}),
    "no value": lambda: experiments.run("speed", settings={"dsnn.n_con": None}),
    "an empty name": lambda: experiments.run(""),
    "true seconds": lambda: experiments.watch("no.mp4", seconds=True),
    "an env": lambda: experiments.score("fixation", env=3),
    "a seed": lambda: experiments.run("speed", seed=-1),
    "repeats": lambda: experiments.run("speed", repeats=0),
    "workers": lambda: experiments.run("speed", workers=1.5),
    "to load nothing": lambda: experiments.load("no"),
    "to list nothing": lambda: experiments.runs("no"),
    "to compare nothing": lambda: experiments.compare("no", "no"),
    "footage": lambda: experiments.watch("no.mp4"),
    "a size": lambda: experiments.watch("no.mp4", size=(3, 3)),
    "a size of text": lambda: experiments.watch("no.mp4", size="320x180"),
    "a camera without end": lambda: experiments.watch("0"),
    "a rate": lambda: experiments.watch("no.mp4", fps="real"),
    "a behaviour": lambda: experiments.score("hybird"),
    "a behaviour of another kind": lambda: experiments.score(3),
    "episodes": lambda: experiments.score("fixation", episodes=0),
    "an argument of no env": lambda: experiments.score("fixation", nope=3),
    "one of gymnasium's": lambda: experiments.score("fixation", max_episode_steps=3),
    "an env's argument": lambda: experiments.score("fixation", robots=99),
    "an env's model": lambda: experiments.score("fixation", model="nope"),
    "a sense": lambda: experiments.score("fixation", observation="state"),
    "no checks": lambda: experiments.decide([]),
    "no sequence": lambda: experiments.decide(None),
    "a single check": lambda: experiments.decide(experiments.Check("x", 1.0, 0.0)),
    "a number for a check": lambda: experiments.decide([1.0]),
    "bounds of a side": lambda: experiments.Check("x", 1.0, (0.0, 2.0)),
    "one end of a range": lambda: experiments.Check("x", 1.0, 0.0, "within"),
    "a side that there is not": lambda: experiments.Check("x", 1.0, 0.0, "more"),
    "to load a file that is no run": lambda: experiments.load(__file__),
}


@pytest.mark.parametrize("what", WRONG)
def test_wrong_uses_are_one_line(what, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(experiments.UsageError) as refused:
        WRONG[what]()
    assert "\n" not in str(refused.value)
    assert list(tmp_path.iterdir()) == []


def test_checks_may_come_one_by_one():
    """An iterator can be read only once; the verdict is that of the list."""
    checks = [experiments.Check("too few", 1.0, 2.0), experiments.Check("enough", 3.0, 2.0)]
    assert experiments.decide(iter(checks)) == experiments.decide(checks) == (False, "too few (needs above 2)")
    assert experiments.decide([experiments.Check("enough", np.float32(3.0), 2)])[0]


# --- footage, behaviours ---------------------------------------------------------------------------------------------


def test_watching_as_the_command_line_does(colias):
    film = ("stimulus", "plain", "--set", "plain.rows=90", "--set", "plain.columns=120", "--out", "film.avi")
    assert colias(*film).returncode == 0
    done = colias("watch", "film.avi", "--no-view", "--model", "emd", "--table", "seen.parquet")
    assert done.returncode == 0, done.stderr
    seen = experiments.watch(colias.folder / "film.avi", models=["emd"], quiet=True)
    assert seen.frames.equals(pl.read_parquet(colias.folder / "seen.parquet"))
    assert seen.motions.height > 0 and set(seen.motions["model"].to_list()) <= {"dsnn", "emd"}
    assert seen.motions["direction"][0] in done.stdout
    short = experiments.watch(str(colias.folder / "film.avi"), only=True, models="dsnn", seconds=0.5, quiet=True)
    assert 0.4 < short.seconds <= 0.5 and not short.notes and not short.troubles
    assert "intervals of motion in 0.5 s" in repr(short)
    failed = dataclasses.replace(short, troubles={"mine": "mine.py, line 3: SystemExit"})
    assert "mine failed: mine.py, line 3: SystemExit" in repr(failed)
