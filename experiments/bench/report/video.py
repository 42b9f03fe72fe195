"""Videos of recordings, and strips of pictures: what is seen, where robots are, and what models respond.

matplotlib draws axes, titles and traces twice, faint and whole; a frame is the faint picture with the whole traces up
to now, and with the pictures and robots of its time. Pictures are read one by one, so that a recording may be long.
"""

from __future__ import annotations

import contextlib
import itertools
import subprocess
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import cv2
import matplotlib as mpl
import numpy as np
import numpy.typing as npt
import pyarrow as pa
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure, SubFigure

from dsnn.model import SPIKING
from experiments.bench.report.palette import colours
from experiments.bench.report.style import look
from experiments.bench.run.errors import UsageError
from experiments.bench.run.files import replacing
from experiments.bench.run.record import OFF, ON, STILL, channel_title, model_part
from experiments.bench.run.recordings import CAMERA, chunks, pictures_of, times_of
from scenes import ARENA_RADIUS_CM
from scenes.hints import nearest

Floats = npt.NDArray[np.float64]
Picture = npt.NDArray[np.uint8]
EXTRA = "the extra [video] (imageio-ffmpeg is not installed): pip install 'colias-sim[video]'"
CODING = {
    ".mp4": "-c:v libx264 -pix_fmt yuv420p -crf 20 -preset medium -movflags +faststart -f mp4",
    ".webp": "-c:v libwebp_anim -pix_fmt yuv420p -quality 75 -loop 0 -f webp",
    ".gif": "-lavfi split[a][b];[a]palettegen=stats_mode=diff[p];[b][p]paletteuse=dither=none -f gif",
}
"""Ending -> options of ffmpeg."""
GIF_RATE = 12.5
"""Most frames a second of a GIF by default: its delays are whole hundredths of a second, here 8."""
MOST_MODELS = 8
"""In one picture: each has a lane."""
SIZES_PX, MOST_HZ = range(160, 3841), 120.0
NOISE, FULL_CHANGE = 4.0, 40.0
"""Changes from one picture to the next, in grey levels: up to the first nothing is drawn, at the second full colour."""
LINES = {"hs": ("-", "line"), "vs": (":", "dotted"), "looming": ("--", "dashed")}
"""Channel -> its line, for matplotlib and in words."""
ROBOT_CM, ROOM_CM, FAINT = 2.0, 7.0, 0.2
OBSERVER, OTHER, NOW = (46, 120, 80), (25, 25, 25), (60, 60, 60)


@dataclass(slots=True)
class Reel:
    """A recording without its pictures.

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
    obstacles
        Outlines on the floor, (N, 2), cm.
    properties
        What the recording says of itself.
    """

    path: Path
    name: str
    values: dict[str, dict[str, Floats]] = field(default_factory=dict)
    levels: dict[str, list[float]] = field(default_factory=dict)
    tracks: dict[str, Floats] = field(default_factory=dict)
    eyes: dict[str, Floats] = field(default_factory=dict)
    obstacles: list[Floats] = field(default_factory=list)
    properties: dict[str, Any] = field(default_factory=dict)

    @property
    def time_s(self) -> Floats:
        """Times of the recording's frames."""
        timed = [series[0] for channels in self.values.values() for series in channels.values()]
        return max([*timed, *self.eyes.values(), *(track[0] for track in self.tracks.values())], key=len)

    @property
    def rate(self) -> float:
        """Frames a second."""
        step = float(np.median(np.diff(self.time_s))) if len(self.time_s) > 1 else 0.0
        return 1.0 / step if step > 0 else 30.0

    def with_models(self, asked: Sequence[str] = ()) -> Reel:
        """Return the recording with some of its models: those asked for, otherwise the first `MOST_MODELS`.

        Raises
        ------
        UsageError
            There is no such model, or more than `MOST_MODELS` are asked for.
        """
        for name in asked:
            if name not in self.values:
                near = nearest(name, list(self.values), " (", ")")
                there = ", ".join(self.values)
                raise UsageError(f"--model {name}: {self.path} has no such model{near}; there are: {there}")
        chosen = list(dict.fromkeys(asked)) or list(self.values)[:MOST_MODELS]
        if len(chosen) > MOST_MODELS:
            raise UsageError(f"--model must be given at most {MOST_MODELS} times, got {len(chosen)}")
        return replace(self, values={name: self.values[name] for name in chosen})


