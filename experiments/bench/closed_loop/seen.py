"""View of a reflex: the answer of a model, of which only the declared channels can be read."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from dsnn import Response
from dsnn.model import CHANNELS, SPIKING
from experiments.bench.run.errors import UsageError


class UndeclaredChannelError(UsageError, AttributeError):
    """A reflex reads a channel that its model does not answer.

    It is an ``AttributeError``, so that ``getattr(seen, "azimuth", 0.0)`` reads a channel that may be missing.
    """


class PartialResponse(Response):
    """A `Response` that lacks the channels, and their spikes, that its model does not declare."""

    __slots__ = ("_declared", "_model")

    def __init__(self, seen: Response, channels: Sequence[str], model: str) -> None:
        kept = ["maps", *channels, *(f"{channel}_spikes" for channel in channels if channel in SPIKING)]
        for name in kept:
            object.__setattr__(self, name, getattr(seen, name))  # what has no value is looked up by __getattr__
        object.__setattr__(self, "_declared", tuple(channels))
        object.__setattr__(self, "_model", model)

    def __getattr__(self, name: str) -> Any:
        """Refuse a channel that is not declared."""
        if name not in Response.__slots__:
            raise AttributeError(f"a Response has no attribute {name}")
        declared = f"its channels are {', '.join(self._declared)}"
        raise UndeclaredChannelError(f"the reflex reads {name}, which {self._model} does not answer; {declared}")

    def __repr__(self) -> str:
        """Show the channels that there are."""
        return f"Response({', '.join(f'{name}={getattr(self, name)!r}' for name in self._declared)})"


def response(
    observation: npt.NDArray[np.float32], channels: Sequence[str] = CHANNELS, model: str = "the model"
) -> Response:
    """Return the `Response` that a neural observation (7,) is of, by a model that declares these channels."""
    hs, vs, hs_spikes, vs_spikes, looming, looming_spikes, azimuth = observation.tolist()
    seen = Response(hs, vs, int(hs_spikes), int(vs_spikes), None, looming, int(looming_spikes), azimuth)
    return seen if set(channels) >= set(CHANNELS) else PartialResponse(seen, channels, model)
