"""One rectangular object: its position in every frame, and its painting with exact coverage of each pixel."""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
import numpy.typing as npt
from pydantic import Field

from dsnn.field_docs import parameters, unit
from dsnn.stimuli.stimulus import STILL, Box, ClipParams, Luma, Truth, Velocity

Direction = Literal["rightward", "leftward", "downward", "upward"]
Motion = Literal["rightward", "leftward", "downward", "upward", "looming", "receding"]
SpeedUnit = Literal["px/s", "px/frame"]

DIRECTIONS: dict[str, tuple[int, int]] = {
    "rightward": (1, 0),
    "leftward": (-1, 0),
    "downward": (0, 1),
    "upward": (0, -1),
}


def per_second(speed: float, unit: SpeedUnit, fps: float) -> float:
    """Convert ``speed`` to px/s."""
    return speed if unit == "px/s" else speed * fps


@parameters
class ObjectParams(ClipParams):
    """Parameters of a rectangle that crosses the frame, looms or recedes.

    Looming and receding have constant speed: the size is inversely proportional to the time to contact.
    """

    motion: Motion = "rightward"
    """Kind or direction of the object's motion."""
    width: Annotated[float, unit("px")] = Field(default=50.0, gt=0.0, le=4096.0)
    """Width of the object at scale 1."""
    height: Annotated[float, unit("px")] = Field(default=90.0, gt=0.0, le=4096.0)
    """Height of the object at scale 1."""
    grey: Annotated[float, unit("grey levels")] = Field(default=40.0, ge=0.0, le=255.0)
    """Grey level of the object."""
    speed: Annotated[float, unit("speed_unit")] = Field(default=120.0, gt=0.0, le=10_000.0)
    """Speed of translation."""
    speed_unit: SpeedUnit = "px/s"
    """Unit of every speed; the paper writes px/frame."""
    enters: bool = True
    """Whether the object starts and ends outside the frame; false: it starts and ends at rest, wholly inside the
    frame."""
    offset: Annotated[float, unit("px")] = Field(default=0.0, ge=-4096.0, le=4096.0)
    """Distance of the path from the frame's centre, right or down positive."""
    far_scale: float = Field(default=0.2, gt=0.0, le=100.0)
    """Size at the far end of looming and receding."""
    near_scale: float = Field(default=1.8, gt=0.0, le=100.0)
    """Size at the near end of looming and receding."""
    duration_s: Annotated[float, unit("s")] = Field(default=2.0, gt=0.0, le=600.0)
    """Duration of looming or receding."""
    rest_s: Annotated[float, unit("s")] = Field(default=0.3, ge=0.0, le=60.0)
    """Stillness before and after the motion."""


