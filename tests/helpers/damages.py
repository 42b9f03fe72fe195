"""Ways to damage the folder of a run, whatever its kind, for tests and larger attacks.

A damage is done to ``folder``; ``other`` is the folder of the same run at another seed, of which parts may be put in.
Going on with a damaged folder must end in one of two ways: ``refused`` (exit 2, one line on stderr that has ``says``,
nothing in the folder touched), or ``mended`` (exit 0, the tables of an undamaged run). Never in a traceback, never in
a table of two runs.
"""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq

TRIALS, FRAMES, EXPERIMENT, FAILURES = "trials.parquet", "frames.parquet", "experiment.json", "failures.json"
Do = Callable[[Path, Path], None]
Rows = list[dict[str, Any]]


@dataclass(frozen=True)
class Damage:
    name: str
    do: Do
    ends: Literal["refused", "mended"]
    says: str = ""
    """What stderr has; with ``|`` between, the words of several commands."""

    def __str__(self) -> str:
        return self.name

    def is_told(self, message: str) -> bool:
        return any(words in message for words in self.says.split("|"))


def refused(name: str, do: Do, says: str) -> Damage:
    return Damage(name, do, "refused", says)


def mended(name: str, do: Do, says: str = "") -> Damage:
    return Damage(name, do, "mended", says)


# What is done to files.


def delete(name: str) -> Do:
    return lambda folder, other: (folder / name).unlink()


def truncate(name: str, share: float = 0.5) -> Do:
    def do(folder: Path, other: Path) -> None:
        data = (folder / name).read_bytes()
        (folder / name).write_bytes(data[: int(share * len(data))])

    return do


def write(name: str, text: str | bytes) -> Do:
    data = text.encode() if isinstance(text, str) else text
    return lambda folder, other: (folder / name).write_bytes(data) and None


def folder_instead(name: str) -> Do:
    def do(folder: Path, other: Path) -> None:
        (folder / name).unlink(missing_ok=True)
        (folder / name).mkdir()

    return do


def of_the_other(name: str) -> Do:
    return lambda folder, other: shutil.copy(other / name, folder / name) and None


# What is done to tables.


def change_table(name: str, change: Callable[[pa.Table, pa.Table], pa.Table]) -> Do:
    def do(folder: Path, other: Path) -> None:
        changed = change(pq.read_table(folder / name), pq.read_table(other / name))
        pq.write_table(changed, folder / name)

    return do


def change_rows(name: str, change: Callable[[Rows], Rows | None]) -> Do:
    """``change`` gets the rows, changes them in place or returns others."""

    def do(table: pa.Table, other: pa.Table) -> pa.Table:
        rows = table.to_pylist()
        given = change(rows)
        return pa.Table.from_pylist(rows if given is None else given, table.schema)

    return change_table(name, do)


def put(name: str, column: str, value: Any, row: int = 0) -> Do:
    """One value into one row; a function gets that which was there."""

    def change(rows: Rows) -> None:
        rows[row][column] = value(rows[row][column]) if callable(value) else value

    return change_rows(name, change)


def cast(name: str, column: str, kind: pa.DataType) -> Do:
    def change(table: pa.Table, other: pa.Table) -> pa.Table:
        return table.set_column(table.schema.get_field_index(column), column, table[column].cast(kind))

    return change_table(name, change)


def swap_peaks(rows: Rows) -> None:
    column = "peak_hs" if "peak_hs" in rows[0] else "reward"
    one, two = next((a, b) for a in rows for b in rows if a[column] != b[column])
    one[column], two[column] = two[column], one[column]


def of_trial(table: pa.Table, trial: int) -> pa.Table:
    return table.filter(pc.equal(table["trial"], trial))


def without_trial(table: pa.Table, trial: int) -> pa.Table:
    return table.filter(pc.not_equal(table["trial"], trial))


# What is done to JSON.


def change_json(name: str, change: Callable[[Any], Any]) -> Do:
    def do(folder: Path, other: Path) -> None:
        value = json.loads((folder / name).read_text())
        given = change(value)
        (folder / name).write_text(json.dumps(value if given is None else given))

    return do


def failure(**changes: Any) -> Do:
    """A failure that would be one of this run, but for the ``changes``; of a model that has a row."""

    def do(folder: Path, other: Path) -> None:
        (row, *_) = pq.read_table(folder / TRIALS).to_pylist()
        item = {name: row[name] for name in ("trial", "model", "seed")}
        item |= {"condition": "c", "attempts": 1, "reason": "r", **changes}
        (folder / FAILURES).write_text(json.dumps([item]))

    return do


BRACKETS = 100_000 * "[" + 100_000 * "]"
NESTED = 900 * "[" + 900 * "]"

