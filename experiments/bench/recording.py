"""Parts of every Rerun recording: a file, a layout, timelines, pictures, and what models answered.

The only module that uses what Rerun keeps to itself: see `send_layout`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, Protocol

import cv2
import numpy as np
import numpy.typing as npt
import rerun as rr
import rerun.blueprint as rrb
import rerun_bindings

from dsnn import ResponseSeries
from experiments.bench.figures.series import Colour, Level, ends, heading, levels, lines
from experiments.bench.run.models import ConfiguredModel

APPLICATION = "colias-sim"
ROBOT_RADIUS_CM = 2.0
OBSERVER_COLOUR, OTHER_COLOUR = (46, 120, 80), (25, 25, 25)
"""Colours of robots where they are discs: in views from above."""
Floats = npt.NDArray[np.float64]
Images = npt.NDArray[np.uint8]
TIMELINE = "sim_time"
"""The timeline that every layout opens with: seconds of a trial, an episode, a clip or a video."""
PAPER = rrb.archetypes.PlotBackground(color=(250, 250, 247), show_grid=False)
"""Background of plots: the palette is for a light background."""
LINKED = rrb.TimeAxis(link="LinkToGlobal")
"""Axis of time of every plot: to zoom one is to zoom all."""
MOST_LANES = 6
"""Lanes below each other; more are in columns."""
MOST_WIDE = 2
"""Columns in which the whole heading of a lane can be read."""


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
    describe_video(recording, entity, images.shape[1:])
    send_video(recording, entity, images, times)


def describe_video(recording: rr.RecordingStream, entity: str, shape: tuple[int, ...]) -> None:
    """Log what stays of grey frames (R, C)."""
    recording.log(entity, rr.Image.from_fields(format=_format(shape)), static=True)


def send_video(recording: rr.RecordingStream, entity: str, images: Images, times: list[rr.TimeColumn]) -> None:
    """Log grey frames, (T, R, C), after `describe_video`."""
    recording.send_columns(entity, times, rr.Image.columns(buffer=images.reshape(len(images), -1)))


def _format(shape: tuple[int, ...]) -> rr.components.ImageFormat:
    rows, columns = shape
    return rr.components.ImageFormat(width=columns, height=rows, color_model="L", channel_datatype="U8")


def describe_coloured(
    recording: rr.RecordingStream, entity: str, shape: tuple[int, ...], colours: tuple[Colour, ...]
) -> None:
    """Log what stays of pictures (R, C) whose 256 values are shown in ``colours``: a byte a pixel, as of grey ones."""
    recording.log(entity, _context(colours), static=True)
    recording.log(entity, rr.SegmentationImage.from_fields(format=_format(shape), opacity=1.0), static=True)


@lru_cache
def _context(colours: tuple[Colour, ...]) -> rr.AnnotationContext:
    """Return what says which value has which colour; made once, as that takes as long as all else of a recording."""
    return rr.AnnotationContext(
        [rr.AnnotationInfo(id=value, color=colour) for value, colour in enumerate(colours)]
    )  # fmt: skip


def send_coloured(recording: rr.RecordingStream, entity: str, images: Images, times: list[rr.TimeColumn]) -> None:
    """Log pictures, (T, R, C), after `describe_coloured`."""
    recording.send_columns(entity, times, rr.SegmentationImage.columns(buffer=images.reshape(len(images), -1)))


def jpegs(recording: rr.RecordingStream, entity: str, images: Images, times: list[rr.TimeColumn], quality: int) -> None:
    """Grey frames, (T, R, C), as JPEG of a ``quality`` up to 100."""
    blobs = [cv2.imencode(".jpg", image, [cv2.IMWRITE_JPEG_QUALITY, quality])[1].tobytes() for image in images]
    recording.log(entity, rr.EncodedImage.from_fields(media_type="image/jpeg"), static=True)
    recording.send_columns(entity, times, rr.EncodedImage.columns(blob=blobs))


class Answering(Protocol):
    """A model whose answers a recording shows."""

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


class Answered(Answering, Protocol):
    """Answers of a model to the frames of a recording."""

    @property
    def series(self) -> ResponseSeries:
        """An entry for each frame."""
        ...


@dataclass(frozen=True, slots=True)
class Model:
    """A model as recordings have it: see `Answering`."""

    model: str
    channels: tuple[str, ...]
    thresholds: Mapping[str, float | None]


@dataclass(frozen=True, slots=True)
class ModelResponses(Model):
    """A model as recordings have it, with its responses."""

    series: ResponseSeries


def responses_of(answers: Iterable[tuple[ConfiguredModel, ResponseSeries]]) -> list[ModelResponses]:
    """Return models as recordings have them, with their responses."""
    return [ModelResponses(model.label, model.channels, model.thresholds, series) for model, series in answers]


def described(models: Iterable[ConfiguredModel]) -> list[Model]:
    """Return models as recordings have them."""
    return [Model(model.label, model.channels, model.thresholds) for model in models]


def potentials(recording: rr.RecordingStream, answers: Sequence[Answered], time_s: Floats) -> None:
    """Log potentials, thresholds, spikes and azimuth of each model at ``time_s``, (T,)."""
    describe_answers(recording, answers)
    frames, models = np.arange(len(time_s)), [answer.model for answer in answers]
    for answer in answers:
        send_answers(recording, answer, models, answer.series, time_s, frames)
    send_thresholds(recording, answers, time_s[[0, -1]], frames[[0, -1]])


def describe_answers(recording: rr.RecordingStream, answering: Sequence[Answering]) -> None:
    """Log the looks of the models' series, and of their thresholds."""
    models = [answer.model for answer in answering]
    for answer in answering:
        for line in lines(answer.model, answer.channels, models):
            if line.shown:
                recording.log(line.entity, line.style(), static=True)
    for level in _levels(answering):
        recording.log(level.entity, level.style(), level.owners(), static=True)


