"""Videos of recordings, and strips of pictures: what is seen, where robots are, and what models respond.

matplotlib draws what stands once, and what moves into a copy of it for each frame. Pictures are read one by one, so
that a recording may be long.
"""

import contextlib
import inspect
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, cast

import cv2
import matplotlib as mpl
import numpy as np
import numpy.typing as npt
import pyarrow as pa
import pyarrow.compute as pc
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.patches import Circle
from matplotlib.ticker import MaxNLocator

from dsnn.model import SPIKING
from experiments.base import palette
from experiments.base.errors import UsageError, check_known
from experiments.base.files import replacing
from experiments.base.palette import rgb
from experiments.draw.style import look
from experiments.show.record import lane_title
from experiments.store.recordings import CAMERA, chunks, pictures_of, times_of
from scenes import ARENA_RADIUS_CM

Floats = npt.NDArray[np.float64]
Picture = npt.NDArray[np.uint8]
Update = Callable[[float, Mapping[str, Picture | None]], object]
"""Moves what moves to a time, at which these pictures are seen."""
CODING = {
    ".mp4": ("libx264", "-vf pad=ceil(iw/2)*2:ceil(ih/2)*2 -crf 20 -movflags +faststart -f mp4"),
    ".webp": ("libwebp_anim", "-quality 75 -loop 0 -f webp"),
}
"""Ending -> codec and options of ffmpeg. H.264 has even sizes only."""
MOST_MODELS, MOST_HZ = 8, 120.0
NOISE, FULL_CHANGE = 4.0, 40.0
"""Changes from one picture to the next, in grey levels: up to the first nothing is drawn, at the second full colour."""
ROBOT_CM, ROOM_CM, TRAIL_FRAMES = 2.0, 7.0, 900
FIRST = "world/observer/camera"
"""The camera whose flow is drawn."""
CHANGE, FLOW = "change", "truth/flow"


def changes(seen: Iterator[tuple[float, Picture]]) -> Iterator[tuple[float, Picture]]:
    """Turn pictures into what changed since the one before, in the colours of brighter and darker pixels."""
    still, brighter, darker = (np.array(rgb(tint)) for tint in (palette.STILL, palette.BRIGHTER, palette.DARKER))
    before: npt.NDArray[np.int16] | None = None
    for time_s, picture in seen:
        change = np.zeros(picture.shape, np.int16) if before is None else picture.astype(np.int16) - before
        before = picture.astype(np.int16)
        strength = np.clip((np.abs(change) - NOISE) / (FULL_CHANGE - NOISE), 0.0, 1.0)[..., None] ** 0.7
        colour = np.where(change[..., None] > 0, brighter, darker)
        yield time_s, np.rint(still + strength * (colour - still)).astype(np.uint8)


