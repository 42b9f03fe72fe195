"""One Rerun recording per trial: what the robot sees, where things are, what models answer.

Everything is sent in columns when the trial is over, and the file is whole before it gets its place in a run:
cheap per frame, and a crash costs at most the trial under way.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Sequence
from functools import lru_cache, partial
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt
import rerun as rr
import rerun.blueprint as rrb

from colias_sim.config import CameraConfig, SceneConfig
from colias_sim.shapes import Shape, robot_shapes
from colias_sim.simulation import TRIAL_ROBOTS
from experiments.bench.figures.series import LIMIT_COLOUR, OFF, ON, STILL, Colour, mixed
from experiments.bench.recording import (
    MOST_LANES,
    Answering,
    describe_coloured,
    describe_video,
    lanes,
    page,
    plot,
    potentials,
    recorded,
    send_coloured,
    send_video,
    timelines,
)
from experiments.bench.sources import room
from experiments.bench.sources.experiment import TrialSpec
from experiments.bench.sources.media import MAP_SCALES, Media
from experiments.bench.sources.robot import FrameColumns, TrialResult, scene_of
from scenes import ARENA_RADIUS_CM, ARENAS

if TYPE_CHECKING:
    from colias_sim.obstacles import Obstacle

MAP_TITLES = {
    "p": "retina, change", "la": "lamina", "f_on": "ON", "f_off": "OFF"
}  # fmt: skip
MAP_FULL = {"p": 40.0, "la": 40.0, "f_on": 1.0, "f_off": 1.0}
"""Layer map -> the value, in its own unit, that has the full colour."""


def record(result: TrialResult) -> bytes:
    """The recording of one finished trial, as the bytes of an .rrd file.

    Raises ``ValueError`` if the trial kept no media.
    """
    if result.media is None:
        raise ValueError(f"trial {result.spec.index} kept no media to record")
    view = layout(result.media, result.answers)
    return recorded(partial(_write, result, result.media), view, title(result.spec), _identity(result))


def title(spec: TrialSpec) -> str:
    """Return the name of a trial's recording."""
    return f"{spec.index:04d} {spec.condition.label()}, repeat {spec.repeat}"


def _write(result: TrialResult, media: Media, recording: rr.RecordingStream) -> None:
    _properties(recording, result)
    describe_trial(recording, result.spec, media)
    send_frames(recording, media, result.columns, np.arange(result.frames))
    potentials(recording, result.answers, result.columns.sim_time_s)
    path = np.column_stack([result.columns.stimulus_x_cm, result.columns.stimulus_y_cm, np.zeros(result.frames)])
    recording.log("scene/path", rr.LineStrips3D([path], colors=[LIMIT_COLOUR], radii=[0.05]), static=True)


def describe_trial(recording: rr.RecordingStream, spec: TrialSpec, media: Media) -> None:
    """Log what stays of a trial: formats of its pictures, the arena, and what the robots look like, in cm."""
    for eye, images in media.pictures.items():
        describe_video(recording, eye_entity(eye), images.shape[1:])
    for name, images in media.maps.items():
        describe_coloured(recording, f"maps/{name}", images.shape[1:], map_colours(name))
    for eye in exposing(media):
        name = f"exposure time{f' of {eye}' if eye else ''}, ms; a row each {media.row_time_us[eye]:g} us"
        recording.log(f"exposure/{eye or 'camera'}", rr.SeriesLines(names=name, widths=1.5), static=True)
    camera, scene = spec.settings.camera, scene_of(spec.condition, spec.settings)
    recording.log("scene", rr.ViewCoordinates.RIGHT_HAND_Z_UP, static=True)
    recording.log("scene/floor", _floor(), static=True)
    if obstacles := room.obstacles(scene.arena):
        recording.log("scene/obstacles", _obstacles(obstacles), static=True)
    for robot in ("observer", "stimulus"):
        recording.log(f"scene/{robot}", *_look(TRIAL_ROBOTS[robot], scene), static=True)
    recording.log(
        "scene/observer/eye",
        rr.Transform3D(translation=[camera.forward_cm, 0, camera.up_cm], mat3x3=[[0, 0, 1], [-1, 0, 0], [0, -1, 0]]),
        rr.Pinhole(
            resolution=[camera.width, camera.height], focal_length=camera.focal_px, image_plane_distance=_plane(camera)
        ),
        static=True,
    )


