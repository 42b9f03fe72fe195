"""Parts of every Rerun recording: a file, a layout, timelines, pictures, and what models answered.

The only module that uses what Rerun keeps to itself: see `send_layout`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, Protocol

import cv2
import numpy as np
import numpy.typing as npt
import rerun as rr
import rerun.blueprint as rrb
import rerun_bindings

from dsnn import ResponseSeries
from experiments.bench.figures.series import levels, lines

APPLICATION = "colias-sim"
ROBOT_RADIUS_CM = 2.0
Floats = npt.NDArray[np.float64]
Images = npt.NDArray[np.uint8]
LIMIT_COLOUR = (140, 140, 140)
TIMELINE = "sim_time"
"""The timeline that every layout opens with: seconds of a trial, an episode, a clip or a video."""
PAPER = rrb.archetypes.PlotBackground(color=(250, 250, 247), show_grid=False)
"""Background of plots: the palette is for a light background."""


def recorded(
    write: Callable[[rr.RecordingStream], None], layout: rrb.Blueprint, name: str, identity: str | None = None
) -> bytes:
    """Make a recording, whole, and leave neither memory nor threads of it behind.

    Parameters
    ----------
    write
        Logs everything to the stream that it is given.
    layout
        How a viewer opens it.
    name
        The recording's name for people.
    identity
        Tells it from others: a viewer merges recordings of one identity. Otherwise it is its own.

    Returns
    -------
    bytes
        Of an .rrd file.
    """
    try:
        return _written(write, layout, name, identity)
    finally:
        # Of streams that nobody holds any more Rerun keeps all that they were sent (rerun#2116), until it is
        # initialised again; like this that does nothing else.
        rr.init(APPLICATION, init_logging=False)


def _written(
    write: Callable[[rr.RecordingStream], None], layout: rrb.Blueprint, name: str, identity: str | None
) -> bytes:
    stream = rr.RecordingStream(APPLICATION, recording_id=identity)
    # In memory, not in a file: on a full disk a flush of Rerun's own writer of files may never return.
    memory = stream.memory_recording()
    try:
        send_layout(stream, layout)
        stream.send_recording_name(name)
        write(stream)
        return memory.drain_as_bytes()
    finally:
        stream.disconnect()


def send_layout(stream: rr.RecordingStream, layout: rrb.Blueprint) -> None:
    """Do what ``stream.send_blueprint`` does, and then end the layout's own stream.

    That call leaves it alive, with two threads, in every recording made: a worker would collect thousands. It cannot
    be reached from outside. So this does the same by the functions that Rerun 0.41 itself does it by, which are not
    meant for others; ``tests/bench/engine/test_recording.py`` tells when they have moved.
    """
    blueprint_stream = rr.RecordingStream._from_native(
        rerun_bindings.new_blueprint(
            application_id=APPLICATION, make_default=False, make_thread_default=False, default_enabled=True
        )
    )
    blueprint_stream.set_time("blueprint", sequence=0)
    layout._log_to_stream(blueprint_stream)
    memory: Any = blueprint_stream.memory_recording()
    rerun_bindings.send_blueprint(memory.storage, False, True, recording=stream.to_native())
    blueprint_stream.disconnect()


def timelines(sim_time_s: Floats, frame: npt.NDArray[np.int64]) -> list[rr.TimeColumn]:
    """Time and number of each frame, (T,), the timelines of every recording."""
    return [rr.TimeColumn(TIMELINE, duration=sim_time_s), rr.TimeColumn("frame", sequence=frame)]


def video(recording: rr.RecordingStream, entity: str, images: Images, times: list[rr.TimeColumn]) -> None:
    """Grey frames, (T, R, C)."""
    count, rows, columns = images.shape
    shape = rr.components.ImageFormat(width=columns, height=rows, color_model="L", channel_datatype="U8")
    recording.log(entity, rr.Image.from_fields(format=shape), static=True)
    recording.send_columns(entity, times, rr.Image.columns(buffer=images.reshape(count, -1)))


def jpegs(recording: rr.RecordingStream, entity: str, images: Images, times: list[rr.TimeColumn], quality: int) -> None:
    """Grey frames, (T, R, C), as JPEG of a ``quality`` up to 100."""
    blobs = [cv2.imencode(".jpg", image, [cv2.IMWRITE_JPEG_QUALITY, quality])[1].tobytes() for image in images]
    recording.log(entity, rr.EncodedImage.from_fields(media_type="image/jpeg"), static=True)
    recording.send_columns(entity, times, rr.EncodedImage.columns(blob=blobs))


class Answered(Protocol):
    """Answers of a model to the frames of a recording."""

    @property
    def model(self) -> str:
        """Return the model's name."""
        ...

    @property
    def channels(self) -> tuple[str, ...]:
        """The channels that it declares: these are drawn, whatever their values."""
        ...

    @property
    def thresholds(self) -> Mapping[str, float | None]:
        """Each channel's spiking threshold on its potential, if it has one."""
        ...

    @property
    def series(self) -> ResponseSeries:
        """An entry for each frame."""
        ...


def potentials(recording: rr.RecordingStream, answers: Sequence[Answered], time_s: Floats) -> None:
    """Potentials, spikes and azimuth of each model at ``time_s`` (T,), and their thresholds as grey lines."""
    frames = np.arange(len(time_s))
    times, models = timelines(time_s, frames), [answer.model for answer in answers]
    for answer in answers:
        for line in lines(answer.model, answer.channels, models):
            values = getattr(answer.series, line.field)
            recording.log(line.entity, line.style(), static=True)
            recording.send_columns(line.entity, times, rr.Scalars.columns(scalars=values.astype(float)))
    ends = timelines(time_s[[0, -1]], frames[[0, -1]])
    for level in levels({answer.model: answer.thresholds for answer in answers}):
        recording.log(level.entity, level.style(), level.owners(), static=True)
        recording.send_columns(level.entity, ends, rr.Scalars.columns(scalars=[level.value, level.value]))


def plot(origin: str, name: str, limit: float | None = None) -> rrb.TimeSeriesView:
    """Return a view of the series below ``origin``, from ``-limit`` to ``limit`` where there is one."""
    axis = None if limit is None else rrb.ScalarAxis(range=(-limit, limit))
    return rrb.TimeSeriesView(origin=origin, name=name, axis_y=axis, background=PAPER)


def plots(channels: Iterable[str]) -> rrb.Horizontal:
    """Return the views of `potentials`; one of the azimuth where a model declares it among its ``channels``."""
    views = [plot("potential", "membrane potential", 1.05), plot("spikes", "spikes per frame", 3.2)]
    if "azimuth" in channels:
        views.append(plot("azimuth", "azimuth, -1 left to 1 right", 1.05))
    return rrb.Horizontal(*views, column_shares=[3, 2, 2][: len(views)])


def page(*views: rrb.View | rrb.Container, shares: Sequence[float]) -> rrb.Blueprint:
    """Return a layout that opens ready to read: ``views`` below each other, and the timeline."""
    return rrb.Blueprint(
        rrb.Vertical(*views, row_shares=list(shares)),
        rrb.TimePanel(state="collapsed", timeline=TIMELINE),
        collapse_panels=True,
    )
