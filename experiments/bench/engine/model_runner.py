"""Run one model on frames: it sees frames that it cannot change, and its answers are checked."""

from __future__ import annotations

import inspect
import os
import time
from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

from dsnn import Response, ResponseSeries, checked_answer
from dsnn.frames import frozen
from dsnn.model import SPIKING
from experiments.bench.engine import interrupts
from experiments.bench.engine.errors import explained
from experiments.bench.engine.models import ConfiguredModel
from experiments.bench.engine.user_code import apart, place_of


class ModelRunner:
    """One model at its work, its answers checked. Whatever goes wrong in it ends its own part, not that of others.

    Parameters
    ----------
    chosen
        The model and its parameters.
    shape
        (R, C) of the frames.
    keep
        Whether `responses` grows with every frame; footage may be endless.

    Attributes
    ----------
    responses
        The answers so far, with the declared channels alone.
    seconds
        Time that the model has taken for its steps.
    trouble
        What went wrong; empty while nothing has.
    """

    def __init__(self, chosen: ConfiguredModel, shape: tuple[int, int], *, keep: bool = True) -> None:
        self.chosen, self.label = chosen, chosen.label
        self.responses: list[Response] = []
        self.seconds = 0.0
        self.trouble = ""
        self._shape, self._keep, self._frames = shape, keep, 0
        self._channels = chosen.channels
        self._process = os.getpid()
        model = self._guarded(lambda: chosen.build(shape))
        if not self.trouble and not callable(getattr(model, "step", None)):
            self.trouble = f"TypeError: build returned a {type(model).__name__} without step(frame)"
        self._model: Any = model
        self._has_maps = not self.trouble and _takes_maps(self._model.step)

    def change(self, network: Any) -> None:
        """Let the model begin anew, with other parameters of its class; its answers so far stay.

        Parameters
        ----------
        network
            The parameters.
        """
        if self.trouble:
            return
        declared = self.chosen.declared
        self._model = self._guarded(lambda: declared.build(self._shape, network))

    def see(self, luma: npt.NDArray[np.uint8], *, maps: bool = False) -> Response | None:
        """Let the model answer the next frame (R, C); ``None`` once something went wrong.

        ``maps`` asks for layer maps, of a model whose ``step`` knows this keyword.
        """
        if self.trouble:
            return None
        frame, asked = frozen(luma), maps and self._has_maps
        began = time.perf_counter()
        answer = self._guarded(lambda: self._model.step(frame, maps=True) if asked else self._model.step(frame))
        self.seconds += time.perf_counter() - began
        if self.trouble:
            return None
        try:
            response = checked_answer(answer, self._channels, self._shape if asked else None)
        except Exception as error:  # attributes of a user's own class may raise anything
            self._broke(error, f"in frame {self._frames}, {error}")
            return None
        self._frames += 1
        if self._keep:
            self.responses.append(response)
        return response

    def series(self) -> ResponseSeries | None:
        """Return the model's answers to all frames; ``None`` if something went wrong."""
        return None if self.trouble else ResponseSeries.from_responses(self.responses)

    def _guarded(self, call: Callable[[], Any]) -> Any:
        try:
            return apart(call)
        except BaseException as error:  # SystemExit too: sys.exit in a model ends the model
            interrupts.pass_on(error)
            self._broke(error)
        finally:
            if os.getpid() != self._process:  # a copy that the model forked; nothing here is its business
                os._exit(0)
        return None

    def _broke(self, error: BaseException, message: str | None = None) -> None:
        self.trouble = f"{place_of(error)}{explained(error, message)}"


def _takes_maps(step: Any) -> bool:
    try:
        parameters = inspect.signature(step).parameters.values()
    except (TypeError, ValueError):
        return False
    return any(p.name == "maps" or p.kind is inspect.Parameter.VAR_KEYWORD for p in parameters)


def spike_counts(model: ConfiguredModel, series: ResponseSeries) -> dict[str, int | None]:
    """Count the spikes of a model's answers.

    Parameters
    ----------
    model
        The model.
    series
        Its answers.

    Returns
    -------
    dict of str to int or None
        ``spikes``, those of the model's `ConfiguredModel.counted` channel, then ``hs_spikes`` and so on. ``None``
        where the channel has no threshold or is not declared: it does not spike.
    """
    counts = {c: series.accumulated_spikes(c) if c in model.spiking else None for c in SPIKING}
    return {"spikes": counts.get(model.counted), **{f"{c}_spikes": count for c, count in counts.items()}}
