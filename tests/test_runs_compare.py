"""``colias runs`` and ``colias compare``: what there is, and how two runs differ."""

import shutil

import pytest

import experiments

QUICK = {"repeats": 3, "recordings": False, "quiet": True, "workers": 0}
FAST = {"experiment.speeds_cm_s": [20, 30]}


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """Three runs of the same trials: by defaults, under another light and gain, and half a run at another seed."""
    folder = tmp_path_factory.mktemp("runs")
    experiments.run("speed", settings=FAST, out=folder / "a", **QUICK)
    experiments.run("speed", settings={**FAST, "dsnn.n_con": 4}, models="emd", out=folder / "b", **QUICK)
    experiments.run(
        "speed", settings=FAST, models="dsnn:n_con=4", only=True, seed=1, out=folder / "part" / "c", **QUICK
    )
    return folder


def test_runs(made, colias):
    table = experiments.runs(made)
    rows = {row["run"].removeprefix(f"{made}/"): row for row in table.to_pylist()}
    assert sorted(rows) == ["a", "b", "part/c"]
    assert rows["a"]["changed"] == "experiment.speeds_cm_s=20,30" and rows["a"]["models"] == "dsnn"
    assert (rows["b"]["seed"], rows["b"]["done"], rows["b"]["planned"], rows["b"]["failures"]) == (0, 6, 6, 0)
    assert rows["b"]["verdicts"] == "4 untested" and rows["b"]["experiment"] == "speed"
    assert rows["part/c"]["models"] == "dsnn:n_con=4"
    assert rows["part/c"]["changed"] == "dsnn.n_con=4, experiment.speeds_cm_s=20,30"
    assert all(row["trouble"] is None for row in rows.values())
    done = colias("runs", str(made))
    assert done.returncode == 0 and "part/c" in done.stdout and "dsnn.n_con=4" in done.stdout and not done.stderr


def test_damaged_folders_are_named_and_not_fatal(made, colias):
    folder = colias.folder / "runs"
    shutil.copytree(made / "a", folder / "a")
    shutil.copytree(made / "a", folder / "nothing said")
    (folder / "nothing said" / "experiment.json").unlink()
    for name, text in {"cut": "{", "list": "[]", "odd": '{"experiment": {}, "seed": 0, "trials": 3}'}.items():
        (folder / name).mkdir()
        (folder / name / "experiment.json").write_text(text)
    (folder / "empty").mkdir()
    done = colias("runs")
    assert done.returncode == 0 and done.stdout.splitlines()[1].startswith("a ")
    said = done.stderr.splitlines()
    assert len(said) == 4 and all(line.startswith("damaged: runs/") for line in said), said
    for name in ("cut", "list", "odd", "nothing said"):
        assert any(line.startswith(f"damaged: runs/{name}: ") for line in said)


def test_no_runs_at_all(colias):
    done = colias("runs")
    assert (done.returncode, done.stdout, done.stderr) == (2, "", "colias: runs: no such folder\n")
    (colias.folder / "runs").mkdir()
    done = colias("runs")
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "no runs in runs\n")


def test_comparing_two_runs(made, colias):
    found = experiments.compare(made / "a", experiments.load(made / "b"))
    differing = {row["parameter"]: (row["first"], row["second"]) for row in found.parameters.to_pylist()}
    assert differing == {"models": ('["dsnn"]', '["dsnn", "emd"]'), "dsnn.n_con": ("8", "4")}
    rows = found.results.to_pylist()
    assert [(row["speed_cm_s"], row["model"], row["against"], row["n"]) for row in rows] == [
        (20.0, "dsnn", "dsnn", 3), (30.0, "dsnn", "dsnn", 3),
    ]  # fmt: skip
    for row in rows:
        means = []
        for name in ("a", "b"):
            own = [r["spikes"] for r in experiments.load(made / name).trials.to_pylist()
                   if (r["speed_cm_s"], r["model"]) == (row["speed_cm_s"], "dsnn")]  # fmt: skip
            means.append(sum(own) / 3)
        assert (row["mean_first"], row["mean_second"]) == pytest.approx(means)
        assert row["mean_difference"] == pytest.approx(means[0] - means[1])
        assert row["p"] <= row["p_holm"] <= 1
    assert found.note == "" and found.code == ""
    assert "2 parameters differ; 2 paired tests" in repr(found) and "<td>dsnn.n_con</td>" in found._repr_html_()
    done = colias("compare", str(made / "a"), str(made / "b"))
    assert done.returncode == 0 and "dsnn.n_con" in done.stdout and "p after Holm" in done.stdout, done.stderr


def test_one_model_each_under_other_labels(made):
    found = experiments.compare(made / "a", made / "part" / "c")
    differing = {row["parameter"]: (row["first"], row["second"]) for row in found.parameters.to_pylist()}
    assert differing == {"models": ('["dsnn"]', '["dsnn:n_con=4"]'), "seed": ("0", "1"), "dsnn.n_con": ("8", "4")}
    assert found.results.num_rows == 0
    assert found.note.startswith("nothing to pair: no trial of the one") and "the seeds are 0 and 1" in found.note


def test_the_same_run_twice(made, colias):
    done = colias("compare", str(made / "a"), str(made / "a"))
    assert done.returncode == 0 and "no parameter differs" in done.stdout and "+0.0" in done.stdout


def test_nothing_in_common(made, colias, tmp_path):
    clips = experiments.run("clean", out=tmp_path / "clips", **{**QUICK, "repeats": 1})
    found = experiments.compare(made / "a", clips)
    assert "nothing to pair: " in found.note and "speed and clean" in found.note and found.results.num_rows == 0
    same = experiments.compare(clips, clips)
    assert same.results.num_rows == 12 and same.parameters.num_rows == 0
    done = colias("compare", str(made / "a"), str(clips.folder))
    assert done.returncode == 0 and "nothing to pair" in done.stderr
    done = colias("compare", str(made / "a"), "no")
    assert (done.returncode, done.stderr.count("\n")) == (2, 1)
    assert done.stderr.startswith("colias: no: no readable experiment.json there")


def test_the_version(colias):
    done = colias("--version")
    assert done.returncode == 0 and not done.stderr
    assert done.stdout.startswith(f"colias-sim {experiments.__version__}") and done.stdout.count("\n") == 1
