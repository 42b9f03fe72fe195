"""Models watch footage: step them frame by frame, find the intervals of motion, keep what a summary needs.

An interval of rightward motion is a series of frames with HS above the model's threshold T, in which no two are
`GAP_S` or more apart and none is below -T, of at least `LEAST_FRAMES`; likewise leftward below -T, and downward and
upward by VS. It lasts from its first frame over the threshold to its last.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Protocol

from dsnn import Response
from experiments.bench.footage.video import Picture
from experiments.bench.run.models import ConfiguredModel
from experiments.bench.run.play import ModelRunner

GAP_S, LEAST_FRAMES = 0.2, 3


@dataclass(slots=True)
class Motion:
    """An interval of motion; ``frames`` counts those over the threshold, ``peak`` is the potential farthest from 0."""

    direction: str
    start_s: float
    end_s: float
    frames: int = 0
    peak: float = 0.0
    spikes: int = 0


WAYS = {"hs": ("rightward", "leftward"), "vs": ("downward", "upward"), "looming": ("looming", "looming")}
"""A spiking channel -> what its potential tells of above the threshold, and below the negative one."""


class Tracker:
    """The intervals of one channel of one model, frame by frame; a model without ``threshold`` has none."""

    def __init__(self, ways: tuple[str, str], threshold: float | None) -> None:
        self._ways, self._threshold = ways, math.inf if threshold is None else threshold
        self._found: list[Motion] = []
        self._open: Motion | None = None

    def add(self, time_s: float, potential: float, spikes: int) -> None:
        """Take a frame's potential and spikes."""
        if not abs(potential) > self._threshold:
            return
        way = self._ways[potential < 0]
        motion = self._open
        if motion is None or motion.direction != way or time_s - motion.end_s >= GAP_S:
            self._close()
            motion = self._open = Motion(way, time_s, time_s)
        motion.end_s = time_s
        motion.frames += 1
        motion.spikes += abs(spikes)
        motion.peak = max(motion.peak, potential, key=abs)

    def motions(self) -> list[Motion]:
        """Return the intervals so far, the one under way among them."""
        here = [self._open] if self._open is not None and self._open.frames >= LEAST_FRAMES else []
        return [*self._found, *here]

    def _close(self) -> None:
        self._found = self.motions()
        self._open = None


class Observer(Protocol):
    """Something that follows along: a table, a recording, a judge."""

    @property
    def note(self) -> str:
        """Return what to say of it at the end; empty if nothing."""
        ...

    def add(self, picture: Picture, answers: Sequence[Response | None]) -> None:
        """Take a frame and the models' answers to it, in the models' order; ``None`` of one that went wrong."""
        ...


class Watcher:
    """One model at its work, with its intervals, spikes of the channels that spike, and time; ``shape`` is (R, C).

    Whatever goes wrong in the model ends its own part: ``trouble`` then says what.
    """

    def __init__(self, chosen: ConfiguredModel, shape: tuple[int, int]) -> None:
        self.chosen = chosen
        self.runner = ModelRunner(chosen, shape, keep=False)
        thresholds = chosen.thresholds
        self._trackers = {c: Tracker(WAYS[c], thresholds[c]) for c in chosen.channels if c in WAYS}
        self.spikes = dict.fromkeys((channel for channel in self._trackers if channel in chosen.spiking), 0)

    @property
    def seconds(self) -> float:
        """Time that the model has taken for its steps."""
        return self.runner.seconds

    @property
    def trouble(self) -> str:
        """Return what went wrong in the model; empty while nothing has."""
        return self.runner.trouble

    def step(self, picture: Picture) -> Response | None:
        """Answer the next frame; ``None`` once something went wrong."""
        answer = self.runner.see(picture.luma)
        if answer is None:
            return None
        for channel, tracker in self._trackers.items():
            spikes = getattr(answer, f"{channel}_spikes")
            tracker.add(picture.time_s, getattr(answer, channel), spikes)
            if channel in self.spikes:
                self.spikes[channel] += abs(spikes)
        return answer

    def motions(self) -> list[Motion]:
        """Return the intervals of motion in the order of their beginnings."""
        motions = [motion for tracker in self._trackers.values() for motion in tracker.motions()]
        return sorted(motions, key=lambda motion: motion.start_s)


@dataclass(slots=True)
class Seen:
    """Amount that was seen, and time that it took besides the models: sums over the frames, seconds."""

    frames: int = 0
    until_s: float = 0.0
    decode_s: float = 0.0
    resize_s: float = 0.0


def watched(
    pictures: Iterable[Picture], watchers: Sequence[Watcher], seen: Seen
) -> Iterator[tuple[Picture, list[Response | None]]]:
    """Show every picture to every model; yield it with their answers. ``seen`` is kept up to date.

    Ends early where every model has gone wrong. A picture that only some could answer counts.
    """
    for picture in pictures:
        answers = [watcher.step(picture) for watcher in watchers]
        if all(answer is None for answer in answers):
            return
        seen.frames += 1
        seen.until_s = picture.time_s
        seen.decode_s += picture.decode_s
        seen.resize_s += picture.resize_s
        yield picture, answers


def watch(pictures: Iterable[Picture], watchers: Sequence[Watcher], observers: Sequence[Observer], seen: Seen) -> None:
    """Show every picture to every model, and the answers to every observer, as `watched` does."""
    for picture, answers in watched(pictures, watchers, seen):
        for observer in observers:
            observer.add(picture, answers)
