"""Footage as it is watched, streamed to a Rerun viewer or a recording. With `log`, the only importer of rerun.

Frames are JPEG at `QUALITY` as the network saw them; potentials, spikes and arrows come in chunks of frames, so that
a frame costs little and nothing piles up here.
"""

from __future__ import annotations

import os
import socket
import subprocess
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import cv2
import numpy as np
import numpy.typing as npt
import rerun as rr
import rerun.blueprint as rrb

from dsnn import Response
from experiments.bench.files import UsageError
from experiments.bench.footage import Picture
from experiments.bench.log import APPLICATION, HS_COLOURS, LIMIT_COLOUR, VS_COLOURS
from experiments.bench.models import Chosen
from experiments.bench.viewer import program

QUALITY = 80
CHUNK_FRAMES = 64
VIEWER_EVERY_S, VIEWER_IMAGES_PER_S = 0.1, 20.0
VIEWER_START_S, VIEWER_SETTLES_S = 20.0, 1.0
VIEWER_MEMORY = "1GB"  # the viewer then drops the oldest data: a camera may run for days


@dataclass(slots=True)
class _Chunk:
    """Frames not sent yet; images with where they belong, the answers of one frame together."""

    times_s: list[float] = field(default_factory=list)
    frames: list[int] = field(default_factory=list)
    answers: list[Sequence[Response]] = field(default_factory=list)
    image_at: list[int] = field(default_factory=list)
    images: list[bytes] = field(default_factory=list)


class LiveLog:
    """One stream to a viewer or a file: pictures with an arrow along HS and one along VS, potentials, spikes.

    ``size`` is (width, height) of the pictures. Make it by `to_file` or `to_viewer`.
    """

    def __init__(
        self, stream: rr.RecordingStream, models: Sequence[Chosen], size: tuple[int, int],
        viewer: subprocess.Popen[bytes] | None = None,
    ) -> None:  # fmt: skip
        self._stream, self._models, self._size, self._viewer = stream, models, size, viewer
        self.note = ""
        self._chunk = _Chunk()
        self._sent = self._shown = 0.0
        self._describe()

    @classmethod
    def to_file(cls, path: Path, models: Sequence[Chosen], size: tuple[int, int]) -> LiveLog:
        """Record into the .rrd file ``path``, every frame with its image."""
        stream = rr.RecordingStream(APPLICATION)
        stream.save(path, default_blueprint=blueprint(size))
        return cls(stream, models, size)

    @classmethod
    def to_viewer(cls, models: Sequence[Chosen], size: tuple[int, int]) -> LiveLog:
        """Open a viewer of its own that listens on 127.0.0.1 alone, and stay open when this is over.

        It gets every potential, and images as often as an eye can follow. Raises `UsageError` where it cannot open.
        """
        if sys.platform.startswith("linux") and not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
            raise UsageError("watch: the viewer needs a screen (DISPLAY is not set): give --no-view, or --record FILE")
        port = _free_port()
        command = [*program(), "--bind", "127.0.0.1", "--port", f"{port}"]
        command += ["--memory-limit", VIEWER_MEMORY, "--expect-data-soon", "--hide-welcome-screen"]
        # A session of its own: Ctrl-C is meant for the watching, not for the viewer.
        quiet = subprocess.DEVNULL  # or a pipe that reads our output would wait for the viewer
        viewer = subprocess.Popen(command, stdout=quiet, stderr=quiet, start_new_session=True)
        _await(viewer, port)
        stream = rr.RecordingStream(APPLICATION)
        stream.connect_grpc(f"rerun+http://127.0.0.1:{port}/proxy", default_blueprint=blueprint(size))
        return cls(stream, models, size, viewer)

    def add(self, picture: Picture, answers: Sequence[Response]) -> None:
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
        """Send what is left and end the stream; a viewer stays open."""
        if self._viewer is None or self._viewer.poll() is None:
            if self._chunk.frames:
                self._send()
            self._stream.flush(timeout_sec=10.0)
        self._stream.disconnect()

    def _describe(self) -> None:
        """What does not change: names, colours, where the arrows start."""
        stream, centre = self._stream, (self._size[0] / 2, self._size[1] / 2)
        stream.log("picture", rr.EncodedImage.from_fields(media_type="image/jpeg"), static=True)
        for place, model in enumerate(self._models):
            prefix = f"{model.label} " if len(self._models) > 1 else ""
            colours = {"hs": HS_COLOURS[place % 5], "vs": VS_COLOURS[place % 5], "looming": HS_COLOURS[place % 5]}
            for system in model.channels:
                colour = colours[system]
                name = f"{prefix}{system.upper()}"
                lines = {"potential": name, "spikes": f"{name} spikes"}
                for kind, shown in lines.items():
                    style = rr.SeriesLines(colors=colour, names=shown, widths=1.5)
                    stream.log(f"{kind}/{model.label}/{system}", style, static=True)
            if "hs" in model.channels:
                both = [colours["hs"], colours["vs"]]
                arrows = rr.Arrows2D.from_fields(origins=[centre] * 2, colors=both, radii=[1.5] * 2)
                stream.log(f"picture/direction/{model.label}", arrows, static=True)
        for level in self._levels():
            name = f"{'' if level > 0 else '-'}T = {level:g}"
            stream.log(_limit(level), rr.SeriesLines(colors=LIMIT_COLOUR, names=name, widths=1.0), static=True)

    def _levels(self) -> list[float]:
        return sorted({sign * model.threshold for model in self._models for sign in (1, -1) if model.threshold})

    def _send(self) -> None:
        chunk, self._chunk = self._chunk, _Chunk()
        when = np.asarray(chunk.times_s), np.asarray(chunk.frames)
        times = _timelines(*when)
        if chunk.images:
            images = rr.EncodedImage.columns(blob=chunk.images)
            self._stream.send_columns("picture", _timelines(*(column[chunk.image_at] for column in when)), images)
        for place, model in enumerate(self._models):
            answers = [answer[place] for answer in chunk.answers]
            self._answers(model, answers, times)
        # A level at the ends of the chunk draws its line.
        ends = _timelines(*(column[[0, -1]] for column in when))
        for level in self._levels():
            self._stream.send_columns(_limit(level), ends, rr.Scalars.columns(scalars=[level, level]))

    def _answers(self, model: Chosen, answers: Sequence[Response], times: list[rr.TimeColumn]) -> None:
        send, label = self._stream.send_columns, model.label
        for system in model.channels:
            potentials = [getattr(answer, system) for answer in answers]
            spikes = [getattr(answer, f"{system}_spikes") for answer in answers]
            send(f"potential/{label}/{system}", times, rr.Scalars.columns(scalars=potentials))
            send(f"spikes/{label}/{system}", times, rr.Scalars.columns(scalars=spikes))
        if "hs" not in model.channels:
            return
        # A potential of 1 reaches the picture's edge.
        half = np.asarray(self._size) / 2
        vectors = np.array([[(answer.hs, 0.0), (0.0, answer.vs)] for answer in answers]) * half
        arrows = rr.Arrows2D.columns(vectors=vectors.reshape(-1, 2)).partition([2] * len(answers))
        send(f"picture/direction/{label}", times, arrows)


