"""One Rerun recording per trial. With `log_clip` and `log_live`, the only importer of rerun.

Everything is sent in columns when the trial is over, and the file is whole before it gets its place in a run:
cheap per frame, and a crash costs at most the trial under way.
"""

from __future__ import annotations

import dataclasses
import hashlib
import math
import tempfile
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt
import rerun as rr
import rerun.blueprint as rrb
import rerun_bindings

from colias_sim.config import CameraConfig
from dsnn import ResponseSeries
from dsnn.model import SPIKING
from experiments.bench.media import Images, Media
from experiments.bench.results import recording_name
from experiments.bench.trial import TrialResult
from scenes import ARENA_RADIUS_CM

APPLICATION = "colias-sim"
Floats = npt.NDArray[np.float64]
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

ROBOT_RADIUS_CM, ROBOT_HEIGHT_CM = 2.0, 3.0
MAP_TITLES = {"p": "retina P", "la": "lamina LA", "f_on": "ON after FDSR", "f_off": "OFF after FDSR"}


def record(result: TrialResult) -> bytes:
    """The recording of one finished trial, as the bytes of an .rrd file.

    Raises ``ValueError`` if the trial kept no media.
    """
    if result.media is None:
        raise ValueError(f"trial {result.spec.index} kept no media to record")
    with tempfile.TemporaryDirectory(prefix="colias-") as folder:
        path = Path(folder) / recording_name(result.spec.index)
        _write(path, result, result.media)
        rerun_bindings.flush_and_cleanup_orphaned_recordings()  # or Rerun keeps megabytes a trial (rerun#2116)
        return path.read_bytes()


def _write(path: Path, result: TrialResult, media: Media) -> None:
    recording = rr.RecordingStream(APPLICATION, recording_id=_identity(result))
    save(recording, path, blueprint(result))
    _properties(recording, result)
    times = timelines(result.columns.sim_time_s, np.arange(result.frames))
    for entity, images in {"camera": media.camera, **{f"maps/{k}": v for k, v in media.maps.items()}}.items():
        video(recording, entity, images, times)
    potentials(recording, result.answers, result.columns.sim_time_s)
    _scene(recording, result, times)
    recording.flush()
    recording.disconnect()


def save(recording: rr.RecordingStream, path: Path, layout: rrb.Blueprint) -> None:
    """What ``recording.save(path, layout)`` does, and then ends the layout's own stream.

    That call leaves it alive, with two threads, in every recording made: a worker would collect thousands.
    """
    own = rr.RecordingStream._from_native(
        rerun_bindings.new_blueprint(
            application_id=APPLICATION, make_default=False, make_thread_default=False, default_enabled=True
        )
    )
    own.set_time("blueprint", sequence=0)
    layout._log_to_stream(own)
    memory: Any = own.memory_recording()
    rerun_bindings.save(path=str(path), default_blueprint=memory.storage, recording=recording.to_native())
    own.disconnect()


def _identity(result: TrialResult) -> str:
    """Equal for equal trials alone: the viewer merges recordings of one identity."""
    digest = hashlib.blake2s(repr(result.spec).encode(), digest_size=6).hexdigest()
    return f"{result.spec.experiment}-{result.spec.index:04d}-{digest}"


def timelines(sim_time_s: Floats, frame: npt.NDArray[np.int64]) -> list[rr.TimeColumn]:
    """Time and number of each frame, (T,), the timelines of every recording."""
    return [rr.TimeColumn("sim_time", duration=sim_time_s), rr.TimeColumn("frame", sequence=frame)]


def _properties(recording: rr.RecordingStream, result: TrialResult) -> None:
    """The trial's conditions and outcome, which the viewer shows as the recording's properties."""
    spec, condition = result.spec, result.spec.condition
    values: dict[str, Any] = {
        "experiment": spec.experiment,
        "trial": spec.index,
        "repeat": spec.repeat,
        "seed": spec.seed,
        **{name: value for name, value in dataclasses.asdict(condition).items() if value is not None},
        **{f"{answer.model}_spikes": answer.spikes for answer in result.answers},
        "achieved_speed_cm_s": result.achieved_speed_cm_s,
        "path_error_mm": result.path_error_mm,
    }
    recording.send_recording_name(f"{spec.index:04d} {condition.label()}, repeat {spec.repeat}")
    recording.send_property("trial", rr.AnyValues(**values))


