"""Recordings for Rerun: where things are, what is seen, and what models respond, of every kind of trial alike.

A recording has these entities, on the timelines ``time`` (a duration) and ``frame``::

    /world/observer, stimulus, ...   pose and looks of robots, in cm; /world/observer/wheels where an agent drives
    /world/observer/camera           the pinhole, its image below it, and the exposure; further eyes camera_<eye>
    /world/observer/camera/events    the events of a frame as points, where there is an event camera
    /world/observer/camera/truth/... flow, depth and surface: what its pixels truly show, of a run with truth
    /world/arena, /world/path        floor, wall and obstacles; the ways of those that move
    /models/<model>/hs, vs, looming  potentials; also azimuth
    /models/<model>/spikes/<channel> spikes of each frame: above 0 of preferred motion (right, down), below of null
    /models/<model>/strokes/<channel> the same as strokes at the edge of the model's lane
    /about                           condition, spikes and commands, in words
    /models/<model>/threshold        a line at each threshold
    /models/<model>/maps/<layer>     layers of the DSNN: p, la, f_on, f_off
    /reward                          the terms of an agent's reward

Values are kept in columns and sent in blocks. What is equal in all recordings of a run is encoded once.
"""

from __future__ import annotations

import itertools
import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt
import pyarrow as pa
import rerun as rr
import rerun.blueprint as rrb
import rerun_bindings
from rerun.chunk import Chunk

from colias_sim.config import CameraConfig, SceneConfig
from colias_sim.events import Events, joined
from colias_sim.obstacles import Obstacle
from colias_sim.shapes import robot_shapes
from colias_sim.truth import Truth
from dsnn import ResponseSeries
from dsnn.model import SPIKING
from experiments.base import palette
from experiments.base.palette import Colour, rgb
from experiments.settings.models import ConfiguredModel
from scenes import ARENA_RADIUS_CM, WALL_HEIGHT_CM

APPLICATION = "colias-sim"
END = b"RRF2FOOT"
"""Near the end of an .rrd file; four bytes follow."""
BLOB = pa.list_(pa.field("item", pa.uint8(), nullable=False))
TIMELINE = "time"
CAMERA, IMAGE = "world/observer/camera", "image"
Floats = npt.NDArray[np.float64]
Images = npt.NDArray[np.uint8]
Outlines = tuple[tuple[float, tuple[tuple[float, float], ...]], ...]
GREY: Colour = rgb(palette.THRESHOLD)
LINE_WIDTH = 1.5
"""Points of the screen."""
LAYERS = {"p": "retina, change", "la": "lamina", "f_on": "ON", "f_off": "OFF"}
EDGE, STROKES = 1.08, 0.22
"""Height at which a lane's strokes begin, and the room of each channel's."""
DEPTH_UNITS = 10_000
"""Units of a recorded depth in a metre: 16 bits of them are 6.5 m."""
ARROWS = 16
"""Arrows of the flow along the longer side of a picture."""
MOST_LANES = 4
"""Models below each other; more stand in columns."""


@dataclass(frozen=True, slots=True)
class RecordedModel:
    """A model whose responses are recorded.

    Parameters
    ----------
    label
        Its name in tables.
    channels
        The channels that it declares: these are drawn, whatever their values.
    thresholds
        Each channel's spiking threshold, if it has one.
    """

    label: str
    channels: tuple[str, ...]
    thresholds: tuple[tuple[str, float | None], ...] = ()

    @classmethod
    def of(cls, model: ConfiguredModel) -> RecordedModel:
        """Return a configured model as recordings have it."""
        return cls(model.label, model.channels, tuple(model.thresholds.items()))

    @property
    def spiking(self) -> list[str]:
        """The channels that have potentials and spikes."""
        return [channel for channel in self.channels if channel in SPIKING]

    def levels(self) -> dict[float, list[str]]:
        """Return each level that a threshold draws, with its channels: of HS and VS on both sides of 0."""
        levels: dict[float, list[str]] = {}
        for channel, threshold in self.thresholds:
            if channel in self.spiking and threshold is not None:
                for level in (threshold,) if channel == "looming" else (threshold, -threshold):
                    levels.setdefault(level, []).append(channel)
        return dict(sorted(levels.items()))


