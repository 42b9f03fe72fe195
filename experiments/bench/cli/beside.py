"""Two recordings of equal trials as one, side by side on one timeline: for ``colias view A B``."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import rerun as rr
import rerun.blueprint as rrb

from dsnn.model import CHANNELS
from experiments.bench.figures.series import CHANNELS_OF, THRESHOLD
from experiments.bench.recording import Model, lanes, page, recorded
from experiments.bench.robot.recording import arena_view
from experiments.bench.run.errors import UsageError
from experiments.bench.sources.conditions import CONDITION_COLUMNS
from experiments.bench.store.pictures import chunks
from experiments.bench.store.record import recordings_in
from experiments.bench.video.reading import model_of
from experiments.bench.video.source import recording

PROPERTIES = "__properties/"
EQUAL = {"trial": ("seed", *CONDITION_COLUMNS), "episode": ("reset seed", "env")}
"""Kind of a recording -> what is the same in equal ones; of a clip everything is."""
PICTURES = ("EncodedImage:blob", "Image:buffer")


@dataclass(slots=True)
class _Contents:
    """Contents of a recording that decide its layout."""

    pictures: list[str] = field(default_factory=list)
    places: set[str] = field(default_factory=set)
    """First parts of the paths."""
    channels: dict[str, set[str]] = field(default_factory=dict)
    thresholds: dict[str, dict[str, float | None]] = field(default_factory=dict)

    def models(self) -> list[Model]:
        return [
            Model(model, tuple(sorted(channels, key=CHANNELS.index)), self.thresholds.get(model, {}))
            for model, channels in self.channels.items()
        ]


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
    sides = {name: path for name, path in zip(names, (one, other), strict=True)}
    contents = {name: _contents(path) for name, path in sides.items()}

    def write(stream: rr.RecordingStream) -> None:
        for name, path in sides.items():
            stream.send_chunks(list(_moved(path, rr.escape_entity_path_part(name))))

    columns = [_column(name, held) for name, held in contents.items()]
    title = f"{names[0]} and {names[1]}, {one.stem}"
    return title, recorded(write, page(rrb.Horizontal(*columns), shares=[1]), title)


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


def _moved(path: Path, below: str) -> Iterator[Any]:
    """Yield a recording's chunks but its properties, below another path."""
    for entity, chunk in chunks(path):
        if not entity.startswith("__properties"):
            yield chunk.with_entity_path(f"/{below}/{entity}")


def _contents(path: Path) -> _Contents:
    held = _Contents()
    for entity, chunk in chunks(path):
        place = entity.partition("/")[0]
        held.places.add(place)
        batch = chunk.to_record_batch()
        if place in ("potential", "azimuth"):
            channel = "azimuth" if place == "azimuth" else entity.rpartition("/")[2]
            held.channels.setdefault(model_of(entity), set()).add(channel)
        elif entity.startswith(THRESHOLD) and CHANNELS_OF in batch.schema.names:
            sign, _, size = entity.rpartition("/")[2].partition("_")
            if sign == "plus":
                of_model = held.thresholds.setdefault(model_of(entity), {})
                of_model |= dict.fromkeys(batch.column(CHANNELS_OF)[0].as_py(), float(size.replace("_", ".")))
        elif place != "maps" and entity not in held.pictures and any(name in PICTURES for name in batch.schema.names):
            held.pictures.append(entity)
    return held


def _column(name: str, held: _Contents) -> rrb.Container:
    """Return the views of one of both recordings."""
    root = f"/{rr.escape_entity_path_part(name)}"
    top: list[rrb.View] = [
        rrb.Spatial2DView(origin=f"{root}/{entity}", name=f"{name}: {entity.replace('_', ' ')}")
        for entity in held.pictures
    ]
    if "scene" in held.places:
        top.insert(0, arena_view(f"{root}/scene", f"{name}: arena"))
    if "arena" in held.places:
        top.append(rrb.Spatial2DView(origin=f"{root}/arena", name=f"{name}: arena from above (cm)"))
    views: list[rrb.View | rrb.Container] = [rrb.Horizontal(*top)] if top else []
    if models := held.models():
        views.append(lanes(models, name))
    return rrb.Vertical(*views, row_shares=[1] * len(views))
