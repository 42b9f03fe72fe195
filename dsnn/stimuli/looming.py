"""A square or a disc on a collision course, seen through a pinhole: the laboratory's looming stimulus.

A square of half-size l approaches at constant speed v. At the time t before contact it subtends the full angle ``2
atan((l / v) / t)``. Its time course depends only on l / v (Gabbiani, Krapp and Laurent 1999, J. Neurosci. 19:1122). As
a comparison the same object can cross the view at the same speed.
"""

from __future__ import annotations

import math
from typing import Annotated, Literal

import numpy as np
import numpy.typing as npt
from pydantic import Field

from dsnn.field_docs import parameters, unit
from dsnn.stimuli.grating import Grating, GratingParams
from dsnn.stimuli.moving import DIRECTIONS, Motion, paint, paint_disc
from dsnn.stimuli.stimulus import STILL, Box, ClipParams, Luma, Stimulus, StimulusFrame, Truth

Degrees = Annotated[float, Field(ge=-80.0, le=80.0), unit("degrees")]
AngularSize = Annotated[float, Field(gt=0.0, lt=180.0), unit("degrees")]


@parameters
class LoomingParams(ClipParams):
    """Parameters of a square that approaches, recedes or crosses, seen with the frame and lens of the robot's camera.

    The centre of expansion stays at ``azimuth_deg`` and ``elevation_deg``, as for any object that would hit the eye.
    With ``miss`` the object passes the eye, and its image drifts outward as it approaches. A crossing object has the
    same speed, stays at the distance of the near end, and passes the direction ``azimuth_deg``, ``elevation_deg``.
    """

    rows: Annotated[int, unit("px")] = Field(default=72, ge=8, le=4096)
    """Rows of a frame."""
    columns: Annotated[int, unit("px")] = Field(default=99, ge=8, le=4096)
    """Columns of a frame."""
    motion: Motion = "looming"
    """Kind of motion. receding: the frames of looming in reverse; rightward and others: across the view at the size of
    the near end."""
    outline: Literal["square", "disc"] = "square"
    """Outline of the object; a disc is as wide as the square."""
    l_over_v_s: Annotated[float, unit("s")] = Field(default=0.16, gt=0.0, le=100.0)
    """Half-size of the square over its speed."""
    azimuth_deg: Degrees = 0.0
    """Direction that the square comes from, right of the axis."""
    elevation_deg: Degrees = 0.0
    """Direction that the square comes from, below the axis."""
    miss: Annotated[float, unit("half-sizes")] = Field(default=0.0, ge=-100.0, le=100.0)
    """Distance to the right of the eye at which the square passes; 0: it hits."""
    start_deg: AngularSize = 8.0
    """Full angle that the square subtends at the far end."""
    end_deg: AngularSize = 60.0
    """Full angle that the square subtends at the near end."""
    focal_px: Annotated[float, unit("px")] = Field(default=70.7, gt=0.0, le=10_000.0)
    """Focal length (the robot's: 70.7)."""
    grey: Annotated[float, unit("grey levels")] = Field(default=40.0, ge=0.0, le=255.0)
    """Grey level of the square."""
    background_grey: Annotated[float, unit("grey levels")] = Field(default=200.0, ge=0.0, le=255.0)
    """Mean grey level behind the square."""
    background: Literal["even", "grating"] = "even"
    """What is behind the square; a grating drifts from the first frame to the last."""
    period_px: Annotated[float, unit("px")] = Field(default=16.0, ge=2.0, le=10_000.0)
    """Wavelength of the grating."""
    temporal_hz: Annotated[float, unit("Hz")] = Field(default=2.0, ge=0.0, le=500.0)
    """Number of the grating's periods that pass a pixel in a second."""
    direction_deg: Annotated[float, unit("degrees")] = Field(default=0.0, ge=-360.0, le=360.0)
    """Direction of the grating's drift: 0 rightward, 90 downward."""
    contrast: float = Field(default=0.4, ge=0.0, le=1.0)
    """Michelson contrast of the grating."""
    object: Literal["present", "absent"] = "present"
    """Whether the square is present; absent: only the background, for the same time."""
    rest_s: Annotated[float, unit("s")] = Field(default=0.3, ge=0.0, le=60.0)
    """Stillness before and after the motion."""