@dataclass(frozen=True, slots=True)
class Content:
    """What a recording has, its values aside: equal in all trials of a run.

    Parameters
    ----------
    models
        The models.
    eyes
        The cameras whose images are there; ``""`` is the camera itself.
    camera
        Where it looks from a robot; ``None`` where images have no place in the world.
    scene
        How robots and arena look; ``None`` where there is no world.
    robots
        Pairs of a robot's name and its variant, of `scenes.ROBOTS`.
    obstacles
        Pairs of an obstacle's height and its outline on the floor, cm.
    maps
        The first model's layers, each with the value that has grey 0 and 255: see `map_colours`.
    plots
        Triples of an entity, its series' names, and the heading: exposure, wheels, reward.
    above
        Whether the whole arena is seen from above; otherwise the observer from behind.
    noted
        Whether there is a text about it.
    surfaces
        Names of the geoms that pixels show; empty without truth.
    events
        Whether there are events.
    """

    models: tuple[RecordedModel, ...] = ()
    eyes: tuple[str, ...] = ()
    camera: CameraConfig | None = None
    scene: SceneConfig | None = None
    robots: tuple[tuple[str, str], ...] = ()
    obstacles: Outlines = ()
    maps: tuple[tuple[str, tuple[Colour, ...]], ...] = ()
    plots: tuple[tuple[str, tuple[str, ...], str], ...] = ()
    above: bool = False
    noted: bool = False
    surfaces: tuple[str, ...] = ()
    events: bool = False


@dataclass(frozen=True, slots=True)
class Frames:
    """Values of T frames of a recording.

    Parameters
    ----------
    time_s, frame
        Time and number of each, (T,).
    responses
        A model's label -> its responses to each; a model that failed has none.
    images
        Eye -> images (T, R, C), or JPEG files, T of them.
    poses
        Robot -> (T, 3): x and y in cm, heading in degrees, counter-clockwise.
    maps
        Layer -> images (T, R, C).
    plots
        Entity -> (T, k), a value of each series.
    taken
        A model's label -> which of the frames it took; others took all.
    truth
        Eye -> what its pixels truly show in each frame, T of them.
    events
        Eye -> the events since the frame before, T of them; ``None`` without an event camera.
    """

    time_s: Floats
    frame: npt.NDArray[np.int64]
    responses: Mapping[str, ResponseSeries] = field(default_factory=dict)
    images: Mapping[str, Images | list[bytes]] = field(default_factory=dict)
    poses: Mapping[str, Floats] = field(default_factory=dict)
    maps: Mapping[str, Images] = field(default_factory=dict)
    plots: Mapping[str, npt.NDArray[Any]] = field(default_factory=dict)
    taken: Mapping[str, slice] = field(default_factory=dict)
    truth: Mapping[str, Sequence[Truth]] = field(default_factory=dict)
    events: Mapping[str, Sequence[Events | None]] = field(default_factory=dict)

    def times(self, model: str = "", at: slice | npt.NDArray[np.intp] = slice(None)) -> list[rr.TimeColumn]:
        """Return the timelines of the frames that a model took, or of some ``at`` of them; of no model, of all."""
        taken = self.taken.get(model, slice(None))
        return times(self.time_s[taken][at], self.frame[taken][at])


def write(
    content: Content, frames: Frames, name: str, identity: str | None = None,
    properties: Mapping[str, rr.AsComponents] | None = None, more: Iterable[Chunk] = (), about: str = "",
) -> bytes:  # fmt: skip
    """Return a whole recording, as the bytes of an .rrd file.

    Parameters
    ----------
    content, frames
        What it has, and the values.
    name
        Its name for people.
    identity
        Tells it from others: a viewer merges recordings of one identity. Otherwise it is its own.
    properties
        What it says of itself: group -> values, such as those of `known`.
    more
        Further chunks.
    about
        What stands in the text beside it, in Markdown.
    """
    content = replace(content, noted=bool(about), events=any(len(joined(one)) for one in frames.events.values()))
    text = [fixed("about", rr.TextDocument(about, media_type=rr.MediaType.MARKDOWN))] * bool(about)
    chunks = [*static(content), *moving(content, frames), *_paths(frames), *more, *text]
    chunks += [Chunk.from_property(group, values) for group, values in (properties or {}).items()]
    stream = rr.RecordingStream(APPLICATION, recording_id=identity)
    try:
        # In memory, not in a file: on a full disk a flush of Rerun's own writer of files may never return.
        memory = rr.binary_stream(stream)
        send_layout(stream, layout_chunks(content))
        stream.send_recording_name(name)
        stream.send_chunks(chunks)
        recording = memory.read(flush=True)
        assert recording, "Rerun has written nothing"
        return recording
    finally:
        stream.disconnect()
        # Of streams that nobody holds any more Rerun keeps all that they were sent (rerun#2116), until it is
        # initialised again; like this that does nothing else.
        rr.init(APPLICATION, init_logging=False)


