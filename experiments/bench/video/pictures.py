"""The pictures of a recording, read one after the other."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt
import pyarrow as pa
import rerun as rr

from experiments.bench.run.errors import UsageError
from experiments.bench.run.record import OFF, ON, STILL

Floats = npt.NDArray[np.float64]
Picture = npt.NDArray[np.uint8]
NOISE, FULL_CHANGE = 4.0, 40.0
"""Changes from one picture to the next, in grey levels: up to the first nothing is drawn, at the second full colour."""


def pictures(path: Path, entity: str) -> Iterator[tuple[float, Picture]]:
    """Read the pictures of an eye one after the other.

    Parameters
    ----------
    path
        The recording.
    entity
        The eye: where it is logged.

    Yields
    ------
    float
        Time in seconds.
    ndarray
        (R, C, 3) uint8, RGB.
    """
    shape: tuple[int, int] | None = None
    chunks = rr.chunk.RrdReader(str(path)).stream()
    late: list[pa.RecordBatch] = []
    for chunk in chunks:
        if str(chunk.entity_path).lstrip("/") != entity:
            continue
        batch = chunk.to_record_batch()
        if chunk.is_static:
            if "Image:format" in batch.schema.names:
                given = batch.column("Image:format")[0].as_py()[0]
                shape = int(given["height"]), int(given["width"])
            continue
        if "Image:buffer" in batch.schema.names and shape is None:
            late.append(batch)  # the format may be logged after what it is of
            continue
        yield from _decoded(batch, shape)
    for batch in late:
        yield from _decoded(batch, shape)


def changes(timed_pictures: Iterator[tuple[float, Picture]]) -> Iterator[tuple[float, Picture]]:
    """Turn pictures into what changed since the one before.

    Parameters
    ----------
    timed_pictures
        Time and picture, (R, C, 3) uint8, RGB.

    Yields
    ------
    float
        Time in seconds.
    ndarray
        (R, C, 3) uint8, RGB: `ON` where the picture became brighter, `OFF` where it became darker, as strong as it
        did; `STILL` where it stayed, but for the camera's noise.
    """
    before: npt.NDArray[np.int16] | None = None
    for time_s, picture in timed_pictures:
        grey = picture.mean(axis=-1).astype(np.int16)
        change = np.zeros_like(grey) if before is None else grey - before
        before = grey
        strength = np.clip((np.abs(change) - NOISE) / (FULL_CHANGE - NOISE), 0.0, 1.0)[..., None] ** 0.7
        colour = np.where(change[..., None] > 0, np.array(ON), np.array(OFF))
        yield time_s, np.rint(np.array(STILL) + strength * (colour - np.array(STILL))).astype(np.uint8)


def _decoded(batch: pa.RecordBatch, shape: tuple[int, int] | None) -> Iterator[tuple[float, Picture]]:
    encoded = "EncodedImage:blob" in batch.schema.names
    column = batch.column("EncodedImage:blob" if encoded else "Image:buffer")
    for row, time_s in enumerate(times_of(batch)):
        content = column[row].values.flatten().to_numpy(zero_copy_only=False).astype(np.uint8, copy=False)
        if encoded:
            yield float(time_s), _as_rgb(cv2.imdecode(content, cv2.IMREAD_COLOR), cv2.COLOR_BGR2RGB)
        elif shape is not None:
            yield float(time_s), _as_rgb(content.reshape(shape), cv2.COLOR_GRAY2RGB)


def _as_rgb(picture: Any, conversion: int) -> Picture:
    if picture is None:
        raise UsageError("video: a picture of the recording cannot be decoded")
    rgb: Any = cv2.cvtColor(picture, conversion)
    return np.asarray(rgb, np.uint8)


def times_of(batch: pa.RecordBatch) -> Floats:
    """Read the time of each row of a chunk in seconds, (N,): of the timeline that has durations, whatever its name."""
    for index, field in enumerate(batch.schema):
        if pa.types.is_duration(field.type):
            times: Floats = batch.column(index).cast(pa.int64()).to_numpy(zero_copy_only=False) / 1e9
            return times
    raise ValueError("a part of it has no time")
