"""More than a hundred ways in which a run's folder can be damaged before somebody goes on with it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pyarrow as pa

from tests.attack.damaging import (
    BRACKETS,
    TABLES,
    Damage,
    Scene,
    both,
    columns,
    cut,
    described,
    doubled,
    failed,
    failure,
    flip,
    folder,
    link,
    lock,
    others_frames,
    pipe,
    remove,
    rows,
    set_in,
    set_trial,
    swap,
    without_first_trial,
    without_last,
    write,
    zero_block,
    zeros,
)


def _of_bytes(kind: str) -> Iterator[Damage]:
    for name in TABLES:
        for at in (0, 4, 0.5, -1):
            yield Damage(f"{name}-cut-at-{at}", kind, cut(name, at))
        yield Damage(f"{name}-zeros", kind, zeros(name))
        for at in (0.1, 0.7):
            yield Damage(f"{name}-zeros-from-{at}", kind, zero_block(name, at))
        yield Damage(f"{name}-text", kind, write(name, "trial,model\n0,dsnn\n"))


def _of_flips(kind: str, seeds: range) -> Iterator[Damage]:
    for name in TABLES:
        for seed in seeds:
            yield Damage(f"{name}-flipped-{seed}", kind, flip(name, seed))


def _of_files(kind: str) -> Iterator[Damage]:
    for name in (*TABLES, "experiment.json", "failures.json", ".lock"):
        yield Damage(f"{name}-is-a-folder", kind, folder(name))
        yield Damage(f"{name}-dangles", kind, link(name, "nowhere/at/all"))
    for name in (*TABLES, "experiment.json"):
        yield Damage(f"{name}-gone", kind, remove(name), must_refuse=name == "experiment.json")
        yield Damage(f"{name}-links-to-itself", kind, link(name, name))
    yield Damage("trials.parquet-is-a-pipe", kind, pipe("trials.parquet"))
    yield Damage("trials.parquet-is-dev-null", kind, link("trials.parquet", "/dev/null"))
    for name in ("summary.csv", "claims.json", "figure.svg", "trials.parquet.part", "recordings/trial-0000.rrd"):
        yield Damage(f"{name}-is-a-folder", kind, folder(name))
    yield Damage("recording-gone", kind, remove("recordings/trial-0000.rrd"))
    yield Damage("recording-cut", kind, cut("recordings/trial-0001.rrd", 0.3))
    yield Damage(
        "recordings-is-a-file", kind, lambda scene: (remove("recordings")(scene), write("recordings", "x")(scene))
    )
    yield Damage("recordings-dangles", kind, link("recordings", "nowhere"))
    yield Damage("leftovers", kind, lambda scene: [write(f"{name}.part", b"PAR1 half")(scene) for name in TABLES])
    yield Damage("locked", kind, lock, must_refuse=True)
    for names in (("trials.parquet",), ("frames.parquet",), TABLES):
        yield Damage(f"{'-and-'.join(names)}-of-another-seed", kind, swap(*names))
    yield Damage("experiment.json-of-another-seed", kind, swap("experiment.json"), must_refuse=True)
    yield Damage("tables-exchanged", kind, lambda scene: _exchange(scene.out / TABLES[0], scene.out / TABLES[1]))


def _exchange(one: Path, other: Path) -> None:
    first, second = one.read_bytes(), other.read_bytes()
    one.write_bytes(second)
    other.write_bytes(first)


def _of_rows(kind: str) -> Iterator[Damage]:
    changes: dict[str, Callable[[Scene], object]] = {
        "row-twice": rows("trials.parquet", doubled),
        "all-rows-twice": both(lambda there: [*there, *there]),
        "row-gone": rows("trials.parquet", without_last),
        "rows-gone": rows("trials.parquet", lambda there: []),
        "trial-gone": rows("trials.parquet", without_first_trial),
        "trial-gone-from-both": both(without_first_trial),
        "frames-gone": rows("frames.parquet", without_first_trial),
        "all-frames-gone": rows("frames.parquet", lambda there: []),
        "frame-gone": rows("frames.parquet", lambda there: [*there[:5], *there[6:]]),
        "last-frame-gone": rows("frames.parquet", without_last),
        "frame-twice": rows("frames.parquet", doubled),
        "frames-of-another-trial": rows("frames.parquet", others_frames),
        "frames-backwards": rows("frames.parquet", lambda there: there[::-1]),
        "rows-backwards": rows("trials.parquet", lambda there: there[::-1]),
        "trial-999": rows("trials.parquet", set_trial(999)),
        "trial-999-in-both": both(set_trial(999)),
        "trial-minus-1": both(set_trial(-1)),
        "trial-null": rows("trials.parquet", set_in(-1, trial=None)),
        "frame-of-no-trial": rows("frames.parquet", set_in(-1, trial=None)),
        "another-seed": rows("trials.parquet", set_in(0, seed=12345)),
        "another-experiment": rows("trials.parquet", set_in(0, experiment="speed")),
        "another-repeat": rows("trials.parquet", set_in(0, repeat=7)),
        "another-model": rows("trials.parquet", set_in(0, model="flow")),
        "no-model": rows("trials.parquet", set_in(0, model=None)),
        "another-model-in-frames": rows("frames.parquet", set_in(0, model="flow")),
        "another-frame-number": rows("frames.parquet", set_in(3, frame=99)),
        "frames-say-another-number": rows("trials.parquet", set_in(0, frames=3)),
        "no-frames-number": rows("trials.parquet", set_in(0, frames=None)),
        "column-gone": columns("trials.parquet", lambda table: table.drop_columns(["repeat"])),
        "column-more": columns("trials.parquet", lambda table: table.append_column("x", pa.array(range(len(table))))),
        "column-of-text": columns(
            "trials.parquet", lambda t: t.set_column(1, "trial", pa.array([str(v) for v in t["trial"].to_pylist()]))
        ),
    }
    yield from (Damage(name, kind, change) for name, change in changes.items())


def _of_trials(kind: str) -> Iterator[Damage]:
    changes = {
        "another-condition": {"speed_cm_s": 3.0}, "no-condition": {"motion": None}, "spikes-null": {"spikes": None},
        "spikes-huge": {"spikes": 2**62}, "peak-nan": {"peak_hs": float("nan")},
    }  # fmt: skip
    # A speed that was not measured is none of these: a trial may be too short for it, and its claims then say so.
    for name, values in changes.items():
        yield Damage(name, kind, rows("trials.parquet", set_in(0, **values)))
    yield Damage("hs-null", kind, rows("frames.parquet", set_in(4, hs=None)))
    yield Damage("hs-nan", kind, rows("frames.parquet", set_in(4, hs=float("nan"))))


def _of_json(kind: str) -> Iterator[Damage]:
    texts: dict[str, str | bytes] = {
        "empty": "", "null": "null", "a-list": "[]", "a-number": "3", "brackets": BRACKETS, "nan": '{"seed": NaN}',
        "bytes": b"\xff\xfe\x00", "half": '{"experiment": {"name": "ti', "empty-object": "{}",
    }  # fmt: skip
    for name, text in texts.items():
        yield Damage(f"experiment.json-{name}", kind, write("experiment.json", text), must_refuse=True)
        if name != "a-list":
            yield Damage(f"failures.json-{name}", kind, write("failures.json", text))
    for name, change in {
        "seed": {"seed": 5},
        "trials": {"trials": 4000},
        "more": {"more": 1},
        "versions": {"versions": 3},
    }.items():
        yield Damage(f"experiment.json-other-{name}", kind, described(**change), must_refuse=True)
    wrong: dict[str, Any] = {
        "trial-text": failure(trial="x"), "trial-999": failure(trial=999), "trial-null": failure(trial=None),
        "trial-list": failure(trial=[0]), "model-unknown": failure(model="flow"), "model-number": failure(model=3),
        "reason-object": failure(reason={"a": [1]}), "extra": failure(more=1), "short": {"trial": 0},
        "number": 3, "none": None,
    }  # fmt: skip
    for name, entry in wrong.items():
        yield Damage(f"failures.json-{name}", kind, failed(entry))


def _few(kind: str) -> Iterator[Damage]:
    """What the kinds of run may differ in."""
    yield Damage("trials.parquet-cut", kind, cut("trials.parquet", 0.5))
    yield Damage("frame-gone", kind, rows("frames.parquet", lambda there: [*there[:5], *there[6:]]))
    yield Damage("row-twice", kind, rows("trials.parquet", doubled))
    yield Damage("trial-999", kind, both(set_trial(999)))
    yield Damage("trial-null", kind, rows("trials.parquet", set_in(-1, trial=None)))
    yield Damage("tables-of-another-seed", kind, swap(*TABLES))
    for name, text in {"null": "null", "brackets": BRACKETS}.items():
        yield Damage(f"experiment.json-{name}", kind, write("experiment.json", text), must_refuse=True)
    yield Damage("experiment.json-dangles", kind, link("experiment.json", "nowhere"), must_refuse=True)
    yield Damage("failures.json-number", kind, failed(3))
    yield Damage("locked", kind, lock, must_refuse=True)


DAMAGES = (
    *_of_bytes("robot"), *_of_files("robot"), *_of_rows("robot"), *_of_trials("robot"), *_of_json("robot"),
    *_of_flips("robot", range(8)), *_of_flips("clips", range(8, 16)),
    *_few("clips"), *_few("tune"), *_few("behave"),
)  # fmt: skip