class ObjectPath:
    """Positions of an object in every frame: at rest, in motion, at rest.

    It raises ``ValueError`` if the object has no room to move, or would not approach by looming.
    """

    def __init__(self, params: ObjectParams) -> None:
        p = self._params = params
        self._rest = round(p.rest_s * p.fps)
        self._speed = per_second(p.speed, p.speed_unit, p.fps)
        if p.motion in DIRECTIONS:
            self._distance = self._room()
            self._steps = int(np.ceil(self._distance / self._speed * p.fps))
        elif p.far_scale >= p.near_scale:
            raise ValueError(f"far_scale must be below near_scale, {p.near_scale:g}, got {p.far_scale:g}")
        else:
            self._steps = max(1, round(p.duration_s * p.fps))

    def _room(self) -> float:
        """Return the length of the path, px."""
        p = self._params
        horizontal = DIRECTIONS[p.motion][0] != 0
        field, size, name = (p.columns, p.width, "width") if horizontal else (p.rows, p.height, "height")
        if p.enters:
            return field + size
        if size >= field:
            raise ValueError(f"{name} must be below the frame's {field} with enters=false, got {size:g}")
        return field - size

    def __len__(self) -> int:
        return 2 * self._rest + self._steps + 1

    def truth(self, index: int, background: Velocity = STILL) -> Truth:
        """Return the truth of frame ``index``, for a background with the velocity ``background``."""
        step = index - self._rest
        moving = 0 <= step < self._steps
        done = min(max(step, 0), self._steps) / self._params.fps
        if self._params.motion in DIRECTIONS:
            box, velocity, contact = self._across(done), self._velocity(), None
        else:
            (box, contact), velocity = self._in_depth(done), STILL
        if not box.touches((self._params.rows, self._params.columns)):
            return Truth("still", background_velocity=background)
        if not moving:
            return Truth("still", box, STILL, background)
        return Truth(self._params.motion, box, velocity, background, contact)

    def _velocity(self) -> Velocity:
        x, y = DIRECTIONS[self._params.motion]
        return x * self._speed, y * self._speed

    def _across(self, elapsed: float) -> Box:
        p = self._params
        x, y = DIRECTIONS[p.motion]
        # From the middle of the path; the last step may be shorter, to end at the right place.
        along = min(self._speed * elapsed, self._distance) - self._distance / 2
        aside_x, aside_y = (0.0, p.offset) if x else (p.offset, 0.0)
        return Box.about(p.columns / 2 + x * along + aside_x, p.rows / 2 + y * along + aside_y, p.width, p.height)

    def _in_depth(self, elapsed: float) -> tuple[Box, float]:
        """Return box and time to contact: the distance, and so 1 / size, changes linearly in time."""
        p = self._params
        duration = self._steps / p.fps
        approached = elapsed if p.motion == "looming" else duration - elapsed
        far, near = 1 / p.far_scale, 1 / p.near_scale
        distance = far + (near - far) * approached / duration
        contact = distance * duration / (far - near)
        box = Box.about(p.columns / 2 + p.offset, p.rows / 2, p.width / distance, p.height / distance)
        return box, contact if p.motion == "looming" else -contact


def paint(canvas: Luma, box: Box, grey: float) -> None:
    """Paint ``box`` over ``canvas`` (R, C), in place: each pixel takes ``grey`` in the share that is covered."""
    (rows, down), (columns, across) = (
        _cover(box.top, box.height, canvas.shape[0]),
        _cover(box.left, box.width, canvas.shape[1]),
    )
    patch = canvas[rows, columns]
    patch[:] = np.rint(patch + (np.float32(grey) - patch) * (down[:, np.newaxis] * across))


CHORDS = 8
"""Number of chords of a disc in a pixel, evenly spaced along its height."""


def paint_disc(canvas: Luma, box: Box, grey: float) -> None:
    """Paint the ellipse that fills ``box`` over ``canvas`` (R, C), in place, with coverage exact to 1 / 64."""
    rows, columns = canvas.shape
    heights = (np.arange(rows * CHORDS) + 0.5) / CHORDS - box.top
    halves = np.sqrt(np.maximum(0.25 - (heights / box.height - 0.5) ** 2, 0.0)) * box.width
    middle, edges = box.left + box.width / 2, np.arange(columns)
    first, last = (middle + sign * halves[:, np.newaxis] for sign in (-1.0, 1.0))
    cover = np.clip(np.minimum(edges + 1, last) - np.maximum(edges, first), 0.0, 1.0)
    share = cover.reshape(rows, CHORDS, columns).mean(axis=1).astype(np.float32)
    canvas[:] = np.rint(canvas + (np.float32(grey) - canvas) * share)


def _cover(start: float, size: float, pixels: int) -> tuple[slice, npt.NDArray[np.float32]]:
    """Find the pixels of a line that an interval touches, and the covered share of each."""
    end = start + size
    first, last = (min(max(int(at), 0), pixels) for at in (np.floor(start), np.ceil(end)))
    edges = np.arange(first, last)
    cover = np.minimum(edges + 1, end) - np.maximum(edges, start)
    return slice(first, last), np.asarray(cover, np.float32)
