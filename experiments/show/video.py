"""A video, a camera, a folder of pictures or a stimulus as a source: grey frames of one size, each with its time."""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext
from itertools import chain
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt
import polars as pl

from dsnn.files import USUAL_FPS, check_white
from dsnn.frames import frozen
from dsnn.pictures import NotAPicture, levels
from dsnn.video import FASTEST, Video, read_video
from experiments.base.errors import UsageError, as_usage_error
from experiments.settings.models import ConfiguredModel
from experiments.settings.pictures import OTHERS, entries, frame_numbers
from experiments.show.clips import ClipSource
from experiments.show.play import Sample
from experiments.store.tables import COUNTS, FRAME, JOB, PEAKS, RESPONSES, peaks

TICK_S = 0.0015
"""More than the clock of 1 ms that many containers have rounds an interval by."""


def mean_flow(before: npt.NDArray[np.uint8], now: npt.NDArray[np.uint8]) -> float:
    """Mean horizontal flow between two luma images (R, C), px per frame, rightward positive (Farneback 2003)."""
    flow = cv2.calcOpticalFlowFarneback(
        before, now, np.empty((*now.shape, 2), np.float32),
        pyr_scale=0.5, levels=3, winsize=15, iterations=3, poly_n=5, poly_sigma=1.2, flags=0,
    )  # fmt: skip
    return float(flow[..., 0].mean())


Image = npt.NDArray[np.uint8]
Reading = tuple[float, Image, Mapping[str, Any]]
"""Time of a frame in s since the first, its grey levels, and what is true of it."""

LONG_SIDE = 320
"""Longer side of what models see where no size is asked for: a 16:9 film becomes the paper's 320x180."""
SIZES_PX = range(8, 4097)
"""Widths and heights that models can be asked to see."""
VARIES = 0.10
"""Frame intervals vary if one is off the mean by this share, and by more than `TICK_S`."""
SAME_ASPECT = 1.05
"""Ratio of two aspects up to which they count as equal: whole pixels round small sizes."""
LOST = "{n} numbers are missing from the names of pictures and count as lost time, the first before {first}"
DAMAGED = "{n} pictures could not be decoded and are left out, the first is {first}"
RESIZED = "{n} frames have another size than the first, the first {first}; another aspect is seen distorted"
SLACK_FRAMES = 4.0
"""Frames by which a film may be shorter than its header says."""
NOTHING: Mapping[str, Any] = {}


TRIALS = pl.Schema(
    {
        **JOB, "source": str, "width": int, "height": int, "fps": float, **COUNTS,
        **PEAKS, "seconds": float, "frames": int, "wall_s": float,
    }
)  # fmt: skip
"""Columns of ``trials.parquet``: what was shown, as models saw it in px, and its own frames per second; of each model
its spikes and peaks, and the time of its last frame.
"""
FRAMES = pl.Schema({**FRAME, "time_s": float, "flow": float, **RESPONSES})
"""Columns of ``frames.parquet``; ``flow`` is the mean horizontal optical flow into the frame, px, or null."""


