"""Footage, frame by frame: any file that OpenCV decodes, or a live camera. Knows no model and no recording."""

from __future__ import annotations

import math
import os
import queue
import threading
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

import cv2
import numpy as np
import numpy.typing as npt

from dsnn.frames import frozen
from experiments.bench.engine.errors import UsageError

LONG_SIDE = 320
"""Largest size of the frames a network gets where no size is asked for: a 16:9 film becomes the paper's 320x180."""

SIZES_PX = range(8, 4097)
"""Widths and heights that a network can be asked to see."""

VARIES, TICK_S = 0.10, 0.0015
"""Frame intervals vary if one is off the mean by this share, and by more than a container's 1 ms clock rounds."""

Image = npt.NDArray[np.uint8]
Item = TypeVar("Item")


@dataclass(frozen=True, slots=True)
class Picture:
    """One frame as a network takes it: BT.601 luma (R, C) at the network's size.

    ``time_s`` is the footage's own time: a file's time stamps, a camera's by the clock since its first frame.
    ``decode_s`` and ``resize_s`` are what decoding (or waiting for the camera), and luma with resizing, took.
    """

    frame: int
    time_s: float
    luma: Image
    decode_s: float
    resize_s: float


class Footage:
    """An open file, or the live camera of a whole-number index, whose first frame is decoded already.

    ``size`` is (width, height) in px, ``rate`` its own frames per second and ``announced`` its number of frames by
    the container, each None where it tells none. Raises `UsageError` if there is nothing to decode.
    """

    def __init__(self, source: str) -> None:
        self.source = source
        self.live = source.isdecimal()
        self._capture = _open(source, self.live)
        self._reading = threading.Lock()
        self._clock = _Clock(self.live)
        began = time.perf_counter()
        first = self._read()
        self._first_s = time.perf_counter() - began
        if first is None:
            raise UsageError(f"{source}: no frame could be decoded")
        self._image: Image | None = first
        self.size = (first.shape[1], first.shape[0])
        self.rate = _positive(self._capture.get(cv2.CAP_PROP_FPS), 1000.0)
        self._clock.start(self._capture, self.rate)
        count = _positive(self._capture.get(cv2.CAP_PROP_FRAME_COUNT), 1e9)
        self.announced = None if count is None or self.live else int(count)
        self._exhausted = False
        self._resized: list[str] = []

    def pictures(self, size: tuple[int, int]) -> Iterator[Picture]:
        """Yield every frame at ``size`` (width, height), once: what has been taken is gone.

        Luma comes before resizing: with a third of the bytes to average it takes two thirds of the time of the other
        order, and the two differ by rounding alone.
        """
        image, began, decode_s = self._image, time.perf_counter(), self._first_s
        while image is not None:
            decoded = time.perf_counter()
            luma = resized(image, size)
            ready = time.perf_counter()
            yield Picture(self._clock.frames - 1, self._clock.now_s, luma, decode_s, ready - decoded)
            before, began = image.shape, time.perf_counter()
            image = self._read()
            decode_s = time.perf_counter() - began
            if image is not None:
                self._clock.tick(self._capture)
                if image.shape != before:
                    self._resized.append(f"{image.shape[1]}x{image.shape[0]} from frame {self._clock.frames - 1} on")
        self._exhausted = True

    def ended_early(self) -> str:
        """Tell why this is not all of the footage, in words; empty if it is, or if reading was broken off.

        AVI and MP4 store their number of frames; elsewhere OpenCV estimates it from duration and rate, so there
        only an end before that duration counts.
        """
        if not self._exhausted:
            return ""
        if self.live:
            return f"camera {self.source} gave no more frames after {self._clock.frames}"
        if self.announced is None or self._clock.frames >= self.announced:
            return ""
        rate = self.rate or 1.0
        if not _stores_count(Path(self.source)) and self._clock.now_s + 3 / rate >= self.announced / rate:
            return ""
        return f"ended early: {self._clock.frames} of the {self.announced} frames its header announces were decoded"

    def notes(self) -> list[str]:
        """Return what to know about the footage as far as it was read, a line each."""
        notes = [f"the frame size changes: {change}" for change in self._resized]
        if not self.live and self._clock.varies():
            low, high = self._clock.shortest_s * 1e3, self._clock.longest_s * 1e3
            notes.append(f"frame intervals vary from {low:.0f} to {high:.0f} ms; the network steps once a frame")
        return notes

    def close(self) -> None:
        """Let go of the file or camera; a camera that hangs in another thread is left to the process's end."""
        if self._reading.acquire(timeout=0.5):
            self._capture.release()

    def _read(self) -> Image | None:
        try:
            with self._reading:
                ok, image = self._capture.read()
        except cv2.error:
            return None
        return np.asarray(image, np.uint8) if ok and image is not None and image.size else None


