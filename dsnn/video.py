"""Read video files as a player shows them, with their orientation, fields and pixel shape, by PyAV."""

from __future__ import annotations

import os
from collections.abc import Iterator
from typing import Any, NoReturn

import av
import numpy as np
import numpy.typing as npt
from av.filter import Graph
from av.sidedata.sidedata import Type
from av.stream import Disposition
from av.video.frame import VideoFrame
from av.video.reformatter import ColorRange
from av.video.stream import VideoStream

from dsnn.files import USUAL_FPS, check_single, check_white

Image = npt.NDArray[np.uint8]

FASTEST = 1000.0
"""Highest credible frame rate. Files without a rate report absurd numbers."""
TRANSPARENT = "parts of it are transparent, and nothing says what is behind; put it onto a background first"
SIDE_DATA = {
    "STEREO3D": ((0, 8), "it has a picture for each eye; take one, for example by ffmpeg's filter stereo3d"),
    "SPHERICAL": ((4,), "it shows a sphere; cut a flat view out of it, for example by ffmpeg's filter v360"),
}
"""Kind of a frame's side data -> its values for flat pictures, and the message for others."""
NAMELESS = sorted(set(range(40)) - {kind.value for kind in Type})
"""Kinds of side data that PyAV does not know, such as EXIF (31): it reads none of a frame's where there is one."""
NO_TRACK = Disposition.attached_pic | Disposition.timed_thumbnails | Disposition.still_image | Disposition.dependent
"""What a file may have beside its films: covers, and parts of another track."""
TO_SCREEN = "convert them: ffmpeg -i FILE -vf zscale=t=linear:npl=203,format=gbrpf32le,zscale=t=bt709 SDR.mp4"
NO_SCREEN = {8: "linear", 9: "logarithmic", 10: "logarithmic", 16: "HDR (PQ)", 18: "HDR (HLG)", 256: "V-Log"}
"""Transfer functions (ITU-T H.273) whose white is not a screen's; as one they read far too dark."""


def read_video(path: str | os.PathLike[str]) -> Video:
    """Open a video file and iterate over its grey frames with their times.

    A video is read as a player shows it: rotated, mirrored and cut as the file specifies, with its range of grey
    levels. The two fields of an interlaced frame become one picture.

    Parameters
    ----------
    path
        Any file that FFmpeg decodes.

    Returns
    -------
    Video
        You can iterate over it once. It yields pairs: the time in s since the first frame, and the frame, (R, C) uint8.
        Pass it to a model's ``run``, and the series has the video's times.

    Raises
    ------
    ValueError
        The file is not a video, or it is transparent, stereoscopic, spherical, HDR, linear, logarithmic or rotated by
        an odd angle, or its white is unknown: of 16 bits, all dark, fewer may be meant.

    Examples
    --------
    >>> from dsnn import DSNN, DSNNParams, read_video
    >>> film = read_video("street.mp4")  # doctest: +SKIP
    >>> series = DSNN(film.shape, DSNNParams.offline()).run(film)  # doctest: +SKIP
    >>> series.time_s, series.hs  # doctest: +SKIP
    """
    film = Video(path)
    if film.deep:
        # A film of 12 bits may have 0 alone, below the black of a limited range.
        check_white(path, (max(int(image.max()), 1) / 255 for _, image in Video(path)))
    return film