TABLES = (
    mended("the trials' table deleted", delete(TRIALS)),
    mended("every row deleted", change_rows(TRIALS, lambda rows: [])),
    mended("a row of the trials deleted", change_rows(TRIALS, lambda rows: rows[1:])),
    mended("a trial's rows deleted", change_table(TRIALS, lambda table, other: without_trial(table, 1))),
    mended("rows in another order", change_rows(TRIALS, lambda rows: rows[::-1])),
    refused("the trials' table cut off", truncate(TRIALS), "trials.parquet cannot be read"),
    refused("the trials' table empty", truncate(TRIALS, 0), "trials.parquet cannot be read"),
    refused("the trials' table is a text", write(TRIALS, "trial,model\n0,dsnn\n"), "trials.parquet cannot be read"),
    refused("the trials' table is a folder", folder_instead(TRIALS), "trials.parquet cannot be read"),
    refused("the trials' table of another seed", of_the_other(TRIALS), "seed is"),
    refused(
        "a row of another seed added",
        change_table(TRIALS, lambda table, other: pa.concat_tables([without_trial(table, 1), of_trial(other, 1)])),
        "trial 1: seed is",
    ),
    refused("a row twice", change_rows(TRIALS, lambda rows: [*rows, rows[0]]), "trial 0: two rows of"),
    refused("trial 999", put(TRIALS, "trial", 999), "trial 999 is not in the plan"),
    refused("trial -1", put(TRIALS, "trial", -1), "trial -1 is not in the plan"),
    refused("trial null", put(TRIALS, "trial", None), "None is no trial's number"),
    refused("trial a fraction", cast(TRIALS, "trial", pa.float64()), "column 'trial' has double"),
    refused("trial a text", cast(TRIALS, "trial", pa.string()), "column 'trial' has string"),
    refused("a seed changed", put(TRIALS, "seed", lambda seed: seed + 1), "trial 0: seed is"),
    refused("a repeat changed", put(TRIALS, "repeat", 5), "trial 0: repeat is 5"),
    refused("an experiment's name changed", put(TRIALS, "experiment", "x"), "trial 0: experiment is 'x'"),
    refused("a model that is not in the run", put(TRIALS, "model", "x"), "model 'x' is not in the plan"),
    refused("a model null", put(TRIALS, "model", None), "model None is not in the plan"),
    refused("the frames of a trial counted wrong", put(TRIALS, "frames", 7), "its row in trials.parquet says 7"),
    refused("the frames of a trial null", put(TRIALS, "frames", None), "frames is None"),
    refused("a code unknown", put(TRIALS, "code", "x"), "code 'x' is none that experiment.json lists"),
    refused("a code null", put(TRIALS, "code", None), "code None is none that experiment.json lists"),
    refused("two trials' results swapped", change_rows(TRIALS, swap_peaks), "its row in trials.parquet says"),
    refused(
        "a column deleted", change_table(TRIALS, lambda table, other: table.drop_columns(["seed"])), "'seed' is missing"
    ),
    refused(
        "a column added",
        change_table(TRIALS, lambda table, other: table.append_column("x", table["trial"])),
        "'x' is unknown",
    ),
    refused(
        "a column twice",
        change_table(TRIALS, lambda table, other: table.append_column("seed", table["seed"])),
        "its columns are not those",
    ),
    refused("the frames deleted", delete(FRAMES), "frames.parquet cannot be read"),
    refused("the frames cut off", truncate(FRAMES), "frames.parquet cannot be read"),
    refused("the frames are a folder", folder_instead(FRAMES), "frames.parquet cannot be read"),
    refused("the frames are the trials", lambda folder, other: shutil.copy(folder / TRIALS, folder / FRAMES) and None,
            "its columns are not those"),
    refused("the frames of another seed", of_the_other(FRAMES), "frames.parquet: trial"),
    refused("a frame deleted", change_table(FRAMES, lambda table, other: table.slice(1)), "frames, its row in"),
    refused(
        "a frame twice",
        change_table(FRAMES, lambda table, other: pa.concat_tables([table, table.slice(0, 1)])),
        "frames, its row in",
    ),
    refused("a frame's number twice", put(FRAMES, "frame", 1), "not numbered from 0"),
    refused("a frame's number null", put(FRAMES, "frame", None), "a row without frame"),
    refused("a frame's trial null", put(FRAMES, "trial", None), "a row without trial"),
    refused("a frame's trial 999", put(FRAMES, "trial", 999), "trial 999 is not in the plan"),
    refused("a frame's model unknown", put(FRAMES, "model", "x"), "frames of 'x', which has no row"),
    refused(
        "a trial's frames deleted", change_table(FRAMES, lambda table, other: without_trial(table, 1)), "has 0 frames"
    ),
    refused(
        "a trial's frames of another seed",
        change_table(FRAMES, lambda table, other: pa.concat_tables([without_trial(table, 1), of_trial(other, 1)])),
        "frames.parquet: trial 1",
    ),
    mended("frames in another order", change_rows(FRAMES, lambda rows: rows[::-1])),
)  # fmt: skip