class _Clock:
    """Times of the frames, in seconds from the start, and bounds of their intervals."""

    def __init__(self, live: bool) -> None:
        self._live = live
        self.frames, self.now_s = 1, 0.0
        self.shortest_s, self.longest_s = math.inf, 0.0

    def start(self, capture: cv2.VideoCapture, rate: float | None) -> None:
        """Begin the times: the first frame has been read."""
        self._usual_s = 1.0 / (rate or 30.0)
        self._origin_s = self._told(capture)

    def tick(self, capture: cv2.VideoCapture) -> None:
        """Another frame has been read."""
        reported_s = self._told(capture) - self._origin_s
        # Raw streams carry no time stamps: then the rate has to do.
        now = reported_s if reported_s > self.now_s else self.now_s + self._usual_s
        self.shortest_s, self.longest_s = min(self.shortest_s, now - self.now_s), max(self.longest_s, now - self.now_s)
        self.frames, self.now_s = self.frames + 1, now

    def varies(self) -> bool:
        """Tell whether the intervals differ from their mean by more than `VARIES`."""
        if self.frames < 3:
            return False
        mean = self.now_s / (self.frames - 1)
        return max(mean - self.shortest_s, self.longest_s - mean) > max(VARIES * mean, TICK_S)

    def _told(self, capture: cv2.VideoCapture) -> float:
        return time.monotonic() if self._live else capture.get(cv2.CAP_PROP_POS_MSEC) / 1e3


def resized(image: Image, size: tuple[int, int]) -> Image:
    """BT.601 luma of a BGR or grey ``image`` at ``size`` (width, height), by area averages; read-only."""
    grey = cv2.cvtColor(image, cv2.COLOR_BGR2GRAY) if image.ndim == 3 else image
    return frozen(np.asarray(cv2.resize(grey, size, interpolation=cv2.INTER_AREA), np.uint8))


def usual_size(size: tuple[int, int]) -> tuple[int, int]:
    """Return the size (width, height) at which a network sees footage of ``size``: its aspect, long side `LONG_SIDE`.

    Smaller footage stays as it is.
    """
    scale = min(1.0, LONG_SIDE / max(size))
    return max(round(size[0] * scale), 2), max(round(size[1] * scale), 2)


AHEAD = 8
"""Items that `ahead` makes before they are asked for, at most."""


def ahead(items: Iterator[Item], stop: threading.Event) -> Iterator[Item]:
    """Yield the items, made up to `AHEAD` before they are asked for on a thread of their own, until ``stop`` is set.

    For cameras: one that hangs does not keep a user from stopping, and no frame is lost while another is worked on.
    For files it does not pay, FFmpeg decodes on threads already. What making an item raises is raised here.
    """
    queued: queue.Queue[tuple[Item | None, BaseException | None]] = queue.Queue(AHEAD)
    left = threading.Event()

    def put(item: Item | None, error: BaseException | None = None) -> bool:
        while not left.is_set():
            try:
                queued.put((item, error), timeout=0.1)
                return True
            except queue.Full:
                pass
        return False

    def make() -> None:
        try:
            for item in items:
                if not put(item):
                    return
            put(None)
        except BaseException as error:
            put(None, error)

    maker = threading.Thread(target=make, name="decoder", daemon=True)
    maker.start()
    try:
        while not stop.is_set():
            try:
                item, error = queued.get(timeout=0.1)
            except queue.Empty:
                continue
            if error is not None:
                raise error
            if item is None:
                return
            yield item
    finally:
        left.set()
        maker.join(timeout=0.5)


def _open(source: str, live: bool) -> cv2.VideoCapture:
    path = Path(source)
    if not live and not path.exists():
        raise UsageError(f"{source}: no such file (a camera is given by its index, from 0 up)")
    if not live and (path.is_dir() or path.stat().st_size == 0):
        raise UsageError(f"{source}: {'a folder' if path.is_dir() else 'the file is empty'}")
    # OpenCV and FFmpeg report to stderr what is told here in one line.
    os.environ.setdefault("OPENCV_FFMPEG_LOGLEVEL", "-8")
    cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_SILENT)
    try:
        # FFmpeg by name: OpenCV's own AVI reader, which comes next, cannot be kept from writing to stderr.
        capture = cv2.VideoCapture(int(source)) if live else cv2.VideoCapture(str(path), cv2.CAP_FFMPEG)
    except cv2.error as error:
        raise UsageError(f"{source}: {error.err}") from None
    if not capture.isOpened():
        raise UsageError(f"camera {source}: cannot be opened" if live else f"{source}: not a video OpenCV can decode")
    return capture


def _positive(value: float, limit: float) -> float | None:
    """Return what a container tells, if it can be true: absent values come as 0, -1, NaN or absurd."""
    return value if 0.0 < value <= limit else None


def _stores_count(path: Path) -> bool:
    with path.open("rb") as file:
        head = file.read(8)
    return head.startswith(b"RIFF") or head[4:] == b"ftyp"