class Looming(Stimulus[LoomingParams]):
    """A looming object. The seed sets the phase of the background's grating; on an even ground nothing is random."""

    is_continuous = True

    def __init__(self, params: LoomingParams, seed: int = 0) -> None:
        super().__init__(params, seed)
        p = params
        if p.start_deg >= p.end_deg:
            raise ValueError(f"start_deg must be below end_deg, {p.end_deg:g}, got {p.start_deg:g}")
        self._first_s, last_s = (p.l_over_v_s / math.tan(math.radians(size) / 2) for size in (p.start_deg, p.end_deg))
        self._steps = max(1, math.floor((self._first_s - last_s) * p.fps))
        self._side, self._speed = 2.0 * p.focal_px * p.l_over_v_s / last_s, p.focal_px / last_s  # of a crossing object
        if p.motion in DIRECTIONS:
            self._steps = max(1, math.ceil(self._way() / self._speed * p.fps))
        self._rest = round(p.rest_s * p.fps)
        self._ground = _grating(p, len(self), seed) if p.background == "grating" else None
        moving = self._ground is not None and p.temporal_hz > 0
        turn, speed = math.radians(p.direction_deg), p.temporal_hz * p.period_px
        self._drift = (speed * math.cos(turn), speed * math.sin(turn)) if moving else STILL

    def __len__(self) -> int:
        return 2 * self._rest + self._steps + 1

    def frame(self, index: int) -> StimulusFrame:
        """Paint frame ``index``."""
        p = self.params
        if self._ground is None:
            canvas: Luma = np.full(self.shape, round(p.background_grey), np.uint8)
        else:
            canvas = self._ground.frame(index).luma
        if p.object == "absent":
            return StimulusFrame(canvas, Truth("still", background_velocity=self._drift))
        truth = self._truth(index - self._rest)
        if truth.box is not None:
            (paint_disc if p.outline == "disc" else paint)(canvas, truth.box, p.grey)
        return StimulusFrame(canvas, truth)

    def contact_s(self) -> npt.NDArray[np.float64]:
        """Time to contact of each frame, s, (T,); NaN before the approach begins.

        The square stops at ``end_deg``. The time continues as if it approached at the same speed, and is negative after
        contact. All values are NaN if the object recedes or is absent.
        """
        p, steps = self.params, np.arange(len(self)) - self._rest
        if p.motion != "looming" or p.object == "absent":
            return np.full(len(self), np.nan)
        return np.where(steps >= 0, self._first_s - steps / p.fps, np.nan)

    def _truth(self, step: int) -> Truth:
        """Return the truth ``step`` frames after the motion began; before and after the motion the square rests."""
        p, done = self.params, min(max(step, 0), self._steps)
        if p.motion in DIRECTIONS:
            return self._crossing(done, 0 <= step < self._steps)
        looming = p.motion == "looming"
        contact = self._first_s - (done if looming else self._steps - done) / p.fps
        near = p.l_over_v_s / contact  # half-size over distance
        x = math.tan(math.radians(p.azimuth_deg)) + p.miss * near
        y = math.tan(math.radians(p.elevation_deg))
        side = 2.0 * p.focal_px * near
        box = Box.about(p.columns / 2 + p.focal_px * x, p.rows / 2 + p.focal_px * y, side, side)
        if not box.touches(self.shape):
            return Truth("still", background_velocity=self._drift)
        if not 0 <= step < self._steps:
            return Truth("still", box, STILL, self._drift)
        outward = p.focal_px * p.miss * near / contact
        velocity = outward if looming else -outward, 0.0
        return Truth(p.motion, box, velocity, self._drift, contact if looming else -contact)

    def _way(self) -> float:
        """Return the length of a crossing, px: from outside the frame to outside the frame."""
        return self._side + (self.shape[1] if DIRECTIONS[self.params.motion][0] else self.shape[0])

    def _crossing(self, done: int, moving: bool) -> Truth:
        """Return the truth of a crossing object ``done`` frames after its start."""
        p, (x, y) = self.params, DIRECTIONS[self.params.motion]
        along = min(self._speed * done / p.fps, self._way()) - self._way() / 2  # the last step may be a part of one
        column = p.columns / 2 + p.focal_px * math.tan(math.radians(p.azimuth_deg)) * (not x) + x * along
        row = p.rows / 2 + p.focal_px * math.tan(math.radians(p.elevation_deg)) * (not y) + y * along
        box = Box.about(column, row, self._side, self._side)
        if not box.touches(self.shape):
            return Truth("still", background_velocity=self._drift)
        velocity = x * self._speed, y * self._speed
        return Truth(p.motion, box, velocity, self._drift) if moving else Truth("still", box, STILL, self._drift)


def _grating(p: LoomingParams, frames: int, seed: int) -> Grating:
    """Make the background's grating; ``ValueError`` if its mean grey is above 127.5."""
    if p.background_grey > 127.5:
        raise ValueError(f"background_grey must be at most 127.5 for a grating, got {p.background_grey:g}")
    duration_s = frames / p.fps
    return Grating(
        GratingParams(
            rows=p.rows, columns=p.columns, fps=p.fps, rest_s=0.0, duration_s=duration_s, period_px=p.period_px,
            temporal_hz=p.temporal_hz, direction_deg=p.direction_deg, contrast=p.contrast, mean_grey=p.background_grey,
        ),
        seed,
    )  # fmt: skip
