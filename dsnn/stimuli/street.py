"""A street scene: people or cars that cross in front of houses, among leaves in the wind.

It imitates the paper's real footage: "a campus avenue and a street view", 320 x 180 px at 30 Hz. There are a pedestrian
each way, a car, translations in both directions, groups, and "windblown vegetation". The paper gives no sizes and no
speeds. Here a walker is 90 px high and moves at 70 px/s, which is 1.4 m/s for a person of 1.75 m. Leaves sway as in
`foliage`.
"""

from __future__ import annotations

from functools import cached_property
from typing import Annotated, Literal

import cv2
import numpy as np
import numpy.typing as npt
from pydantic import Field

from dsnn.field_docs import parameters, unit
from dsnn.stimuli.foliage import Amplitude, Sway, check_band
from dsnn.stimuli.movers import WHEEL_GREY, Kind, Mover, group
from dsnn.stimuli.moving import paint
from dsnn.stimuli.scenes import PINK_MEAN, PINK_SD, pink
from dsnn.stimuli.stimulus import Box, ClipParams, Luma, Stimulus, StimulusFrame, Truth
from dsnn.stimuli.streams import stream

Floats = npt.NDArray[np.float32]

GROUND_ROW = 0.93
"""Place of the nearest movers' feet, in shares of the frame's rows."""
LEAVES_MEAN, LEAVES_SD = 80.0, 35.0
CROWNS = ((0.16, 0.28, 0.20, 0.32), (0.84, 0.30, 0.18, 0.30))
"""Foliage behind the movers: column and row of the middle, half width and half height, in shares of the frame."""
BUSHES = ((0.30, 0.98, 0.13, 0.13), (0.72, 1.00, 0.17, 0.13))
"""Foliage in front of the movers, over their feet."""
RAGGED, EDGE = 0.15, 8.0
"""Distance that leaves stick out of a crown, as a share of its radius, and sharpness of its rim."""


@parameters
class StreetParams(ClipParams):
    """Parameters of a street: its movers, and the wind, which blows from the first frame to the last."""

    movers: Literal["one", "opposite", "group"] = "one"
    """Who crosses. one: one mover; opposite: a second one the opposite way after the first; group: several, one way."""
    motion: Literal["rightward", "leftward"] = "rightward"
    """Direction of the first mover, or of the group."""
    object: Literal["present", "absent"] = "present"
    """Whether the movers are present; absent: only the street, for the same time."""
    kind: Kind = "person"
    """Who moves: person or car."""
    height: Annotated[float, unit("px")] = Field(default=90.0, ge=4.0, le=4096.0)
    """Height of the movers; in a group, of the nearest."""
    speed: Annotated[float, unit("px/s")] = Field(default=70.0, gt=0.0, le=10_000.0)
    """Speed of the movers; in a group, the nearest one's mean."""
    grey: Annotated[float, unit("grey levels")] = Field(default=40.0, ge=0.0, le=255.0)
    """Grey level of a person's trunk or a car's body; a group has random greys."""
    count: int = Field(default=5, ge=1, le=100)
    """Number of movers in a group."""
    gap_s: Annotated[float, unit("s")] = Field(default=1.0, ge=0.0, le=60.0)
    """Time between two movers with nobody in view."""
    rest_s: Annotated[float, unit("s")] = Field(default=0.5, ge=0.0, le=60.0)
    """Stillness before the first mover and after the last."""
    foliage: Literal["windblown", "none"] = "windblown"
    """Whether leaves sway in the wind in front of the house."""
    amplitude_px: tuple[Amplitude, Amplitude] = (2.0, 0.5)
    """Standard deviation of the displacement of leaves within a field, along x and y."""
    low_hz: Annotated[float, unit("Hz")] = Field(default=0.5, gt=0.0, le=500.0)
    """Lowest frequency of the sway."""
    high_hz: Annotated[float, unit("Hz")] = Field(default=3.0, gt=0.0, le=500.0)
    """Highest frequency of the sway."""
    patch_px: Annotated[float, unit("px")] = Field(default=30.0, ge=1.0, le=1000.0)
    """Distance over which leaves sway together."""
    ground: Literal["textured", "even"] = "textured"
    """Ground of the street: a house front and a pavement, or one grey."""
    ground_grey: Annotated[float, unit("grey levels")] = Field(default=150.0, ge=0.0, le=255.0)
    """Mean grey level of the house front."""
    ground_sd: Annotated[float, unit("grey levels")] = Field(default=22.0, ge=0.0, le=127.0)
    """Standard deviation of the house front's texture."""


