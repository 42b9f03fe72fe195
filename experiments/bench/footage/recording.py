"""Footage as it is watched, streamed to a Rerun viewer or a recording.

Frames are JPEG at `QUALITY` as the network saw them; potentials, spikes and arrows come in chunks of frames, so that
a frame costs little and nothing piles up here.
"""

from __future__ import annotations

import ctypes
import math
import subprocess
import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import cv2
import numpy as np
import numpy.typing as npt
import rerun as rr
import rerun.blueprint as rrb

from colias_sim.gl import has_screen
from dsnn import Response, ResponseSeries
from experiments.bench import viewer
from experiments.bench.figures.palette import colours
from experiments.bench.figures.series import rgb
from experiments.bench.footage.video import Picture
from experiments.bench.recording import (
    APPLICATION,
    Floats,
    describe_answers,
    described,
    lanes,
    page,
    send_answers,
    send_layout,
    send_thresholds,
    timelines,
)
from experiments.bench.run.errors import UsageError
from experiments.bench.run.models import ConfiguredModel
from experiments.bench.store.places import part

QUALITY = 80
CHUNK_FRAMES = 64
ARROW_WIDTH = 6.0
"""Width of the arrows along HS and VS, in points of the screen: as wide in a small picture as in a large one."""
LONGEST_ARROW_AT = 0.5
"""Potential from which an arrow is as long as it gets. Models spike from some 0.15 on, and rarely go beyond 0.5."""
VIEWER_EVERY_S, VIEWER_IMAGES_PER_S = 0.1, 20.0


@dataclass(slots=True)
class _Chunk:
    """Frames not sent yet; images with where they belong, the answers of one frame together."""

    times_s: list[float] = field(default_factory=list)
    frames: list[int] = field(default_factory=list)
    answers: list[Sequence[Response | None]] = field(default_factory=list)
    image_at: list[int] = field(default_factory=list)
    images: list[bytes] = field(default_factory=list)


