"""``colias list runs`` and ``experiments.compare``: what there is, and how two runs differ."""

import datetime
import json
import os
import shutil

import pytest

import experiments
from experiments.bench.cli import main as cli_main
from experiments.bench.engine import terminal

QUICK = {"repeats": 3, "recordings": False, "quiet": True, "workers": 0}
FAST = {"experiment.speeds_cm_s": [20, 30]}


@pytest.fixture(scope="module")
def runs_folder(tmp_path_factory):
    """Three runs of the same trials: by defaults, under another light and gain, and half a run at another seed."""
    folder = tmp_path_factory.mktemp("runs")
    experiments.run("speed", settings=FAST, out=folder / "a", **QUICK)
    experiments.run("speed", settings={**FAST, "dsnn.n_con": 4}, models="emd", out=folder / "b", **QUICK)
    experiments.run(
        "speed", settings=FAST, models="dsnn:n_con=4", only=True, seed=1, out=folder / "part" / "c", **QUICK
    )
    return folder


def test_runs(runs_folder, colias):
    table = experiments.runs(runs_folder)
    rows = {row["run"].removeprefix(f"{runs_folder}/"): row for row in table.to_dicts()}
    assert sorted(rows) == ["a", "b", "part/c"]
    assert rows["a"]["changed"] == "experiment.speeds_cm_s=20,30" and rows["a"]["models"] == "dsnn"
    assert (rows["b"]["seed"], rows["b"]["done"], rows["b"]["planned"], rows["b"]["failures"]) == (0, 6, 6, 0)
    assert (
        rows["b"]["verdicts"] == "not judged: C15 (dsnn), C29 (dsnn), C15 (emd), C29 (emd)"
        and rows["b"]["experiment"] == "speed"
    )
    assert rows["part/c"]["models"] == "dsnn:n_con=4"
    assert rows["part/c"]["changed"] == "dsnn.n_con=4, experiment.speeds_cm_s=20,30"
    assert all(row["trouble"] is None for row in rows.values())
    done = colias("list", "runs", str(runs_folder))
    assert done.returncode == 0 and "part/c" in done.stdout and not done.stderr


def test_runs_tell_when_they_were_begun_and_by_what_commit(runs_folder, tmp_path, monkeypatch, capsys):
    """The time is the run's own, whatever becomes of its files."""
    began = datetime.datetime.now(datetime.UTC) - datetime.timedelta(minutes=30)
    shutil.copytree(runs_folder / "a", tmp_path / "copied")
    os.utime(tmp_path / "copied" / "run.json", (0, 0))
    text = json.loads((runs_folder / "a" / "run.json").read_text())
    (copied,) = experiments.runs(tmp_path).to_dicts()
    assert copied["when"] > began and copied["when"] == experiments.load(runs_folder / "a").begun
    assert copied["commit"] == experiments.load(runs_folder / "a").commit
    assert str(copied["commit"])[:12] == str(text["source"]["commit"])[:12]
    monkeypatch.setattr(terminal.out_console, "width", 200)
    assert cli_main.command(["list", "runs", str(tmp_path)]) == 0
    header, first = capsys.readouterr().out.splitlines()[:2]
    assert header.split() == ["run", "begun", "experiment", "seed", "trials", "models", "changed", "verdicts", "commit"]
    assert " speed " in first


def test_going_on_keeps_the_time(runs_folder, tmp_path):
    shutil.copytree(runs_folder / "a", tmp_path / "out")
    file = tmp_path / "out" / "run.json"
    text = json.loads(file.read_text())
    file.write_text(json.dumps({**text, "begun": "2001-01-01T00:00:00+00:00"}))
    run = experiments.run("speed", settings=FAST, out=tmp_path / "out", **QUICK)
    assert run.begun == datetime.datetime(2001, 1, 1, tzinfo=datetime.UTC)
    assert json.loads(file.read_text()) == {**text, "begun": "2001-01-01T00:00:00+00:00"}


def test_a_run_of_another_version_is_listed_with_the_version_that_reads_it(runs_folder, colias):
    shutil.copytree(runs_folder / "a", colias.folder / "runs" / "a")
    (colias.folder / "runs" / "older").mkdir()
    older = {"experiment": {}, "seed": 0, "trials": 3, "versions": {"colias-sim": "0.1.0"}}
    (colias.folder / "runs" / "older" / "run.json").write_text(json.dumps(older))
    done = colias("list", "runs")
    assert done.returncode == 0 and "\na " in done.stdout
    assert "colias-sim 0.1" in done.stderr and done.stderr.count("\n") == 1


def test_comparing_two_runs(runs_folder):
    comparison = experiments.compare(runs_folder / "a", experiments.load(runs_folder / "b"))
    differing = {row["parameter"]: (row["first"], row["second"]) for row in comparison.parameters.to_dicts()}
    assert differing == {"models": ('["dsnn"]', '["dsnn", "emd"]'), "dsnn.n_con": ("8", "4")}
    rows = comparison.results.to_dicts()
    assert [(row["speed_cm_s"], row["model"], row["against"], row["n"]) for row in rows] == [
        (20.0, "dsnn", "dsnn", 3), (30.0, "dsnn", "dsnn", 3),
    ]  # fmt: skip
    for row in rows:
        means = []
        for name in ("a", "b"):
            spikes = [r["spikes"] for r in experiments.load(runs_folder / name).trials.to_dicts()
                   if (r["speed_cm_s"], r["model"]) == (row["speed_cm_s"], "dsnn")]  # fmt: skip
            means.append(sum(spikes) / 3)
        assert (row["mean_first"], row["mean_second"]) == pytest.approx(means)
        assert row["mean_difference"] == pytest.approx(means[0] - means[1])
        assert row["p"] <= row["p_holm"] <= 1
    assert comparison.note == "" and comparison.code == ""
    assert (
        "2 parameters differ; 2 paired tests" in repr(comparison) and "<td>dsnn.n_con</td>" in comparison._repr_html_()
    )
    assert "dsnn.n_con" in str(comparison) and "rank_biserial" in str(comparison)


def test_one_model_each_under_other_labels(runs_folder):
    comparison = experiments.compare(runs_folder / "a", runs_folder / "part" / "c")
    differing = {row["parameter"]: (row["first"], row["second"]) for row in comparison.parameters.to_dicts()}
    assert differing == {"models": ('["dsnn"]', '["dsnn:n_con=4"]'), "seed": ("0", "1"), "dsnn.n_con": ("8", "4")}
    assert comparison.results.height == 0
    assert (
        comparison.note.startswith("nothing to pair: no trial of the one")
        and "the seeds are 0 and 1" in comparison.note
    )


def test_nothing_in_common(runs_folder, tmp_path):
    clips = experiments.run("clean", out=tmp_path / "clips", **{**QUICK, "repeats": 1})
    comparison = experiments.compare(runs_folder / "a", clips)
    assert (
        "nothing to pair: " in comparison.note
        and "speed and clean" in comparison.note
        and comparison.results.height == 0
    )
    same = experiments.compare(clips, clips)
    assert same.results.height == 12 and same.parameters.height == 0


def test_the_version(colias):
    done = colias("--version")
    assert done.returncode == 0 and not done.stderr
    assert done.stdout.startswith(f"colias-sim {experiments.__version__}") and done.stdout.count("\n") == 1