class Reel:
    """A recording without its pictures.

    Parameters
    ----------
    path
        An .rrd file of a trial, a clip, an episode or footage.
    models
        Labels of the models that are wanted; otherwise the first `MOST_MODELS`.

    Attributes
    ----------
    path, name
        The .rrd file, and the recording's name for people.
    values
        Model -> channel, or ``spikes/`` and a channel -> times and values, (2, T).
    levels
        Model -> its thresholds.
    tracks
        Robot -> times, x and y in cm, heading in radians, (4, T).
    eyes
        Entity of a camera's pictures -> their times.
    flow
        Time, s -> what has moved in the first camera's picture, from where to where in px, (N, 2, 2).
    obstacles
        Outlines on the floor, (N, 2), cm.
    properties
        The recording's properties.

    Raises
    ------
    UsageError
        The file cannot be read, has neither pictures nor responses nor robots, or has no such model.
    """

    def __init__(self, path: Path, models: Sequence[str] = ()) -> None:
        self.path, self.name = path, path.stem
        self.values: dict[str, dict[str, Floats]] = {}
        self.levels: dict[str, list[float]] = {}
        self.tracks: dict[str, Floats] = {}
        self.eyes, self.flow = dict[str, Floats](), dict[float, Floats]()
        self.obstacles: list[Floats] = []
        self.properties: dict[str, Any] = {}
        found: dict[tuple[str, str], list[Floats]] = {}
        for entity, chunk in chunks(path):
            batch = chunk.to_record_batch()
            names, part = batch.schema.names, model_part(entity)
            if entity == "__properties" and "RecordingInfo:name" in names:
                self.name = str(batch["RecordingInfo:name"][0].as_py()[0])
            elif entity.startswith("__properties/"):
                for name in names:
                    value = batch[name][0].as_py()
                    if isinstance(value, list) and value and not name.startswith("rerun."):
                        self.properties[name.rpartition(":")[2]] = value[0]
            elif entity == "world/arena/obstacles":
                strips = [np.asarray(strip) for strip in batch["LineStrips3D:strips"][0].as_py()]
                self.obstacles = [strip[:, :2] for strip in strips if not strip[:, 2].any()]
            elif chunk.is_static:
                continue
            elif part and part[1] == "threshold":
                self.levels[part[0]] = batch["Scalars:scalars"][0].as_py()
            elif entity == f"{FIRST}/{FLOW}":
                self.flow |= _arrows(batch)
            elif CAMERA.fullmatch(entity):
                found.setdefault(("eyes", entity), []).append(times_of(batch)[None])
            elif "Transform3D:translation" in names:
                places = _flat(batch, "Transform3D:translation").reshape(-1, 3)[:, :2]
                turns = _flat(batch, "Transform3D:quaternion").reshape(-1, 4)
                poses = np.vstack([times_of(batch), places.T, 2 * np.arctan2(turns[:, 2], turns[:, 3])])
                found.setdefault(("tracks", entity.rpartition("/")[2]), []).append(poses)
            elif part and part[1].removeprefix("spikes/") in SPIKING:
                found.setdefault(part, []).append(np.vstack([times_of(batch), _flat(batch, "Scalars:scalars")]))
        for (owner, name), parts in found.items():
            whole = np.hstack(parts)
            if owner == "eyes":
                self.eyes[name] = whole[0]
            elif owner == "tracks":
                self.tracks[name] = whole
            else:
                self.values.setdefault(owner, {})[name] = whole
        if not found:
            raise UsageError(f"video {path}: a recording with neither pictures nor potentials nor robots")
        for name in models:
            check_known("--model", name, self.values)
        self.values = {name: self.values[name] for name in models or list(self.values)[:MOST_MODELS]}

    @property
    def time_s(self) -> Floats:
        """Times of the recording's frames."""
        timed = [series[0] for channels in self.values.values() for series in channels.values()]
        return max([*timed, *self.eyes.values(), *(track[0] for track in self.tracks.values())], key=len)

    def seen(self, times: Sequence[float]) -> Iterator[dict[str, Picture | None]]:
        """Yield the last picture of each eye, and of changes, at each of rising times; ``None`` before the first."""
        sources = {eye: pictures_of(self.path, eye) for eye in self.eyes}
        if self.eyes:
            sources[CHANGE] = changes(pictures_of(self.path, next(iter(self.eyes))))
        now: dict[str, Picture | None] = dict.fromkeys(sources)
        following = {eye: next(source, None) for eye, source in sources.items()}
        for time_s in times:
            for eye, source in sources.items():
                while (one := following[eye]) is not None and one[0] <= time_s + 1e-6:
                    now[eye], following[eye] = one[1], next(source, None)
            yield dict(now)