class Street(Stimulus[StreetParams]):
    """A street with movers. The seed makes house front, leaves, sway and the members of a group.

    The truth's box contains all movers in view, and its velocity is their mean. With no mover in view the motion is
    ``swaying``, or ``still`` without foliage.
    """

    is_continuous = True

    def __init__(self, params: StreetParams, seed: int = 0) -> None:
        super().__init__(params, seed)
        p = params
        check_band(p.low_hz, p.high_hz)
        crossing = _movers(p, stream("street.movers", seed))
        self._movers = crossing if p.object == "present" else ()
        self._frames = int(np.ceil((max(mover.leaves_s for mover in crossing) + p.rest_s) * p.fps)) + 1

    def __len__(self) -> int:
        return self._frames

    # A declaration makes its clips only to check them, so random numbers are drawn with the first frame.

    @cached_property
    def _ground(self) -> Floats:
        return _ground(self.params, stream("street.ground", self.seed))

    @cached_property
    def _blown(self) -> tuple[Floats, Sway]:
        """Draw the leaves at rest, then their sway."""
        p, rng = self.params, stream("street.leaves", self.seed)
        leaves = _leaves(self.shape, rng)
        return leaves, Sway(self.shape, p.amplitude_px, (p.low_hz, p.high_hz), p.patch_px, rng)

    def frame(self, index: int) -> StimulusFrame:
        """Paint frame ``index``."""
        seconds = index / self.fps
        if self.params.foliage == "none":
            luma = _grey(self._ground)
            self._paint_movers(luma, seconds)
            return StimulusFrame(luma, self._truth(seconds))
        at_rest, sway = self._blown
        x, y = sway.places(index, self.fps)
        blown = cv2.remap(at_rest, x, y, cv2.INTER_CUBIC, borderMode=cv2.BORDER_REFLECT)
        leaves, behind, before = blown[..., 0], *np.clip(np.moveaxis(blown[..., 1:], -1, 0), 0.0, 1.0)
        luma = _grey(self._ground + behind * (leaves - self._ground))
        self._paint_movers(luma, seconds)
        return StimulusFrame(_grey(luma + before * (leaves - luma)), self._truth(seconds))

    def _paint_movers(self, luma: Luma, seconds: float) -> None:
        for mover in self._movers:
            if mover.box(seconds).touches(self.shape):
                for box, grey in mover.parts(seconds):
                    paint(luma, box, grey)

    def _truth(self, seconds: float) -> Truth:
        seen = [mover for mover in self._movers if mover.box(seconds).touches(self.shape)]
        if not seen:
            return Truth("still" if self.params.foliage == "none" else "swaying")
        velocity = sum(mover.velocity for mover in seen) / len(seen)
        box = _around([mover.box(seconds) for mover in seen])
        return Truth("rightward" if velocity > 0 else "leftward", box, (velocity, 0.0))


def _movers(p: StreetParams, rng: np.random.Generator) -> tuple[Mover, ...]:
    """Make all movers, in the order of painting."""
    way = 1.0 if p.motion == "rightward" else -1.0
    greys = (p.grey, WHEEL_GREY, 190.0) if p.kind == "car" else (p.grey, 60.0, 120.0)
    first = Mover(p.kind, p.height, way * p.speed, p.rest_s, GROUND_ROW * p.rows, p.columns, greys)
    if p.movers == "group":
        return group(first, p.count, rng)
    if p.movers == "one":
        return (first,)
    enters_s = first.leaves_s + p.gap_s
    return first, Mover(p.kind, p.height, -way * p.speed, enters_s, first.ground, p.columns, greys)


def _ground(p: StreetParams, rng: np.random.Generator) -> Floats:
    """Paint the still background, (R, C): a house front with windows above a darker pavement."""
    shape = rows, columns = p.rows, p.columns
    grey = np.full(shape, p.ground_grey, np.float32)
    if p.ground == "even":
        return grey
    grey += p.ground_sd * (pink(shape, rng) - PINK_MEAN) / PINK_SD
    for left in np.arange(0.06, 1.0, 0.19):
        grey[round(0.10 * rows) : round(0.33 * rows), round(left * columns) : round((left + 0.09) * columns)] -= 55.0
    grey[round(0.82 * rows) :] -= 30.0
    return np.asarray(np.clip(grey, 0.0, 255.0), np.float32)


def _leaves(shape: tuple[int, int], rng: np.random.Generator) -> Floats:
    """Draw leaves at rest, (R, C, 3): their grey, and the coverage by crowns and by bushes."""
    rows, columns = shape
    grey = LEAVES_MEAN + LEAVES_SD * (pink(shape, rng) - PINK_MEAN) / PINK_SD
    ragged = RAGGED * (pink(shape, rng) - PINK_MEAN) / PINK_SD
    down, across = np.mgrid[:rows, :columns] + 0.5
    covers = []
    for patches in (CROWNS, BUSHES):
        inward = [
            1.0 - np.hypot((across / columns - x) / width, (down / rows - y) / height)
            for x, y, width, height in patches
        ]
        covers.append(np.clip(EDGE * (np.max(inward, axis=0) + ragged), 0.0, 1.0))
    return np.stack([np.clip(grey, 0.0, 255.0), *covers], axis=-1).astype(np.float32)


def _around(boxes: list[Box]) -> Box:
    """Return the smallest box that contains all boxes."""
    left, top = min(box.left for box in boxes), min(box.top for box in boxes)
    right, bottom = max(box.left + box.width for box in boxes), max(box.top + box.height for box in boxes)
    return Box(left, top, right - left, bottom - top)


def _grey(luma: npt.NDArray[np.floating]) -> Luma:
    """Round to whole grey levels, in a new array."""
    return np.asarray(np.clip(np.rint(luma), 0.0, 255.0), np.uint8)