def read(path: Path) -> Reel:
    """Read a recording without its pictures.

    Parameters
    ----------
    path
        An .rrd file of a trial, a clip, an episode or footage.

    Raises
    ------
    UsageError
        The file cannot be read, or has neither pictures nor responses nor robots.
    """
    reel = Reel(path, path.stem)
    found: dict[tuple[str, str], list[Floats]] = {}
    for entity, chunk in chunks(path):
        batch = chunk.to_record_batch()
        names, part = batch.schema.names, model_part(entity)
        if entity == "__properties" and "RecordingInfo:name" in names:
            reel.name = str(batch["RecordingInfo:name"][0].as_py()[0])
        elif entity.startswith("__properties/"):
            known = {name.rpartition(":")[2]: batch[name][0].as_py() for name in names if not name.startswith("rerun.")}
            reel.properties |= {name: value[0] for name, value in known.items() if isinstance(value, list) and value}
        elif entity == "world/arena/obstacles":
            strips = [np.asarray(strip) for strip in batch["LineStrips3D:strips"][0].as_py()]
            reel.obstacles = [strip[:, :2] for strip in strips if not strip[:, 2].any()]
        elif part and "levels" in names:
            reel.levels[part[0]] = _flat(batch, "levels").tolist()
        elif chunk.is_static:
            continue
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
            reel.eyes[name] = whole[0]
        elif owner == "tracks":
            reel.tracks[name] = whole
        else:
            reel.values.setdefault(owner, {})[name] = whole
    if not found:
        raise UsageError(f"video {path}: a recording with neither pictures nor potentials nor robots")
    return reel


def changes(seen: Iterator[tuple[float, Picture]]) -> Iterator[tuple[float, Picture]]:
    """Turn pictures into what changed since the one before: warm where it became brighter, cool where darker."""
    before: npt.NDArray[np.int16] | None = None
    for time_s, picture in seen:
        change = np.zeros(picture.shape, np.int16) if before is None else picture.astype(np.int16) - before
        before = picture.astype(np.int16)
        strength = np.clip((np.abs(change) - NOISE) / (FULL_CHANGE - NOISE), 0.0, 1.0)[..., None] ** 0.7
        colour = np.where(change[..., None] > 0, np.array(ON), np.array(OFF))
        yield time_s, np.rint(np.array(STILL) + strength * (colour - np.array(STILL))).astype(np.uint8)


def _latest(source: Iterator[tuple[float, Picture]], times: Sequence[float]) -> Iterator[Picture | None]:
    """Yield the last picture that is not after each of some rising times; ``None`` before the first."""
    now, following = None, next(source, None)
    for time_s in times:
        while following is not None and following[0] <= time_s + 1e-6:
            now, following = following[1], next(source, None)
        yield now