class LiveLog:
    """One stream to a viewer or a file: pictures with an arrow along HS and one along VS, potentials, spikes.

    ``size`` is (width, height) of the pictures. Make it by `to_file` or `to_viewer`.
    """

    def __init__(
        self, stream: rr.RecordingStream, models: Sequence[ConfiguredModel], size: tuple[int, int],
        process: subprocess.Popen[bytes] | None = None, path: Path | None = None,
    ) -> None:  # fmt: skip
        self._stream, self._models, self._size, self._viewer = stream, models, size, process
        self._path = path
        self.note = ""
        self._chunk = _Chunk()
        self._sent = self._shown = 0.0
        self._answering = described(models)
        self._describe()

    @classmethod
    def to_file(cls, path: Path, models: Sequence[ConfiguredModel], size: tuple[int, int]) -> LiveLog:
        """Record every frame with its image into the .rrd file ``path``, which is NAME.part until it is whole."""
        stream = rr.RecordingStream(APPLICATION)
        stream.save(part(path))
        send_layout(stream, blueprint(size, models))
        return cls(stream, models, size, path=path)

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
        stream = rr.RecordingStream(APPLICATION)
        stream.connect_grpc(viewer.url(address), default_blueprint=blueprint(size, models))
        return cls(stream, models, size, process)

    def add(self, picture: Picture, answers: Sequence[Response | None]) -> None:
        """Take a frame and the models' answers to it. A viewer that was closed is not missed."""
        if self._viewer is not None and self._viewer.poll() is not None:
            self.note = "the viewer was closed, or could not open its window: watching went on without it"
            return
        chunk, now = self._chunk, time.monotonic()
        if self._viewer is None or now - self._shown >= 1 / VIEWER_IMAGES_PER_S:
            jpeg = cv2.imencode(".jpg", picture.luma, [cv2.IMWRITE_JPEG_QUALITY, QUALITY])[1]
            chunk.image_at.append(len(chunk.frames))
            chunk.images.append(jpeg.tobytes())
            self._shown = now
        chunk.times_s.append(picture.time_s)
        chunk.frames.append(picture.frame)
        chunk.answers.append(answers)
        if len(chunk.frames) >= CHUNK_FRAMES or (self._viewer is not None and now - self._sent >= VIEWER_EVERY_S):
            self._send()
            self._sent = now

    def close(self) -> None:
        """Send what is left and end the stream: a file gets its name, and a viewer stays open."""
        if self._viewer is None or self._viewer.poll() is None:
            if self._chunk.frames:
                self._send()
            try:
                self._stream.flush(timeout_sec=math.inf if self._viewer is None else 5.0)
            except RuntimeError as error:
                # Rerun would flush once more, for ever, when the stream is deleted, and when Python ends.
                ctypes.pythonapi.Py_IncRef(ctypes.py_object(self._stream))
                rr.unregister_shutdown()
                if self._viewer is None:
                    raise
                self.note = f"the viewer did not take everything: {error}"
                return
        self._stream.disconnect()
        if self._path is not None:
            part(self._path).replace(self._path)

    def _describe(self) -> None:
        """Log what does not change: names, colours, where the arrows start."""
        stream, tints = self._stream, colours(model.label for model in self._models)
        stream.log("picture", rr.EncodedImage.from_fields(media_type="image/jpeg"), static=True)
        for place, model in enumerate(self._models):
            arrows = [system for system in ("hs", "vs") if system in model.channels]
            if arrows:
                tint = [rgb(tints[model.label])] * len(arrows)
                radii = rr.Radius.ui_points([ARROW_WIDTH / 2] * len(arrows))
                arrows_shown = rr.Arrows2D.from_fields(
                    origins=[self._origin(place)] * len(arrows), colors=tint, radii=radii
                )
                stream.log(_direction(model), arrows_shown, static=True)
        describe_answers(stream, self._answering)

    def _origin(self, place: int) -> tuple[float, float]:
        """Return where the arrows of a model begin: the models' places share the picture's middle row."""
        width, height = self._size
        return width * (place + 1) / (len(self._models) + 1), height / 2

    def _send(self) -> None:
        chunk, self._chunk = self._chunk, _Chunk()
        when = np.asarray(chunk.times_s), np.asarray(chunk.frames)
        if chunk.images:
            images = rr.EncodedImage.columns(blob=chunk.images)
            self._stream.send_columns("picture", timelines(*(column[chunk.image_at] for column in when)), images)
        for place in range(len(self._models)):
            known = [i for i, answers in enumerate(chunk.answers) if answers[place] is not None]
            if known:
                present = [answer for answers in chunk.answers if (answer := answers[place]) is not None]
                self._answers(place, present, when[0][known], when[1][known])
        # A level at the ends of the chunk draws its line.
        send_thresholds(self._stream, self._answering, *(column[[0, -1]] for column in when))

    def _answers(
        self, place: int, answers: Sequence[Response], time_s: Floats, frames: npt.NDArray[np.int64]
    ) -> None:  # fmt: skip
        model, labels = self._models[place], [model.label for model in self._models]
        series = ResponseSeries.from_responses(answers)
        send_answers(self._stream, self._answering[place], labels, series, time_s, frames)
        axes = [(system, axis) for system, axis in (("hs", (1, 0)), ("vs", (0, 1))) if system in model.channels]
        if not axes:
            return
        vectors = np.array([[np.multiply(getattr(a, system), axis) for system, axis in axes] for a in answers])
        vectors = arrow_lengths(vectors, self._size)
        arrows = rr.Arrows2D.columns(vectors=vectors.reshape(-1, 2)).partition([len(axes)] * len(answers))
        self._stream.send_columns(_direction(model), timelines(time_s, frames), arrows)


def arrow_lengths(potentials: npt.NDArray[np.float64], size: tuple[int, int]) -> npt.NDArray[np.float64]:
    """Return arrows (..., 2), in pixels of a picture of ``size``, for potentials (..., 2) along x and y.

    A potential of `LONGEST_ARROW_AT` or more is half the picture's smaller side long, and others in proportion.
    """
    return np.clip(potentials / LONGEST_ARROW_AT, -1.0, 1.0) * (min(size) / 2)


def _direction(model: ConfiguredModel) -> str:
    """Return where the arrows of a model are logged."""
    return f"picture/direction/{rr.escape_entity_path_part(model.label)}"


def blueprint(size: tuple[int, int], models: Sequence[ConfiguredModel]) -> rrb.Blueprint:
    """Lay out the recording to be read: the picture of ``size`` with its arrows, beneath it what the models answer."""
    bounds = rrb.VisualBounds2D(x_range=(0, size[0]), y_range=(0, size[1]))
    return page(
        rrb.Spatial2DView(origin="picture", name="what the network sees; HS and VS as arrows", visual_bounds=bounds),
        lanes(described(models)),
        shares=[2, 1],
    )
