"""Places of the panels of a video's frames, and ranges of data that they show."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from experiments.bench.video.pictures import Floats
from experiments.bench.video.reading import Reel, Trace
from scenes import ARENA_RADIUS_CM

LONGEST_WHOLE_S, WINDOW_S = 30.0, 20.0
"""Up to this length the lanes' axis has all of a recording. Of a longer one it has the last seconds, and moves on."""
PLAIN_HEIGHT = 720
"""Height of a frame, in pixels, at which type and lines have their plain size."""
LEFT, RIGHT, BELOW = 112.0, 30.0, 64.0
"""Room about the lanes for the numbers of their axes, at plain size."""
PAD, CAPTION, TITLE = 20.0, 50.0, 38.0
"""Margin of a frame, and room for its caption and for the title above a panel, at plain size."""
ONE_COLUMN, SMALLER = 3, 0.72
"""Lanes in one column at most; the size of type where there are more lanes than one."""
MOST_DOWN, SMALLEST = 6, 0.85
"""Lanes below each other at most, where there are two columns and more; the size of titles where there are more."""
SHARE = 0.66, 0.56, 0.46
"""How far down the pictures reach: above one lane, above up to `ONE_COLUMN`, above more."""
ROOM_CM = 7.0
"""Room about the robots of a plan that does not show the whole arena."""
NEAR_ZERO = 0.05
"""A potential that goes below zero by this share of its peak has a lane with both signs."""
SPIKES = 0.14
"""Share of a lane's height, at its upper and its lower edge, that is left to spikes."""


@dataclass(frozen=True, slots=True)
class Panel:
    """A rectangle of the frame, and the range of data that it shows.

    Parameters
    ----------
    left, top, width, height
        In pixels, from the top left of the frame.
    x, y
        The data at the left and right edge, and at the bottom and top edge.
    """

    left: float
    top: float
    width: float
    height: float
    x: tuple[float, float] = (0.0, 1.0)
    y: tuple[float, float] = (0.0, 1.0)

    def pixels(self, x: Floats, y: Floats) -> Floats:
        """Return where data points are in the frame, (N, 2): column and row."""
        across = self.left + self.width * (np.asarray(x) - self.x[0]) / (self.x[1] - self.x[0])
        down = self.top + self.height * (self.y[1] - np.asarray(y)) / (self.y[1] - self.y[0])
        return np.column_stack([across, down])


@dataclass(frozen=True, slots=True)
class Layout:
    """Places of everything in a frame.

    Parameters
    ----------
    width, height
        Of the frame, in pixels.
    eyes
        A panel for each eye.
    plan
        The arena from above in cm, if robots were recorded and are not seen from outside.
    outside
        The view from outside, if there is one.
    change
        What became brighter and darker before the first eye, if there is one.
    lanes
        Model -> the panel of its potentials, with its spikes at the edges. Its x is the time in s, or that before now
        where it moves on.
    moving
        Whether the lanes' axes move on.
    scale
        Size of type and lines, 1 at `PLAIN_HEIGHT`.
    """

    width: int
    height: int
    eyes: tuple[Panel, ...]
    plan: Panel | None
    outside: Panel | None
    change: Panel | None
    lanes: Mapping[str, Panel]
    moving: bool
    scale: float


def lay_out(reel: Reel, aspects: Sequence[float], width: int, height: int, *, outside: float | None = None) -> Layout:
    """Place the panels of a recording in a frame: the way from the world to the network above, its answers below.

    Parameters
    ----------
    reel
        The recording.
    aspects
        Width over height of each eye's pictures.
    width, height
        Of the frame, in pixels.
    outside
        Width over height of the view from outside; ``None``: a plan shows the robots.

    Returns
    -------
    Layout
        The panels.
    """
    scale = min(height / PLAIN_HEIGHT, width / 960)
    models = lanes_of(reel)
    crowd = 0 if len(models) <= 1 else 1 if len(models) <= ONE_COLUMN else 2
    shapes = [*([] if outside is None else [outside]), *aspects, *aspects[:1]]
    if outside is None and reel.tracks:
        shapes.insert(0, 1.0)
    head = (CAPTION + TITLE) * scale
    bottom = SHARE[crowd] * height - TITLE * scale if models else height - PAD * scale
    panels = _row(shapes, (PAD * scale, head, width - PAD * scale, bottom), scale)
    first = panels.pop(0) if outside is not None or reel.tracks else None
    change = panels.pop() if aspects else None
    plan = None
    if outside is None and first is not None:
        x, y = ground(reel)
        plan = replace(first, x=x, y=y)
    top = (max((p.top + p.height for p in panels), default=bottom) if shapes else CAPTION * scale) + TITLE * scale
    box, moving = (LEFT * scale, top, width - RIGHT * scale, height - BELOW * scale), moves_on(reel)
    lanes = lane_panels(reel, box, scale, moving=moving)
    return Layout(width, height, tuple(panels), plan, None if outside is None else first, change, lanes, moving, scale)


def lanes_of(reel: Reel) -> list[str]:
    """Return the models with potentials or spikes, which have a lane each."""
    answering = [trace.model for trace in reel.traces if trace.place in ("potential", "spikes")]
    return list(dict.fromkeys(answering))


