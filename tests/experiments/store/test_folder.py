"""The tables of a run: whatever a kill leaves is read, and joined in the end."""

import errno
import shutil

import polars as pl
import pytest

import experiments
from experiments.base.files import part
from experiments.store.folder import PARTS, RunFolder, _part, read_table

CLIP = (("rows", 40), ("columns", 60), ("width", 9), ("height", 20), ("speed", 240.0))
SMALL = experiments.OfflineExperiment("small", "small", (experiments.Clip("right", "plain", CLIP),), ("dsnn",))
QUICK = {"repeats": 4, "recordings": False, "quiet": True, "workers": 0}


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """A finished run of four clips; it is not written to."""
    return experiments.run(SMALL, out=tmp_path_factory.mktemp("whole") / "out", **QUICK).folder


@pytest.fixture
def folder(whole, tmp_path):
    shutil.copytree(whole, tmp_path / "out")
    return tmp_path / "out"


def cut(folder, trials):
    """Give trials of the joined tables their own files."""
    (folder / PARTS).mkdir(exist_ok=True)
    for name in ("frames", "trials"):
        table = pl.read_parquet(folder / f"{name}.parquet")
        for trial in trials:
            table.filter(trial=trial).write_ipc_stream(_part(folder, trial, name))


def keep(folder, trials):
    """Leave those trials alone in the joined tables; without any there are none."""
    for name in ("frames", "trials"):
        path = folder / f"{name}.parquet"
        table = pl.read_parquet(path).filter(pl.col("trial").is_in(trials))
        path.unlink()
        if trials:
            table.write_parquet(path)


def numbers(folder):
    return [read_table(folder, name).drop("wall_s", strict=False) for name in ("trials", "frames")]


@pytest.mark.parametrize("left", [[], [0], [1, 3], [0, 1, 2, 3]], ids=str)
def test_a_trial_s_own_files_and_the_joined_tables_are_read_alike(whole, folder, left):
    cut(folder, [1, 2, 3])
    keep(folder, left)
    there = {1, 2, 3, *left}
    assert experiments.load(folder).done == len(there)
    assert read_table(folder, "trials", ["spikes"]).columns == ["spikes"]
    experiments.run(SMALL, out=folder, **QUICK)
    assert not (folder / PARTS).exists()
    assert all(a.equals(b) for a, b in zip(numbers(folder), numbers(whole), strict=True))
    rows = pl.read_parquet(folder / "trials.parquet").to_dicts()
    old = {row["trial"]: row for row in pl.read_parquet(whole / "trials.parquet").to_dicts()}
    assert all(row == old[row["trial"]] for row in rows if row["trial"] in there), "what was there is not redone"


def test_a_full_disk_is_named_with_the_file_and_nothing_takes_its_name(tmp_path):
    files, rows = RunFolder(tmp_path, pl.Schema({"trial": int}), pl.Schema()), pl.DataFrame({"trial": [1]})
    (tmp_path / PARTS).mkdir()
    for path, write in {
        tmp_path / "t.parquet": lambda path: files.write_table(path, rows),
        tmp_path / "t.csv": lambda path: files.write_rows(path.name, rows.to_dicts()),
        tmp_path / "t.rrd": lambda path: files.write_bytes(path, b"1"),
        _part(tmp_path, 1, "trials"): lambda path: files._write_part(1, "trials", rows),
    }.items():
        part(path).symlink_to("/dev/full")
        with pytest.raises(OSError) as raised:
            write(path)
        assert (raised.value.errno, raised.value.filename) == (errno.ENOSPC, str(path))
        assert not path.exists() and not part(path).is_symlink()


@pytest.mark.parametrize("text", [b"", b"[]", b"{", b"{}", b"\xff\xfe", b'{"kind": "clips", "versions": 3}'])
def test_a_run_that_cannot_be_read_hides_no_other(folder, text):
    (folder.parent / "bad").mkdir()
    (folder.parent / "bad" / "run.json").write_bytes(text)
    listed = experiments.runs(folder.parent)
    assert listed.filter(pl.col("trouble").is_null())["run"].to_list() == [str(folder)]
    (trouble,) = listed["trouble"].drop_nulls()
    assert str(folder.parent / "bad") in trouble and "\n" not in trouble