def video(recording: rr.RecordingStream, entity: str, images: Images, times: list[rr.TimeColumn]) -> None:
    """Grey frames, (T, R, C)."""
    count, rows, columns = images.shape
    shape = rr.components.ImageFormat(width=columns, height=rows, color_model="L", channel_datatype="U8")
    recording.log(entity, rr.Image.from_fields(format=shape), static=True)
    recording.send_columns(entity, times, rr.Image.columns(buffer=images.reshape(count, -1)))


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


def _scene(recording: rr.RecordingStream, result: TrialResult, times: list[rr.TimeColumn]) -> None:
    """Both robots in centimetres: the observer at the origin with its view, the stimulus moving."""
    columns, camera = result.columns, result.spec.settings.camera
    recording.log("scene", rr.ViewCoordinates.RIGHT_HAND_Z_UP, static=True)
    recording.log("scene/floor", _floor(), static=True)
    recording.log("scene/observer", _body((46, 120, 80)), static=True)
    recording.log(
        "scene/observer/eye",
        rr.Transform3D(translation=[camera.forward_cm, 0, camera.up_cm], mat3x3=[[0, 0, 1], [-1, 0, 0], [0, -1, 0]]),
        rr.Pinhole(
            resolution=[camera.width, camera.height], focal_length=camera.focal_px, image_plane_distance=_plane(camera)
        ),
        static=True,
    )
    recording.log("scene/stimulus", _body((25, 25, 25)), static=True)
    _move(
        recording, "scene/observer", columns.observer_x_cm, columns.observer_y_cm, columns.observer_heading_deg, times
    )
    _move(
        recording, "scene/stimulus", columns.stimulus_x_cm, columns.stimulus_y_cm, columns.stimulus_heading_deg, times
    )
    path = np.column_stack([columns.stimulus_x_cm, columns.stimulus_y_cm, np.zeros(result.frames)])
    recording.log("scene/path", rr.LineStrips3D([path], colors=[LIMIT_COLOUR], radii=[0.05]), static=True)


def _move(
    recording: rr.RecordingStream, entity: str, x: Floats, y: Floats, heading: Floats, times: list[rr.TimeColumn]
) -> None:
    half, zero = np.radians(heading) / 2, np.zeros_like(x)
    place, turn = np.column_stack([x, y, zero]), np.column_stack([zero, zero, np.sin(half), np.cos(half)])
    recording.send_columns(entity, times, rr.Transform3D.columns(translation=place, quaternion=turn))


def _plane(camera: CameraConfig) -> float:
    """How far out to draw the view: near enough to leave the stimulus visible."""
    return 4.0 / max(1.0, camera.width / camera.focal_px)


def _body(colour: tuple[int, int, int]) -> rr.Cylinders3D:
    return rr.Cylinders3D(
        lengths=[ROBOT_HEIGHT_CM],
        radii=[ROBOT_RADIUS_CM],
        centers=[[0, 0, ROBOT_HEIGHT_CM / 2]],
        colors=[colour],
        fill_mode="solid",
    )


def _floor() -> rr.LineStrips3D:
    circles: list[npt.NDArray[np.float64]] = []
    for radius in (10.0, 20.0, ARENA_RADIUS_CM):
        turn = np.linspace(0, 2 * math.pi, 65)
        circles.append(np.column_stack([radius * np.cos(turn), radius * np.sin(turn), np.zeros_like(turn)]))
    return rr.LineStrips3D(circles, colors=[LIMIT_COLOUR], radii=[0.05])


def blueprint(result: TrialResult) -> rrb.Blueprint:
    """A layout that opens ready to read: what the robot sees, where things are, what the network says."""
    views = [
        rrb.Horizontal(
            rrb.Spatial2DView(origin="camera", name="camera (Y, 8 bit)"),
            rrb.Spatial3DView(
                origin="scene",
                name="arena (cm)",
                background=(214, 214, 210),
                eye_controls=rrb.EyeControls3D(position=(-13, -9, 12), look_target=(6, 0, 0), eye_up=(0, 0, 1)),
            ),
            column_shares=[2, 3],
        ),
        plots(result.answers),
    ]
    if result.media is not None and result.media.maps:
        maps = [rrb.Spatial2DView(origin=f"maps/{name}", name=MAP_TITLES[name]) for name in result.media.maps]
        views.append(rrb.Horizontal(*maps))
    return rrb.Blueprint(
        rrb.Vertical(*views, row_shares=[3, 2, 2][: len(views)]),
        rrb.TimePanel(state="collapsed", timeline="sim_time"),
        collapse_panels=True,
    )
