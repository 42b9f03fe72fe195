"""Footage as it is watched, streamed to a Rerun viewer or a recording.

Frames are JPEG at `QUALITY` as the network saw them; potentials, spikes and arrows come in chunks of frames, so that
a frame costs little and nothing piles up here.
"""

from __future__ import annotations

import math
import subprocess
import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import numpy.typing as npt
import rerun as rr
from rerun.chunk import Chunk

from colias_sim.gl import has_screen
from dsnn import Response, ResponseSeries
from experiments.bench.footage.video import Picture
from experiments.bench.report.palette import colours
from experiments.bench.run import record as rerun
from experiments.bench.run import viewer
from experiments.bench.run.errors import UsageError
from experiments.bench.run.files import part
from experiments.bench.run.models import ConfiguredModel
from experiments.bench.run.record import Content, Frames, Model, Stream

QUALITY = 80
CHUNK_FRAMES = 64
ARROW_WIDTH = 6.0
"""Width of the arrows along HS and VS, in points of the screen: as wide in a small picture as in a large one."""
LONGEST_ARROW_AT = 0.5
"""Potential from which an arrow is as long as it gets. Models spike from some 0.15 on, and rarely go beyond 0.5."""
VIEWER_EVERY_S, VIEWER_IMAGES_PER_S = 0.1, 20.0
AXES = {"hs": (1, 0), "vs": (0, 1)}


@dataclass(slots=True)
class _Chunk:
    """Frames not sent yet; images with where they belong, the responses to one frame together."""

    times_s: list[float] = field(default_factory=list)
    frames: list[int] = field(default_factory=list)
    responses: list[Sequence[Response | None]] = field(default_factory=list)
    image_at: list[int] = field(default_factory=list)
    images: list[bytes] = field(default_factory=list)