def send_answers(
    recording: rr.RecordingStream, answering: Answering, models: Sequence[str], series: ResponseSeries, time_s: Floats,
    frames: npt.NDArray[np.int64],
) -> None:  # fmt: skip
    """Log a model's answers.

    Parameters
    ----------
    recording
        The stream.
    answering
        The model.
    models
        The labels of all models of the recording.
    series
        Its answers, T of them.
    time_s, frames
        Time and number of each, (T,).
    """
    times = timelines(time_s, frames)
    for line in lines(answering.model, answering.channels, models):
        values = getattr(series, line.field)
        if line.row is None:
            recording.send_columns(line.entity, times, rr.Scalars.columns(scalars=values.astype(float)))
        elif (fired := values != 0).any():
            heights = line.row * np.sign(values[fired])
            recording.send_columns(
                line.entity, timelines(time_s[fired], frames[fired]), rr.Scalars.columns(scalars=heights)
            )


def send_thresholds(
    recording: rr.RecordingStream, answering: Sequence[Answering], time_s: Floats, frames: npt.NDArray[np.int64]
) -> None:
    """Log the models' thresholds at the two ends of a span of time, (2,): a line through them is drawn."""
    for level in _levels(answering):
        columns = rr.Scalars.columns(scalars=[level.value, level.value])
        recording.send_columns(level.entity, timelines(time_s, frames), columns)


def _levels(answering: Sequence[Answering]) -> list[Level]:
    return levels({answer.model: answer.thresholds for answer in answering})


def plot(origin: str, name: str, limit: float | None = None, *, legend: bool = False) -> rrb.TimeSeriesView:
    """Return a view of the series below ``origin``, from ``-limit`` to ``limit`` where there is one.

    A ``legend`` covers a part of the traces: it is for series that no heading can name.
    """
    axis = None if limit is None else rrb.ScalarAxis(range=(-limit, limit))
    key = rrb.PlotLegend(rrb.Corner2D.LeftTop, visible=legend)
    return rrb.TimeSeriesView(
        origin=origin, name=name, axis_x=LINKED, axis_y=axis, background=PAPER, plot_legend=key
    )  # fmt: skip


def lanes(answering: Sequence[Answering], run: str = "") -> rrb.Container | rrb.TimeSeriesView:
    """Return the views of `potentials`: a lane for each model, all of one axis of time.

    Parameters
    ----------
    answering
        The models.
    run
        The name below which their series are, and which headings begin with; empty: at the root.

    Returns
    -------
    rerun.blueprint.Container or rerun.blueprint.TimeSeriesView
        Lanes below each other, in columns where they are many.
    """
    columns = -(-len(answering) // MOST_LANES)
    height = -(-len(answering) // columns)
    views = [_lane(answer, run, narrow=columns > MOST_WIDE) for answer in answering]
    stacks = [views[first : first + height] for first in range(0, len(views), height)]
    stacked = [rrb.Vertical(*stack) if len(stack) > 1 else stack[0] for stack in stacks]
    return rrb.Horizontal(*stacked) if len(stacked) > 1 else stacked[0]


def _lane(answer: Answering, run: str, *, narrow: bool) -> rrb.TimeSeriesView | rrb.Horizontal:
    """Return the lane of a model, with its azimuth beside it where it has one; a ``narrow`` one is named briefly."""
    root, prefix = (f"/{rr.escape_entity_path_part(run)}", f"{run}: ") if run else ("", "")
    name = rr.escape_entity_path_part(answer.model)
    lane = rrb.TimeSeriesView(
        origin=f"{root}/potential/{name}",
        contents=[f"{root}/{part}/{name}/**" for part in ("potential", "threshold", "raster")],
        name=prefix + heading(answer.model, answer.channels, answer.thresholds, narrow=narrow),
        axis_x=LINKED,
        axis_y=rrb.ScalarAxis(range=ends(answer.channels), zoom_lock=True),
        background=PAPER,
        plot_legend=rrb.PlotLegend(visible=False),
    )
    if "azimuth" not in answer.channels:
        return lane
    azimuth = plot(f"{root}/azimuth/{name}", f"{prefix}{answer.model}: azimuth, -1 left to 1 right", 1.05)
    return rrb.Horizontal(lane, azimuth, column_shares=[3, 1])


def page(*views: rrb.View | rrb.Container, shares: Sequence[float]) -> rrb.Blueprint:
    """Return a layout that opens ready to read: ``views`` below each other, and the timeline."""
    return rrb.Blueprint(
        rrb.Vertical(*views, row_shares=list(shares)),
        rrb.TimePanel(state="collapsed", timeline=TIMELINE),
        collapse_panels=True,
    )
