"""The parts of a run's tables: whatever a kill leaves is read, by the newest part of a trial, and joined in the end."""

import itertools
import shutil

import pyarrow.parquet as pq
import pytest

import experiments
from experiments.bench.store import tables

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


def cut(folder, part, trials, change=lambda table: table):
    """Write some trials of the whole tables as a part."""
    (folder / tables.PARTS).mkdir(exist_ok=True)
    for name in ("frames", "trials"):
        table = pq.read_table(folder / tables.file_name(name, None))
        part_rows = table.filter([trial in trials for trial in table["trial"].to_pylist()])
        pq.write_table(change(part_rows), folder / tables.file_name(name, part))


def keep(folder, trials):
    """Leave those trials alone in the whole tables; without any there are none."""
    for name in ("frames", "trials"):
        path = folder / tables.file_name(name, None)
        table = pq.read_table(path)
        path.unlink()
        if trials:
            pq.write_table(table.filter([trial in trials for trial in table["trial"].to_pylist()]), path)


def scaled(table):
    """Rows and frames as another computation of the trial would have them."""
    for name in ("hs", "peak_hs", "trough_hs"):
        if name in table.column_names:
            place = table.schema.get_field_index(name)
            values = [None if value is None else 2 * value for value in table[name].to_pylist()]
            table = table.set_column(place, table.schema.field(place), [values])
    return table


def without_times(table):
    return table.drop_columns([name for name in ("wall_s",) if name in table.column_names])


def numbers(folder):
    return [without_times(tables.read(folder, name)) for name in ("trials", "frames")]


@pytest.mark.parametrize("left", [(), (0,), (1, 3), (0, 1, 2, 3)], ids=str)
def test_parts_and_whole_are_read_alike_and_joined(whole, folder, left):
    """Parts in any order of trials, beside whole tables that have the others, some of them, or none."""
    cut(folder, 0, {3, 1})
    cut(folder, 7, {2})
    keep(folder, set(left))
    there = {1, 2, 3, *left}
    run = experiments.load(folder)
    assert run.done == len(there)
    if len(there) == 4:
        assert all(a.equals(b) for a, b in zip(numbers(folder), numbers(whole), strict=True))
    assert tables.read(folder, "trials", ["spikes"]).column_names == ["spikes"]
    experiments.run(SMALL, out=folder, **QUICK)
    assert not (folder / tables.PARTS).exists()
    assert all(a.equals(b) for a, b in zip(numbers(folder), numbers(whole), strict=True))
    rows = pq.read_table(folder / "trials.parquet").to_pylist()
    old = {row["trial"]: row for row in pq.read_table(whole / "trials.parquet").to_pylist()}
    assert all(row == old[row["trial"]] for row in rows if row["trial"] in there), "what was there is not redone"


def test_of_a_trial_the_newest_part_counts_with_its_frames(whole, folder):
    cut(folder, 0, {1, 2})
    cut(folder, 1, {2}, scaled)
    old, new = (numbers(place) for place in (whole, folder))
    for before, now in zip(old, new, strict=True):
        peaks = "peak_hs" if "peak_hs" in now.column_names else "hs"
        for a, b in zip(before.to_pylist(), now.to_pylist(), strict=True):
            assert b[peaks] == (2 * a[peaks] if a["trial"] == 2 else a[peaks])
    experiments.run(SMALL, out=folder, **QUICK)
    assert all(a.equals(b) for a, b in zip(numbers(folder), new, strict=True))


class Killed(BaseException):
    pass


def test_a_join_that_is_cut_short_at_any_step_changes_nothing(whole, tmp_path, monkeypatch):
    """Every file that it writes, renames or removes is a step; what is left is gone on with."""
    row_count = pq.read_table(whole / "trials.parquet").num_rows
    for step in itertools.count():
        folder = tmp_path / f"{step}"
        shutil.copytree(whole, folder)
        cut(folder, 0, {0, 1, 2})
        cut(folder, 1, {1}, scaled)
        keep(folder, {3})
        before = numbers(folder)
        left = iter(range(step))
        with monkeypatch.context() as patched:
            for name in ("replace", "unlink", "rmdir"):
                usual = getattr(tables.Path, name)

                def counted(path, *arguments, usual=usual, left=left, **more):
                    if path.name.endswith(".part") and not arguments:
                        return usual(path, *arguments, **more)
                    if next(left, None) is None:
                        raise Killed
                    return usual(path, *arguments, **more)

                patched.setattr(tables.Path, name, counted)
            try:
                experiments.run(SMALL, out=folder, **QUICK)
                done = True
            except Killed:
                done = False
        assert all(a.equals(b) for a, b in zip(numbers(folder), before, strict=True)), step
        if done:
            break
        experiments.run(SMALL, out=folder, **QUICK)
        assert not (folder / tables.PARTS).exists()
        assert all(a.equals(b) for a, b in zip(numbers(folder), before, strict=True)), step
    assert step > 6 and row_count == 4
