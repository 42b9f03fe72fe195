"""Two recordings as one, side by side on one timeline: for ``colias view A B``."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import rerun as rr
import rerun.blueprint as rrb
from rerun.chunk import Chunk

from colias_sim.config import SceneConfig
from dsnn.model import CHANNELS
from experiments.bench.run.record import Content, Model, encoded, model_part, packed, page, views
from experiments.bench.run.recordings import CAMERA, chunks, recording


def side_by_side(first: Path, second: Path, trial: int | None) -> tuple[str, bytes]:
    """Put a trial of one run beside that of the same number of another.

    Parameters
    ----------
    first, second
        Folders of runs, or .rrd files.
    trial
        The number of the trial; ``None`` for a file, and for the first that was recorded.

    Returns
    -------
    str
        What it is, for people.
    bytes
        Of an .rrd file.

    Raises
    ------
    UsageError
        There is no such recording.
    """
    one, other = recording(first, trial), recording(second, trial)
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
