"""The moving part of a video's frames: pictures, robots, traces up to now."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import cv2
import matplotlib as mpl
import numpy as np
import numpy.typing as npt
from PIL import Image, ImageDraw, ImageFont

from colias_sim.config import CameraConfig
from experiments.bench.run.record import Colour
from experiments.bench.video.layout import WINDOW_S, Layout, Panel, seeing, traces_of
from experiments.bench.video.outside import Outside
from experiments.bench.video.pictures import Floats, Picture
from experiments.bench.video.reading import Reel, Trace, Track, until
from experiments.bench.video.still import TYPE_PX, spike_ends
from scenes import ARENA_RADIUS_CM

ROBOT_RADIUS_CM = 2.0
VIEW: Colour = (250, 233, 180)
SIGHT_CM = ARENA_RADIUS_CM - 0.3
"""Radius to which the observer's field of view is drawn: up to the line of the wall."""
TRAIL_FRAMES = 900
"""Number of frames a robot's trail goes back."""
NOW: Colour = (60, 60, 60)
ARROW: Colour = (255, 255, 255)
SMALLEST = 0.1
"""Share of its largest potential from which on a model's answer is drawn as an arrow of motion."""
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
    outside
        What draws the view from outside, if the layout has one.
    """

    def __init__(self, reel: Reel, layout: Layout, base: Picture, outside: Outside | None = None) -> None:
        self._reel, self._layout, self._base, self._outside = reel, layout, base, outside
        fonts = Path(mpl.get_data_path()) / "fonts" / "ttf"
        self._font = ImageFont.truetype(str(fonts / "DejaVuSansMono.ttf"), max(round(0.9 * TYPE_PX * layout.scale), 7))
        spikes = [trace for trace in reel.traces if trace.place == "spikes"]
        self._counted = next((trace for trace in spikes if trace.channel == "hs"), spikes[0] if spikes else None)
        self._counts = np.array([]) if self._counted is None else np.abs(self._counted.values).cumsum()

    def frame(self, time_s: float, pictures: Sequence[Picture | None], change: Picture | None) -> Picture:
        """Draw the frame of a time.

        Parameters
        ----------
        time_s
            The time, in seconds.
        pictures
            What each eye saw last; ``None`` before its first picture.
        change
            What changed in the first eye's last picture.

        Returns
        -------
        ndarray
            (H, W, 3) uint8, RGB.
        """
        frame, layout = self._base.copy(), self._layout
        for panel, picture in zip(layout.eyes, pictures, strict=True):
            if picture is not None:
                self.picture(frame, panel, picture, time_s)
        if layout.change is not None and change is not None:
            self.change(frame, layout.change, change, time_s)
        if layout.outside is not None:
            self.outside(frame, layout.outside, time_s)
        if layout.plan is not None:
            self.plan(frame, layout.plan, time_s)
        for model, panel in layout.lanes.items():
            self._lane(frame, panel, model, time_s)
        self._time(frame, time_s)
        return frame

    def outside(self, frame: Picture, panel: Panel, time_s: float) -> None:
        """Put the view from outside into a panel."""
        if self._outside is not None:
            _put(frame, panel, self._outside.at(time_s))

    def change(self, frame: Picture, panel: Panel, change: Picture, time_s: float) -> None:
        """Put what changed into a panel, and the arrow of the motion that the first model with HS and VS answers."""
        _put(frame, panel, change)
        hs, vs = (self._first(channel) for channel in ("hs", "vs"))
        if hs is None or not (known := until(hs.time_s, time_s)):
            return
        largest = max(float(np.abs(hs.values).max()), max(map(abs, self._reel.levels), default=0.0), 1e-9)
        motion = np.array([hs.values[known - 1], 0.0 if vs is None else vs.values[known - 1]]) / largest
        length = float(np.hypot(*motion))
        if length < SMALLEST:
            return
        reach = 0.36 * panel.width * motion / max(length, 1.0)  # rightward and downward are positive, as in the picture
        width = min(5.0 * self._layout.scale, float(np.hypot(*reach)) / 6)  # a short arrow keeps its shaft
        bottom = panel.top + panel.height  # the arrow stands as low as it can, where pictures have the ground
        middle = np.array([panel.left + panel.width / 2, bottom - abs(reach[1]) / 2 - 3.0 * width])
        _arrow(frame, middle - reach / 2, middle + reach / 2, width)

    def _first(self, channel: str) -> Trace | None:
        """Return the potential of a channel of the model whose answer the arrow is."""
        potentials = traces_of(self._reel, seeing(self._reel))
        return next((trace for trace in potentials if trace.channel == channel), None)

    def picture(self, frame: Picture, panel: Panel, picture: Picture, time_s: float) -> None:
        """Put a picture into its panel, with a mark where models see something at that time."""
        left, top, width, height = _put(frame, panel, picture)
        for trace in (trace for trace in self._reel.traces if trace.place == "azimuth"):
            if known := until(trace.time_s, time_s):
                across = left + width * (float(np.clip(trace.values[known - 1], -1, 1)) + 1) / 2
                size = 9 * self._layout.scale
                tip = np.array([[across, top + height - size], [across - size / 2, top + height],
                                [across + size / 2, top + height]])  # fmt: skip
                cv2.fillPoly(frame, [_fixed(tip)], trace.colour, cv2.LINE_AA, _BITS)

    def plan(self, frame: Picture, panel: Panel, time_s: float) -> None:
        """Draw the robots as discs with their heading and trail, and the observer's field of view, into a panel."""
        left, top, width, height = (int(v) for v in (panel.left, panel.top, panel.width, panel.height))
        part = frame[top : top + height, left : left + width]  # drawing beyond it is cut off
        local = replace(panel, left=0, top=0)
        _view(part, local, self._reel.tracks[0], time_s, self._reel.view_deg)
        for track in reversed(self._reel.tracks):
            self._robot(part, local, track, time_s)

    def _robot(self, part: Picture, panel: Panel, track: Track, time_s: float) -> None:
        known = max(until(track.time_s, time_s), 1)
        trail = track.poses[max(known - TRAIL_FRAMES, 0) : known]
        x, y, heading = trail[-1]
        scale, per_cm = self._layout.scale, panel.width / (panel.x[1] - panel.x[0])
        if len(trail) > 1:
            _line(part, panel.pixels(trail[:, 0], trail[:, 1]), track.colour, 1.2 * scale)
        (centre,) = panel.pixels(np.array([x]), np.array([y]))
        radius = round(ROBOT_RADIUS_CM * per_cm * 2**_BITS)
        cv2.circle(part, tuple(_fixed(centre).tolist()), radius, track.colour, -1, cv2.LINE_AA, _BITS)
        if np.isfinite(heading):
            nose = panel.pixels(x + np.array([0.0, 2.2]) * np.cos(heading), y + np.array([0.0, 2.2]) * np.sin(heading))
            _line(part, nose, (255, 255, 255), 2.0 * scale)

    def _lane(self, frame: Picture, panel: Panel, model: str, time_s: float) -> None:
        for trace in (*traces_of(self._reel, model), *traces_of(self._reel, model, "spikes")):
            last = until(trace.time_s, time_s)
            first = until(trace.time_s, time_s - WINDOW_S) if self._layout.moving else 0
            times = trace.time_s[first:last] - (time_s if self._layout.moving else 0.0)
            values = trace.values[first:last]
            if trace.place == "spikes":
                fired = values != 0
                ends = spike_ends(panel, trace.values)[first:last][fired]
                for at, (edge, end) in zip(times[fired], ends, strict=True):
                    stroke = panel.pixels(np.array([at, at]), np.array([edge, end]))
                    _line(frame, stroke, trace.colour, 2.4 * self._layout.scale)
            elif trace.dotted:  # dots beside the line of another channel leave both to be seen
                self._dots(frame, panel.pixels(times, values), trace.colour)
            elif len(times) > 1:
                _line(frame, panel.pixels(times, values), trace.colour, 3.0 * self._layout.scale)
        if not self._layout.moving:
            _line(frame, panel.pixels(np.array([time_s, time_s]), np.array(panel.y)), NOW, 1.4 * self._layout.scale)

    def _dots(self, frame: Picture, points: Floats, colour: Colour) -> None:
        radius = round(2.2 * self._layout.scale * 2**_BITS)
        for centre in _fixed(points):
            cv2.circle(frame, tuple(centre.tolist()), radius, colour, -1, cv2.LINE_AA, _BITS)

    def _time(self, frame: Picture, time_s: float) -> None:
        """Draw the time and the spikes so far, at the top right."""
        text = f"{self.spikes_so_far(time_s)}  {time_s:6.2f} s"
        width, scale = round(self._font.getlength(text)) + 4, self._layout.scale
        left, high = max(frame.shape[1] - round(20 * scale) - width, 0), round(36 * scale)
        top = max(round(27 * scale) - high // 2, 0)
        part = Image.fromarray(frame[top : top + high, left : left + width])
        ImageDraw.Draw(part).text((2, high // 2), text, font=self._font, fill=(20, 20, 20), anchor="lm")
        frame[top : top + high, left : left + width] = np.asarray(part)

    def spikes_so_far(self, time_s: float) -> str:
        """Return the spikes so far of the only model, in words; empty of several, or of none that spikes.

        They are those of HS, which tables and figures count, or of looming.
        """
        trace = self._counted
        if len(self._layout.lanes) != 1 or trace is None:
            return ""
        known = until(trace.time_s, time_s)
        count = int(self._counts[known - 1]) if known else 0
        return f"{count} {'HS ' if trace.channel == 'hs' else ''}spike{'' if count == 1 else 's'}"


def _view(part: Picture, panel: Panel, track: Track, time_s: float, view_deg: float) -> None:
    """Draw the observer's field of view, from its lens to the wall; what is drawn already stays to be seen."""
    x, y, heading = track.pose_at(time_s)
    if not np.isfinite(heading):
        return
    directions = heading + np.radians(np.linspace(-view_deg / 2, view_deg / 2, 33))
    rays = np.column_stack([np.cos(directions), np.sin(directions)])
    lens = np.array([np.cos(heading), np.sin(heading)]) * CameraConfig().forward_cm + (x, y)
    along = rays @ lens
    lengths = np.sqrt(np.maximum(along**2 + SIGHT_CM**2 - lens @ lens, 0.0)) - along
    corners = np.vstack([lens, lens + np.maximum(lengths, 0.0)[:, None] * rays])
    tint = np.full_like(part, 255)
    cv2.fillPoly(tint, [_fixed(panel.pixels(corners[:, 0], corners[:, 1]))], VIEW, cv2.LINE_AA, _BITS)
    np.minimum(part, tint, out=part)


def _put(frame: Picture, panel: Panel, picture: Picture) -> tuple[int, int, int, int]:
    """Put a picture into a panel, and return the panel's left, top, width and height."""
    left, top, width, height = (int(v) for v in (panel.left, panel.top, panel.width, panel.height))
    larger = width >= picture.shape[1]
    frame[top : top + height, left : left + width] = cv2.resize(
        picture, (width, height), interpolation=cv2.INTER_NEAREST if larger else cv2.INTER_AREA
    )
    return left, top, width, height


def _arrow(frame: Picture, tail: Floats, tip: Floats, width: float) -> None:
    """Draw an arrow of a shaft and a head."""
    along = (tip - tail) / np.linalg.norm(tip - tail)
    across = np.array([-along[1], along[0]])
    neck = tip - 3.4 * width * along
    _line(frame, np.vstack([tail, neck]), ARROW, width)
    head = np.vstack([tip, neck + 2.2 * width * across, neck - 2.2 * width * across])
    cv2.fillPoly(frame, [_fixed(head)], ARROW, cv2.LINE_AA, _BITS)


def _fixed(points: Floats) -> npt.NDArray[np.int32]:
    fixed: npt.NDArray[np.int32] = np.rint(np.asarray(points) * 2**_BITS).astype(np.int32)
    return fixed


def _line(frame: Picture, points: Floats, colour: Colour, width: float) -> None:
    cv2.polylines(frame, [_fixed(points)], False, colour, max(round(width), 1), cv2.LINE_AA, _BITS)