def is_whole(file: Path) -> bool:
    """Return whether a recording has its end, which one that was cut short lacks."""
    with file.open("rb") as recording:
        recording.seek(-min(file.stat().st_size, len(END) + 4), os.SEEK_END)
        return recording.read(len(END)) == END


def properties(values: Mapping[str, Any]) -> rr.AnyValues:
    """Return values as a recording's properties, without those that are ``None``."""
    return rr.AnyValues(**{name: value for name, value in values.items() if value is not None})


def send_layout(stream: rr.RecordingStream, layout: Sequence[Chunk]) -> None:
    """Do what ``stream.send_blueprint`` does, with a layout that is encoded already, and end the layout's own stream.

    That call leaves it alive, with two threads, in every recording made. It cannot be reached from outside, so this
    uses the functions by which Rerun 0.41 itself does it; ``test_record.py`` fails when they move.
    """
    blueprint = rr.RecordingStream._from_native(
        rerun_bindings.new_blueprint(
            application_id=APPLICATION, make_default=False, make_thread_default=False, default_enabled=True
        )
    )
    memory: Any = blueprint.memory_recording()
    blueprint.send_chunks(layout)
    rerun_bindings.send_blueprint(memory.storage, True, True, recording=stream.to_native())
    blueprint.disconnect()


@lru_cache(maxsize=8)
def layout_chunks(content: Content) -> tuple[Chunk, ...]:
    """Return the layout of a content as chunks, encoded once.

    No file is written: on a full disk Rerun's own writer never returns. A layout is logged to what has a method for it.
    """
    chunks: list[Chunk] = []

    def log(entity: str, archetype: rr.AsComponents, *, static: bool = False) -> None:
        when = () if static else (rr.TimeColumn("blueprint", sequence=[0]),)
        chunks.append(fixed(entity, archetype, when=when))

    arrangement(views(content))._log_to_stream(SimpleNamespace(log=log))  # type: ignore[arg-type]
    return tuple(chunks)


def times(time_s: Floats, frame: npt.NDArray[np.int64]) -> list[rr.TimeColumn]:
    """Return the timelines of frames: time in s and number, (T,) each."""
    return [rr.TimeColumn(TIMELINE, duration=time_s), rr.TimeColumn("frame", sequence=frame)]


def chunk(entity: str, when: Sequence[rr.TimeColumn], columns: Iterable[Any]) -> Chunk:
    """Return columns of an entity, a value for each time; without times they hold for all."""
    return Chunk.from_columns(f"/{entity}", when, list(columns))


def fixed(entity: str, *archetypes: rr.AsComponents, when: Sequence[rr.TimeColumn] = ()) -> Chunk:
    """Return what stays of an entity, from a single time on or for all."""
    batches = [batch for archetype in archetypes for batch in archetype.as_component_batches()]
    return chunk(entity, when, [batch.partition([len(batch.as_arrow_array())]) for batch in batches])


