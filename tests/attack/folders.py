"""Small run folders of every kind, made once, and what going on with a damaged copy comes to."""

from __future__ import annotations

import hashlib
import shutil
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pyarrow.csv
import pyarrow.parquet as pq

from tests.attack.commands import CLIPS, EXPERIMENT
from tests.attack.damages import Damage, Scene
from tests.attack.judging import refusal, strict_json
from tests.attack.processes import Ended
from tests.helpers.inside import inside


@dataclass(frozen=True, slots=True)
class Kind:
    """A command that leaves a run's folder: its words without those that name the folder."""

    words: tuple[str, ...]


QUIETLY, MODELS = ("--workers", "0", "-q"), ("--model", "dsnn", "--model", "emd")
KINDS = {
    "robot": Kind(("run", "tiny.py", "--repeats", "2", *QUIETLY, *MODELS)),
    "clips": Kind(("run", "clips.py", "--repeats", "2", *QUIETLY, "--model", "dsnn")),
    "tune": Kind(("tune", "--curve", "size", *QUIETLY, *MODELS)),
    "behave": Kind(("behave", "straight", "--episodes", "2", "--no-baselines", *QUIETLY)),
}

DERIVED = ("summary.csv", "comparisons.csv", "claims.json", "scores.csv", "tuning.csv", "preferences.csv")


def make(folder: Path, kind: str) -> None:
    """Run the command twice: into ``out``, and into ``other`` at another seed."""
    (folder / "tiny.py").write_text(EXPERIMENT.format(repeats=1, speeds="(20, 25)"))
    (folder / "clips.py").write_text(CLIPS)
    for out, seed in (("out", "0"), ("other", "1")):
        done = inside(folder, [*KINDS[kind].words, "--seed", seed, "--out", out])
        assert (done.returncode, done.stderr) == (0, ""), done


def copied(source: Path, place: Path) -> Path:
    """Copy a folder with its runs, whose descriptions name the files of one's own that are in it by their paths."""
    shutil.copytree(source, place, symlinks=True)
    for path in place.glob("*/experiment.json"):
        path.write_text(path.read_text().replace(f"{source}/", f"{place}/"))
    return place


def go_on(folder: Path, kind: str) -> Ended:
    """The same command again on what it left."""
    done = inside(folder, [*KINDS[kind].words, "--out", "out"])
    return Ended(None if done.returncode < 0 else done.returncode, done.stdout, done.stderr, ())


def tables(out: Path) -> dict[str, Any]:
    """Every table, times on the wall left out."""
    contents: dict[str, Any] = {}
    for name in ("trials.parquet", "frames.parquet"):
        rows = pq.read_table(out / name).to_pylist()
        contents[name] = [{key: repr(value) for key, value in row.items() if key != "wall_s"} for row in rows]
    for name in DERIVED:
        path = out / name
        if path.exists():
            contents[name] = strict_json(path) if path.suffix == ".json" else pyarrow.csv.read_csv(path).to_pylist()
    contents["failures.json"] = strict_json(out / "failures.json") if (out / "failures.json").exists() else []
    return contents


def state(out: Path) -> dict[str, str]:
    """Every file's contents, what kind of thing it is; lock and leftovers aside."""
    states = {}
    for path in sorted(out.rglob("*")):
        if path.name == ".lock" or path.name.endswith(".part"):
            continue
        name = str(path.relative_to(out))
        if path.is_symlink():
            states[name] = f"link to {path.readlink()}"
        elif path.is_file():
            states[name] = hashlib.sha256(path.read_bytes()).hexdigest()
        else:
            states[name] = "folder" if path.is_dir() else "other"
    return states


def problems(damage: Damage, source: Path, place: Path, whole: dict[str, Any]) -> list[str]:
    """Damage a copy of the folder ``source``, go on with it, and say what is not as promised."""
    out = copied(source, place) / "out"
    with ExitStack() as stack:
        damage.apply(Scene(out, place / "other", stack))
        before = state(out)
        ended = go_on(place, damage.kind)
    if ended.status == 0 and not ended.crashes() and not damage.must_refuse:
        return [f"{damage.kind}, {damage.name}: {difference}" for difference in _differences(out, whole)]
    faults = refusal(ended)
    if ended.status == 0:
        faults = ["goes on as if nothing were"]
    elif ended.status is None:
        faults = ["does not end"]
    after = state(out)
    changed = sorted(name for name in {*before, *after} if before.get(name) != after.get(name))
    if changed and ended.status != 0:
        faults.append(f"changed {', '.join(changed)}")
    return [f"{damage.kind}, {damage.name}: {fault}" for fault in faults]


def _differences(out: Path, whole: dict[str, Any]) -> list[str]:
    try:
        there = tables(out)
    except Exception as error:  # whatever reading raises is the finding
        return [f"ends with 0, and its tables cannot be read: {type(error).__name__}: {str(error)[:150]}"]
    return [f"ends with 0, and {name} is another" for name in whole if there.get(name) != whole[name]]
