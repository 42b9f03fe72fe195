"""Runs of every earlier version are read, drawn, compared and exported; see tests/data/runs/README.md."""

import json
import re
import shutil
from pathlib import Path

import numpy as np
import pyarrow.csv
import pyarrow.parquet as pq
import pytest

import experiments
from experiments.bench.cli.main import command
from experiments.bench.judging import stored

ROOT = Path(__file__).parents[3]
RUNS = ROOT / "tests" / "data" / "runs"
VERSIONS = sorted(path.name for path in RUNS.iterdir() if path.is_dir())
KINDS = {"speed": "trials", "clean": "clips", "reproduce": "reproduction"}
WITH_TABLES = [f"{version}/{name}" for version in VERSIONS for name in ("speed", "clean")]
ALL = [f"{version}/{name}" for version in VERSIONS for name in KINDS]


def raw_claims(run):
    """The claims of a file as it is: a list until 0.1, in an object since."""
    content = json.loads((RUNS / run / "claims.json").read_text())
    return content if isinstance(content, list) else content["claims"]


def test_each_earlier_version_has_its_runs():
    released = re.findall(r"^## \[(\d\S*)\] - \d", (ROOT / "CHANGELOG.md").read_text(), re.MULTILINE)
    assert sorted(VERSIONS) == sorted(released[1:])
    for run in ALL:
        described = json.loads(next((RUNS / run).rglob("experiment.json")).read_text())
        if "versions" not in described:
            described = json.loads((RUNS / run / "design.json").read_text())
        assert described["versions"]["colias-sim"] == run.split("/")[0], "made by that version's own code"


@pytest.mark.parametrize("run", ALL)
def test_it_loads_with_its_kind_and_claims(run):
    loaded = experiments.load(RUNS / run)
    assert loaded.kind.name == KINDS[run.split("/")[1]]
    claims, raw = loaded.claims.to_pylist(), raw_claims(run)
    assert [claim["id"] for claim in claims] == [claim["id"] for claim in raw] and claims
    for claim, entry in zip(claims, raw, strict=True):
        outcome = entry.get("outcome", entry)
        assert claim["decided"] == outcome["decided"]
        assert (claim["outcome"] == "holds") == (outcome["verdict"] == "holds")


@pytest.mark.parametrize("version", VERSIONS)
def test_a_reproduction_keeps_in_how_many_replicates_a_claim_held(version):
    """Until 0.1 these were called seeds, and counted in fields of their own."""
    verdicts = stored.verdicts(json.loads((RUNS / version / "reproduce" / "claims.json").read_text()))
    judged = 0
    for verdict, entry in zip(verdicts, raw_claims(f"{version}/reproduce"), strict=True):
        held = entry["count"]["holds"] if "count" in entry else entry["seeds_holding"]
        if held is not None:
            assert verdict.count.holds == held
            judged += held
    assert judged > 10


@pytest.mark.parametrize("run", WITH_TABLES)
def test_its_tables_are_those_of_the_files_and_it_is_drawn(run, tmp_path):
    loaded = experiments.load(RUNS / run)
    for name in ("trials", "frames"):
        table = pq.read_table(RUNS / run / f"{name}.parquet")
        assert getattr(loaded, name).num_rows == table.num_rows > 0
    assert loaded.trials["spikes"].to_pylist() == pq.read_table(RUNS / run / "trials.parquet")["spikes"].to_pylist()
    figure = loaded.figure()
    lines = [line for axes in figure.axes for line in axes.lines if len(line.get_xdata()) > 20]
    peaks = [float(np.max(np.abs(np.asarray(line.get_ydata(), float)))) for line in lines]
    hs = np.abs(np.asarray(loaded.frames["hs"], float))
    assert peaks and max(peaks) == pytest.approx(float(np.nanmax(hs)), abs=1e-6), "the strongest answer is in a trace"


@pytest.mark.parametrize("run", WITH_TABLES)
@pytest.mark.parametrize("form", ["csv", "npz", "mat"])
def test_it_is_exported(run, form, tmp_path, capsys):
    assert command(["export", str(RUNS / run), "--to", form, "--out", str(tmp_path / "out")]) == 0
    spikes = pq.read_table(RUNS / run / "trials.parquet")["spikes"].to_pylist()
    path = tmp_path / "out" / f"trials.{form}"
    if form == "csv":
        assert pyarrow.csv.read_csv(path)["spikes"].to_pylist() == spikes
    elif form == "npz":
        with np.load(path) as content:
            assert content["spikes"].tolist() == spikes
    else:
        assert path.stat().st_size > 0


@pytest.mark.parametrize("version", VERSIONS)
def test_its_log_is_one_of_a_robot(version, tmp_path):
    log = tmp_path / "log"
    assert command(["export", str(RUNS / version / "speed"), "--to", "log", "--out", str(log)]) == 0
    assert pyarrow.csv.read_csv(log / "log.csv").num_rows > 100


@pytest.fixture(scope="module")
def todays(tmp_path_factory):
    """The same runs by today's code, and their folder."""
    folder = tmp_path_factory.mktemp("today")
    options = {"repeats": 1, "recordings": False, "workers": 0, "quiet": True}
    experiments.run("speed", out=folder / "speed", models=["dsn2017"], settings={"experiment.speeds_cm_s": "10,20"},
                    **options)  # fmt: skip
    experiments.run("clean", out=folder / "clean", **options)
    return folder


@pytest.mark.parametrize("run", WITH_TABLES)
def test_it_is_compared_with_todays_and_no_spike_has_changed(run, todays):
    """A change of structure changes no number: equal seeds give equal spikes since the first version."""
    comparison = experiments.compare(RUNS / run, todays / run.split("/")[1])
    assert comparison.note == "" and comparison.code
    results = comparison.results.to_pylist()
    assert sum(row["n"] for row in results) == experiments.load(RUNS / run).trials.num_rows
    assert {row["mean_difference"] for row in results} == {0.0}


def test_two_old_versions_are_compared_too(capsys):
    for name in ("speed", "clean"):
        results = experiments.compare(*(RUNS / version / name for version in VERSIONS[:2])).results
        assert results.num_rows > 0


@pytest.mark.parametrize("version", VERSIONS)
def test_a_run_of_another_version_is_not_gone_on_with(version, tmp_path, capsys):
    """Rows of two versions never stand in one table, and the old folder stays as it was."""
    folder = tmp_path / "speed"
    shutil.copytree(RUNS / version / "speed", folder)
    before = {path.name: path.read_bytes() for path in folder.iterdir()}
    with pytest.raises(experiments.UsageError, match="choose another"):
        experiments.run("speed", out=folder, repeats=1, models=["dsn2017"], recordings=False, workers=0, quiet=True,
                        settings={"experiment.speeds_cm_s": "10,20"})  # fmt: skip
    assert {name: (folder / name).read_bytes() for name in before} == before


def test_the_list_of_runs_has_them(tmp_path):
    listed = experiments.runs(RUNS).to_pylist()
    assert not [row["trouble"] for row in listed if row["trouble"]]
    assert sum(row["experiment"] == "speed" for row in listed) == len(VERSIONS)
