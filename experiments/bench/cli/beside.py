"""Two recordings of equal trials as one, side by side on one timeline: for ``colias view A B``."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import rerun as rr
import rerun.blueprint as rrb
from rerun.chunk import Chunk

from colias_sim.config import SceneConfig
from dsnn.model import CHANNELS
from experiments.bench.run.errors import UsageError
from experiments.bench.run.record import Content, Model, encoded, model_part, packed, page, views
from experiments.bench.run.recordings import CAMERA, chunks, recording, recordings_in
from experiments.bench.sources.conditions import CONDITION_COLUMNS

PROPERTIES = "__properties/"
EQUAL = {"trial": ("seed", *CONDITION_COLUMNS), "episode": ("reset seed", "env")}
"""Kind of a recording -> what is the same in equal ones; of a clip everything is."""


def side_by_side(first: Path, second: Path, trial: int | None) -> tuple[str, bytes]:
    """Put a trial of one run beside the equal trial of another.

    Parameters
    ----------
    first, second
        Folders of runs, or .rrd files.
    trial
        The number of the trial in the first; ``None`` for the first that was recorded.

    Returns
    -------
    str
        What it is, for people.
    bytes
        Of an .rrd file.

    Raises
    ------
    UsageError
        There is no recording, or none of the second is of the same seed and condition.
    """
    one = recording(first, trial)
    condition = conditions(one)
    if not condition:
        raise UsageError(f"view {one}: a recording that does not tell its seed and condition has no equal one")
    other = _equal(condition, one, second)
    names = _names(first, second)
    sides = dict(zip(names, (one, other), strict=True))
    columns: list[rrb.Vertical] = []
    moved: list[Chunk] = []
    for name, path in sides.items():
        below = rr.escape_entity_path_part(name)
        moved += _moved(path, below)
        rows = views(_content(path), f"/{below}", f"{name}: ")
        columns.append(rrb.Vertical(*(view for _, view in rows), row_shares=[share for share, _ in rows]))
    title = f"{names[0]} and {names[1]}, {one.stem}"
    return title, packed(moved, encoded(page([(1.0, rrb.Horizontal(*columns))])), title)


def conditions(path: Path) -> dict[str, Any]:
    """Return what has to be equal in equal trials, clips or episodes; empty where a recording does not tell."""
    told: dict[str, Any] = {}
    for entity, chunk in chunks(path, f"/{PROPERTIES}**"):
        kind = entity.removeprefix(PROPERTIES)
        columns = chunk.to_record_batch()
        values = {
            name.rpartition(":")[2]: value[0] if isinstance(value := columns.column(name)[0].as_py(), list) else value
            for name in columns.schema.names if not name.startswith("rerun.")
        }  # fmt: skip
        if kind == "stimulus":
            told |= {"kind": kind, **values}
        elif kind in EQUAL:
            told |= {"kind": kind, **{name: values[name] for name in EQUAL[kind] if name in values}}
    return told if "seed" in told or told.get("reset seed", "none") != "none" else {}


def _equal(condition: Mapping[str, Any], one: Path, second: Path) -> Path:
    """Find the recording of the second run that is of the same seed and condition, first under the same name."""
    paths = [second] if second.is_file() else sorted(recordings_in(second), key=lambda path: path.name != one.name)
    if not paths:
        raise UsageError(f"{second}: no such file, or no .rrd recordings in it")
    nearest: dict[str, Any] = {}
    for path in paths:
        there = conditions(path)
        if there == condition:
            return path
        nearest = nearest or there
    differing = next(
        (f"{name} is {condition.get(name)} and {nearest.get(name)}" for name in [*condition, *nearest]
         if condition.get(name) != nearest.get(name)), "it does not tell",
    )  # fmt: skip
    whose = f"{second} is not" if second.is_file() else f"no recording of {second} is"
    raise UsageError(f"view: {whose} of the same seed and condition as {one} ({differing})")


def _names(first: Path, second: Path) -> tuple[str, str]:
    names = tuple(path.resolve().stem if path.is_file() else path.resolve().name for path in (first, second))
    return (names[0], names[1]) if names[0] != names[1] else ("first", "second")


def _moved(path: Path, below: str) -> Iterator[Chunk]:
    """Yield a recording's chunks but its properties, below another path."""
    for entity, chunk in chunks(path):
        if not entity.startswith("__properties"):
            yield chunk.with_entity_path(f"/{below}/{entity}")


def _content(path: Path) -> Content:
    """Read what a recording has, as far as its layout needs it, without maps."""
    eyes: dict[str, None] = {}
    channels: dict[str, list[str]] = {}
    thresholds: dict[str, dict[str, float | None]] = {}
    world = above = False
    for entity, chunk in chunks(path):
        if camera := CAMERA.fullmatch(entity):
            eyes[camera[2] or ""] = None
        world, above = world or entity == "world", above or entity == "world/observer/wheels"
        part = model_part(entity)
        if part is None:
            continue
        label, name = part
        if name in CHANNELS:
            channels.setdefault(label, []).append(name)
        batch = chunk.to_record_batch()
        if name == "threshold" and "levels" in batch.schema.names:
            for owners, level in zip(*(batch[column][0].as_py() for column in ("channels", "levels")), strict=True):
                if level > 0:
                    thresholds.setdefault(label, {}).update(dict.fromkeys(owners.split(), level))
    models = [
        Model(label, tuple(sorted(set(names), key=CHANNELS.index)), tuple(thresholds.get(label, {}).items()))
        for label, names in channels.items()
    ]
    return Content(tuple(models), tuple(eyes), scene=SceneConfig() if world else None, above=above)