class LiveLog:
    """One stream to a viewer or a file: pictures with an arrow along HS and one along VS, potentials, spikes.

    ``size`` is (width, height) of the pictures. Make it by `to_file` or `to_viewer`.
    """

    def __init__(
        self, stream: Stream, models: Sequence[ConfiguredModel], size: tuple[int, int],
        process: subprocess.Popen[bytes] | None = None, path: Path | None = None,
    ) -> None:  # fmt: skip
        self._stream, self._models, self._size, self._viewer = stream, models, size, process
        self._path = path
        self.note = ""
        self._chunk = _Chunk()
        self._sent = self._shown = 0.0
        stream.send(_NOTHING, self._arrows_at_rest())

    @classmethod
    def to_file(cls, path: Path, models: Sequence[ConfiguredModel], size: tuple[int, int]) -> LiveLog:
        """Record every frame with its image into the .rrd file ``path``, which is NAME.part until it is whole."""
        return cls(Stream.to_file(_content(models), part(path)), models, size, path=path)

    @classmethod
    def to_viewer(cls, models: Sequence[ConfiguredModel], size: tuple[int, int]) -> LiveLog:
        """Open a viewer of its own that listens on 127.0.0.1 alone, and stay open when this is over.

        It gets every potential, and images as often as an eye can follow. Raises `UsageError` where it cannot open.
        """
        if not has_screen():
            raise UsageError("watch: the viewer needs a screen (DISPLAY is not set): give --no-view, or --record FILE")
        process, address = viewer.opened(
            "watch: the Rerun viewer did not open on this screen: give --no-view, or --record FILE"
        )
        return cls(Stream.to_viewer(_content(models), viewer.url(address)), models, size, process)

    def add(self, picture: Picture, answers: Sequence[Response | None]) -> None:
        """Take a frame and the models' responses to it. A viewer that was closed is not missed."""
        if self._viewer is not None and self._viewer.poll() is not None:
            self.note = "the viewer was closed, or could not open its window: watching went on without it"
            return
        chunk, now = self._chunk, time.monotonic()
        if self._viewer is None or now - self._shown >= 1 / VIEWER_IMAGES_PER_S:
            chunk.image_at.append(len(chunk.frames))
            chunk.images += rerun.jpegs([picture.luma], QUALITY)
            self._shown = now
        chunk.times_s.append(picture.time_s)
        chunk.frames.append(picture.frame)
        chunk.responses.append(answers)
        if len(chunk.frames) >= CHUNK_FRAMES or (self._viewer is not None and now - self._sent >= VIEWER_EVERY_S):
            self._send()
            self._sent = now

    def close(self) -> None:
        """Send what is left and end the stream: a file gets its name, and a viewer stays open."""
        open_still = self._viewer is None or self._viewer.poll() is None
        if open_still and self._chunk.frames:
            self._send()
        trouble = self._stream.close(flush=open_still, patience_s=math.inf if self._viewer is None else 5.0)
        if trouble and self._viewer is None:
            raise RuntimeError(trouble)
        if trouble:
            self.note = f"the viewer did not take everything: {trouble}"
        if self._path is not None:
            part(self._path).replace(self._path)

    def _arrows_at_rest(self) -> list[Chunk]:
        """Return where arrows begin, and their colours: the models' places share the picture's middle row."""
        (width, height), tints = self._size, colours(model.label for model in self._models)
        arrows = []
        for place, model in enumerate(self._models):
            if count := len(_axes(model)):
                origin = width * (place + 1) / (len(self._models) + 1), height / 2
                look = rr.Arrows2D.from_fields(
                    origins=[origin] * count, colors=[rerun.rgb(tints[model.label])] * count,
                    radii=rr.Radius.ui_points([ARROW_WIDTH / 2] * count),
                )  # fmt: skip
                arrows.append(rerun.fixed(_direction(model), look))
        return arrows

    def _send(self) -> None:
        chunk, self._chunk = self._chunk, _Chunk()
        time_s, frame = np.asarray(chunk.times_s), np.asarray(chunk.frames)
        if chunk.images:
            at = chunk.image_at
            self._stream.send(Frames(time_s[at], frame[at], images={"": chunk.images}))
        for place, model in enumerate(self._models):
            known = [i for i, responses in enumerate(chunk.responses) if responses[place] is not None]
            present = [response for one in chunk.responses if (response := one[place]) is not None]
            if present:
                series = ResponseSeries.from_responses(present)
                shown = Frames(time_s[known], frame[known], {model.label: series})
                self._stream.send(shown, self._arrows(model, series, shown))

    def _arrows(self, model: ConfiguredModel, series: ResponseSeries, shown: Frames) -> list[Chunk]:
        axes = _axes(model)
        if not axes:
            return []
        vectors = np.stack([np.outer(getattr(series, channel), AXES[channel]) for channel in axes], axis=1)
        arrows = rr.Arrows2D.columns(vectors=arrow_lengths(vectors, self._size).reshape(-1, 2))
        when = rerun.times(shown.time_s, shown.frame)
        return [rerun.chunk(_direction(model), when, arrows.partition([len(axes)] * len(vectors)))]


_NOTHING = Frames(np.zeros(0), np.zeros(0, np.int64))


def arrow_lengths(potentials: npt.NDArray[np.float64], size: tuple[int, int]) -> npt.NDArray[np.float64]:
    """Return arrows (..., 2), in pixels of a picture of ``size``, for potentials (..., 2) along x and y.

    A potential of `LONGEST_ARROW_AT` or more is half the picture's smaller side long, and others in proportion.
    """
    return np.clip(potentials / LONGEST_ARROW_AT, -1.0, 1.0) * (min(size) / 2)


def _axes(model: ConfiguredModel) -> list[str]:
    return [channel for channel in AXES if channel in model.channels]


def _direction(model: ConfiguredModel) -> str:
    """Return where the arrows of a model are: on the picture."""
    return f"{rerun.CAMERA}/motion/{rr.escape_entity_path_part(model.label)}"


def _content(models: Sequence[ConfiguredModel]) -> Content:
    return Content(tuple(map(Model.of, models)), eyes=("",))
