"""The one reader of runs: of every kind what it says of itself, and of folders that say nothing what they hold."""

import json

import pyarrow as pa
import pyarrow.csv
import pytest

import experiments
from experiments.bench.cli import main
from experiments.bench.engine.errors import UsageError
from experiments.bench.store.kinds import KINDS
from experiments.bench.video.source import recording

OLDER = {
    "trials": {"experiment": {"name": "speed", "design": {}}},
    "measured": {"experiment": {"name": "speed"}, "measured": {"provenance": "measured"}},
    "clips": {"experiment": {"name": "clean", "clips": []}},
    "tuning": {"experiment": "tuning"},
    "episodes": {"experiment": "behave"},
    "map": {"experiment": "map"},
    "study": {"experiment": "sensitivity"},
}
"""Kind -> what an older version's description of such a run has, by which it is known."""
WHOLES = {"sweep.csv": "sweep", "leaderboard.csv": "leaderboard", "design.json": "reproduction", "notes.txt": "whole"}


def describe(folder, description):
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "experiment.json").write_text(json.dumps({"seed": 0, "trials": 2, **description}))
    return folder


@pytest.mark.parametrize("kind", KINDS)
def test_a_run_is_of_the_kind_that_it_says(kind, tmp_path):
    described = describe(tmp_path / "out", {"kind": kind, "experiment": "x"})
    assert experiments.load(described).kind is KINDS[kind]


@pytest.mark.parametrize("kind", OLDER)
def test_the_kind_of_an_older_folder_is_inferred(kind, tmp_path):
    run = experiments.load(describe(tmp_path / "out", OLDER[kind]))
    assert run.kind is KINDS[kind]
    (row,) = experiments.runs(tmp_path).to_pylist()
    assert row["trouble"] is None and (row["done"], row["planned"]) == (0, 2)


def test_the_episodes_of_a_training_are_told_from_others(tmp_path):
    folder = describe(tmp_path / "out", OLDER["episodes"])
    (folder / "learning.csv").write_text("steps,episodes,return\n")
    assert experiments.load(folder).kind is KINDS["training"]


@pytest.mark.parametrize("mark", WHOLES)
def test_a_whole_of_parts_that_says_nothing_of_itself(mark, tmp_path):
    for name in ("one", "two"):
        describe(tmp_path / "out" / name, OLDER["trials"])
    (tmp_path / "out" / mark).write_text("a,b\n1,2\n")
    run = experiments.load(tmp_path / "out")
    assert run.kind is KINDS[WHOLES[mark]]
    assert [part.folder.name for part in run.parts] == ["one", "two"] and (run.done, run.planned) == (0, 4)
    with pytest.raises(UsageError, match=r"^[^\n]*has no table of trials itself; its parts are: one, two$"):
        _ = run.trials


@pytest.mark.parametrize("kind", [3, "x", None, ["trials"]])
def test_a_kind_that_is_not_known_is_one_line(kind, tmp_path):
    folder = describe(tmp_path / "out", {**OLDER["trials"], "kind": kind})
    if kind is None:
        assert experiments.load(folder).kind is KINDS["trials"]
        return
    with pytest.raises(UsageError, match=r"^[^\n]*experiment\.json: kind .* is not known here; known are trials,"):
        experiments.load(folder)


@pytest.mark.parametrize("kind", sorted(KINDS.keys() - {"trials", "measured", "clips"}))
def test_what_makes_no_sense_of_a_kind_is_one_line(kind, tmp_path):
    folder = describe(tmp_path / "out", {"kind": kind, "experiment": "x"})
    run = experiments.load(folder)
    for ask in (run.figure, lambda: run.summary, lambda: main.command(["export", str(folder), "--to", "log", "--out",
                str(tmp_path / "log")]), lambda: recording(folder, None)):  # fmt: skip
        with pytest.raises(UsageError, match=rf"^{folder}: [^\n]+$"):
            ask()
    assert "nothing to pair: " in experiments.compare(folder, folder).note


def test_footage_is_a_file(tmp_path):
    table = pa.table({"frame": [0, 1], "model": ["dsnn", "dsnn"], "hs": [0.0, 0.5]})
    pa.csv.write_csv(table, tmp_path / "seen.csv")
    run = experiments.load(tmp_path / "seen.csv")
    assert run.kind is KINDS["footage"] and run.frames.equals(table) and run.recordings == []
    with pytest.raises(UsageError, match="no table of trials there"):
        _ = run.trials
    (tmp_path / "seen.rrd").write_bytes(b"RRF2")
    assert experiments.load(tmp_path / "seen.rrd").recordings == [tmp_path / "seen.rrd"]
    assert experiments.load(tmp_path).recordings == [tmp_path / "seen.rrd"]