class VideoSource:
    """Frames of a video, a camera, a folder of pictures or a stimulus. It can be read once.

    Parameters
    ----------
    name
        A video file, the index of a camera from 0 up, a folder of pictures, or the name of the ``stimulus``.
    size
        (width, height) that models see, px; otherwise the source's own, of a video at most `LONG_SIDE`.
    seconds
        How much of it to show; otherwise all.
    flow
        Whether to compute optical flow between frames.
    stimulus
        A clip to show, in place of a file.

    Attributes
    ----------
    own_size
        (width, height) of the source as it is shown, px.
    rate, count
        Its frames per second, and number of frames, as it says itself; ``None`` where it does not.
    stopped
        Whether `stop` ended it.

    Raises
    ------
    UsageError
        There is nothing to read, or the size is not legal.
    """

    frame_columns = FRAMES

    def __init__(
        self, name: str, size: tuple[int, int] | None = None, seconds: float | None = None, *, flow: bool = False,
        stimulus: ClipSource | None = None,
    ) -> None:  # fmt: skip
        self.name, self.seconds, self.flow, self.stimulus = name, seconds, flow, stimulus
        self.is_camera = stimulus is None and name.isdecimal()
        self.film: Video | None = None
        self.rate: float | None = None
        self.count: int | None = None
        self.stopped = self._ended = False
        self._noted: dict[str, tuple[int, str]] = {}
        readings = self._open()
        first = next(readings, None)
        if first is None:
            raise UsageError(f"{name}: no frame could be read")
        self._readings = chain([first], readings)
        rows, columns = first[1].shape[:2]
        self.own_size = self.film.size if self.film else (columns, rows)
        self.size = size or (self.own_size if stimulus else usual_size(self.own_size))
        if any(side not in SIZES_PX for side in self.size) and size:
            raise UsageError(f"size must be WIDTHxHEIGHT, each between {SIZES_PX[0]} and {SIZES_PX[-1]} px, got {size}")
        self.fps, self.shape = self.rate or USUAL_FPS, self.size[::-1]

    def _open(self) -> Iterator[Reading]:
        """Begin to read, and set what the source says of itself."""
        path = Path(self.name)
        if self.stimulus is not None:
            self.rate, self.count = self.stimulus.fps, len(self.stimulus)
            return ((sample.time_s, sample.image, sample.truth) for sample in self.stimulus)
        if self.is_camera:
            cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_SILENT)  # the error says it
            capture = cv2.VideoCapture(int(self.name))
            if not capture.isOpened():
                raise UsageError(f"camera {self.name}: cannot be opened")
            rate = capture.get(cv2.CAP_PROP_FPS)
            self.rate = rate if 0.0 < rate <= FASTEST else None
            return _of_camera(capture)
        if path.is_dir():
            pictures, others = entries(path)
            self.count = len(pictures)
            if others:
                self._note(OTHERS, others[0], len(others))
            return _readable(self._of_folder(pictures))
        if not path.exists():
            raise UsageError(f"{self.name}: no such file, folder or stimulus (a camera is given by its index)")
        with as_usage_error():
            self.film = read_video(path)
        self.rate = self.film.fps
        self.count = round(self.film.length_s * self.rate) or None if self.rate else None
        return _readable((time_s, image, NOTHING) for time_s, image in self.film)

    def _of_folder(self, paths: Sequence[Path]) -> Iterator[Reading]:
        """Yield the pictures of a folder, `USUAL_FPS` numbers a second."""
        expected, is_checked = 0, False
        for index, (path, number) in enumerate(zip(paths, frame_numbers(paths), strict=False)):
            if number > expected:
                self._note(LOST, path.name, number - expected)
            expected = number + 1
            picture, share = _levels(path)
            if share and not is_checked:  # they are one camera's, and a scene may begin dark
                check_white(path, filter(None, (_levels(one)[1] for one in paths[index:])))
                is_checked = True
            if picture is None:
                self._note(DAMAGED, path.name)
            else:
                yield number / USUAL_FPS, picture, NOTHING

    def _note(self, text: str, first: str, count: int = 1) -> None:
        """Add to what is known of so many frames or files, of which the first is told."""
        before, told = self._noted.get(text, (0, first))
        self._noted[text] = before + count, told

    def open(self, seed: int) -> VideoSource:
        """Return itself, as the source of its only trial: neither a camera nor a stream can be opened twice."""
        return self

    def label(self) -> str:
        """Return what is shown, as messages name it."""
        return f"camera {self.name}" if self.is_camera else self.name

    def stop(self) -> None:
        """End after the present frame: at Ctrl-C, or when every model has failed."""
        self.stopped = True

    def __iter__(self) -> Iterator[Sample]:
        before: Image | None = None
        for time_s, image, truth in self._readings:
            if self.seconds is not None and time_s > self.seconds:
                return
            shown = self.film.size if self.film else image.shape[1::-1]
            if shown != self.own_size:
                self._note(RESIZED, "{}x{} at {:.2f} s".format(*shown, time_s))
            luma = resized(image, self.size)
            flow = mean_flow(before, luma) if self.flow and before is not None else None
            before = luma if self.flow else None
            yield Sample(time_s, luma, {**truth, "time_s": time_s, "flow": flow})
            if self.stopped:
                return
        self._ended = True

    def absent(self) -> AbstractContextManager[None]:
        """Return nothing: of a film nobody knows what moves by itself."""
        return nullcontext()

    def columns(self, _truth: pl.DataFrame) -> dict[str, Any]:
        """Return what is shown, as columns of ``trials.parquet``."""
        return {"source": self.name, "width": self.size[0], "height": self.size[1], "fps": self.rate}

    def measures(self, model: ConfiguredModel, frames: pl.DataFrame) -> dict[str, float | None]:
        """Return peaks and troughs of a model's potentials, and the time of its last frame."""
        return {**peaks(frames), "seconds": float(frames["time_s"][-1])}

    def ended_early(self, frames: int, until_s: float) -> str:
        """Say why this is not all of the source, after so many frames and seconds; empty if it is, or was left."""
        if self._ended and self.is_camera:
            return f"camera {self.name} gave no more frames after {frames}"
        if self._ended and self.film and until_s + SLACK_FRAMES / self.fps < self.film.length_s:
            return f"ended early: {until_s:.1f} s of the {self.film.length_s:.1f} s that its header says were decoded"
        return ""

    def notes(self, time_s: npt.NDArray[np.float64]) -> list[str]:
        """Return what to know about the source as far as it was read, at these times (T,), a line each."""
        notes = [text.format(n=count, first=first) for text, (count, first) in self._noted.items()]
        ratio = self.own_size[0] * self.size[1] / (self.own_size[1] * self.size[0])
        if (stretch := max(ratio, 1 / ratio)) > SAME_ASPECT:
            shown, own = (f"{width}x{height}" for width, height in (self.size, self.own_size))
            notes.append(f"{shown} is not the aspect of {own}: models see it distorted by {stretch - 1:.0%}")
        gaps, film = np.diff(time_s), self.film
        if film is None:
            return notes
        if len(gaps) > 1 and np.abs(gaps - gaps.mean()).max() > max(VARIES * gaps.mean(), TICK_S):
            low, high = gaps.min() * 1e3, gaps.max() * 1e3
            notes.append(f"frame intervals vary from {low:.0f} to {high:.0f} ms; models take one step a frame")
        if film.tracks > 1:
            shown = "{}x{}".format(*self.own_size)
            notes.append(
                f"one of its {film.tracks} films is shown, {shown}; take another by: ffmpeg -i FILE -map 0:v:1 B.mkv"
            )
        if film.damaged:
            notes.append(f"{film.damaged} frames could not be decoded and are left out")
        return notes


