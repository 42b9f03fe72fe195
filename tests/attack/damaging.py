"""How a run's folder is damaged: functions that make what does it to a `Scene`."""

from __future__ import annotations

import fcntl
import json
import os
import shutil
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

Row = dict[str, Any]


@dataclass(frozen=True, slots=True)
class Scene:
    """A run's folder to damage, and the folder of the same run at another seed."""

    out: Path
    other: Path
    stack: ExitStack
    """Closed when the command has ended: for what is to be held until then."""


@dataclass(frozen=True, slots=True)
class Damage:
    """One damage, done by ``apply`` to the folder of a run of the kind ``kind``."""

    name: str
    kind: str
    apply: Callable[[Scene], object]
    must_refuse: bool = False
    """Going on as if nothing were would be wrong."""


TABLES = ("trials.parquet", "frames.parquet")
BRACKETS = "[" * 100_000


# Of bytes.


def cut(name: str, at: float) -> Callable[[Scene], object]:
    """Keep the first ``at`` bytes, or that share, or all but the last ``-at``."""

    def apply(scene: Scene) -> None:
        path = scene.out / name
        data = path.read_bytes()
        path.write_bytes(data[: int(at * len(data)) if 0 < at < 1 else int(at)])

    return apply


def zeros(name: str) -> Callable[[Scene], object]:
    """As long, but nothing in it: what some file systems leave after a crash."""
    return lambda scene: (scene.out / name).write_bytes(bytes((scene.out / name).stat().st_size))


def zero_block(name: str, at: float) -> Callable[[Scene], object]:
    """Sixty-four bytes of nothing."""

    def apply(scene: Scene) -> None:
        path = scene.out / name
        data = bytearray(path.read_bytes())
        start = int(at * len(data))
        data[start : start + 64] = bytes(len(data[start : start + 64]))
        path.write_bytes(bytes(data))

    return apply


def flip(name: str, seed: int) -> Callable[[Scene], object]:
    """Some bits turned, where they are drawn by the seed."""

    def apply(scene: Scene) -> None:
        rng = np.random.default_rng([seed, len(name)])
        path = scene.out / name
        data = bytearray(path.read_bytes())
        for place in rng.integers(0, len(data), 1 + seed % 5):
            data[place] ^= 1 << int(rng.integers(8))
        path.write_bytes(bytes(data))

    return apply


def write(name: str, text: str | bytes) -> Callable[[Scene], object]:
    """Something else in its place."""
    return lambda scene: (scene.out / name).write_bytes(text.encode() if isinstance(text, str) else text)


# Of files and folders.


def remove(name: str) -> Callable[[Scene], object]:
    """It is gone."""
    return lambda scene: _gone(scene.out / name)


def _gone(path: Path) -> None:
    shutil.rmtree(path) if path.is_dir() and not path.is_symlink() else path.unlink(missing_ok=True)


def folder(name: str) -> Callable[[Scene], object]:
    """A folder has its name."""

    def apply(scene: Scene) -> None:
        _gone(scene.out / name)
        (scene.out / name).mkdir()

    return apply


def link(name: str, to: str) -> Callable[[Scene], object]:
    """A link has its name."""

    def apply(scene: Scene) -> None:
        _gone(scene.out / name)
        (scene.out / name).symlink_to(to)

    return apply


def swap(*names: str) -> Callable[[Scene], object]:
    """The files of the run at another seed."""

    def apply(scene: Scene) -> None:
        for name in names:
            shutil.copy(scene.other / name, scene.out / name)

    return apply


def pipe(name: str) -> Callable[[Scene], object]:
    """A pipe that nobody writes to has its name: opening it would wait for ever."""

    def apply(scene: Scene) -> None:
        _gone(scene.out / name)
        os.mkfifo(scene.out / name)

    return apply


def lock(scene: Scene) -> None:
    """Another process writes there."""
    file = scene.stack.enter_context((scene.out / ".lock").open("w"))
    fcntl.flock(file, fcntl.LOCK_EX)


# Of rows.


def rows(name: str, change: Callable[[list[Row]], list[Row]]) -> Callable[[Scene], object]:
    """The table with other rows, under the same schema."""

    def apply(scene: Scene) -> None:
        path = scene.out / name
        table = pq.read_table(path)
        pq.write_table(pa.Table.from_pylist(change(table.to_pylist()), table.schema), path)

    return apply


def both(change: Callable[[list[Row]], list[Row]]) -> Callable[[Scene], object]:
    """The same change of both tables."""

    def apply(scene: Scene) -> None:
        for name in TABLES:
            rows(name, change)(scene)

    return apply


def columns(name: str, change: Callable[[pa.Table], pa.Table]) -> Callable[[Scene], object]:
    """The table with other columns."""

    def apply(scene: Scene) -> None:
        pq.write_table(change(pq.read_table(scene.out / name)), scene.out / name)

    return apply


def set_in(index: int, **values: object) -> Callable[[list[Row]], list[Row]]:
    """One row with other values."""
    return lambda there: [{**row, **values} if i == index % len(there) else row for i, row in enumerate(there)]


def set_trial(number: object) -> Callable[[list[Row]], list[Row]]:
    """The last trial's rows under another number."""

    def change(there: list[Row]) -> list[Row]:
        last = there[-1]["trial"]
        return [{**row, "trial": number} if row["trial"] == last else row for row in there]

    return change


def without_last(there: list[Row]) -> list[Row]:
    """No last row."""
    return there[:-1]


def without_first_trial(there: list[Row]) -> list[Row]:
    """Nothing of trial 0."""
    return [row for row in there if row["trial"] != 0]


def doubled(there: list[Row]) -> list[Row]:
    """The first row twice."""
    return [there[0], *there]


def others_frames(there: list[Row]) -> list[Row]:
    """Trial 0 has the frames of trial 1 too."""
    return [row for row in there if row["trial"] != 0] + [{**row, "trial": 0} for row in there if row["trial"] == 1]


# Of JSON.


def described(**changes: object) -> Callable[[Scene], object]:
    """``experiment.json`` with other values."""

    def apply(scene: Scene) -> None:
        path = scene.out / "experiment.json"
        path.write_text(json.dumps({**json.loads(path.read_text()), **changes}))

    return apply


def failed(*entries: object) -> Callable[[Scene], object]:
    """``failures.json`` with these entries."""
    return write("failures.json", json.dumps(list(entries)))


def failure(**changes: object) -> Row:
    """An entry of ``failures.json``."""
    return {"trial": 0, "model": "emd", "condition": "a", "seed": 1, "attempts": 1, "reason": "odd"} | changes