@lru_cache(maxsize=8)
def static(content: Content) -> tuple[Chunk, ...]:
    """Return what stays: looks of robots, arena and series, and the lens."""
    chunks = [chunk for model in content.models for chunk in _looks_of_series(model)]
    for entity, names, _ in content.plots:
        hues = [rgb(tint) for tint in palette.of_others(names).values()]
        chunks.append(fixed(entity, rr.SeriesLines(names=names, colors=hues, widths=[LINE_WIDTH] * len(names))))
    for name, tints in content.maps:
        look = rr.AnnotationContext([rr.AnnotationInfo(id=grey, color=tint) for grey, tint in enumerate(tints)])
        chunks.append(fixed(f"{model_entity(content.models[0].label)}/maps/{name}", look))
    for eye in content.eyes if content.surfaces else ():
        colours = {"nothing": palette.STILL, **palette.of_others(content.surfaces)}
        infos = [rr.AnnotationInfo(place, name, rgb(hue)) for place, (name, hue) in enumerate(colours.items())]
        chunks.append(fixed(f"{camera_entity(eye)}/truth/surface", rr.AnnotationContext(infos)))
    if content.scene is None:
        return tuple(chunks)
    chunks += [fixed("world", rr.ViewCoordinates.RIGHT_HAND_Z_UP), *_arena(content, content.scene)]
    chunks += [fixed(f"world/{name}", *_solids(variant, content.scene)) for name, variant in content.robots]
    if (lens := content.camera) is not None:
        near = 4.0 / max(1.0, lens.width / lens.focal_px)  # near enough to leave the stimulus visible
        place = rr.Transform3D(translation=[lens.forward_cm, 0, lens.up_cm], mat3x3=[[0, 0, 1], [-1, 0, 0], [0, -1, 0]])
        pinhole = rr.Pinhole(
            resolution=[lens.width, lens.height], focal_length=lens.focal_px, image_plane_distance=near
        )
        chunks += [fixed(camera_entity(eye), place, pinhole) for eye in content.eyes or ("",)]
    return tuple(chunks)


def _looks_of_series(model: RecordedModel) -> list[Chunk]:
    """Return a model's series as they look: a channel has its hue in every model."""
    root, chunks = model_entity(model.label), []
    for channel in model.spiking:
        tone, title = rgb(palette.CHANNELS[channel]), palette.TITLES[channel]
        chunks.append(fixed(f"{root}/{channel}", rr.SeriesLines(colors=tone, names=title, widths=LINE_WIDTH)))
        for kind in ("spikes", "strokes"):
            look = rr.SeriesLines(colors=tone, names=f"{title} spikes", widths=LINE_WIDTH, aggregation_policy="Off")
            chunks.append(fixed(f"{root}/{kind}/{channel}", look))  # or both ends of a stroke become their mean
    for channel in (name for name in ("azimuth", "target") if name in model.channels):
        look = rr.SeriesLines(colors=rgb(palette.INK), names=channel, widths=LINE_WIDTH)
        chunks.append(fixed(f"{root}/{channel}", look))
    if levels := model.levels():
        names = [f"threshold {level:g} ({', '.join(owners)})" for level, owners in levels.items()]
        look = rr.SeriesLines(colors=[GREY] * len(levels), names=names, widths=[1.0] * len(levels))
        chunks.append(fixed(f"{root}/threshold", look))
    return chunks


def moving(content: Content, frames: Frames) -> list[Chunk]:
    """Return the values of frames as chunks, a block an entity."""
    when, chunks = frames.times(), []
    for eye, images in frames.images.items():
        entity = f"{camera_entity(eye)}/{IMAGE}"
        if isinstance(images, np.ndarray):
            chunks += _pictures(entity, rr.Image, images, when)
        else:
            chunks.append(fixed(entity, rr.EncodedImage.from_fields(media_type="image/jpeg")))
            chunks.append(chunk(entity, when, rr.EncodedImage.columns(blob=images)))
    for eye, truths in frames.truth.items():
        chunks += _truth(f"{camera_entity(eye)}/truth", truths, when)
    for eye, events in frames.events.items() if content.events else ():
        chunks += _points(f"{camera_entity(eye)}/events", events, when)
    for name, images in frames.maps.items():
        first = content.models[0].label
        entity = f"{model_entity(first)}/maps/{name}"
        chunks += _pictures(entity, rr.SegmentationImage, images, frames.times(first))
    for robot, poses in frames.poses.items():
        half, zero = np.radians(poses[:, 2]) / 2, np.zeros(len(poses))
        place, turn = np.column_stack([poses[:, :2], zero]), np.column_stack([zero, zero, np.sin(half), np.cos(half)])
        chunks.append(chunk(f"world/{robot}", when, rr.Transform3D.columns(translation=place, quaternion=turn)))
    for entity, values in frames.plots.items():
        chunks.append(chunk(entity, when, _scalars(values)))
    ends = times(frames.time_s[[0, -1]], frames.frame[[0, -1]]) if len(frames.time_s) else []
    for model in content.models:
        series, root = frames.responses.get(model.label), model_entity(model.label)
        if series is None:
            continue
        taken = frames.times(model.label)
        for channel in model.channels:
            chunks.append(chunk(f"{root}/{channel}", taken, _scalars(getattr(series, channel))))
        for rank, channel in enumerate(model.spiking):
            counts = getattr(series, f"{channel}_spikes")
            chunks.append(chunk(f"{root}/spikes/{channel}", taken, _scalars(counts)))
            at, heights = strokes(counts, EDGE + STROKES * rank)
            if len(at):  # the viewer ends on a timeline without times
                chunks.append(chunk(f"{root}/strokes/{channel}", frames.times(model.label, at), _scalars(heights)))
        if levels := list(model.levels()):
            chunks.append(chunk(f"{root}/threshold", ends, _scalars(np.array([levels, levels]))))
    return chunks