class Canvas:
    """Axes of a recording, and what moves in them.

    Attributes
    ----------
    panels
        For each column: its kind, an eye's entity, ``change`` or ``plan`` -> its axes.
    lanes
        Model -> the axes of its traces.

    Parameters
    ----------
    reel
        The recording.
    size
        Width and height, px.
    moments
        Columns of pictures: their times, or none, for a video.
    """

    def __init__(self, reel: Reel, size: tuple[int, int], moments: Sequence[float] = ()) -> None:
        self._reel, self._film, count = reel, not moments, max(len(moments), 1)
        self._updates: list[list[Update]] = [[] for _ in range(count)]
        type_size = size[1] / 45 if self._film else size[0] / 110
        sizes: Any = dict.fromkeys(("font.size", "axes.labelsize", "xtick.labelsize", "ytick.labelsize"), type_size)
        figsize = size[0] / 72, size[1] / 72
        self.figure = figure = Figure(figsize=figsize, dpi=72, layout="constrained")  # a point is a pixel
        self._canvas = cast(Any, FigureCanvasAgg(figure))
        with look(), mpl.rc_context(sizes | {"axes.titlesize": 1.2 * type_size}):
            more = [*([CHANGE] if reel.eyes else []), *([FLOW] if reel.flow else [])]
            kinds = [*reel.eyes, *more, *(["plan"] if reel.tracks else [])]
            heights = [1.0, 0.75 + 0.25 * min(len(reel.values), 4)] if self._film else [2.0, 1.0]
            parts: Any = figure.subfigures(2, 1, height_ratios=heights if reel.values else [1.0, 0.01])
            experiment = reel.properties.get("experiment")
            figure.suptitle(f"{experiment}: {reel.name}" if experiment else reel.name, x=0.01, ha="left")
            grid = parts[0].subplots(*((1, max(len(kinds), 1)) if self._film else (len(kinds), count)), squeeze=False)
            columns = grid if self._film else grid.T
            self.panels = [dict(zip(kinds, column, strict=False)) for column in columns]
            for place, column in enumerate(self.panels):
                for kind, axes in column.items():
                    axes.set(xticks=[], yticks=[])
                    draw = {"plan": self._plan, FLOW: self._flow}.get(kind, self._picture)
                    self._updates[place].append(draw(kind, axes))
                    if place == 0:
                        axes.set_title(_panel_title(kind), loc="left")
            for time_s, axes in zip(moments, grid[0], strict=False):
                axes.set_title(f"{time_s:.2f} s", loc="right")
            self.lanes = self._draw_lanes(parts[1], moments)
            if self._film:
                clock = figure.text(0.99, 0.99, "", ha="right", va="top", animated=True)
                self._updates[0].append(lambda time_s, _: clock.set_text(f"{time_s:.2f} s"))
            self._canvas.draw()
        self._still = self._canvas.copy_from_bbox(figure.bbox)
        self._moving = figure.findobj(lambda artist: artist.get_animated())

    def _picture(self, kind: str, axes: Axes) -> Update:
        first = next(pictures_of(self._reel.path, next(iter(self._reel.eyes)) if kind == CHANGE else kind))[1]
        way = "nearest" if 3 * first.shape[1] < self.figure.bbox.width else "auto"  # pixels as they are, if enlarged
        image = axes.imshow(
            np.full_like(first, 255), cmap="gray", vmin=0, vmax=255, interpolation=way, animated=self._film
        )

        def update(_: float, seen: Mapping[str, Picture | None]) -> None:
            if (picture := seen[kind]) is not None:
                image.set_data(picture)

        return update

    def _flow(self, _kind: str, axes: Axes) -> Update:
        """Draw the true flow over the picture: a stroke from where each point was to a dot where it is."""
        eye, times = next(iter(self._reel.eyes)), np.array([*self._reel.flow])
        picture = self._picture(eye, axes)
        strokes = LineCollection([], colors=palette.TRUE, linewidths=2, animated=self._film)
        axes.add_collection(strokes)
        (heads,) = axes.plot([], [], ".", color=palette.TRUE, ms=6, animated=self._film)

        def update(time_s: float, seen: Mapping[str, Picture | None]) -> None:
            picture(time_s, seen)
            now = max(int(np.searchsorted(times, time_s + 1e-6)), 1)
            moved = self._reel.flow[float(times[now - 1])] - 0.5  # matplotlib counts pixels from their middle
            strokes.set_segments(list(moved))
            heads.set_data(*moved[:, 1].T)

        return update

    def _plan(self, _kind: str, axes: Axes) -> Update:
        (x, y), turn = _ground(self._reel), np.linspace(0, 2 * np.pi, 181)
        axes.set(xlim=x, ylim=y, aspect="equal", facecolor="#f4f4f2")
        axes.plot(ARENA_RADIUS_CM * np.cos(turn), ARENA_RADIUS_CM * np.sin(turn), color="#555555")
        for outline in self._reel.obstacles:
            axes.fill(*outline.T, facecolor="#9a9a9a")
        start, level = (near + 0.06 * (far - near) for near, far in (x, y))
        axes.plot([start, start + 10], [level, level], color="black")
        axes.annotate("10 cm", (start, level), xytext=(0, 3), textcoords="offset points")
        drawn = []
        for name, track in reversed(self._reel.tracks.items()):
            colour = palette.OBSERVER if name == "observer" else palette.STIMULUS
            (trail,) = axes.plot([], [], color=colour, lw=1, animated=self._film)
            body = Circle((0, 0), ROBOT_CM, color=colour, animated=self._film, zorder=3)
            axes.add_patch(body)
            (nose,) = axes.plot([], [], color="white", lw=2, animated=self._film, zorder=4)
            drawn.append((track, trail, body, nose))

        def update(time_s: float, _: object) -> None:
            for track, trail, body, nose in drawn:
                now = max(int(np.searchsorted(track[0], time_s + 1e-6)), 1)
                place, heading = track[1:3, now - 1], track[3, now - 1]
                trail.set_data(*track[1:3, max(now - TRAIL_FRAMES, 0) : now])
                body.set_center((place[0], place[1]))
                nose.set_data(*np.transpose([place, place + 2.2 * np.array([np.cos(heading), np.sin(heading)])]))

        return update

    def _draw_lanes(self, figure: Any, moments: Sequence[float]) -> dict[str, Axes]:
        """Draw a lane for each model: potentials, thresholds, and strokes of spikes at the edges."""
        reel = self._reel
        if not reel.values:
            return {}
        columns = 1 if len(reel.values) <= 3 else 2
        grid = figure.subplots(-(-len(reel.values) // columns), columns, sharex=True, squeeze=False)
        lanes = dict(zip(reel.values, grid.T.flat, strict=False))
        for model, axes in lanes.items():
            self._lane(axes, model)
            for time_s in moments:
                axes.axvline(time_s, color="#787878", lw=1)
        for axes in list(grid.T.flat)[len(lanes) :]:
            axes.remove()
        for axes in list(lanes.values())[-columns:]:
            axes.set_xlabel("time (s)")
        return lanes

    def _lane(self, axes: Axes, model: str) -> None:
        channels, levels = self._reel.values[model], self._reel.levels.get(model, [])
        potentials = {name: series for name, series in channels.items() if "/" not in name}
        spikes = {name.removeprefix("spikes/"): series for name, series in channels.items()
                  if "/" in name and series[1].any()}  # fmt: skip
        high = max([0.1, *(np.nanmax(np.abs(values)) for _, values in potentials.values()), *map(abs, levels)])
        negative = any((values < -0.05 * high).any() for _, values in [*potentials.values(), *spikes.values()])
        begin, end = self._reel.time_s[0], self._reel.time_s[-1] + 1e-6
        axes.set(xlim=(begin, end), ylim=(-1.3 * high if negative else -0.25 * high, 1.3 * high))
        axes.yaxis.set_major_locator(MaxNLocator(4))  # others go by the layout, which goes by them
        axes.axhline(0.0, color="#c9c9c9", lw=1)
        for level in levels:
            axes.axhline(level, color=palette.THRESHOLD, lw=1, ls=(0, (5, 3)))
            named = f"T = {level:g}" if level > 0.0 or -level not in levels else ""
            axes.annotate(named, (begin, level), (2, 2), textcoords="offset points", color=palette.GREY)
        for channel, (time_s, values) in potentials.items():
            axes.plot(time_s, values, color=palette.CHANNELS[channel], lw=2, label=channel)
        for channel, (time_s, counts) in spikes.items():
            edge = 1.3 * high * np.sign(counts)
            axes.vlines(time_s, edge, edge - high * (0.05 * np.sign(counts) + 0.13 * counts / np.abs(counts).max()),
                        color=palette.CHANNELS[channel], lw=2)  # fmt: skip
        strokes = "; strokes at the edge: spikes" * bool(spikes)
        axes.set_title(f"{lane_title(model, potentials, levels)}{strokes}", loc="left")
        if self._film:  # what is to come is faint
            veil = axes.axvspan(begin, end, facecolor=(1, 1, 1, 0.8), edgecolor="#3c3c3c", animated=True, zorder=5)
            self._updates[0].append(lambda time_s, _: veil.set_bounds(time_s, -1.0, end - begin, 3.0))

    def frame(self, time_s: float, seen: Mapping[str, Picture | None]) -> Picture:
        """Return the frame of a time, (H, W, 3) uint8: ``seen`` has the last picture of each eye, and of changes."""
        for update in self._updates[0]:
            update(time_s, seen)
        self._canvas.restore_region(self._still)
        for artist in self._moving:
            artist.draw(self._canvas.get_renderer())
        return np.array(self._canvas.buffer_rgba(), np.uint8)[..., :3]

    def strip(self, moments: Sequence[float], seen: Sequence[Mapping[str, Picture | None]]) -> Picture:
        """Return the picture with those of each moment, (H, W, 3) uint8."""
        for updates, time_s, pictures in zip(self._updates, moments, seen, strict=True):
            for update in updates:
                update(time_s, pictures)
        self._canvas.draw()
        return np.array(self._canvas.buffer_rgba(), np.uint8)[..., :3]


def _panel_title(kind: str) -> str:
    eye = kind.split("/")[-2].partition("_")[2] if "/" in kind else ""
    titles = {"plan": "from above", CHANGE: "brighter yellow, darker pink", FLOW: "true flow since the frame before"}
    return titles.get(kind, f"what is seen{f', {eye}' if eye else ''}")


def _ground(reel: Reel) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return the square of ground in cm that a plan shows: of an episode the arena, of a trial what is near robots."""
    if "env" in reel.properties:
        half = ARENA_RADIUS_CM + 2.0
        return (-half, half), (-half, half)
    places = np.hstack([track[1:3] for track in reel.tracks.values()])
    middle, half = (places.max(1) + places.min(1)) / 2, float(np.ptp(places, axis=1).max()) / 2 + ROOM_CM
    return (middle[0] - half, middle[0] + half), (middle[1] - half, middle[1] + half)


def film_times(reel: Reel, rate: float | None = None, speed: float = 1.0) -> tuple[Floats, float]:
    """Return the times of the recording that a film shows, and its frames a second."""
    step = float(np.median(np.diff(reel.time_s))) if len(reel.time_s) > 1 else 0.0
    own = 1.0 / step if step > 0 else 30.0
    shown = rate or min(own, MOST_HZ)
    if speed == 1.0 and shown == own:
        return reel.time_s, shown
    length = float(np.ptp(reel.time_s))
    return reel.time_s[0] + np.arange(int(length / speed * shown + 1e-6) + 1) * speed / shown, shown


def make(
    reel: Reel, out: Path, size: tuple[int, int] | None = None, rate: float | None = None, speed: float = 1.0,
    advance: Callable[[], None] = lambda: None,
) -> int:  # fmt: skip
    """Write a film of a recording; no more than a few frames are in memory at any time.

    Parameters
    ----------
    reel
        The recording.
    out
        The file: ``.mp4`` (H.264) or ``.webp``.
    size
        Width and height, px; otherwise 1280x720.
    rate
        Frames a second; otherwise the recording's.
    speed
        Seconds of the recording in a second of the film.
    advance
        Called after each frame.

    Returns
    -------
    int
        The number of frames.
    """
    import imageio_ffmpeg

    times, shown = film_times(reel, rate, speed)
    canvas, (codec, options) = Canvas(reel, size or (1280, 720)), CODING[out.suffix]
    with replacing(out) as partial:
        film = imageio_ffmpeg.write_frames(
            str(partial), canvas.figure.canvas.get_width_height(), fps=shown, codec=codec, quality=None,
            macro_block_size=1, ffmpeg_log_level="quiet", output_params=options.split(),
        )  # fmt: skip
        film.send(None)
        ffmpeg = inspect.getgeneratorlocals(film)["p"]
        with contextlib.closing(film):
            for time_s, seen in zip(times.tolist(), reel.seen(times.tolist()), strict=True):
                picture = np.ascontiguousarray(canvas.frame(time_s, seen))
                with contextlib.suppress(OSError, StopIteration):  # it has ended: see below
                    film.send(picture)
                advance()
        if ffmpeg.returncode:
            with contextlib.suppress(OSError):
                ffmpeg.stdin.close()  # which has a frame that nobody takes
            raise OSError(f"{out}: ffmpeg could not write it to its end: is the disk full?")
    return len(times)


def moments(reel: Reel, count: int) -> list[float]:
    """Return ``count`` times, in s, spread between the first response and the last, or over a silent recording."""
    # A stimulus is taken to be in view while a response is over a twentieth of its peak.
    moving = [time_s[np.abs(values) > 0.05 * np.abs(values).max()]
              for channels in reel.values.values() for time_s, values in channels.values()]  # fmt: skip
    shown = np.concatenate([*moving, [] if any(map(len, moving)) else reel.time_s[[0, -1]]])
    return list(np.linspace(shown.min(), shown.max(), count + 2)[1:-1])


def strip(reel: Reel, out: Path, count: int = 6, size: tuple[int, int] | None = None) -> None:
    """Write a strip as a PNG file: pictures of ``count`` `moments`, and below them the traces with a line at each."""
    kinds = len(reel.eyes) + bool(reel.eyes) + bool(reel.flow) + bool(reel.tracks)
    size = size or (1800, round(1.5 * kinds * 1800 / count * 0.8) + 60)
    times = moments(reel, count)
    picture = Canvas(reel, size, times).strip(times, list(reel.seen(times)))
    with replacing(out) as partial:
        partial.write_bytes(cv2.imencode(".png", cv2.cvtColor(picture, cv2.COLOR_RGB2BGR))[1].tobytes())


def _arrows(batch: pa.RecordBatch) -> dict[float, Floats]:
    """Return both ends of a chunk's arrows, (N, 2, 2), by their time."""
    both = [[np.array(ends or []).reshape(-1, 2) for ends in batch[f"Arrows2D:{name}"].to_pylist()]
            for name in ("origins", "vectors")]  # fmt: skip
    return {
        time_s: np.stack([tails, tails + ways], 1) for time_s, tails, ways in zip(times_of(batch), *both, strict=True)
    }


def _flat(batch: pa.RecordBatch, column: str) -> Floats:
    """Return all numbers of a column of lists, of any depth."""
    values: Any = pc.list_flatten(batch[column], recursive=True)
    flat: Floats = values.to_numpy(zero_copy_only=False).astype(np.float64)
    return flat


def model_part(entity: str) -> tuple[str, str] | None:
    """Return the model whose responses an entity has, and what of them; ``None`` of any other entity."""
    parts = re.findall(r"(?:\\.|[^/])+", entity)
    if len(parts) < 3 or parts[0] != "models":
        return None
    return re.sub(r"\\(.)", r"\1", parts[1]), "/".join(parts[2:])
