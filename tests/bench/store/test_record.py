"""The one reader of runs: of every kind what it says of itself."""

import json

import polars as pl
import pytest

import colias_sim
import experiments
from experiments.bench.run.errors import UsageError
from experiments.bench.store.kinds import KINDS


def describe(folder, description):
    folder.mkdir(parents=True, exist_ok=True)
    made_by = {"versions": {"colias-sim": colias_sim.__version__}}
    (folder / "run.json").write_text(json.dumps({"seed": 0, "trials": 2, **made_by, **description}))
    return folder


@pytest.mark.parametrize("kind", KINDS)
def test_a_run_is_of_the_kind_that_it_says(kind, tmp_path):
    described = describe(tmp_path / "out", {"kind": kind, "experiment": "x"})
    assert experiments.load(described).kind is KINDS[kind]


def test_a_run_of_another_version_is_one_line_that_names_the_version(tmp_path):
    folder = describe(tmp_path / "out", {"experiment": "x", "versions": {"colias-sim": "0.1.0"}, "kind": "trials"})
    with pytest.raises(UsageError, match=r"^[^\n]*colias-sim 0\.1[^\n]*$"):
        experiments.load(folder)
    (row,) = experiments.runs(tmp_path).to_dicts()
    assert "0.1" in row["trouble"]


def test_a_folder_of_runs_is_a_whole_of_parts(tmp_path):
    for name in ("one", "two"):
        describe(tmp_path / name, {"kind": "trials", "experiment": "x"})
    run = experiments.load(tmp_path)
    assert [part.folder.name for part in run.parts] == ["one", "two"] and (run.done, run.planned) == (0, 4)


def test_footage_is_a_file(tmp_path):
    table = pl.DataFrame({"frame": [0, 1], "model": ["dsnn", "dsnn"], "hs": [0.0, 0.5]})
    table.write_csv(tmp_path / "seen.csv")
    run = experiments.load(tmp_path / "seen.csv")
    assert run.kind is KINDS["footage"] and run.frames.equals(table) and run.recordings == []
    with pytest.raises(UsageError, match="no table of trials there"):
        _ = run.trials
    (tmp_path / "seen.rrd").write_bytes(b"RRF2")
    assert experiments.load(tmp_path / "seen.rrd").recordings == [tmp_path / "seen.rrd"]
    assert experiments.load(tmp_path).recordings == [tmp_path / "seen.rrd"]
