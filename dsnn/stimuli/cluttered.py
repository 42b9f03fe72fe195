"""An object in front of a moving natural image (the paper's ``simu-nature-*`` and ``simu-sys-*``)."""

from __future__ import annotations

from functools import cached_property
from typing import Annotated, Literal

from pydantic import AfterValidator, Field

from dsnn.field_docs import parameters, unit
from dsnn.stimuli.background import PHOTOGRAPH, Panorama, known_background, panorama
from dsnn.stimuli.moving import ObjectParams, ObjectPath, paint, per_second
from dsnn.stimuli.stimulus import Stimulus, StimulusFrame
from dsnn.stimuli.streams import stream


@parameters
class ClutteredParams(ObjectParams):
    """Parameters of a dark object in front of a textured background.

    Speeds are in px/s by default, see ``speed_unit``. The paper writes px/frame, but at its own numbers an object would
    cross the frame in a few steps.
    """

    columns: Annotated[int, unit("px")] = Field(default=540, ge=8, le=4096)
    """Columns of a frame (paper: 540)."""
    grey: Annotated[float, unit("grey levels")] = Field(default=0.0, ge=0.0, le=255.0)
    """Grey level of the object; black is darker than any background."""
    background: Annotated[str, AfterValidator(known_background)] = PHOTOGRAPH
    """What is behind the object: photograph (palm leaves); dead-leaves, pink, foliage or street, which are scenes made
    from the seed; or the path of a picture. An experiment that sets none has scene r in replicate r."""
    background_speed: Annotated[float, unit("speed_unit")] = Field(default=-8.0, ge=-10_000.0, le=10_000.0)
    """Speed of the background, rightward positive."""
    start: Annotated[float | None, unit("px")] = Field(
        default=None, ge=0.0, le=8192.0,
        description="column of the background at the first frame's left border; None: the seed chooses it",
    )  # fmt: skip
    object: Literal["present", "absent"] = "present"
    """Whether the object is present; absent: only the background, for the same time."""


class Cluttered(Stimulus[ClutteredParams]):
    """An object in front of a textured background. The seed makes the scene, and its start unless ``start`` sets it.

    A scene repeats after twice the frame's width, the photograph every 1,080 px: 540 columns, then their mirror image.
    The background shifts from the first frame to the last, through the object's rest.
    """

    is_continuous = True

    def __init__(self, params: ClutteredParams, seed: int = 0) -> None:
        super().__init__(params, seed)
        self._path = ObjectPath(params)
        self._background = per_second(params.background_speed, params.speed_unit, params.fps), 0.0

    def __len__(self) -> int:
        return len(self._path)

    # A declaration makes its clips only to check them, so random numbers are drawn with the first frame.

    @cached_property
    def _panorama(self) -> Panorama:
        return panorama(self.params.background, self.shape, self.seed)

    @cached_property
    def _start(self) -> float:
        drawn = stream("cluttered.start", self.seed).uniform(0, self._panorama.period)
        return drawn if self.params.start is None else self.params.start

    def frame(self, index: int) -> StimulusFrame:
        """Paint frame ``index``."""
        truth = self._path.truth(index, self._background)
        canvas = self._panorama.view(self._start - self._background[0] * index / self.fps)
        if self.params.object == "absent":
            return StimulusFrame(canvas, truth.without_object())
        if truth.box is not None:
            paint(canvas, truth.box, self.params.grey)
        return StimulusFrame(canvas, truth)