def blueprint(size: tuple[int, int]) -> rrb.Blueprint:
    """A layout that opens ready to read: the picture of ``size`` with its arrows, beneath it what the network says."""
    bounds = rrb.VisualBounds2D(x_range=(0, size[0]), y_range=(0, size[1]))
    return rrb.Blueprint(
        rrb.Vertical(
            rrb.Spatial2DView(
                origin="picture", name="what the network sees; HS and VS as arrows", visual_bounds=bounds
            ),
            rrb.TimeSeriesView(origin="potential", name="membrane potential"),
            rrb.TimeSeriesView(origin="spikes", name="spikes per frame"),
            row_shares=[4, 2, 1],
        ),
        rrb.TimePanel(state="collapsed", timeline="time"),
        collapse_panels=True,
    )


def _timelines(times_s: npt.NDArray[np.float64], frames: npt.NDArray[np.int64]) -> list[rr.TimeColumn]:
    return [rr.TimeColumn("time", duration=times_s), rr.TimeColumn("frame", sequence=frames)]


def _limit(level: float) -> str:
    return f"potential/threshold/{'plus' if level > 0 else 'minus'}_{abs(level):g}".replace(".", "_")


def _await(viewer: subprocess.Popen[bytes], port: int) -> None:
    """Wait until the viewer listens, and a moment longer: it listens before it finds that it has no window."""
    deadline = time.monotonic() + VIEWER_START_S
    while viewer.poll() is None and time.monotonic() < deadline:
        with socket.socket() as probe:
            listens = probe.connect_ex(("127.0.0.1", port)) == 0
        time.sleep(VIEWER_SETTLES_S if listens else 0.05)
        if listens and viewer.poll() is None:
            return
    viewer.terminate()
    raise UsageError("watch: the Rerun viewer did not open on this screen: give --no-view, or --record FILE")


def _free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])
