"""The tables of a run: whatever a kill leaves is read, and joined in the end."""

import itertools
import shutil
from pathlib import Path

import polars as pl
import pytest

import experiments
from experiments.bench.run.folder import PARTS, _part, read_table

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


def cut(folder, trials, change=lambda table: table):
    """Give trials of the joined tables their own files."""
    (folder / PARTS).mkdir(exist_ok=True)
    for name in ("frames", "trials"):
        table = pl.read_parquet(folder / f"{name}.parquet")
        for trial in trials:
            change(table.filter(trial=trial)).write_parquet(_part(folder, trial, name))


def keep(folder, trials):
    """Leave those trials alone in the joined tables; without any there are none."""
    for name in ("frames", "trials"):
        path = folder / f"{name}.parquet"
        table = pl.read_parquet(path).filter(pl.col("trial").is_in(trials))
        path.unlink()
        if trials:
            table.write_parquet(path)


def scaled(table):
    """Rows and frames as another computation of the trial would have them."""
    return table.with_columns(pl.col(name) * 2 for name in ("hs", "peak_hs", "trough_hs") if name in table.columns)


def without_times(table):
    return table.drop("wall_s", strict=False)


def numbers(folder):
    return [without_times(read_table(folder, name)) for name in ("trials", "frames")]


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


class Killed(BaseException):
    pass


def test_a_join_that_is_cut_short_at_any_step_changes_nothing(whole, tmp_path, monkeypatch):
    """Every file that it writes, renames or removes is a step; what is left is gone on with."""
    row_count = pl.read_parquet(whole / "trials.parquet").height
    for step in itertools.count():
        folder = tmp_path / f"{step}"
        shutil.copytree(whole, folder)
        cut(folder, [0, 2])
        cut(folder, [1], scaled)
        keep(folder, [1, 3])
        before = numbers(folder)
        left = iter(range(step))
        with monkeypatch.context() as patched:
            for name in ("replace", "unlink"):
                usual = getattr(Path, name)

                def counted(path, *arguments, usual=usual, left=left, **more):
                    if path.name.endswith(".part") and not arguments:
                        return usual(path, *arguments, **more)
                    if next(left, None) is None:
                        raise Killed
                    return usual(path, *arguments, **more)

                patched.setattr(Path, name, counted)
            try:
                experiments.run(SMALL, out=folder, **QUICK)
                done = True
            except Killed:
                done = False
        assert all(a.equals(b) for a, b in zip(numbers(folder), before, strict=True)), step
        if done:
            break
        experiments.run(SMALL, out=folder, **QUICK)
        assert not (folder / PARTS).exists()
        assert all(a.equals(b) for a, b in zip(numbers(folder), before, strict=True)), step
    assert step > 6 and row_count == 4