def strokes(counts: npt.NDArray[Any], edge: float) -> tuple[npt.NDArray[np.int64], Floats]:
    """Return the frames and heights of strokes that stand outward from an edge: both ends of each, then a gap."""
    at = np.flatnonzero(counts)
    sign, size = np.sign(counts[at]), 0.04 + 0.04 * np.minimum(np.abs(counts[at]), 4)
    heights = np.column_stack([sign * edge, sign * (edge + size), np.full(len(at), np.nan)])
    return np.repeat(at, 3), heights.ravel()


def _points(entity: str, events: Sequence[Events | None], when: Sequence[rr.TimeColumn]) -> list[Chunk]:
    """Return events as points in the colours of brighter and darker pixels."""
    every = joined(events)
    tints = np.where(every["polarity"][:, None] > 0, rgb(palette.BRIGHTER), rgb(palette.DARKER)).astype(np.uint8)
    points = rr.Points2D.columns(positions=np.column_stack([every["x"], every["y"]]) + 0.5, colors=tints)
    points = points.partition([0 if one is None else len(one) for one in events])
    return [fixed(entity, rr.Points2D.from_fields(radii=[0.5])), chunk(entity, when, points)]


def _truth(entity: str, truths: Sequence[Truth], when: Sequence[rr.TimeColumn]) -> list[Chunk]:
    """Return flow as arrows on a grid, from where a point was to where it is, depth, and the geoms by number from 1."""
    rows, columns = truths[0].depth_m.shape
    step = -(-max(rows, columns) // ARROWS)
    across, down = np.meshgrid(np.arange(step // 2, columns, step), np.arange(step // 2, rows, step))
    flows = [truth.flow[down, across].reshape(-1, 2) for truth in truths]
    shown = [np.hypot(*flow.T) > 0.0 for flow in flows]  # NaN is not
    here = np.column_stack([across.ravel(), down.ravel()]) + 0.5
    vectors = np.concatenate([flow[there] for flow, there in zip(flows, shown, strict=True)])
    heads = np.concatenate([here[there] for there in shown])
    arrows = rr.Arrows2D.columns(origins=heads - vectors, vectors=vectors)
    depth = np.stack([np.nan_to_num(truth.depth_m, nan=0.0) * DEPTH_UNITS for truth in truths])
    return [
        fixed(f"{entity}/flow", rr.Arrows2D.from_fields(colors=[rgb(palette.TRUE)], radii=[0.15])),
        chunk(f"{entity}/flow", when, arrows.partition([int(there.sum()) for there in shown])),
        *_pictures(f"{entity}/depth", rr.DepthImage, np.rint(depth).astype(np.uint16), when, meter=DEPTH_UNITS),
        *_pictures(
            f"{entity}/surface", rr.SegmentationImage, np.stack([truth.geom + 1 for truth in truths]).astype(np.uint16),
            when,
        ),
    ]  # fmt: skip


def _pictures(
    entity: str, kind: Any, images: npt.NDArray[np.uint8 | np.uint16], when: Sequence[rr.TimeColumn], **look: float
) -> list[Chunk]:
    count, rows, columns = images.shape
    size = images.itemsize
    bits = rr.ChannelDatatype.U8 if size == 1 else rr.ChannelDatatype.U16
    form = rr.components.ImageFormat(width=columns, height=rows, color_model="L", channel_datatype=bits)
    # By Arrow's own means, without a copy: from an array Rerun makes two.
    ends = pa.array(np.arange(count + 1) * (rows * columns * size), pa.int32())  # raises where a list is too long
    buffers = pa.ListArray.from_arrays(ends, images.ravel().view(np.uint8), type=BLOB)
    return [fixed(entity, kind.from_fields(format=form, **look)), chunk(entity, when, kind.columns(buffer=buffers))]


def _scalars(values: npt.NDArray[Any]) -> Iterable[Any]:
    """Return values (T,) of a series, or (T, k) of k."""
    columns = rr.Scalars.columns(scalars=values.astype(np.float64).ravel())
    return columns if values.ndim == 1 else columns.partition([values.shape[1]] * len(values))


def _paths(frames: Frames) -> list[Chunk]:
    """Return the ways on the floor of the robots that move."""
    ways = [poses for poses in frames.poses.values() if np.ptp(poses, axis=0).max() > 0.01]
    lines = [np.column_stack([way[:, :2], np.zeros(len(way))]) for way in ways]
    return [fixed("world/path", rr.LineStrips3D(lines, colors=[GREY] * len(lines), radii=0.1))] if lines else []


def jpegs(images: Iterable[Images], quality: int = 85) -> list[bytes]:
    """Return grey images as JPEG files of a ``quality`` up to 100: exact ones are ten times as large."""
    return [cv2.imencode(".jpg", image, [cv2.IMWRITE_JPEG_QUALITY, quality])[1].tobytes() for image in images]


def outlines(obstacles: Iterable[Obstacle]) -> Outlines:
    """Return obstacles as contents have them: height and closed outline, cm."""
    return tuple((100 * one.height, tuple((x, y) for x, y in one.closed_cm.tolist())) for one in obstacles)


def _arena(content: Content, scene: SceneConfig) -> list[Chunk]:
    """Return floor, wall and obstacles. Only the wall's inner side is drawn, so that it hides nothing from outside."""
    turn = np.linspace(0, 2 * np.pi, 65)
    ring = np.column_stack([np.cos(turn), np.sin(turn), np.zeros_like(turn)])
    away = scene.wall_cm
    floor = [radius * ring for radius in (10.0, 20.0)]
    foot = away * ring
    corners = np.vstack([foot, foot + np.array([0, 0, WALL_HEIGHT_CM * away / ARENA_RADIUS_CM])])
    near = np.arange(64)
    lower, upper = np.column_stack([near, near + 65, near + 1]), np.column_stack([near + 1, near + 65, near + 66])
    wall = rr.Mesh3D(  # corners in the order in which they go round counter-clockwise from inside
        vertex_positions=corners, triangle_indices=np.vstack([lower, upper]), vertex_normals=np.vstack([-ring, -ring]),
        albedo_factor=(196, 196, 190), face_rendering="front",
    )  # fmt: skip
    disc = rr.Cylinders3D(
        lengths=[0.1], radii=[away], centers=[(0, 0, -0.1)], colors=[(235, 235, 231)], fill_mode="solid"
    )
    chunks = [
        fixed("world/arena/floor", disc),
        fixed("world/arena/circles", rr.LineStrips3D([*floor, foot], colors=[GREY], radii=[0.08])),
        fixed("world/arena/wall", wall),
    ]
    if content.obstacles:
        strips = [
            np.column_stack([outline, np.full(len(outline), top)])
            for height, outline in content.obstacles for top in (0.0, height)
        ]  # fmt: skip
        chunks.append(fixed("world/arena/obstacles", rr.LineStrips3D(strips, colors=[GREY], radii=[0.1])))
    return chunks


@lru_cache(maxsize=32)
def _solids(variant: str, scene: SceneConfig) -> tuple[rr.AsComponents, ...]:
    """Return the solids of a robot, in cm."""
    solids: list[rr.AsComponents] = []
    for kind, shapes in robot_shapes(variant, scene).items():
        half = 100 * shapes["half_size"]
        placed: dict[str, Any] = {
            "centers": 100 * shapes["centre"], "quaternions": shapes["turn"], "colors": shapes["colour"],
            "fill_mode": "solid",
        }  # fmt: skip
        if kind == "cylinder":
            solids.append(rr.Cylinders3D(lengths=2 * half[:, 2], radii=half[:, 0], **placed))
        else:
            shaped = rr.Boxes3D if kind == "box" else rr.Ellipsoids3D
            solids.append(shaped(half_sizes=half, **placed))
    return tuple(solids)


def views(content: Content) -> list[tuple[float, Any]]:
    """Return what a viewer opens with, from top to bottom: shares of the height, and views or rows of them."""
    top: list[tuple[float, Any]] = []
    if content.scene is not None:
        top.append((5.0, _world(content, content.scene)))
    for eye in content.eyes:
        name = f"what is seen{', and its true flow' if content.surfaces else ''}{f' ({eye})' if eye else ''}"
        place = f"/{camera_entity(eye)}"
        apart = ("depth", "surface") if content.surfaces else ()
        contents = ["$origin/**", "- $origin/events", *(f"- $origin/truth/{part}" for part in apart)]
        top.append((4.0, rrb.Spatial2DView(origin=place, contents=contents, name=name)))
        if content.events:
            top.append((4.0, rrb.Spatial2DView(origin=place, contents=["$origin/events"], name="ON yellow, OFF pink")))
        if apart:
            true = [rrb.Spatial2DView(origin=f"{place}/truth/{part}", name=f"true {part}") for part in apart]
            top.append((3.0, rrb.Vertical(*true)))
    if content.maps:
        label = content.models[0].label
        maps = [
            rrb.Spatial2DView(origin=f"/{model_entity(label)}/maps/{name}", name=f"{label}: {LAYERS.get(name, name)}")
            for name, _ in content.maps
        ]
        top.append((5.0, rrb.Grid(*maps, grid_columns=2)))
    if content.noted:
        top.append((3.0, rrb.TextDocumentView(origin="/about", name="about")))
    rows: list[tuple[float, Any]] = []
    if top:
        rows.append((4.0, rrb.Horizontal(*(view for _, view in top), column_shares=[share for share, _ in top])))
    if content.above:  # an episode: a lane for each channel, below each other
        for model in content.models:
            rows += [(1.5, _lane(model, [channel])) for channel in model.spiking]
            rows += [(1.0, plot) for plot in _azimuth(model)]
    elif content.models:
        columns = -(-len(content.models) // MOST_LANES)
        lanes = (rrb.Horizontal(*([_lane(model, model.spiking)] if model.spiking else ()), *_azimuth(model))
                 for model in content.models)  # fmt: skip
        rows.append((3.0 + min(len(content.models), MOST_LANES) / 2, rrb.Grid(*lanes, grid_columns=columns)))
    for entity, names, heading in content.plots:
        hues = zip(names, itertools.cycle(palette.OTHERS), strict=False)
        which = f": {', '.join(map(' '.join, hues))}" if len(names) > 1 else ""
        rows.append((1.0, _plot(f"/{entity}", [f"/{entity}"], f"{heading}{which}")))
    return rows


def arrangement(rows: Sequence[tuple[float, Any]]) -> rrb.Blueprint:
    """Return a layout that opens ready to read: rows below each other, with shares of the height, and the timeline."""
    return rrb.Blueprint(
        rrb.Vertical(*(view for _, view in rows), row_shares=[share for share, _ in rows]),
        rrb.TimePanel(state="collapsed", timeline=TIMELINE),
        collapse_panels=True,
    )


def _world(content: Content, scene: SceneConfig) -> rrb.Spatial3DView:
    """Return the view of the arena: from behind the observer, or the whole from above."""
    if content.above:
        eye = rrb.EyeControls3D(position=(0, 0, 105), look_target=(0, 0, 0), eye_up=(0, 1, 0))
    else:
        eye = rrb.EyeControls3D(position=(-13, -9, 12), look_target=(6, 0, 0), eye_up=(0, 0, 1))
    hidden = [f"- /{camera_entity(other)}/**" for other in content.eyes[1:]]
    apart = ["truth/**"] * bool(content.surfaces) + ["events"] * content.events
    hidden += [f"- /{camera_entity(eye)}/{part}" for eye in content.eyes for part in apart]
    hidden += ["- /world/arena/wall"] if content.above else []  # the outer circle is its foot
    return rrb.Spatial3DView(
        origin="/world", contents=["+ /world/**", *hidden], background=(206, 206, 202),
        name=f"arena{' from above' if content.above else ''} (circles: 10, 20 and {scene.wall_cm:g} cm)",
        eye_controls=eye, line_grid=False,
    )  # fmt: skip


def _lane(model: RecordedModel, channels: Sequence[str]) -> rrb.TimeSeriesView:
    """Return a lane of a model: potentials of channels, thresholds, and strokes of spikes at its edge."""
    place = f"/{model_entity(model.label)}"
    contents = [f"{place}/{part}{channel}" for channel in channels for part in ("", "strokes/")]
    highest = EDGE + STROKES * len(model.spiking)
    levels = [level for level, owners in model.levels().items() if {*owners} & {*channels}]
    title = lane_title(model.label, channels, levels) + "; strokes at the edge: spikes" * bool(levels)
    origin = place if [*channels] == model.spiking else f"{place}/{channels[0]}"
    lowest = -0.05 if [*channels] == ["looming"] else -highest
    return _plot(origin, [*contents, f"{place}/threshold"], title, (lowest, highest))


def _azimuth(model: RecordedModel) -> list[rrb.TimeSeriesView]:
    """Return the plots of how strongly a model sees a small target, and where it sees motion, if it says so."""
    place, plots = f"/{model_entity(model.label)}", []
    if "target" in model.channels:
        plots.append(_plot(f"{place}/target", [f"{place}/target"], f"{model.label}: strength of the target"))
    if "azimuth" in model.channels:
        heading = f"{model.label}: azimuth, -1 left to 1 right"
        plots.append(_plot(f"{place}/azimuth", [f"{place}/azimuth"], heading, (-1.05, 1.05)))
    return plots


def _plot(
    origin: str, contents: Sequence[str], name: str, ends: tuple[float, float] | None = None
) -> rrb.TimeSeriesView:
    """Return a plot of series, on one axis of time with all others; its heading stands for a legend."""
    return rrb.TimeSeriesView(
        origin=origin, contents=list(contents), name=name,
        axis_x=rrb.TimeAxis(link="LinkToGlobal"), axis_y=rrb.ScalarAxis(range=ends) if ends else None,
        background=rrb.archetypes.PlotBackground(color=(250, 250, 247), show_grid=False),
        plot_legend=rrb.PlotLegend(visible=False),
    )  # fmt: skip


def note(values: Mapping[str, Any], *commands: str) -> str:
    """Return a text about a recording, in Markdown: values that are known, then commands."""
    shown = {name: f"{value:.4g}" if isinstance(value, float) else value for name, value in values.items()}
    lines = [f"{name.replace('_', ' ')}: **{value}**" for name, value in shown.items() if value is not None]
    return "  \n".join([*lines, *(f"`{command}`" for command in commands)])


def camera_entity(eye: str) -> str:
    """Return where a camera is; the image that it took is below."""
    return f"{CAMERA}_{eye}" if eye else CAMERA


def model_entity(label: str) -> str:
    """Return where a model's responses are."""
    return f"models/{rr.escape_entity_path_part(label)}"


def lane_title(model: str, channels: Iterable[str], levels: Iterable[float]) -> str:
    """Return the heading of a model's lane: which hue is which potential, its thresholds, and what strokes are."""
    hues = [f"{palette.TITLES[channel]} {palette.HUES[channel]}" for channel in channels]
    limits = ", ".join(f"{level:g}" for level in sorted({abs(level) for level in levels}))
    return ", ".join([f"{model}: {hues[0]}" if hues else model, *hues[1:], *[f"T = {limits} grey"] * bool(limits)])
