"""Stimuli as files: a lossless video, and a table of the truth about each of its frames beside it."""

from __future__ import annotations

import csv
from collections.abc import Callable, Generator
from contextlib import closing
from pathlib import Path
from typing import Any

import cv2

from dsnn.stimuli import ClipParams, Stimulus, StimulusFrame, Truth
from experiments.bench.run.errors import UsageError
from experiments.bench.run.files import replacing

COLUMNS = (
    "frame", "time_s", "motion", "left_px", "top_px", "width_px", "height_px", "velocity_x_px_s", "velocity_y_px_s",
    "background_x_px_s", "background_y_px_s", "time_to_contact_s",
)  # fmt: skip


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
    # OpenCV chooses the container by the name's end. The video is closed before the parts are removed: an open one
    # would be written to once more.
    with (
        replacing(video, ".avi") as part, replacing(table) as lines,
        lines.open("w", newline="") as file, closing(_encoded(clip, part)) as frames,
    ):  # fmt: skip
        writer = csv.writer(file)
        writer.writerow(COLUMNS)
        for index, frame in enumerate(frames):
            writer.writerow(_row(index, index / clip.fps, frame.truth))
            advance()
    return table


def refuse(*places: Path) -> None:
    """Raise `UsageError` if one of the files is there already."""
    for place in places:
        if place.exists():
            raise UsageError(f"{place} is there already: choose another name, or remove it")


def _encoded(clip: Stimulus[ClipParams], path: Path) -> Generator[StimulusFrame, None, None]:
    """Write each frame to the video at ``path``, and pass it on."""
    rows, columns = clip.shape
    fourcc = cv2.VideoWriter.fourcc(*"FFV1")
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
