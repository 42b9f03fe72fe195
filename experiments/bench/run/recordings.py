"""Recordings read back: which a run has, their chunks, and the pictures in them."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from experiments.bench.run.errors import UsageError

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
        The number of a trial or episode; ``None`` for a file, and for the first one that a folder has.

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
    if trial is None:
        return found[0]
    numbers = {int("".join(filter(str.isdigit, path.stem)) or -1): path for path in found}
    if trial not in numbers:
        raise UsageError(f"--trial must be one of {', '.join(map(str, numbers))}, got {trial}")
    return numbers[trial]


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


def pictures(recording: Path) -> dict[str, Images]:
    """Read the frames of a recording.

    Parameters
    ----------
    recording
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
    sizes: dict[str, tuple[int, int]] = {}
    images: dict[str, list[tuple[int, Any]]] = {}
    for entity, chunk in chunks(recording):
        if (seen := CAMERA.fullmatch(entity)) is None:
            continue
        entity = seen[1]
        batch = chunk.to_record_batch()
        for name in batch.schema.names:
            if name == "Image:format":
                (form,) = batch[name][0].as_py()
                sizes[entity] = form["height"], form["width"]
            elif name in ("Image:buffer", "EncodedImage:blob"):
                numbers = batch["frame"].to_pylist()
                images.setdefault(entity, []).extend(
                    (number, row.values[0].values.to_numpy())
                    for number, row in zip(numbers, batch[name], strict=True) if row.is_valid
                )  # fmt: skip
    return {entity: _stacked(recording, numbered, sizes.get(entity)) for entity, numbered in sorted(images.items())}


def _stacked(recording: Path, numbered: list[tuple[int, Any]], size: tuple[int, int] | None) -> Images:
    pixels = [image for _, image in sorted(numbered, key=lambda pair: pair[0])]
    if size is None:
        decoded = [cv2.imdecode(image, cv2.IMREAD_GRAYSCALE) for image in pixels]
    else:
        decoded = [image.reshape(size) for image in pixels]
    whole = [np.asarray(image, np.uint8) for image in decoded if image is not None]
    if len(whole) < len(decoded):
        raise UsageError(f"{recording}: a picture in it cannot be decoded")
    return np.stack(whole)


def write_pictures(folder: Path, frames: Images, ending: str) -> None:
    """Write frames (T, R, C) as ``000000.png`` and so on into a new folder; ``ending`` is that of the files."""
    folder.mkdir(parents=True)
    for index, frame in enumerate(frames):
        done, encoded = cv2.imencode(ending, frame)
        assert done, f"OpenCV does not write {ending}"
        (folder / f"{index:06d}{ending}").write_bytes(encoded.tobytes())