class Video:
    """An open video file, made by `read_video`.

    Parameters
    ----------
    path
        Any file that FFmpeg decodes.

    Attributes
    ----------
    shape
        (R, C) of the first frame, px.
    size
        (width, height) of the latest frame as displayed, px. Pixels need not be square.
    fps
        Mean number of frames per second; ``None`` if the file does not specify it.
    length_s
        Duration of the pictures according to the file, s; 0 if it does not specify it.
    tracks
        Number of its films; the one that a player chooses is read.
    deep
        Whether its first frame has levels of 16 bits, which may be fewer that do not say so.
    interlaced, damaged
        Number of frames so far that had two fields, and that could not be decoded.

    Raises
    ------
    ValueError
        As of `read_video`.
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self._path = os.fspath(path)
        self.interlaced = self.damaged = 0
        try:
            self._container = av.open(f"file:{self._path}")  # without "file:" a name with a colon is taken for a URL
        except av.FFmpegError as error:
            raise ValueError(f"{self._path}: not a video that FFmpeg can decode ({error.strerror})") from None
        stream = self._container.streams.best("video")
        if not isinstance(stream, VideoStream) or stream.codec_context is None:
            self._refuse("not a video that FFmpeg can decode (it has no pictures, or an unknown codec)")
        if stream.metadata.get("alpha_mode") == "1":  # WebM: FFmpeg's own decoders ignore the transparency
            self._refuse(TRANSPARENT)
        if self._container.format.name == "image2" or self._container.format.name.endswith("_pipe"):
            check_single(self._path)
        stream.thread_type = "AUTO"
        self._stream, self._pixel_aspect = stream, float(stream.sample_aspect_ratio or 1)
        films = (one for one in self._container.streams.video if not one.disposition & NO_TRACK and one.frames != 1)
        self.tracks, self.deep = len(list(films)), False
        rate = float(stream.average_rate or stream.guessed_rate or 0)
        self.fps = rate if 0.0 < rate <= FASTEST else None
        # In MOV and MP4 edit lists skip frames.
        count = 0 if self._container.format.name.startswith("mov") else stream.frames
        self.length_s = count / (self.fps or USUAL_FPS) or float((stream.duration or 0) * (stream.time_base or 0))
        self._frames = self._upright()
        first = next(self._frames, None)
        if first is None:
            self._refuse("no frame could be decoded")
        self._first, self.shape = first, first[1].shape

    def __iter__(self) -> Iterator[tuple[float, Image]]:
        began_s, image = self._first
        now_s, usual_s = 0.0, 1.0 / (self.fps or USUAL_FPS)
        yield now_s, image
        for stamp_s, image in self._frames:
            later_s = 0.0 if stamp_s is None else stamp_s - (began_s or 0.0)
            now_s = later_s if later_s > now_s else now_s + usual_s  # raw streams have no time stamps
            yield now_s, image

    def _upright(self) -> Iterator[tuple[float | None, Image]]:
        """Yield the time stamp of each frame in s, or None, and its grey levels in display orientation."""
        graph: Graph | None = None
        form: tuple[object, ...] = ()
        codec, aspect = self._stream.codec_context, self._pixel_aspect
        may_change = self._stream.sample_aspect_ratio == codec.sample_aspect_ratio  # otherwise the container's counts
        for frame in self._decoded():
            transparent = any(component.is_alpha for component in frame.format.components)
            if transparent and frame.to_ndarray(format="rgba")[:, :, 3].min() < 255:
                self._refuse(TRANSPARENT)
            if frame.color_trc in NO_SCREEN:
                self._refuse(f"its levels are {NO_SCREEN[frame.color_trc]}; {TO_SCREEN}")
            self.interlaced += frame.interlaced_frame
            aspect = float(codec.sample_aspect_ratio or 1) if may_change else aspect
            before = form
            form = frame.width, frame.height, frame.format.name, frame.color_range, frame.color_trc, aspect
            if form != before:
                yield from self._filtered(graph, None)
                graph, self._pixel_aspect = _to_grey(frame), aspect
                self.deep |= any(component.bits == 16 for component in frame.format.components)
            yield from self._filtered(graph, frame)
        yield from self._filtered(graph, None)

    def _decoded(self) -> Iterator[VideoFrame]:
        for packet in self._container.demux(self._stream):
            try:
                frames: Any = packet.decode()
                yield from frames
            except av.FFmpegError:
                self.damaged += 1
        self._container.close()

    def _filtered(self, graph: Graph | None, frame: VideoFrame | None) -> Iterator[tuple[float | None, Image]]:
        """Push a frame, or the end, and yield the frames that the graph has ready."""
        if graph is None:
            return
        graph.vpush(frame)
        while True:
            try:
                grey = graph.vpull()
            except (av.BlockingIOError, av.EOFError):
                return
            yield grey.time, self._turned(grey)

    def _turned(self, frame: VideoFrame) -> Image:
        """Rotate and mirror the picture of a grey frame by its display matrix."""
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

    def _refuse(self, problem: str) -> NoReturn:
        raise ValueError(f"{self._path}: {problem}")


def _side_data(frame: VideoFrame, name: str) -> list[int]:
    """Read a frame's side data of this name as whole numbers; empty if there are none."""
    data: Any = frame.side_data.get(name)
    return [] if data is None else np.frombuffer(bytes(data), "<i4").tolist()


def _to_grey(frame: VideoFrame) -> Graph:
    """Make a graph of FFmpeg's filters that converts frames like this one to grey levels from 0 to 255."""
    graph = Graph()
    filters = [
        graph.add_buffer(width=frame.width, height=frame.height, format=frame.format, time_base=frame.time_base),
        *(graph.add("sidedata", f"mode=delete:type={kind}") for kind in NAMELESS),
        graph.add("bwdif", "mode=send_frame:deint=interlaced"),
        graph.add("scale", "sws_dither=none"),
        graph.add("format", "pix_fmts=gray"),
    ]
    if frame.format.name.startswith("gray") and frame.color_range == ColorRange.MPEG:
        # FFmpeg widens the range of every format with colours, and assumes that pure grey is wide already.
        filters.append(graph.add("lut", "c0=round((val-16)*255/219)"))
    graph.link_nodes(*filters, graph.add("buffersink"))
    graph.configure()
    return graph
