"""An object on an even background (the paper's ``simu-clean``)."""

from __future__ import annotations

from typing import Annotated

import numpy as np
from pydantic import Field

from dsnn.field_docs import parameters, unit
from dsnn.stimuli.moving import ObjectParams, ObjectPath, paint
from dsnn.stimuli.stimulus import Stimulus, StimulusFrame


@parameters
class PlainParams(ObjectParams):
    """Parameters of a dark object on a lighter ground; set both greys for the opposite.

    The paper gives neither sizes nor greys. Size and speed are from the project's notes on the paper, and the greys
    from the network's golden vectors.
    """

    background_grey: Annotated[float, unit("grey levels")] = Field(default=200.0, ge=0.0, le=255.0)
    """Grey level of the background."""


class Plain(Stimulus[PlainParams]):
    """An object in front of an even ground. It has nothing random: every seed gives the same frames."""

    is_continuous = True

    def __init__(self, params: PlainParams, seed: int = 0) -> None:
        super().__init__(params, seed)
        self._path = ObjectPath(params)

    def __len__(self) -> int:
        return len(self._path)

    def frame(self, index: int) -> StimulusFrame:
        """Paint frame ``index``."""
        truth = self._path.truth(index)
        canvas = np.full(self.shape, round(self.params.background_grey), np.uint8)
        if truth.box is not None:
            paint(canvas, truth.box, self.params.grey)
        return StimulusFrame(canvas, truth)