def _levels(path: Path) -> tuple[Image | None, float | None]:
    """Read a picture as `dsnn.pictures.levels` does; nothing of one that is damaged."""
    try:
        return levels(path)
    except NotAPicture:
        return None, None


def _of_camera(capture: cv2.VideoCapture) -> Iterator[Reading]:
    """Yield the frames of a camera, with the time of the clock since the first, until there are no more."""
    began_s: float | None = None
    try:
        while (read := capture.read())[0]:
            now_s = time.monotonic()
            began_s = now_s if began_s is None else began_s
            yield now_s - began_s, np.asarray(read[1], np.uint8), NOTHING
    finally:
        capture.release()


def _readable(readings: Iterator[Reading]) -> Iterator[Reading]:
    """Yield the frames of files; `UsageError` where one cannot be decoded."""
    with as_usage_error():
        yield from readings


def resized(image: Image, size: tuple[int, int]) -> Image:
    """Return the BT.601 luma of a BGR or grey image at ``size`` (width, height), by area averages; read-only.

    Luma comes before resizing: with a third of the bytes to average it takes two thirds of the time of the other order.
    """
    grey = cv2.cvtColor(image, cv2.COLOR_BGR2GRAY) if image.ndim == 3 else image
    return frozen(np.asarray(cv2.resize(grey, size, interpolation=cv2.INTER_AREA), np.uint8))


def usual_size(size: tuple[int, int]) -> tuple[int, int]:
    """Return the size (width, height) at which models see a video of ``size``: its aspect, never larger."""
    scale = min(1.0, LONG_SIDE / max(size))
    return max(round(size[0] * scale), 2), max(round(size[1] * scale), 2)
