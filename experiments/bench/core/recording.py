"""What every Rerun recording is made of: a file, a layout, timelines, pictures, and what models answered.

The only module that uses what Rerun keeps to itself: see `save`.
"""

from __future__ import annotations

import dataclasses
import tempfile
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, Protocol

import cv2
import numpy as np
import numpy.typing as npt
import rerun as rr
import rerun.blueprint as rrb
import rerun_bindings

from dsnn import ResponseSeries
from dsnn.model import SPIKING

APPLICATION = "colias-sim"
ROBOT_RADIUS_CM = 2.0
Floats = npt.NDArray[np.float64]
Images = npt.NDArray[np.uint8]
LIMIT_COLOUR = (140, 140, 140)
Colour = tuple[int, int, int]
HS_COLOURS: tuple[Colour, ...] = (
    (31, 119, 180), (44, 160, 44), (148, 103, 189), (23, 190, 207), (100, 100, 100)
)  # fmt: skip
VS_COLOURS: tuple[Colour, ...] = (
    (214, 124, 30), (214, 39, 40), (227, 119, 194), (188, 189, 34), (160, 160, 160)
)  # fmt: skip
LOOMING_COLOURS: tuple[Colour, ...] = ((180, 30, 60), (120, 60, 20), (90, 0, 120), (0, 90, 90), (60, 60, 60))
COLOURS = {"hs": HS_COLOURS, "vs": VS_COLOURS, "looming": LOOMING_COLOURS, "azimuth": HS_COLOURS}
"""Channel -> the colours of the first model's line, the second's, ..."""


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
    with tempfile.TemporaryDirectory(prefix="colias-") as folder:
        path = Path(folder) / "recording.rrd"
        _write(path, write, layout, name, identity)
        # Of streams that nobody holds any more Rerun keeps all that they were sent (rerun#2116), until it is
        # initialised again; like this that does nothing else.
        rr.init(APPLICATION, init_logging=False)
        return path.read_bytes()


def _write(
    path: Path, write: Callable[[rr.RecordingStream], None], layout: rrb.Blueprint, name: str, identity: str | None
) -> None:
    stream = rr.RecordingStream(APPLICATION, recording_id=identity)
    save(stream, path, layout)
    stream.send_recording_name(name)
    write(stream)
    stream.flush()
    stream.disconnect()


def save(stream: rr.RecordingStream, path: Path, layout: rrb.Blueprint) -> None:
    """Do what ``stream.save(path, layout)`` does, and then end the layout's own stream.

    That call leaves it alive, with two threads, in every recording made: a worker would collect thousands. It cannot
    be reached from outside. So this does the same by the functions that Rerun 0.41 itself does it by, which are not
    meant for others; ``tests/test_recording.py`` tells when they have moved.
    """
    own = rr.RecordingStream._from_native(
        rerun_bindings.new_blueprint(
            application_id=APPLICATION, make_default=False, make_thread_default=False, default_enabled=True
        )
    )
    own.set_time("blueprint", sequence=0)
    layout._log_to_stream(own)
    memory: Any = own.memory_recording()
    rerun_bindings.save(path=str(path), default_blueprint=memory.storage, recording=stream.to_native())
    own.disconnect()


def timelines(sim_time_s: Floats, frame: npt.NDArray[np.int64]) -> list[rr.TimeColumn]:
    """Time and number of each frame, (T,), the timelines of every recording."""
    return [rr.TimeColumn("sim_time", duration=sim_time_s), rr.TimeColumn("frame", sequence=frame)]


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
    """What a model answered to the frames of a recording."""

    @property
    def model(self) -> str:
        """Its name."""
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


@dataclasses.dataclass(frozen=True, slots=True)
class Line:
    """A line of a recording's plots: where it is logged, its title, its colour, the `dsnn.Response` field it shows."""

    entity: str
    title: str
    colour: Colour
    field: str


def lines(model: str, channels: Sequence[str], place: int, several: bool) -> list[Line]:
    """The lines of the declared channels of the model at ``place``; titles name the model where there are several."""
    name, prefix = rr.escape_entity_path_part(model), f"{model} " if several else ""
    made = []
    for channel in channels:
        colour, title = COLOURS[channel][place % 5], channel.upper() if channel in ("hs", "vs") else channel
        if channel not in SPIKING:
            made.append(Line(f"{channel}/{name}", f"{prefix}{title}", colour, channel))
            continue
        made.append(Line(f"potential/{name}/{channel}", f"{prefix}{title}", colour, channel))
        made.append(Line(f"spikes/{name}/{channel}", f"{prefix}{title} spikes", colour, f"{channel}_spikes"))
    return made


def levels(thresholds: Iterable[Mapping[str, float | None]]) -> list[float]:
    """The thresholds to draw, lowest first: of either sign for HS and VS, of looming the positive one alone."""
    signs = {"hs": (1, -1), "vs": (1, -1), "looming": (1,)}
    known = [(signs[c], level) for own in thresholds for c, level in own.items() if c in signs and level is not None]
    return sorted({sign * level for both, level in known for sign in both})


def level_entity(level: float) -> str:
    """Where the line of a threshold is logged."""
    return f"potential/threshold/{'plus' if level > 0 else 'minus'}_{abs(level):g}".replace(".", "_")


def potentials(recording: rr.RecordingStream, answers: Sequence[Answered], time_s: Floats) -> None:
    """Potentials, spikes and azimuth of each model at ``time_s`` (T,), and their thresholds as grey lines."""
    frames = np.arange(len(time_s))
    times = timelines(time_s, frames)
    for place, answer in enumerate(answers):
        for line in lines(answer.model, answer.channels, place, len(answers) > 1):
            values = getattr(answer.series, line.field)
            style = rr.SeriesLines(colors=line.colour, names=line.title, widths=1.5)
            recording.log(line.entity, style, static=True)
            recording.send_columns(line.entity, times, rr.Scalars.columns(scalars=values.astype(float)))
    ends = timelines(time_s[[0, -1]], frames[[0, -1]])
    for level in levels(answer.thresholds for answer in answers):
        entity, name = level_entity(level), f"{'' if level > 0 else '-'}T = {level:g}"
        recording.log(entity, rr.SeriesLines(colors=LIMIT_COLOUR, names=name, widths=1.0), static=True)
        recording.send_columns(entity, ends, rr.Scalars.columns(scalars=[level, level]))


def plots(answers: Sequence[Answered]) -> rrb.Horizontal:
    """The views of `potentials`; one of the azimuth where a model declares it."""
    wide = rrb.ScalarAxis(range=(-1.05, 1.05))
    views = [
        rrb.TimeSeriesView(origin="potential", name="membrane potential", axis_y=wide),
        rrb.TimeSeriesView(origin="spikes", name="spikes per frame", axis_y=rrb.ScalarAxis(range=(-3.2, 3.2))),
    ]
    if any("azimuth" in answer.channels for answer in answers):
        views.append(rrb.TimeSeriesView(origin="azimuth", name="azimuth, -1 left to 1 right", axis_y=wide))
    return rrb.Horizontal(*views, column_shares=[3, 2, 2][: len(views)])
