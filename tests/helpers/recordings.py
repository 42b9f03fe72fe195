"""Reading a recording back, by Rerun's public reader."""

from pathlib import Path
from typing import Any

from rerun.chunk import RrdReader


def columns(path: Path, static: bool | None = None) -> dict[str, dict[str, list[Any]]]:
    """Entity -> column without its archetype -> values; of what is ``static``, of what is not, or of both."""
    entities: dict[str, dict[str, list[Any]]] = {}
    for chunk in RrdReader(path).stream().filter(is_static=static).to_chunks():
        batch = chunk.to_record_batch()
        held = entities.setdefault(str(chunk.entity_path), {})
        for name, values in zip(batch.schema.names, batch.columns, strict=True):
            values = values.cast("int64") if name == "time" else values
            held.setdefault(name.rpartition(":")[2], []).extend(values.to_pylist())
    return entities
