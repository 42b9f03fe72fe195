"""The moving part of a video's frames: pictures, robots, traces up to now."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import cv2
import matplotlib as mpl
import numpy as np
import numpy.typing as npt
from PIL import Image, ImageDraw, ImageFont

from colias_sim.config import CameraConfig
from experiments.bench.video.layout import WINDOW_S, Layout, Panel, traces_of
from experiments.bench.video.pictures import Floats, Picture
from experiments.bench.video.reading import Colour, Reel, Track
from scenes import ARENA_RADIUS_CM

ROBOT_RADIUS_CM = 2.0
VIEW: Colour = (250, 233, 180)
SIGHT_CM = ARENA_RADIUS_CM - 0.3
"""Radius to which the observer's field of view is drawn: up to the line of the wall."""
TRAIL_FRAMES = 900
"""Number of frames a robot's trail goes back."""
NOW: Colour = (60, 60, 60)
_BITS = 4  # below the pixel, in OpenCV's drawing calls


class Drawer:
    """Draws the frames of one recording.

    Parameters
    ----------
    reel
        The recording.
    layout
        Where its panels are.
    base
        The still part of each frame, (H, W, 3) uint8, RGB.
    """

    def __init__(self, reel: Reel, layout: Layout, base: Picture) -> None:
        self._reel, self._layout, self._base = reel, layout, base
        fonts = Path(mpl.get_data_path()) / "fonts" / "ttf"
        self._font = ImageFont.truetype(str(fonts / "DejaVuSansMono.ttf"), max(round(17 * layout.scale), 7))
        self._counts = {id(trace): np.abs(trace.values).cumsum() for trace in reel.traces if trace.place == "spikes"}

    def frame(self, time_s: float, pictures: Sequence[Picture | None]) -> Picture:
        """Draw the frame of a time.

        Parameters
        ----------
        time_s
            The time, in seconds.
        pictures
            What each eye saw last; ``None`` before its first picture.

        Returns
        -------
        ndarray
            (H, W, 3) uint8, RGB.
        """
        frame, layout = self._base.copy(), self._layout
        for panel, picture in zip(layout.eyes, pictures, strict=True):
            if picture is not None:
                self.picture(frame, panel, picture, time_s)
        if layout.plan is not None:
            self.plan(frame, layout.plan, time_s)
        for key, panel in layout.traces.items():
            self._traces(frame, panel, key, time_s)
        self._time(frame, time_s)
        return frame

    def picture(self, frame: Picture, panel: Panel, picture: Picture, time_s: float) -> None:
        """Put a picture into its panel, with a mark where models see something at that time."""
        left, top, width, height = (int(v) for v in (panel.left, panel.top, panel.width, panel.height))
        larger = width >= picture.shape[1]
        frame[top : top + height, left : left + width] = cv2.resize(
            picture, (width, height), interpolation=cv2.INTER_NEAREST if larger else cv2.INTER_AREA
        )
        for trace in (trace for trace in self._reel.traces if trace.place == "azimuth"):
            until = _until(trace.time_s, time_s)
            if until:
                across = left + width * (float(np.clip(trace.values[until - 1], -1, 1)) + 1) / 2
                size = 9 * self._layout.scale
                tip = np.array([[across, top + height - size], [across - size / 2, top + height],
                                [across + size / 2, top + height]])  # fmt: skip
                cv2.fillPoly(frame, [_fixed(tip)], trace.colour, cv2.LINE_AA, _BITS)

    def plan(self, frame: Picture, panel: Panel, time_s: float) -> None:
        """Draw the robots as discs with their heading and trail, and the observer's field of view, into a panel."""
        left, top, width, height = (int(v) for v in (panel.left, panel.top, panel.width, panel.height))
        part = frame[top : top + height, left : left + width]  # drawing beyond it is cut off
        local = Panel(0, 0, panel.width, panel.height, panel.x, panel.y)
        _view(part, local, self._reel.tracks[0], time_s, self._reel.view_deg)
        for track in reversed(self._reel.tracks):
            self._robot(part, local, track, time_s)

    def _robot(self, part: Picture, panel: Panel, track: Track, time_s: float) -> None:
        until = max(_until(track.time_s, time_s), 1)
        x, y, heading = track.poses[until - 1]
        trail = track.poses[max(until - TRAIL_FRAMES, 0) : until]
        scale, per_cm = self._layout.scale, panel.width / (panel.x[1] - panel.x[0])
        if len(trail) > 1:
            _line(part, panel.pixels(trail[:, 0], trail[:, 1]), track.colour, 1.2 * scale)
        (centre,) = panel.pixels(np.array([x]), np.array([y]))
        radius = round(ROBOT_RADIUS_CM * per_cm * 2**_BITS)
        cv2.circle(part, tuple(_fixed(centre).tolist()), radius, track.colour, -1, cv2.LINE_AA, _BITS)
        if np.isfinite(heading):
            nose = panel.pixels(x + np.array([0.0, 2.2]) * np.cos(heading), y + np.array([0.0, 2.2]) * np.sin(heading))
            _line(part, nose, (255, 255, 255), 2.0 * scale)

    def _traces(self, frame: Picture, panel: Panel, key: str, time_s: float) -> None:
        now = 0.0 if self._layout.moving else time_s
        for trace in traces_of(self._reel, key):
            until = _until(trace.time_s, time_s)
            first = _until(trace.time_s, time_s - WINDOW_S) if self._layout.moving else 0
            times = trace.time_s[first:until] - (time_s if self._layout.moving else 0.0)
            values = trace.values[first:until]
            if trace.place == "spikes":
                times, values = times[values != 0], values[values != 0]
            if trace.dotted:  # dots on the strokes of another channel leave both to be seen
                self._dots(frame, panel.pixels(times, values), trace.colour)
            elif trace.place == "spikes":
                for at, value in zip(times, values, strict=True):
                    _line(frame, panel.pixels(np.array([at, at]), np.array([0.0, value])), trace.colour,
                          1.7 * self._layout.scale)  # fmt: skip
            elif len(times) > 1:
                _line(frame, panel.pixels(times, values), trace.colour, 1.8 * self._layout.scale)
        if not self._layout.moving:
            _line(frame, panel.pixels(np.array([now, now]), np.array(panel.y)), NOW, 1.0 * self._layout.scale)

    def _dots(self, frame: Picture, points: npt.NDArray[np.float64], colour: Colour) -> None:
        radius = round(1.8 * self._layout.scale * 2**_BITS)
        for centre in _fixed(points):
            cv2.circle(frame, tuple(centre.tolist()), radius, colour, -1, cv2.LINE_AA, _BITS)

    def _time(self, frame: Picture, time_s: float) -> None:
        """Draw the time and the spikes so far, at the top right."""
        text = f"{self._spikes(time_s)}{time_s:7.2f} s"
        width, scale = round(self._font.getlength(text)) + 4, self._layout.scale
        left, high = max(frame.shape[1] - round(14 * scale) - width, 0), round(26 * scale)
        top = max(round(26 * scale) - high // 2, 0)
        part = Image.fromarray(frame[top : top + high, left : left + width])
        ImageDraw.Draw(part).text((2, high // 2), text, font=self._font, fill=(20, 20, 20), anchor="lm")
        frame[top : top + high, left : left + width] = np.asarray(part)

    def _spikes(self, time_s: float) -> str:
        counts = {trace.name: int(self._counts[id(trace)][until - 1]) if (until := _until(trace.time_s, time_s)) else 0
                  for trace in self._reel.traces if trace.place == "spikes"}  # fmt: skip
        return f"{_listed(counts)} spikes  " if 0 < len(counts) <= 3 else ""


def _view(part: Picture, panel: Panel, track: Track, time_s: float, view_deg: float) -> None:
    """Draw the observer's field of view, from its lens to the wall; what is drawn already stays to be seen."""
    x, y, heading = track.poses[max(_until(track.time_s, time_s), 1) - 1]
    if not np.isfinite(heading):
        return
    bearings = heading + np.radians(np.linspace(-view_deg / 2, view_deg / 2, 33))
    rays = np.column_stack([np.cos(bearings), np.sin(bearings)])
    lens = np.array([np.cos(heading), np.sin(heading)]) * CameraConfig().forward_cm + (x, y)
    along = rays @ lens
    lengths = np.sqrt(np.maximum(along**2 + SIGHT_CM**2 - lens @ lens, 0.0)) - along
    corners = np.vstack([lens, lens + np.maximum(lengths, 0.0)[:, None] * rays])
    tint = np.full_like(part, 255)
    cv2.fillPoly(tint, [_fixed(panel.pixels(corners[:, 0], corners[:, 1]))], VIEW, cv2.LINE_AA, _BITS)
    np.minimum(part, tint, out=part)


def _listed(counts: Mapping[str, int]) -> str:
    return " ".join(f"{name} {count}" for name, count in counts.items())


def _until(times: Floats, time_s: float) -> int:
    """Tell how many entries are not after a time."""
    return int(np.searchsorted(times, time_s + 1e-6))


def _fixed(points: npt.NDArray[np.float64]) -> npt.NDArray[np.int32]:
    fixed: npt.NDArray[np.int32] = np.rint(np.asarray(points) * 2**_BITS).astype(np.int32)
    return fixed


def _line(frame: Picture, points: npt.NDArray[np.float64], colour: Colour, width: float) -> None:
    cv2.polylines(frame, [_fixed(points)], False, colour, max(round(width), 1), cv2.LINE_AA, _BITS)