def send_frames(
    recording: rr.RecordingStream, media: Media, columns: FrameColumns, frames: npt.NDArray[np.int64]
) -> None:
    """Log frames of a trial after `describe_trial`: pictures, exposure times, and where the robots are.

    Parameters
    ----------
    recording
        The stream.
    media
        The pictures, (T, R, C).
    columns
        Time and poses, (T,).
    frames
        The frames' numbers, (T,).
    """
    times = timelines(columns.sim_time_s, frames)
    for eye, images in media.pictures.items():
        send_video(recording, eye_entity(eye), images, times)
    for name, images in media.maps.items():
        send_coloured(recording, f"maps/{name}", images, times)
    for eye in exposing(media):
        scalars = rr.Scalars.columns(scalars=media.exposure_ms[eye])
        recording.send_columns(f"exposure/{eye or 'camera'}", times, scalars)
    for robot in ("observer", "stimulus"):
        x, y, heading = (getattr(columns, f"{robot}_{name}") for name in ("x_cm", "y_cm", "heading_deg"))
        half, zero = np.radians(heading) / 2, np.zeros_like(x)
        place, turn = np.column_stack([x, y, zero]), np.column_stack([zero, zero, np.sin(half), np.cos(half)])
        recording.send_columns(f"scene/{robot}", times, rr.Transform3D.columns(translation=place, quaternion=turn))


def eye_entity(eye: str) -> str:
    """Return where the frames of an eye are logged."""
    return f"camera_{eye}" if eye else "camera"


def exposing(media: Media) -> list[str]:
    """The eyes of which there is something to tell: a rolling shutter, or an exposure time that a loop controls."""
    return [eye for eye, exposure in media.exposure_ms.items() if media.row_time_us[eye] or np.ptp(exposure) > 0]


def _identity(result: TrialResult) -> str:
    """Equal for equal trials alone: the viewer merges recordings of one identity."""
    digest = hashlib.blake2s(repr(result.spec).encode(), digest_size=6).hexdigest()
    return f"{result.spec.experiment}-{result.spec.index:04d}-{digest}"


def _properties(recording: rr.RecordingStream, result: TrialResult) -> None:
    """The trial's conditions and outcome, which the viewer shows as the recording's properties."""
    spec, condition = result.spec, result.spec.condition
    values: dict[str, Any] = {
        "experiment": spec.experiment,
        "arena": arena if (arena := spec.settings.scene.arena) in ARENAS else None,  # no path of a user's own file
        "trial": spec.index,
        "repeat": spec.repeat,
        "seed": spec.seed,
        **condition.columns(),
        **{f"{answer.model}_spikes": answer.spikes for answer in result.answers},
        "achieved_speed_cm_s": result.achieved_speed_cm_s,
        "path_error_mm": result.path_error_mm,
        "drift_mm": result.drift_mm,
        "drive": result.drive,
    }
    recording.send_property(
        "trial", rr.AnyValues(**{name: value for name, value in values.items() if value is not None})
    )


def _plane(camera: CameraConfig) -> float:
    """Tell how far out to draw the view: near enough to leave the stimulus visible."""
    return 4.0 / max(1.0, camera.width / camera.focal_px)


