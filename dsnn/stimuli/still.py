"""The first frame of a clip throughout, and what takes a clip's object away: controls of what moves."""

from __future__ import annotations

from typing import Any

from dsnn.stimuli.plain import PlainParams
from dsnn.stimuli.stimulus import ClipParams, Stimulus, StimulusFrame, Truth


class Still(Stimulus[ClipParams]):
    """The first frame of a clip throughout."""

    def __init__(self, inner: Stimulus[ClipParams]) -> None:
        super().__init__(inner.params, inner.seed)
        self._count, self._first = len(inner), StimulusFrame(inner.frame(0).luma, Truth("still"))

    def __len__(self) -> int:
        return self._count

    def frame(self, index: int) -> StimulusFrame:
        """Return the first frame."""
        return self._first


def without_object(params: ClipParams) -> dict[str, Any]:
    """Return the parameters that take a clip's object away; none of a stimulus that has no object of its own."""
    if isinstance(params, PlainParams):
        return {"grey": params.background_grey}
    return {"object": "absent"} if hasattr(params, "object") else {}