def moves_on(reel: Reel) -> bool:
    """Tell whether a recording is too long to show its traces whole."""
    return float(np.ptp(reel.time_s)) > LONGEST_WHOLE_S


def _row(shapes: Sequence[float], box: tuple[float, float, float, float], scale: float) -> list[Panel]:
    """Return panels of these shapes side by side, equally high, as large as the box allows."""
    if not shapes:
        return []
    left, top, right, bottom = box
    gap = 18.0 * scale
    high = min(bottom - top, (right - left - gap * (len(shapes) - 1)) / sum(shapes))
    across = left + (right - left - sum(shapes) * high - gap * (len(shapes) - 1)) / 2
    panels = []
    for shape in shapes:
        panels.append(Panel(round(across), round(top), round(shape * high), round(high)))
        across += shape * high + gap
    return panels


def ground(reel: Reel) -> tuple[tuple[float, float], tuple[float, float]]:
    """Find the square of ground in cm that a plan shows.

    Of an episode that is the whole arena. Of a trial it is what is near the robots, with each obstacle that stands in
    the camera's field of view.
    """
    if "env" in reel.properties:
        half = ARENA_RADIUS_CM + 2.0
        return (-half, half), (-half, half)
    seen = [outline for outline in reel.obstacles if _in_view(reel, outline)]
    places = np.concatenate([*(track.poses[:, :2] for track in reel.tracks), *seen])
    middle, half = (places.max(0) + places.min(0)) / 2, float(np.ptp(places, axis=0).max()) / 2 + ROOM_CM
    return (middle[0] - half, middle[0] + half), (middle[1] - half, middle[1] + half)


def _in_view(reel: Reel, outline: Floats) -> bool:
    """Tell whether any corner of an obstacle was ever in the observer's field of view."""
    poses = reel.tracks[0].poses[:, None]
    away = outline[None] - poses[..., :2]
    off = np.arctan2(away[..., 1], away[..., 0]) - poses[..., 2]
    return bool((np.abs(np.angle(np.exp(1j * off))) <= math.radians(reel.view_deg / 2)).any())


def seeing(reel: Reel) -> str:
    """Return the first model that answers with HS, whose answer the arrow of motion is; empty if none does."""
    return next((trace.model for trace in reel.traces if trace.channel == "hs"), "")


def traces_of(reel: Reel, model: str, place: str = "potential") -> list[Trace]:
    """Return the potentials of a model, or its spikes."""
    return [trace for trace in reel.traces if trace.place == place and trace.model == model]


def levels_of(reel: Reel, model: str) -> list[float]:
    """Return the thresholds of a model; of a recording that does not tell whose they are, all."""
    return [level for level in reel.levels if model in reel.owners.get(level, (model,))]


def lane_panels(
    reel: Reel, box: tuple[float, float, float, float], scale: float, *, moving: bool
) -> dict[str, Panel]:  # fmt: skip
    """Place the lanes in a box (left, top, right, bottom), in pixels: below each other, in columns where many.

    Their axis has all of the recording's time, or that before now where it is ``moving`` on.
    """
    left, top, right, bottom = box
    models = lanes_of(reel)
    if not models:
        return {}
    columns = 1 if len(models) <= ONE_COLUMN else max(2, math.ceil(len(models) / MOST_DOWN))
    rows = math.ceil(len(models) / columns)
    gap, between = TITLE * SMALLER * scale, LEFT * scale
    wide, high = (right - left - between * (columns - 1)) / columns, (bottom - top - gap * (rows - 1)) / rows
    x = (-WINDOW_S, 0.0) if moving else (float(reel.time_s[0]), float(reel.time_s[-1]) + 1e-6)
    return {
        model: Panel(left + (place // rows) * (wide + between), top + (place % rows) * (high + gap), wide, high,
                     x, _range(reel, model))
        for place, model in enumerate(models)
    }  # fmt: skip


def _range(reel: Reel, model: str) -> tuple[float, float]:
    """Return the potentials that a lane shows: equal in all lanes, but where one leaves -1 to 1.

    Spikes have the lane's edges to themselves; below only where a spike or a potential is negative.
    """
    traces = traces_of(reel, model)
    if all(map(_bounded, traces)):
        traces = [trace for trace in reel.traces if trace.place == "potential" and _bounded(trace)]
        levels = list(reel.levels)
    else:
        levels = levels_of(reel, model)
    spikes = [trace.values for trace in reel.traces if trace.place == "spikes"]
    ends = [float(end(trace.values)) for trace in traces for end in (np.nanmin, np.nanmax)] + [0.0]
    negative = min(ends) < -NEAR_ZERO * max(ends) or any((values < 0).any() for values in spikes)
    low = min([*ends, *(level for level in levels if negative or level > 0)])
    high = max([*ends, *levels, 0.1])
    room = (high - low) * SPIKES / (1 - (2 if negative else 1.4) * SPIKES)
    return low - room * (1.0 if negative else 0.4), high + room


def _bounded(trace: Trace) -> bool:
    """Tell whether a potential stays where those of networks are: that of optic flow counts pixels."""
    return bool(np.nanmax(np.abs(trace.values)) <= 1.0)
