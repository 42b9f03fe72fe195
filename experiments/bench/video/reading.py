"""Source of a video: a recording, read back without its pictures, and its pictures one by one.

Traces, poses and texts are some numbers a frame and are read whole. Pictures are read again for each video, chunk by
chunk, so that a recording of any length fits into memory.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa

from colias_sim.config import CameraConfig
from experiments.bench.run.errors import UsageError
from experiments.bench.run.record import Colour, model_part
from experiments.bench.store.pictures import CAMERA, chunks
from experiments.bench.video.pictures import Floats, times_of

GREY: Colour = (90, 90, 90)
OBSERVER_COLOUR, OTHER_COLOUR = (46, 120, 80), (25, 25, 25)
"""Colours of robots where they are discs: in views from above."""


@dataclass(frozen=True, slots=True)
class Trace:
    """A line of a recording's plots.

    Parameters
    ----------
    place
        ``potential``, ``azimuth`` or ``spikes``.
    name
        Its title.
    colour
        As RGB.
    time_s, values
        (N,) each.
    dotted
        Whether the recording draws it as dots: so it does with the second channel of a model, such as VS.
    model
        The label of the model that answered.
    channel
        The channel of its answer, such as ``hs``.
    """

    place: str
    name: str
    colour: Colour
    time_s: Floats
    values: Floats
    dotted: bool = False
    model: str = ""
    channel: str = ""


@dataclass(frozen=True, slots=True)
class Track:
    """The way of a robot.

    Parameters
    ----------
    name
        The robot.
    colour
        As RGB.
    time_s
        (N,).
    poses
        (N, 3): x and y in cm, heading in radians, left positive; NaN where no heading is recorded.
    """

    name: str
    colour: Colour
    time_s: Floats
    poses: Floats

    def pose_at(self, time_s: float) -> Floats:
        """Return the last pose that is not after a time, (3,); before all of them, the first."""
        pose: Floats = self.poses[max(until(self.time_s, time_s), 1) - 1]
        return pose


@dataclass(frozen=True, slots=True)
class Reel:
    """A recording without its pictures.

    Parameters
    ----------
    path
        The .rrd file.
    name
        The recording's name for people.
    time_s
        (N,) the time of each frame of the video.
    traces, tracks
        What models answered, and where robots were; the observer first.
    levels
        Thresholds that potentials are held against.
    eyes
        The entities with pictures, in the order in which they were logged.
    view_deg
        Horizontal field of view of the observer's camera.
    properties
        What the recording says of itself.
    owners
        Level -> the models whose threshold it is; without an entry where the recording does not tell.
    hidden
        How many models of the recording have no traces here.
    obstacles
        The outline of each obstacle of the arena on the floor, (N, 2), cm.
    """

    path: Path
    name: str
    time_s: Floats
    traces: tuple[Trace, ...]
    tracks: tuple[Track, ...]
    levels: tuple[float, ...]
    eyes: tuple[str, ...]
    view_deg: float
    properties: Mapping[str, Any]
    owners: Mapping[float, tuple[str, ...]] = field(default_factory=dict)
    hidden: int = 0
    obstacles: tuple[Floats, ...] = ()

    @property
    def models(self) -> tuple[str, ...]:
        """The models that have traces, in the order in which they were logged."""
        return tuple(dict.fromkeys(trace.model for trace in self.traces))

    @property
    def rate(self) -> float:
        """Frames a second."""
        steps = np.diff(self.time_s)
        return float(1.0 / np.median(steps)) if len(steps) and np.median(steps) > 0 else 30.0


def read(path: Path) -> Reel:
    """Read a recording without its pictures.

    Parameters
    ----------
    path
        An .rrd file of a trial, a clip, an episode or footage.

    Returns
    -------
    Reel
        The recording.

    Raises
    ------
    UsageError
        If the file cannot be read, or has neither pictures nor traces nor robots.
    """
    contents = _Found()
    for entity, chunk in chunks(path):
        contents.take(entity, chunk.is_static, chunk.to_record_batch())
    return contents.reel(path)


class _Found:
    """Collects what a recording has, part by part."""

    def __init__(self) -> None:
        self._scalars: dict[str, list[tuple[Floats, Floats]]] = {}
        self._places: dict[str, list[tuple[Floats, Floats]]] = {}
        self._styles: dict[str, tuple[str, Colour]] = {}
        self._dotted: set[str] = set()
        self._levels: dict[float, tuple[str, ...]] = {}
        self._eyes: dict[str, list[Floats]] = {}
        self._properties: dict[str, Any] = {}
        self._obstacles: tuple[Floats, ...] = ()
        self._name = ""
        self._view_deg = CameraConfig().hfov_deg

    def take(self, entity: str, static: bool, batch: pa.RecordBatch) -> None:
        """Take in one chunk of the recording."""
        names = batch.schema.names
        if static:
            self._take_static(entity, batch)
        elif CAMERA.fullmatch(entity):
            self._eyes.setdefault(entity, []).append(times_of(batch))
        elif "Transform3D:translation" in names:
            places = _flat(batch, "Transform3D:translation").reshape(-1, 3)[:, :2]
            turns = _flat(batch, "Transform3D:quaternion").reshape(-1, 4)
            poses = np.column_stack([places, 2 * np.arctan2(turns[:, 2], turns[:, 3])])
            self._places.setdefault(entity, []).append((times_of(batch), poses))
        elif (part := model_part(entity)) and "Scalars:scalars" in names and part[1] != "threshold":
            self._scalars.setdefault(entity, []).append((times_of(batch), _flat(batch, "Scalars:scalars")))

    def _take_static(self, entity: str, batch: pa.RecordBatch) -> None:
        names = batch.schema.names
        if entity == "__properties":
            if "RecordingInfo:name" in names:
                self._name = str(batch.column("RecordingInfo:name")[0].as_py()[0])
        elif entity.startswith("__properties/"):
            columns = {  # of the settings of a clip, the names come after that of their class
                name.rpartition(":")[2]: batch.column(name)[0].as_py()
                for name in names
                if not name.startswith("rerun.")
            }
            self._properties |= {name: value[0] for name, value in columns.items() if value}
        elif entity == "world/arena/obstacles":
            strips = [np.asarray(strip) for strip in batch.column("LineStrips3D:strips")[0].as_py()]
            self._obstacles = tuple(strip[:, :2] for strip in strips if not strip[:, 2].any())
        elif "Pinhole:image_from_camera" in names:
            focal, (columns, _) = _flat(batch, "Pinhole:image_from_camera")[0], _flat(batch, "Pinhole:resolution")
            self._view_deg = math.degrees(2 * math.atan(columns / 2 / focal))
        elif "levels" in names:
            for level in _flat(batch, "levels").tolist():
                self._levels[level] = (*self._levels.get(level, ()), (model_part(entity) or ("",))[0])
        elif series := [kind for kind in ("SeriesLines", "SeriesPoints") if f"{kind}:names" in names]:
            title = str(batch.column(f"{series[0]}:names")[0].as_py()[0])
            self._styles[entity] = title, _colour(batch, f"{series[0]}:colors") or GREY
            self._dotted |= {entity} if series[0] == "SeriesPoints" else set()

    def reel(self, path: Path) -> Reel:
        """Put together what was found."""
        tracks = [
            Track(name, OBSERVER_COLOUR if name == "observer" else OTHER_COLOUR, *_joined(parts))
            for name, parts in ((entity.rpartition("/")[2], parts) for entity, parts in self._places.items())
        ]
        tracks.sort(key=lambda track: track.name != "observer")
        traces = [self._trace(entity, *_joined(parts)) for entity, parts in self._scalars.items()]
        timed = [np.concatenate(parts) for parts in self._eyes.values()]
        timed += [trace.time_s for trace in traces] + [track.time_s for track in tracks]
        if not timed:
            raise UsageError(f"video {path}: a recording with neither pictures nor potentials nor robots")
        traces.sort(key=lambda trace: trace.place == "spikes")
        return Reel(path, self._name or path.stem, max(timed, key=len), tuple(traces), tuple(tracks),
                    tuple(sorted(self._levels)), tuple(self._eyes), self._view_deg, self._properties,
                    self._levels, obstacles=self._obstacles)  # fmt: skip

    def _trace(self, entity: str, time_s: Floats, values: Floats) -> Trace:
        model, part = model_part(entity) or ("", "")
        place, channel = ("spikes", part.partition("/")[2]) if "/" in part else ("potential", part)
        place = "azimuth" if part == "azimuth" else place
        title, colour = self._styles.get(entity, (entity, GREY))
        return Trace(
            place, title.removesuffix(" spikes"), colour, time_s, values, entity in self._dotted, model, channel
        )


def until(times: Floats, time_s: float) -> int:
    """Tell how many of some rising times are not after ``time_s``."""
    return int(np.searchsorted(times, time_s + 1e-6))


def _joined(parts: list[tuple[Floats, Floats]]) -> tuple[Floats, Floats]:
    return np.concatenate([times for times, _ in parts]), np.concatenate([values for _, values in parts])


def _flat(batch: pa.RecordBatch, column: str) -> Floats:
    """Return all numbers of a column of lists, of any depth."""
    values: Any = batch.column(column)
    while pa.types.is_list(values.type) or pa.types.is_fixed_size_list(values.type):
        values = values.flatten()
    flat: Floats = values.to_numpy(zero_copy_only=False).astype(np.float64)
    return flat


def _colour(batch: pa.RecordBatch, column: str) -> Colour | None:
    """Return the first colour of a column, which has RGBA in 32 bits."""
    if column not in batch.schema.names:
        return None
    rgba = int(batch.column(column)[0].as_py()[0])
    return rgba >> 24 & 255, rgba >> 16 & 255, rgba >> 8 & 255