DESCRIPTIONS = (
    refused("the description deleted", delete(EXPERIMENT), "no readable experiment.json there|already holds a run"),
    refused("the description cut off", truncate(EXPERIMENT), "experiment.json cannot be read"),
    refused("the description empty", truncate(EXPERIMENT, 0), "experiment.json cannot be read"),
    refused("the description is a folder", folder_instead(EXPERIMENT), "no readable experiment.json there"),
    refused("the description is brackets", write(EXPERIMENT, BRACKETS), "experiment.json cannot be read"),
    refused("the description is a list", write(EXPERIMENT, "[]"), "holds a list, expected an object"),
    refused("the description is a number", write(EXPERIMENT, "3"), "holds a int, expected an object"),
    refused("the description is null", write(EXPERIMENT, "null"), "holds a NoneType, expected an object"),
    refused("the description is no text", write(EXPERIMENT, b"\xff\xfe\x00"), "experiment.json cannot be read"),
    refused("the description of another seed", of_the_other(EXPERIMENT), "seed is"),
    refused("the description without a parameter", change_json(EXPERIMENT, lambda it: it.pop("trials") and None),
            "trials is null there"),
    refused("the description with one more", change_json(EXPERIMENT, lambda it: {**it, "x": 1}), "x is 1 there"),
    refused("a parameter nested deeply", change_json(EXPERIMENT, lambda it: {**it, "trials": json.loads(NESTED)}),
            "trials is [["),
    refused("another source", change_json(EXPERIMENT, lambda it: it["source"].update(digest="0")), "--other-code"),
    refused("no source", change_json(EXPERIMENT, lambda it: {**it, "source": None}), "--other-code"),
    refused("the list of codes is a text", change_json(EXPERIMENT, lambda it: {**it, "resumed_with": "x"}),
            "resumed_with should be a list of objects"),
    refused("the list of codes has a number", change_json(EXPERIMENT, lambda it: {**it, "resumed_with": [1]}),
            "resumed_with should be a list of objects"),
    refused("another code", change_json(EXPERIMENT, lambda it: {**it, "code": "x"}), "none that experiment.json lists"),
    refused("no code", change_json(EXPERIMENT, lambda it: it.pop("code") and None), "none that experiment.json lists"),
)  # fmt: skip

FAILURE_LISTS = (
    refused("failures are brackets", write(FAILURES, BRACKETS), "failures.json cannot be read"),
    refused("failures are an object", write(FAILURES, "{}"), "holds a dict, expected a list"),
    refused("failures are numbers", write(FAILURES, "[1]"), "expected objects of trial"),
    refused("failures are no text", write(FAILURES, b"\xff\xfe"), "failures.json cannot be read"),
    refused("failures are a folder", folder_instead(FAILURES), "failures.json cannot be read"),
    refused("a failure of trial null", failure(trial=None), "expected objects of trial"),
    refused("a failure without a reason", failure(more=1), "expected objects of trial"),
    refused("a failure of trial 999", failure(trial=999), "trial 999 is not in the plan"),
    refused("a failure of another seed", failure(seed=12345), "seed is 12345"),
    refused("a failure of a model that is not in the run", failure(model="x"), "model 'x' is not in the plan"),
    refused("a failure of a model that has a row", failure(), "failed, but has a row"),
    mended("a failure of a whole trial that was done", failure(model="")),
)

RECORDING = "recordings/trial-0000.rrd"


def file_for_the_recordings(folder: Path, other: Path) -> None:
    shutil.rmtree(folder / "recordings")
    (folder / "recordings").write_text("x")


RECORDINGS = (
    mended("a recording deleted", delete(RECORDING), "done again"),
    mended("a recording cut off", truncate(RECORDING), "done again"),
    mended("a recording empty", truncate(RECORDING, 0), "done again"),
    mended("the recordings deleted", lambda folder, other: shutil.rmtree(folder / "recordings"), "done again"),
    refused("a recording is a folder", folder_instead(RECORDING), "recordings/trial-0000.rrd cannot be read"),
    refused("a recording of no trial", write("recordings/trial-0999.rrd", "x"), "trial-0999.rrd is of no trial"),
    refused("a file for the recordings", file_for_the_recordings, "recordings"),
)

LEFTOVERS = (
    mended("leftovers of a kill", lambda folder, other: [
        (folder / name).write_text("half") for name in
        (f"{TRIALS}.part", f"{EXPERIMENT}.1.part", "recordings/trial-0001.rrd.part")] and None),
    refused("the lock is a folder", folder_instead(".lock"), ".lock"),
)  # fmt: skip

DAMAGES: tuple[Damage, ...] = (*TABLES, *DESCRIPTIONS, *FAILURE_LISTS, *RECORDINGS, *LEFTOVERS)
