"""Recordings read back: which a run has, their chunks, and the pictures in them."""

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt
import polars as pl
import pyarrow as pa

from experiments.base.errors import UsageError, check_known
from experiments.base.files import read_parquet

Images = npt.NDArray[np.uint8]
CAMERA = re.compile(r"world/observer/(camera(?:_(\w+))?)/image")
"""Entity of what an eye saw; further eyes have a name of their own."""


def recordings_in(folder: Path) -> list[Path]:
    """Return the paths of the recordings in a folder, a run's or any other."""
    return sorted([*folder.glob("*.rrd"), *folder.glob("recordings/*.rrd")])


def recording(source: Path, trial: int | None) -> Path:
    """Find the recording that is meant.

    Parameters
    ----------
    source
        An .rrd file, or the folder of a run.
    trial
        The number of a trial or episode; ``None`` for a file, and for the first in a folder in which a model spikes.

    Raises
    ------
    UsageError
        If there is none, in one line.
    """
    if source.is_file() and trial is None:
        return source
    found = recordings_in(source)
    if not found:
        raise UsageError(f"{source}: no .rrd recordings in it; runs make them unless told --no-recordings")
    numbers = {int("".join(filter(str.isdigit, path.stem)) or -1): path for path in found}
    if trial is None:
        return next((numbers[trial] for trial in spiking(source) if trial in numbers), found[0])
    check_known("--trial", str(trial), list(map(str, numbers)))
    return numbers[trial]


def spiking(folder: Path) -> list[int]:
    """Return the trials of a run in which any model spikes, in their order; of none if its tables do not say so."""
    table = folder / "trials.parquet"
    rows = read_parquet(table) if table.is_file() else pl.DataFrame()
    return sorted(set(rows.filter(pl.col("spikes") > 0)["trial"])) if "spikes" in rows.columns else []


def chunks(path: Path, content: str = "") -> Iterator[tuple[str, Any]]:
    """Yield the chunks of a recording with their entities, all or those of ``content``.

    Raises `UsageError` where it cannot be read.
    """
    import rerun as rr  # not before: it takes its time to load

    try:
        stream = rr.chunk.RrdReader(path).stream()
        for chunk in stream.filter(content=content) if content else stream:  # "/**" would leave out the properties
            yield str(chunk.entity_path).strip("/"), chunk
    except (RuntimeError, ValueError) as error:  # as Rerun has it of a file that is not there, or no recording
        raise UsageError(f"{path}: no recording that can be read ({error})") from None


def times_of(batch: Any) -> npt.NDArray[np.float64]:
    """Return the time of each row of a chunk, s, (N,)."""
    times: npt.NDArray[np.float64] = batch["time"].cast(pa.int64()).to_numpy(zero_copy_only=False) / 1e9
    return times


def pictures_of(path: Path, entity: str) -> Iterator[tuple[float, Images]]:
    """Yield time in s and picture, (R, C) uint8, of a camera, one after the other: a recording may be long.

    Parameters
    ----------
    path
        An .rrd file of a trial, a clip, an episode or of footage.
    entity
        Entity of the camera's images: see `CAMERA`.

    Raises
    ------
    UsageError
        The file cannot be read, or holds pictures that cannot.
    """
    shape = (0, 0)
    for _, chunk in chunks(path, f"/{entity}"):
        batch = chunk.to_record_batch()
        if "Image:format" in batch.schema.names:
            (form,) = batch["Image:format"][0].as_py()
            shape = form["height"], form["width"]
        name = next((name for name in batch.schema.names if name in ("Image:buffer", "EncodedImage:blob")), None)
        for row, time_s in enumerate(times_of(batch)) if name else ():
            content = batch[name][row].values.flatten().to_numpy().astype(np.uint8, copy=False)
            picture = content.reshape(shape) if shape[0] else cv2.imdecode(content, cv2.IMREAD_GRAYSCALE)
            if picture is None:
                raise UsageError(f"{path}: a picture in it cannot be decoded")
            yield float(time_s), np.asarray(picture, np.uint8)


def pictures(path: Path) -> dict[str, Images]:
    """Read all frames of a recording.

    Parameters
    ----------
    path
        An .rrd file of a trial, a clip, an episode or of footage.

    Returns
    -------
    dict
        Camera (``camera``; of further eyes ``camera_ov7670``) -> its frames, (T, R, C) uint8, in order of time. Those
        of clips, episodes and footage went through JPEG. Empty where nothing was seen.

    Raises
    ------
    UsageError
        The file cannot be read, or holds pictures that cannot.
    """
    eyes = {entity: match[1] for entity, _ in chunks(path) if (match := CAMERA.fullmatch(entity))}
    return {eyes[entity]: np.stack([image for _, image in pictures_of(path, entity)]) for entity in sorted(eyes)}


def write_pictures(folder: Path, frames: npt.NDArray[np.uint8 | np.uint16], ending: str) -> None:
    """Write frames as ``000000.png`` and so on into a new folder.

    Parameters
    ----------
    folder
        The folder.
    frames
        (T, R, C), or (T, R, C, 3): blue, green and red.
    ending
        That of the files.
    """
    folder.mkdir(parents=True)
    for index, frame in enumerate(frames):
        done, encoded = cv2.imencode(ending, frame)
        assert done, f"OpenCV does not write {ending}"
        (folder / f"{index:06d}{ending}").write_bytes(encoded.tobytes())