@lru_cache
def _look(variant: str, scene: SceneConfig) -> tuple[rr.AsComponents, ...]:
    """Return the solids of a robot, in cm."""
    by_kind: dict[str, list[Shape]] = {}
    for shape in robot_shapes(variant, scene):
        by_kind.setdefault(shape.kind, []).append(shape)
    looks: list[rr.AsComponents] = []
    for kind, shapes in by_kind.items():
        half = 100 * np.array([shape.half_size for shape in shapes])
        placed: dict[str, Any] = {
            "centers": 100 * np.array([shape.centre for shape in shapes]),
            "quaternions": np.array([shape.turn for shape in shapes]),
            "colors": [shape.colour for shape in shapes],
            "fill_mode": "solid",
        }
        if kind == "cylinder":
            looks.append(rr.Cylinders3D(lengths=2 * half[:, 2], radii=half[:, 0], **placed))
        elif kind == "box":
            looks.append(rr.Boxes3D(half_sizes=half, **placed))
        else:
            looks.append(rr.Ellipsoids3D(half_sizes=half, **placed))
    return tuple(looks)


def _floor() -> rr.LineStrips3D:
    circles: list[npt.NDArray[np.float64]] = []
    for radius in (10.0, 20.0, ARENA_RADIUS_CM):
        turn = np.linspace(0, 2 * math.pi, 65)
        circles.append(np.column_stack([radius * np.cos(turn), radius * np.sin(turn), np.zeros_like(turn)]))
    return rr.LineStrips3D(circles, colors=[LIMIT_COLOUR], radii=[0.05])


def _obstacles(obstacles: Sequence[Obstacle]) -> rr.LineStrips3D:
    """Draw the outline of each obstacle on the floor and at its top, in cm."""
    strips = []
    for obstacle in obstacles:
        around = obstacle.closed_cm
        strips += [np.column_stack([around, np.full(len(around), z)]) for z in (0.0, 100 * obstacle.height)]
    return rr.LineStrips3D(strips, colors=[LIMIT_COLOUR], radii=[0.1])


@lru_cache
def map_colours(name: str) -> tuple[Colour, ...]:
    """Return the colours of a layer map's 256 values: warm where it became brighter, cool where darker, else dark."""
    gain, zero = MAP_SCALES[name]
    full = MAP_FULL[name]
    clipped = max(zero, 0.0)  # the values below are noise
    strength = [(value - clipped) / (gain * full) for value in range(256)]
    if name == "f_off":
        strength = [-share for share in strength]
    return tuple(mixed(STILL, ON if share > 0 else OFF, min(abs(share), 1.0)) for share in strength)


def arena_view(origin: str, name: str) -> rrb.Spatial3DView:
    """Return the view of both robots in their arena, from behind the observer."""
    eye = rrb.EyeControls3D(position=(-13, -9, 12), look_target=(6, 0, 0), eye_up=(0, 0, 1))
    return rrb.Spatial3DView(origin=origin, name=name, background=(214, 214, 210), eye_controls=eye)


def layout(media: Media, answering: Sequence[Answering]) -> rrb.Blueprint:
    """Return a layout that opens ready to read: where things are, what the robot sees, what the layers of the first
    model make of it, and beneath it what each model answers.
    """
    eyes = [
        rrb.Spatial2DView(origin=eye_entity(eye), name=f"what the robot sees{f' ({eye})' if eye else ''}")
        for eye in media.pictures
    ]
    top: list[rrb.View | rrb.Container] = [arena_view("scene", "arena (circles: 10, 20 and 45 cm)"), *eyes]
    shares = [5.0, *[4.0] * len(eyes)]
    if media.maps:
        whose = answering[0].model  # a trial keeps the layer maps of its first model
        maps = [rrb.Spatial2DView(origin=f"maps/{name}", name=f"{whose}: {MAP_TITLES[name]}") for name in media.maps]
        top.append(rrb.Grid(*maps, grid_columns=2))
        shares.append(5.0)
    views: list[rrb.View | rrb.Container] = [rrb.Horizontal(*top, column_shares=shares), lanes(answering)]
    heights = [4.0, 3.0 + min(len(answering), MOST_LANES) / 2]
    if exposing(media):
        views.append(plot("exposure", "exposure time of each row (ms)", legend=len(media.pictures) > 1))
        heights.append(1.0)
    return page(*views, shares=heights)
