"""A film of a recording: its frames at the times of the video, and the file they go to."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from experiments.bench.run.errors import UsageError
from experiments.bench.video.drawing import Drawer
from experiments.bench.video.encoding import writer
from experiments.bench.video.layout import lay_out
from experiments.bench.video.outside import ASPECT, outside
from experiments.bench.video.pictures import Floats, Picture, changes, pictures
from experiments.bench.video.reading import Reel
from experiments.bench.video.still import still_of

GIF_RATE = 12.5
"""Most frames a second of a GIF by default: its delays are whole hundredths of a second, here 8."""
PALETTE_FRAMES = 6
SIZES_PX = range(160, 3841)
RATES_HZ, SPEEDS = (0.1, 120.0), (0.01, 100.0)


@dataclass(frozen=True, slots=True)
class Film:
    """A film to make of a recording.

    Parameters
    ----------
    out
        The file: ``.mp4``, ``.gif`` or ``.webp``.
    width, height
        In pixels; even for ``.mp4``.
    caption
        The text at the top; by default the recording's name.
    rate
        Frames a second; by default those of the recording, at most `GIF_RATE` in a GIF.
    speed
        Seconds of the recording in a second of the film.

    Raises
    ------
    UsageError
        For a value that is not legal, in one line.
    """

    out: Path
    width: int = 1280
    height: int = 720
    caption: str | None = None
    rate: float | None = None
    speed: float = 1.0

    def __post_init__(self) -> None:
        given = f"--size {self.width}x{self.height}"
        if self.width not in SIZES_PX or self.height not in SIZES_PX:
            raise UsageError(f"{given}: legal is WIDTHxHEIGHT, each from {SIZES_PX[0]} to {SIZES_PX[-1]} px")
        if self.out.suffix == ".mp4" and (self.width % 2 or self.height % 2):
            even = f"{self.width + self.width % 2}x{self.height + self.height % 2}"
            raise UsageError(f"{given}: H.264 has even sizes only, for example {even}")
        for name, value, (low, high) in (("--fps", self.rate, RATES_HZ), ("--speed", self.speed, SPEEDS)):
            if value is not None and not low <= value <= high:
                raise UsageError(f"{name} {value:g}: legal is {low:g} .. {high:g}")

    def frames_per_second(self, reel: Reel) -> float:
        """Return the film's rate."""
        if self.rate is not None:
            return self.rate
        rate = round(reel.rate * self.speed, 3)
        return min(rate, GIF_RATE) if self.out.suffix == ".gif" else min(max(rate, RATES_HZ[0]), 60.0)

    def times(self, reel: Reel) -> Floats:
        """Return the time of the recording that each frame shows, (N,), in seconds."""
        step = self.speed / self.frames_per_second(reel)
        first, last = float(reel.time_s[0]), float(reel.time_s[-1])
        times: Floats = first + step * np.arange(math.floor((last - first) / step + 1e-6) + 1, dtype=np.float64)
        return times


def make(reel: Reel, film: Film, advance: Callable[[], None] = lambda: None) -> int:
    """Write a film of a recording. No more than a few frames are in memory at any time.

    Parameters
    ----------
    reel
        The recording.
    film
        What to make.
    advance
        Called after each frame.

    Returns
    -------
    int
        The number of frames.
    """
    drawer, times = drawer_of(reel, film), film.times(reel)

    def samples() -> Iterator[Picture]:
        return frames(reel, drawer, times[np.unique(np.linspace(0, len(times) - 1, PALETTE_FRAMES).astype(int))])

    size, colours = (film.width, film.height), [trace.colour for trace in reel.traces]
    colours += [track.colour for track in reel.tracks]
    with writer(film.out, size, film.frames_per_second(reel), samples, colours) as take:
        for frame in frames(reel, drawer, times):
            take(frame)
            advance()
    return len(times)


def frames(reel: Reel, drawer: Drawer, times: Floats) -> Iterator[Picture]:
    """Draw the frames of increasing times, (H, W, 3) uint8 each, reading pictures as they are needed."""
    sources = [pictures(reel.path, eye) for eye in reel.eyes]
    changed: Iterator[tuple[float, Picture]] = iter(())
    if sources:
        sources[0], again = itertools.tee(sources[0])
        changed = changes(again)
    eyes, change = [_Latest(source) for source in sources], _Latest(changed)
    for time_s in times.tolist():
        yield drawer.frame(time_s, [eye.at(time_s) for eye in eyes], change.at(time_s))


def aspects(reel: Reel) -> list[float]:
    """Width over height of each eye's pictures."""
    shapes = [next(pictures(reel.path, eye))[1].shape for eye in reel.eyes]
    return [shape[1] / shape[0] for shape in shapes]


def caption_of(reel: Reel, given: str | None) -> str:
    """Return the caption that was given, or what the recording says it is, and how many models are not shown."""
    if given is not None:
        return given
    experiment = reel.properties.get("experiment")
    name = f"{experiment}: {reel.name.partition(' ')[2] or reel.name}" if experiment else reel.name
    return f"{name}; {not_shown(reel)}" if reel.hidden else name


def not_shown(reel: Reel) -> str:
    """Say how many models of a recording are not shown."""
    return f"{reel.hidden} of {reel.hidden + len(reel.models)} models are not shown"


def drawer_of(reel: Reel, film: Film) -> Drawer:
    """Return what draws the frames of a film: with the view from outside where that can be drawn, else with a plan."""
    shapes = aspects(reel)
    layout = lay_out(reel, shapes, film.width, film.height, outside=ASPECT)
    view = None if layout.outside is None else outside(reel, int(layout.outside.height))
    if view is None:
        layout = lay_out(reel, shapes, film.width, film.height)
    return Drawer(reel, layout, still_of(reel, layout, caption_of(reel, film.caption)).picture(), view)


class _Latest:
    """Pictures by time: the last one that is not after it."""

    def __init__(self, source: Iterator[tuple[float, Picture]]) -> None:
        self._source = source
        self._now: Picture | None = None
        self._next = next(source, None)

    def at(self, time_s: float) -> Picture | None:
        """Return the picture of a time. Times never decrease."""
        while self._next is not None and self._next[0] <= time_s + 1e-6:
            self._now, self._next = self._next[1], next(self._source, None)
        return self._now


def latest_at(source: Iterator[tuple[float, Picture]], times: Sequence[float]) -> list[Picture | None]:
    """Return the last picture of a source at each of some increasing times; ``None`` before the first."""
    latest = _Latest(source)
    return [latest.at(time_s) for time_s in times]
