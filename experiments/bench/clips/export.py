"""Stimuli as files: a lossless video, and a table of the truth about each of its frames beside it."""

from __future__ import annotations

import csv
import errno
import os
from collections.abc import Callable, Generator
from contextlib import closing
from pathlib import Path
from typing import Any

import cv2

from dsnn.stimuli import ClipParams, Stimulus, StimulusFrame, Truth
from experiments.bench.run.errors import UsageError
from experiments.bench.store.places import replacing

COLUMNS = (
    "frame", "time_s", "motion", "left_px", "top_px", "width_px", "height_px", "velocity_x_px_s", "velocity_y_px_s",
    "background_x_px_s", "background_y_px_s", "time_to_contact_s",
)  # fmt: skip
PROBE_BYTES = 2**16


def write(clip: Stimulus[ClipParams], video: Path, advance: Callable[[], None]) -> Path:
    """Write ``clip`` to ``video`` (FFV1, grey, lossless) and its truth to a .csv file of the same name; return that.

    Both get their names only when whole. Raises `UsageError` if either is there already, ``video`` is no .avi
    file, rows or columns are odd in number, or the video cannot be written. ``advance`` is called once a frame.
    """
    table = video.with_suffix(".csv")
    refuse(video, table)
    if video.suffix != ".avi":
        raise UsageError(f"--out {video}: the file's name should end in .avi")
    rows, columns = clip.shape
    if rows % 2 or columns % 2:  # OpenCV would drop the odd one, and say nothing
        raise UsageError(f"--out {video}: legal in a video are even rows and columns, not {rows} and {columns}")
    video.parent.mkdir(parents=True, exist_ok=True)
    video.parent.mkdir(parents=True, exist_ok=True)
    # OpenCV chooses the container by the name's end.
    with replacing(video, ".avi") as part, replacing(table) as lines:
        # Closed before the parts are removed: an open video would be written to once more.
        with lines.open("w", newline="") as file, closing(_encoded(clip, part)) as frames:
            writer = csv.writer(file)
            writer.writerow(COLUMNS)
            for index, frame in enumerate(frames):
                writer.writerow(_row(index, index / clip.fps, frame.truth))
                advance()
        _check_whole(part)
    return table


def _check_whole(video: Path) -> None:
    """Raise ``OSError`` if a part of an .avi file is missing. OpenCV tells nobody that a disk is full.

    Such a file is a row of RIFF chunks, each with its length, which is known when its end has been written.
    """
    end, size = 0, video.stat().st_size
    with video.open("rb") as file:
        while end < size:
            file.seek(end)
            head = file.read(8)
            if head[:4] != b"RIFF" or len(head) < 8:
                break
            end += 8 + int.from_bytes(head[4:], "little")
    if end != size or not size:
        with video.open("ab") as file:  # a full disk refuses more, and says so
            file.write(bytes(PROBE_BYTES))
            file.flush()
            os.fsync(file.fileno())
        raise OSError(errno.EIO, "")


def refuse(*places: Path) -> None:
    """Raise `UsageError` if one of the files is there already."""
    for place in places:
        if place.exists():
            raise UsageError(f"{place} is there already: choose another name, or remove it")


def _encoded(clip: Stimulus[ClipParams], path: Path) -> Generator[StimulusFrame, None, None]:
    """Write each frame to the video at ``path``, and pass it on."""
    rows, columns = clip.shape
    fourcc = cv2.VideoWriter.fourcc(*"FFV1")
    # A warning for each frame that a full disk does not take: `_check_whole` says it in a line.
    cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_SILENT)
    writer = cv2.VideoWriter(str(path), cv2.CAP_FFMPEG, fourcc, clip.fps, (columns, rows), isColor=False)
    try:
        if not writer.isOpened():
            raise UsageError(f"{path.parent}: a video of {columns}x{rows} px cannot be written there (FFV1)")
        for frame in clip:
            writer.write(frame.luma)
            yield frame
    finally:
        writer.release()


def _row(index: int, time_s: float, truth: Truth) -> list[Any]:
    """A row of the table: times and lengths to a millionth; empty where there is no object or no contact."""
    box, velocity = truth.box, truth.velocity
    place = (box.left, box.top, box.width, box.height) if box else (None,) * 4
    numbers = (*place, *(velocity or (None, None)), *truth.background_velocity, truth.time_to_contact_s)
    return [index, f"{time_s:.6f}", truth.motion, *("" if n is None else f"{n:.6f}" for n in numbers)]
