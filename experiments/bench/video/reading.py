"""Source of a video: a recording, read back without its pictures, and its pictures one by one.

Traces, poses and texts are some numbers a frame and are read whole. Pictures are read again for each video, chunk by
chunk, so that a recording of any length fits into memory.
"""

from __future__ import annotations

import dataclasses
import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa

from colias_sim.config import CameraConfig
from experiments.bench.figures.series import THRESHOLD, Colour
from experiments.bench.recording import OBSERVER_COLOUR, OTHER_COLOUR
from experiments.bench.run.errors import UsageError
from experiments.bench.store.pictures import chunks
from experiments.bench.video.pictures import Floats, times_of

PLACES = ("potential", "azimuth", "spikes")
"""Where recordings log what models answered: the first part of an entity's path."""
MAPS = "maps/"
"""Pictures that no video shows."""
GREY: Colour = (90, 90, 90)


@dataclass(frozen=True, slots=True)
class Trace:
    """A line of a recording's plots.

    Parameters
    ----------
    place
        One of `PLACES`.
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
        self._colours: dict[str, Colour] = {}
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
        elif "EncodedImage:blob" in names or "Image:buffer" in names:
            if not entity.startswith(MAPS):
                self._eyes.setdefault(entity, []).append(times_of(batch))
        elif "Scalars:scalars" in names and entity.startswith((*PLACES, THRESHOLD)):
            self._scalars.setdefault(entity, []).append((times_of(batch), _flat(batch, "Scalars:scalars")))
        elif "Transform3D:translation" in names:
            self._take_pose(entity, batch)
        elif "Points2D:positions" in names and entity.startswith("arena/"):
            places = _flat(batch, "Points2D:positions").reshape(-1, 2) * (1.0, -1.0)  # a 2-D view's y axis points down
            self._put(entity.removesuffix("/body"), batch, places, np.full(len(places), np.nan))
        elif "Arrows2D:vectors" in names and entity.startswith("arena/"):
            ahead, robot = _flat(batch, "Arrows2D:vectors").reshape(-1, 2), entity.removesuffix("/heading")
            times, poses = self._places[robot][-1]
            self._places[robot][-1] = times, np.column_stack([poses[:, :2], np.arctan2(-ahead[:, 1], ahead[:, 0])])

    def _take_pose(self, entity: str, batch: pa.RecordBatch) -> None:
        places = _flat(batch, "Transform3D:translation").reshape(-1, 3)[:, :2]
        turns = _flat(batch, "Transform3D:quaternion").reshape(-1, 4)
        self._put(entity, batch, places, 2 * np.arctan2(turns[:, 2], turns[:, 3]))

    def _put(self, robot: str, batch: pa.RecordBatch, places: Floats, headings: Floats) -> None:
        self._places.setdefault(robot, []).append((times_of(batch), np.column_stack([places, headings])))

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
        elif entity == "scene/obstacles":
            strips = [np.asarray(strip) for strip in batch.column("LineStrips3D:strips")[0].as_py()]
            self._obstacles = tuple(strip[:, :2] for strip in strips if not strip[:, 2].any())
        elif entity == "arena/obstacles":
            strips = [np.asarray(strip) for strip in batch.column("LineStrips2D:strips")[0].as_py()]
            self._obstacles = tuple(strip * (1.0, -1.0) for strip in strips)  # a 2-D view's y axis points down
        elif "Pinhole:image_from_camera" in names:
            focal, (columns, _) = _flat(batch, "Pinhole:image_from_camera")[0], _flat(batch, "Pinhole:resolution")
            self._view_deg = math.degrees(2 * math.atan(columns / 2 / focal))
        elif series := [kind for kind in ("SeriesLines", "SeriesPoints") if f"{kind}:names" in names]:
            title = str(batch.column(f"{series[0]}:names")[0].as_py()[0])
            self._styles[entity] = title, _colour(batch, f"{series[0]}:colors") or GREY
            self._dotted |= {entity} if series[0] == "SeriesPoints" else set()
        elif "Points2D:colors" in names:
            self._colours[entity.removesuffix("/body")] = _colour(batch, "Points2D:colors") or GREY

    def reel(self, path: Path) -> Reel:
        """Put together what was found."""
        series = {entity: _joined(parts) for entity, parts in self._scalars.items()}
        levels = {entity: float(joined[1][0]) for entity, joined in series.items() if entity.startswith(THRESHOLD)}
        owners: dict[float, tuple[str, ...]] = {}
        for entity, level in levels.items():
            owners[level] = (*owners.get(level, ()), model_of(entity))
        traces = [
            Trace(entity.partition("/")[0], *self._styles.get(look := self._look(entity), (entity, GREY)), *joined,
                  look in self._dotted, model_of(entity), entity.rpartition("/")[2])
            for entity, joined in series.items() if entity not in levels
        ]  # fmt: skip
        tracks = [
            Track(robot.rpartition("/")[2], self._colours.get(robot, _usual_colour(robot)), *_joined(parts))
            for robot, parts in self._places.items()
        ]
        tracks.sort(key=lambda track: track.name != "observer")
        timed = [np.concatenate(parts) for parts in self._eyes.values()]
        timed += [trace.time_s for trace in traces] + [track.time_s for track in tracks]
        if not timed:
            raise UsageError(f"video {path}: a recording with neither pictures nor potentials nor robots")
        times = max(timed, key=len)
        first = [trace for trace in traces if trace.place != "spikes"]
        spiking = [dataclasses.replace(trace, name=trace.name.removesuffix(" spikes")) for trace in traces
                   if trace.place == "spikes"]  # fmt: skip
        return Reel(path, self._name or path.stem, times, (*first, *spiking), tuple(tracks),
                    tuple(sorted({*levels.values()})), tuple(self._eyes), self._view_deg, self._properties,
                    owners, obstacles=self._obstacles)  # fmt: skip

    def _look(self, entity: str) -> str:
        """Return the entity whose style a series has: spikes that are not drawn, that of their potential."""
        return entity if entity in self._styles else entity.replace("spikes/", "potential/", 1)


def until(times: Floats, time_s: float) -> int:
    """Tell how many of some rising times are not after ``time_s``."""
    return int(np.searchsorted(times, time_s + 1e-6))


def model_of(entity: str) -> str:
    """Read the label of the model whose answer is there: the second part of the path, which escapes some letters."""
    label = re.findall(r"(?:\\.|[^/])+", entity)[1]
    return re.sub(r"\\(.)", r"\1", label)


def _usual_colour(robot: str) -> Colour:
    """Return the colour of a robot's disc where the recording has the robot as it looks."""
    return OBSERVER_COLOUR if robot.rpartition("/")[2] == "observer" else OTHER_COLOUR


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
