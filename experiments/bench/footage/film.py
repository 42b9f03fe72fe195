"""A video file as it is shown: PyAV decodes it, and what it says of its orientation, fields and pixels is obeyed."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import NoReturn, cast

import av
import numpy as np
import numpy.typing as npt
from av.filter import Graph
from av.sidedata.sidedata import SideData
from av.video.frame import VideoFrame
from av.video.reformatter import ColorRange
from av.video.stream import VideoStream

from experiments.bench.run.errors import UsageError

Image = npt.NDArray[np.uint8]

TRANSPARENT = "parts of it are transparent, and nothing says what is behind; put it onto a background first"
SIDE_DATA = {
    "STEREO3D": ((0, 8), "it has a picture for each eye; take one, for example by ffmpeg's filter stereo3d"),
    "SPHERICAL": ((4,), "it shows a sphere; cut a flat view out of it, for example by ffmpeg's filter v360"),
}
"""What a frame may say of its kind -> the kinds that are flat pictures, and why others are refused with the way out."""


class Film:
    """An open video file.

    ``size`` is (width, height) in px as the latest picture is shown, ``rate`` the mean number of frames per second,
    and ``length_s`` how long the file says that it is, both 0 where it does not. That may be wrong by ``slack`` frames.
    ``interlaced`` and ``damaged`` count frames up to now: those of two fields, and those that could not be decoded.
    Raises `UsageError` for a file that is no video, or that asks for what is not possible here.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self.size = (0, 0)
        self.interlaced = self.damaged = 0
        try:
            self._container = av.open(f"file:{path}")  # without "file:" a name with a colon is taken for a URL
        except av.FFmpegError as error:
            raise UsageError(f"{path}: not a video that FFmpeg can decode ({error.strerror})") from None
        stream = self._container.streams.best("video")
        if not isinstance(stream, VideoStream) or stream.codec_context is None:
            raise UsageError(f"{path}: not a video that FFmpeg can decode (it has no pictures, or an unknown codec)")
        if stream.metadata.get("alpha_mode") == "1":  # WebM: FFmpeg's own decoders leave the transparency out
            self._refuse(TRANSPARENT)
        stream.thread_type = "AUTO"
        self._stream = stream
        self._pixel_aspect = float(stream.sample_aspect_ratio or 1)
        self.rate = float(stream.average_rate or stream.guessed_rate or 0)
        if stream.frames and self.rate and not self._container.format.name.startswith("mov"):
            self.length_s, self.slack = stream.frames / self.rate, 0.5
        elif stream.duration is not None and stream.time_base is not None:  # in MOV and MP4 edit lists leave frames out
            self.length_s, self.slack = float(stream.duration * stream.time_base), 0.5
        else:  # the length of the whole file, in which sound may be longer
            self.length_s, self.slack = (self._container.duration or 0) / av.time_base, 3.0

    def frames(self) -> Iterator[tuple[float | None, Image]]:
        """Yield the time of each frame in seconds, where the file says it, and its grey levels (R, C), upright.

        Two fields of one frame become one picture, so that frames and their rate are those of the file.
        """
        graph: Graph | None = None
        form: tuple[object, ...] = ()
        for frame in self._decoded():
            if any(component.is_alpha for component in frame.format.components):
                self._check_opaque(frame)
            self.interlaced += frame.interlaced_frame
            before, form = form, (frame.width, frame.height, frame.format.name, frame.color_range)
            if graph is None or form != before:
                if graph is not None:
                    yield from self._pulled(graph, None)
                graph = _to_grey(frame)
            yield from self._pulled(graph, frame)
        if graph is not None:
            yield from self._pulled(graph, None)

    def close(self) -> None:
        """Let go of the file."""
        self._container.close()

    def _decoded(self) -> Iterator[VideoFrame]:
        packets = self._container.demux(self._stream)
        while True:
            try:
                packet = next(packets, None)
            except av.FFmpegError:  # nothing after this can be read
                return
            if packet is None:
                return
            try:
                frames = packet.decode()
            except av.FFmpegError:
                self.damaged += 1
                continue
            yield from (frame for frame in frames if isinstance(frame, VideoFrame))

    def _pulled(self, graph: Graph, frame: VideoFrame | None) -> Iterator[tuple[float | None, Image]]:
        """Push a frame, or the end, and yield what the graph has ready."""
        graph.vpush(frame)
        while True:
            try:
                grey = graph.vpull()
            except (av.BlockingIOError, av.EOFError):
                return
            yield grey.time, self._upright(grey)

    def _upright(self, frame: VideoFrame) -> Image:
        """Return the picture of a grey frame, turned and mirrored as its display matrix says."""
        for name, (flat, problem) in SIDE_DATA.items():
            if any(kind not in flat for kind in _side_data(frame, name)[:1]):
                self._refuse(problem)
        # A point (x, y) is shown at (xx x + xy y, yx x + yy y), with y downward.
        xx, yx, _, xy, yy = _side_data(frame, "DISPLAYMATRIX")[:5] or (1, 0, 0, 0, 1)
        picture, pixel_aspect = frame.to_ndarray(), self._pixel_aspect
        if not xx and not yy:
            picture, xx, yy, xy, yx, pixel_aspect = picture.T, xy, yx, 0, 0, 1 / pixel_aspect
        if xy or yx or not xx or not yy:
            self._refuse("its display matrix is no quarter turn and no mirror; turn it by: ffmpeg -i FILE TURNED.mp4")
        self.size = (round(picture.shape[1] * pixel_aspect), picture.shape[0])
        return np.ascontiguousarray(picture[:: -1 if yy < 0 else 1, :: -1 if xx < 0 else 1])

    def _check_opaque(self, frame: VideoFrame) -> None:
        if frame.to_ndarray(format="rgba")[:, :, 3].min() < 255:
            self._refuse(TRANSPARENT)

    def _refuse(self, problem: str) -> NoReturn:
        raise UsageError(f"{self._path}: {problem}")


def _side_data(frame: VideoFrame, name: str) -> list[int]:
    """Return what a frame says beside its picture, as whole numbers; empty if it has no data of this name."""
    data = cast(SideData | None, frame.side_data.get(name))
    return [] if data is None else np.frombuffer(bytes(data), "<i4").tolist()


def _to_grey(frame: VideoFrame) -> Graph:
    """Return a graph of FFmpeg's filters that makes grey levels from 0 to 255 of frames like this one."""
    graph = Graph()
    filters = [
        graph.add_buffer(width=frame.width, height=frame.height, format=frame.format, time_base=frame.time_base),
        graph.add("bwdif", "mode=send_frame:deint=interlaced"),
        graph.add("scale", "sws_dither=none"),
        graph.add("format", "pix_fmts=gray"),
    ]
    if frame.format.name.startswith("gray") and frame.color_range == ColorRange.MPEG:
        # FFmpeg widens the range of every format with colours, and takes that of pure grey for wide already.
        filters.append(graph.add("lut", "c0=round((val-16)*255/219)"))
    graph.link_nodes(*filters, graph.add("buffersink"))
    graph.configure()
    return graph
