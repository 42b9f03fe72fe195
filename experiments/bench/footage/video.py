"""Footage, frame by frame: a video file, or a live camera. Knows no model and no recording."""

from __future__ import annotations

import math
import queue
import threading
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

import cv2
import numpy as np

from dsnn.frames import frozen
from experiments.bench.footage.film import Film, Image
from experiments.bench.run.errors import UsageError

LONG_SIDE = 320
"""Largest size of the frames a network gets where no size is asked for: a 16:9 film becomes the paper's 320x180."""

SIZES_PX = range(8, 4097)
"""Widths and heights that a network can be asked to see."""

FASTEST = 1000.0
"""Frames per second above which a rate that a file or camera tells is none: absent ones come as absurd numbers."""

VARIES, TICK_S = 0.10, 0.0015
"""Frame intervals vary if one is off the mean by this share, and by more than a container's 1 ms clock rounds."""

Item = TypeVar("Item")


@dataclass(frozen=True, slots=True)
class Picture:
    """One frame as a network takes it: luma (R, C) at the network's size, a camera's by BT.601.

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

    ``size`` is (width, height) in px as it is shown, ``rate`` its own frames per second and ``announced`` its number of
    frames by the container, each None where it tells none. Raises `UsageError` if there is nothing to decode.
    """

    def __init__(self, source: str) -> None:
        self.source = source
        self.live = source.isdecimal()
        self._reader = _Camera(int(source)) if self.live else Film(_file(source))
        self._frames = self._reader.frames()
        began = time.perf_counter()
        self._first = next(self._frames, None)
        self._first_s = time.perf_counter() - began
        if self._first is None:
            raise UsageError(f"{source}: no frame could be decoded")
        self.size = self._reader.size
        self.rate = self._reader.rate if 0.0 < self._reader.rate <= FASTEST else None
        self._clock = _Clock(self._first[0], self.rate)
        self.announced = round(self._reader.length_s * self.rate) or None if self.rate else None
        self._exhausted = False
        self._resized: list[str] = []

    def pictures(self, size: tuple[int, int]) -> Iterator[Picture]:
        """Yield every frame at ``size`` (width, height), once: what has been taken is gone.

        Luma comes before resizing: with a third of the bytes to average it takes two thirds of the time of the other
        order, and the two differ by rounding alone.
        """
        frame, began, decode_s = self._first, time.perf_counter(), self._first_s
        while frame is not None:
            decoded = time.perf_counter()
            luma = resized(frame[1], size)
            ready = time.perf_counter()
            yield Picture(self._clock.frames - 1, self._clock.now_s, luma, decode_s, ready - decoded)
            before, began = frame[1].shape, time.perf_counter()
            frame = next(self._frames, None)
            decode_s = time.perf_counter() - began
            if frame is not None:
                self._clock.tick(frame[0])
                if frame[1].shape != before:
                    width, height = self._reader.size
                    self._resized.append(f"{width}x{height} from frame {self._clock.frames - 1} on")
        self._exhausted = True

    def ended_early(self) -> str:
        """Tell why this is not all of the footage, in words; empty if it is, or if reading was broken off.

        A file's length may be that of its sound, so an end counts only where time and number of frames agree on it.
        """
        if not self._exhausted:
            return ""
        if self.live:
            return f"camera {self.source} gave no more frames after {self._clock.frames}"
        if self.rate is None or self.announced is None or self._clock.frames >= self.announced:
            return ""
        if self._clock.now_s + (1 + self._reader.slack) / self.rate >= self._reader.length_s:
            return ""
        return f"ended early: {self._clock.frames} of the {self.announced} frames its header announces were decoded"

    def notes(self) -> list[str]:
        """Return what to know about the footage as far as it was read, a line each."""
        notes = [f"the frame size changes: {change}" for change in self._resized]
        if not self.live and self._clock.varies():
            low, high = self._clock.shortest_s * 1e3, self._clock.longest_s * 1e3
            notes.append(f"frame intervals vary from {low:.0f} to {high:.0f} ms; the network steps once a frame")
        if self._reader.interlaced:
            notes.append("interlaced: one picture is made of the two fields of a frame")
        if self._reader.damaged:
            notes.append(f"{self._reader.damaged} frames could not be decoded and are left out")
        return notes

    def close(self) -> None:
        """Let go of the file or camera."""
        self._reader.close()


class _Camera:
    """A camera by its index, read by OpenCV. It is neither long nor interlaced as a `Film` is."""

    length_s = slack = 0.0
    interlaced = damaged = 0

    def __init__(self, index: int) -> None:
        cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_SILENT)  # the error says it
        try:
            self._capture = cv2.VideoCapture(index)
        except cv2.error as error:
            raise UsageError(f"camera {index}: {error.err}") from None
        if not self._capture.isOpened():
            raise UsageError(f"camera {index}: cannot be opened")
        self._reading = threading.Lock()
        self.rate = self._capture.get(cv2.CAP_PROP_FPS)
        self.size = (0, 0)

    def frames(self) -> Iterator[tuple[float, Image]]:
        """Yield each frame, BGR or grey, with the time of the clock in seconds, until there are no more."""
        while True:
            try:
                with self._reading:
                    ok, image = self._capture.read()
            except cv2.error:
                return
            if not ok or image is None or not image.size:
                return
            self.size = (image.shape[1], image.shape[0])
            yield time.monotonic(), np.asarray(image, np.uint8)

    def close(self) -> None:
        """Let go of the camera; one that hangs in another thread is left to the process's end."""
        if self._reading.acquire(timeout=0.5):
            self._capture.release()


class _Clock:
    """Times of the frames, in seconds from the start, and bounds of their intervals."""

    def __init__(self, first_s: float | None, rate: float | None) -> None:
        self.frames, self.now_s = 1, 0.0
        self.shortest_s, self.longest_s = math.inf, 0.0
        self._origin_s, self._usual_s = first_s or 0.0, 1.0 / (rate or 30.0)

    def tick(self, time_s: float | None) -> None:
        """Another frame has been read, with its time stamp. Raw streams have none: then the rate has to do."""
        stamped = None if time_s is None else time_s - self._origin_s
        now = stamped if stamped is not None and stamped > self.now_s else self.now_s + self._usual_s
        self.shortest_s, self.longest_s = min(self.shortest_s, now - self.now_s), max(self.longest_s, now - self.now_s)
        self.frames, self.now_s = self.frames + 1, now

    def varies(self) -> bool:
        """Tell whether the intervals differ from their mean by more than `VARIES`."""
        if self.frames < 3:
            return False
        mean = self.now_s / (self.frames - 1)
        return max(mean - self.shortest_s, self.longest_s - mean) > max(VARIES * mean, TICK_S)


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


def _file(source: str) -> Path:
    path = Path(source)
    if not path.exists():
        raise UsageError(f"{source}: no such file (a camera is given by its index, from 0 up)")
    if path.is_dir() or path.stat().st_size == 0:
        raise UsageError(f"{source}: {'a folder' if path.is_dir() else 'the file is empty'}")
    return path