class Canvas:
    """Axes of a picture of a recording, drawn once, and what moves drawn into it.

    Attributes
    ----------
    faint, whole
        The picture with faint traces and with whole ones, (H, W, 3) uint8, RGB.

    Parameters
    ----------
    reel
        The recording.
    size
        Width and height, px.
    caption
        The text at the top.
    moments
        Columns of pictures: their times, or one of no time, for a video.
    """

    def __init__(self, reel: Reel, size: tuple[int, int], caption: str, moments: Sequence[float] = ()) -> None:
        if not all(length in SIZES_PX for length in size):
            raise UsageError(f"--size {size[0]}x{size[1]}: each must be between {SIZES_PX[0]} and {SIZES_PX[-1]} px")
        self._reel, self._size, count = reel, size, max(len(moments), 1)
        self._shapes = [next(pictures_of(reel.path, eye))[1].shape for eye in reel.eyes]
        type_size = size[1] / 45 if count == 1 else size[0] / 110
        type_sizes: Any = dict.fromkeys(
            ("font.size", "axes.labelsize", "xtick.labelsize", "ytick.labelsize"), type_size
        )
        figsize = size[0] / 72, size[1] / 72
        self.figure = figure = Figure(figsize=figsize, dpi=72, layout="constrained")  # a point is a pixel
        canvas = FigureCanvasAgg(figure)
        with look(), mpl.rc_context(type_sizes | {"axes.titlesize": 1.2 * type_size}):
            kinds = [*reel.eyes, *(["change"] if reel.eyes else []), *(["plan"] if reel.tracks else [])]
            heights = [1.3 * len(kinds) if count > 1 else 1.0, 0.75 + 0.25 * min(len(reel.values), 4)]
            parts: Any = figure.subfigures(2, 1, height_ratios=heights if reel.values else [1.0, 0.01])
            top, lanes = parts
            figure.suptitle(caption, x=0.01, ha="left")
            grid = top.subplots(*((len(kinds), count) if count > 1 else (1, max(len(kinds), 1))), squeeze=False)
            self._panels = [
                self._panel(kind, grid[(row, k) if count > 1 else (0, row)], titled=k == 0)
                for k in range(count) for row, kind in enumerate(kinds)
            ]  # fmt: skip
            for place, time_s in enumerate(moments):
                grid[0, place].set_title(f"{time_s:.2f} s", loc="right")
            self._lanes = self._draw_lanes(lanes, moments)
            canvas.draw()  # type: ignore[no-untyped-call]
            self.whole = np.asarray(canvas.buffer_rgba(), np.uint8)[..., :3].copy()  # type: ignore[no-untyped-call]
            figure.set_layout_engine("none")
            for line in (line for axes in self._lanes for line in axes.lines if line.get_gid() == "trace"):
                line.set_alpha(FAINT)
            canvas.draw()  # type: ignore[no-untyped-call]
            self.faint = np.asarray(canvas.buffer_rgba(), np.uint8)[..., :3].copy()  # type: ignore[no-untyped-call]

    def _panel(self, kind: str, axes: Axes, *, titled: bool) -> tuple[str, Axes]:
        axes.set(xticks=[], yticks=[])
        if kind == "plan":
            (x, y), turn = _ground(self._reel), np.linspace(0, 2 * np.pi, 181)
            axes.set(xlim=x, ylim=y, aspect="equal", facecolor="#f4f4f2")
            axes.plot(ARENA_RADIUS_CM * np.cos(turn), ARENA_RADIUS_CM * np.sin(turn), color="#555555")
            for outline in self._reel.obstacles:
                axes.fill(*outline.T, facecolor="#9a9a9a")
            start, level = (near + 0.06 * (far - near) for near, far in (x, y))
            axes.plot([start, start + 10], [level, level], color="black")
            axes.annotate("10 cm", (start, level), xytext=(0, 3), textcoords="offset points")
        else:
            rows, columns = self._shapes[0] if kind == "change" else self._shapes[list(self._reel.eyes).index(kind)]
            axes.set(xlim=(0, columns), ylim=(rows, 0), aspect="equal")
        eye = kind.split("/")[-2].partition("_")[2] if "/" in kind else ""
        titles = {"plan": "from above", "change": "brighter (warm), darker (cool)"}
        if titled:
            axes.set_title(titles.get(kind, f"what is seen{f', {eye}' if eye else ''}"), loc="left")
        return kind, axes

    def _draw_lanes(self, figure: SubFigure, moments: Sequence[float]) -> list[Axes]:
        """Draw a lane for each model: potentials, thresholds, and strokes of spikes at the edges."""
        reel = self._reel
        if not reel.values:
            return []
        columns = 1 if len(reel.values) <= 3 else 2
        grid = figure.subplots(-(-len(reel.values) // columns), columns, sharex=True, squeeze=False)
        tints = colours(reel.values)
        bounded = [series[1] for model in reel.values.values() for name, series in model.items() if "/" not in name]
        shared = max([np.nanmax(np.abs(v)) for v in bounded if np.nanmax(np.abs(v)) <= 1] + [0.1])
        for axes, (model, channels) in zip(grid.T.flat, reel.values.items(), strict=False):
            potentials = {name: series for name, series in channels.items() if "/" not in name}
            levels = reel.levels.get(model, [])
            high = max([shared, *(np.nanmax(np.abs(v)) for _, v in potentials.values()), *map(abs, levels)])
            negative = any(
                (series[1] < (0 if "/" in name else -0.05 * high)).any() for name, series in channels.items()
            )
            low = -1.3 * high if negative else -0.25 * high
            axes.set(xlim=(reel.time_s[0], reel.time_s[-1] + 1e-6), ylim=(low, 1.3 * high))
            axes.axhline(0.0, color="#c9c9c9", lw=1)
            for level in levels:
                axes.axhline(level, color=tints[model], lw=1, ls=(0, (5, 3)))
            for channel, (time_s, values) in potentials.items():
                axes.plot(time_s, values, LINES[channel][0], color=tints[model], lw=2, gid="trace")
                if (counts := channels.get(f"spikes/{channel}")) is not None and counts[1].any():
                    size = np.sign(counts[1]) * (0.05 + 0.13 * np.abs(counts[1]) / np.abs(counts[1]).max()) * high
                    edge = np.sign(counts[1]) * 1.3 * high
                    ends = np.where(counts[1] == 0, np.nan, np.vstack([edge, edge - size, np.full(len(edge), np.nan)]))
                    axes.plot(np.repeat(counts[0], 3), ends.T.ravel(), color=tints[model], lw=2, gid="trace")
            looks = ", ".join(f"{channel_title(name)} ({LINES[name][1]})" for name in potentials)
            spiking = any("/" in name and series[1].any() for name, series in channels.items())
            limits = f"; threshold {', '.join(f'{level:.3g}' for level in levels if level > 0)}" if levels else ""
            edges = "; spikes at the edges, above of right or down, below of left or up" if columns == 1 else ""
            axes.set_title(f"{model}: {looks}{limits}{edges if spiking else ''}", loc="left")
            for time_s in moments:
                axes.axvline(time_s, color="#787878", lw=1)
        for axes in grid[-1]:
            axes.set_xlabel("time (s)")
        for axes in list(grid.T.flat)[len(reel.values) :]:
            axes.remove()
        return list(grid.T.flat)[: len(reel.values)]

    def frame(self, time_s: float, seen: Mapping[str, Picture | None]) -> Picture:
        """Return the frame of a time, (H, W, 3) uint8: ``seen`` has the last picture of each eye, and of changes."""
        frame = self.faint.copy()
        self.paste(frame, self._panels, time_s, seen)
        for axes in self._lanes:
            left, top, right, bottom = self._box(axes)
            now = min(round(self._pixel(axes, time_s, 0.0)[0]), right)
            frame[top:bottom, left:now] = self.whole[top:bottom, left:now]
            frame[top:bottom, max(now - 1, left) : now + 1] = NOW
        text, scale = f"{time_s:.2f} s", self._size[1] / 900
        (width, height), _ = cv2.getTextSize(text, cv2.FONT_HERSHEY_SIMPLEX, scale, 1)
        place = self._size[0] - width - 10, height + 8
        cv2.putText(frame, text, place, cv2.FONT_HERSHEY_SIMPLEX, scale, NOW, 1, cv2.LINE_AA)
        return frame

    def strip(self, moments: Sequence[float], seen: Mapping[str, Sequence[Picture | None]]) -> Picture:
        """Return the picture with those of each moment."""
        frame, kinds = self.whole.copy(), len(self._panels) // len(moments)
        for place, time_s in enumerate(moments):
            panels = self._panels[place * kinds : (place + 1) * kinds]
            self.paste(frame, panels, time_s, {eye: found[place] for eye, found in seen.items()})
        return frame

    def paste(
        self, frame: Picture, panels: Sequence[tuple[str, Axes]], time_s: float, seen: Mapping[str, Picture | None]
    ) -> None:  # fmt: skip
        """Draw pictures, and robots with their trails, into panels."""
        for kind, axes in panels:
            left, top, right, bottom = self._box(axes)
            if kind == "plan":
                for name, track in reversed(self._reel.tracks.items()):
                    self._robot(frame[top:bottom, left:right], axes, name, track[:, track[0] <= time_s + 1e-6])
            elif (picture := seen.get(kind)) is not None:
                coloured = picture if picture.ndim == 3 else cv2.cvtColor(picture, cv2.COLOR_GRAY2RGB)
                larger = right - left >= picture.shape[1]
                way = cv2.INTER_NEAREST if larger else cv2.INTER_AREA
                frame[top:bottom, left:right] = cv2.resize(coloured, (right - left, bottom - top), interpolation=way)

    def _robot(self, part: Picture, axes: Axes, name: str, track: Floats) -> None:
        if not track.shape[1]:
            return
        left, top, *_ = self._box(axes)
        trail = np.array([self._pixel(axes, x, y) for x, y in track[1:3, -900:].T]) - (left, top)
        x, y, heading = track[1:, -1]
        nose = np.subtract(self._pixel(axes, x + 2.2 * np.cos(heading), y + 2.2 * np.sin(heading)), (left, top))
        colour, one = OBSERVER if name == "observer" else OTHER, self._pixel(axes, x + ROBOT_CM, y)[0] - left
        cv2.polylines(part, [np.rint(trail * 16).astype(np.int32)], False, colour, 1, cv2.LINE_AA, 4)
        centre = tuple(np.rint(trail[-1] * 16).astype(int).tolist())
        cv2.circle(part, centre, round(16 * (one - trail[-1][0])), colour, -1, cv2.LINE_AA, 4)
        cv2.line(part, centre, tuple(np.rint(nose * 16).astype(int).tolist()), (255, 255, 255), 2, cv2.LINE_AA, 4)

    def _box(self, axes: Axes) -> tuple[int, int, int, int]:
        """Return left, top, right and bottom of axes, px."""
        box = axes.get_window_extent()
        height = self._size[1]
        return round(box.x0) + 1, height - round(box.y1) + 1, round(box.x1), height - round(box.y0)

    def _pixel(self, axes: Axes, x: float, y: float) -> tuple[float, float]:
        across, up = axes.transData.transform((x, y))
        return float(across), self._size[1] - float(up)


def _ground(reel: Reel) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return the square of ground in cm that a plan shows: of an episode the arena, of a trial what is near robots."""
    if "env" in reel.properties:
        half = ARENA_RADIUS_CM + 2.0
        return (-half, half), (-half, half)
    places = np.hstack([track[1:3] for track in reel.tracks.values()])
    middle, half = (places.max(1) + places.min(1)) / 2, float(np.ptp(places, axis=1).max()) / 2 + ROOM_CM
    return (middle[0] - half, middle[0] + half), (middle[1] - half, middle[1] + half)


def _caption(reel: Reel, given: str | None) -> str:
    experiment = reel.properties.get("experiment")
    name = f"{experiment}: {reel.name.partition(' ')[2] or reel.name}" if experiment else reel.name
    return name if given is None else given


def _seen(reel: Reel, times: Sequence[float]) -> dict[str, Iterator[Picture | None]]:
    seen = {eye: _latest(pictures_of(reel.path, eye), times) for eye in reel.eyes}
    if reel.eyes:
        seen["change"] = _latest(changes(pictures_of(reel.path, next(iter(reel.eyes)))), times)
    return seen


def film_times(reel: Reel, rate: float | None = None, speed: float = 1.0, ending: str = ".mp4") -> tuple[Floats, float]:
    """Return the times of the recording that a film shows, and its frames a second."""
    usual = min(reel.rate, GIF_RATE) if ending == ".gif" else reel.rate
    shown = rate or min(usual, MOST_HZ)
    if rate is None and speed == 1.0 and shown == reel.rate:
        return reel.time_s, shown
    length = float(np.ptp(reel.time_s))
    return reel.time_s[0] + np.arange(int(length / speed * shown + 1e-6) + 1) * speed / shown, shown


def make(
    reel: Reel, out: Path, size: tuple[int, int] | None = None, caption: str | None = None, rate: float | None = None,
    speed: float = 1.0, advance: Callable[[], None] = lambda: None,
) -> int:  # fmt: skip
    """Write a film of a recording; no more than a few frames are in memory at any time.

    Parameters
    ----------
    reel
        The recording.
    out
        The file: ``.mp4`` (H.264), ``.gif`` or ``.webp``.
    size
        Width and height, px, even for ``.mp4``; otherwise 1280x720, of a GIF 640x360.
    caption
        The text at the top; otherwise what the recording is of.
    rate
        Frames a second; otherwise the recording's, in a GIF at most `GIF_RATE`.
    speed
        Seconds of the recording in a second of the film.
    advance
        Called after each frame.

    Returns
    -------
    int
        The number of frames.

    Raises
    ------
    UsageError
        The size is not legal.
    """
    size = size or ((640, 360) if out.suffix == ".gif" else (1280, 720))
    if out.suffix == ".mp4" and any(length % 2 for length in size):
        raise UsageError(f"--size {size[0]}x{size[1]}: H.264 has even sizes only")
    times, shown = film_times(reel, rate, speed, out.suffix)
    with writer(out, size, shown) as take:
        for frame in frames(reel, times.tolist(), size, caption):
            take(frame)
            advance()
    return len(times)


def frames(reel: Reel, times: Sequence[float], size: tuple[int, int], caption: str | None = None) -> Iterator[Picture]:
    """Draw the frames of rising times, (H, W, 3) uint8 each, reading pictures as they are needed."""
    canvas, seen = Canvas(reel, size, _caption(reel, caption)), _seen(reel, times)
    for time_s, found in zip(times, zip(*seen.values(), strict=True) if seen else itertools.repeat(()), strict=False):
        yield canvas.frame(time_s, dict(zip(seen, found, strict=True)))


def strip(
    reel: Reel, out: Path, count: int = 6, size: tuple[int, int] | None = None, caption: str | None = None
) -> None:
    """Write a strip as a PNG file: ``count`` moments side by side, and below them the traces with a line at each."""
    kinds = len(reel.eyes) + bool(reel.eyes) + bool(reel.tracks)
    size = size or (1800, round(kinds * 1800 / count * 0.8 + 150 + 200 * min(len(reel.values), 4)))
    moments = np.linspace(reel.time_s[0], reel.time_s[-1], count).tolist()
    found = {eye: list(latest) for eye, latest in _seen(reel, moments).items()}
    picture = Canvas(reel, size, _caption(reel, caption), moments).strip(moments, found)
    with replacing(out) as partial:
        partial.write_bytes(cv2.imencode(".png", cv2.cvtColor(picture, cv2.COLOR_RGB2BGR))[1].tobytes())


def require_encoder(asked: str) -> None:
    """Raise `UsageError` in one line that begins with what was ``asked`` for if it cannot be encoded here."""
    try:
        import imageio_ffmpeg  # noqa: F401
    except ImportError:
        raise UsageError(f"{asked} needs {EXTRA}") from None


@contextmanager
def writer(out: Path, size: tuple[int, int], rate: float) -> Iterator[Callable[[Picture], object]]:
    """Open a file of moving pictures; yields what takes its frames, (H, W, 3) uint8, one after the other.

    The file has its name once it is whole. Raises ``OSError`` if it cannot be written.
    """
    import imageio_ffmpeg

    source = ["-f", "rawvideo", "-pix_fmt", "rgb24", "-s", f"{size[0]}x{size[1]}", "-r", f"{rate}", "-i", "-"]
    with replacing(out) as partial:
        command = [imageio_ffmpeg.get_ffmpeg_exe(), "-y", *source, "-an", *CODING[out.suffix].split(), "-v", "fatal"]
        # Ctrl-C is meant for this process, which then ends the encoder.
        process = subprocess.Popen([*command, str(partial)], stdin=subprocess.PIPE, start_new_session=True)
        assert process.stdin is not None
        pipe = process.stdin
        try:
            yield lambda frame: pipe.write(np.ascontiguousarray(frame).data)
            pipe.close()
            if status := process.wait():
                raise OSError(f"{out}: ffmpeg ended with status {status}")
        finally:
            process.kill()
            with contextlib.suppress(OSError):
                pipe.close()
            process.wait()


def _flat(batch: pa.RecordBatch, column: str) -> Floats:
    """Return all numbers of a column of lists, of any depth."""
    values: Any = batch[column]
    while pa.types.is_list(values.type) or pa.types.is_fixed_size_list(values.type):
        values = values.flatten()
    flat: Floats = values.to_numpy(zero_copy_only=False).astype(np.float64)
    return flat
