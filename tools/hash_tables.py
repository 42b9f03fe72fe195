"""Run a small sample of every kind of run, and hash every column of every table that it leaves.

A change of structure changes no number: run this before and after, and compare.

    python -m tools.hash_tables before.json
    python -m tools.hash_tables after.json --against before.json     # exit status 1 where a column differs
    python -m tools.hash_tables after.json --reproduce               # with `reproduce --quick` too, some minutes more

The commands run in processes of their own, in the environment of this one, two worker processes each.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from pathlib import Path

import pyarrow as pa
import pyarrow.csv
import pyarrow.parquet as pq

SAMPLES: Mapping[str, tuple[str, ...]] = {
    "trials": ("run", "speed", "--repeats", "1", "--model", "dsnn", "--no-recordings"),
    "recession": ("run", "angular-recession", "--repeats", "1", "--seed", "3", "--no-recordings"),
    "clips": ("run", "clean", "--no-recordings"),
    "clutter": ("run", "clutter-translation", "--repeats", "1", "--seed", "5", "--no-recordings"),
    "spikes": (
        "map",
        "speed",
        "--measure",
        "spikes",
        "--over",
        "dsnn.n_con=4,8",
        "--over",
        "scene.light=0.7,1",
        "--repeats",
        "1",
    ),
    "tune": ("tune", "--curve", "size", "--curve", "direction"),
    "leaderboard": ("leaderboard", "--only", "--model", "dsnn", "--model", "hybrid", "--repeats", "1"),
    "behave": ("behave", "fixation", "--episodes", "2", "--no-recordings"),
}
STIMULUS = ("stimulus", "cluttered", "--set", "cluttered.columns=320", "--out", "film.avi")
WATCH = ("watch", "film.avi", "--no-view", "--model", "dsnn", "--model", "hybrid", "--table", "watch.parquet")
REPRODUCE = ("reproduce", "--quick")
BY_A_CLOCK = ("wall_s", "us_", "code")
"""Beginnings of columns that tell of the machine or of the source, not of the numbers."""


def main() -> int:
    """Run the samples, write the hashes, and say what differs."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("out", type=Path, help="where to write the hashes, a .json file")
    parser.add_argument("--against", type=Path, help="hashes to compare with")
    parser.add_argument("--reproduce", action="store_true", help="run `reproduce --quick` too")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="colias-tables-") as folder:
        hashes = sampled(Path(folder), {**SAMPLES, "reproduce": REPRODUCE} if given.reproduce else SAMPLES)
    given.out.write_text(json.dumps(hashes, indent=1) + "\n", encoding="utf-8")
    print(f"{len(hashes)} columns of tables hashed into {given.out}")
    return compared(json.loads(given.against.read_text(encoding="utf-8")), hashes) if given.against else 0


def sampled(folder: Path, samples: Mapping[str, tuple[str, ...]]) -> dict[str, str]:
    """Run the samples in ``folder``; "table: column" -> SHA-256 of its values."""
    for name, arguments in samples.items():
        colias(folder, *arguments, "--workers", "2", "--quiet", "--out", name)
    colias(folder, *STIMULUS)
    colias(folder, *WATCH)
    digests: dict[str, str] = {}
    for path in sorted([*folder.rglob("*.parquet"), *folder.rglob("*.csv")]):
        digests |= {f"{path.relative_to(folder)}: {name}": digest for name, digest in columns(path).items()}
    return digests


def colias(folder: Path, *arguments: str) -> None:
    """Run a command; a wrong exit status ends this."""
    print("colias", *arguments, file=sys.stderr)
    command = [sys.executable, "-m", "experiments.bench.cli", *arguments]
    subprocess.run(command, cwd=folder, check=True, stdout=subprocess.DEVNULL)


def columns(path: Path) -> dict[str, str]:
    """Column -> SHA-256 of its values, of a table in Parquet or CSV."""
    table: pa.Table = pq.read_table(path) if path.suffix == ".parquet" else pa.csv.read_csv(path)
    return {
        name: hashlib.sha256(json.dumps(table[name].to_pylist()).encode()).hexdigest()[:16]
        for name in table.column_names
        if not name.startswith(BY_A_CLOCK)
    }


def compared(before: Mapping[str, str], after: Mapping[str, str]) -> int:
    """Print every column that is new, gone or other; 1 if one is gone or other."""
    gone, new = sorted(before.keys() - after.keys()), sorted(after.keys() - before.keys())
    other = [name for name in before.keys() & after.keys() if before[name] != after[name]]
    for what, names in (("gone", gone), ("new", new), ("differs", sorted(other))):
        for name in names:
            print(f"{what:<8}{name}")
    print(f"{len(before.keys() & after.keys()) - len(other)} columns are the same")
    return int(bool(gone or other))


if __name__ == "__main__":
    sys.exit(main())
