"""Run one model on frames: it sees frames that it cannot change, and its answers are checked."""

from __future__ import annotations

import inspect
import time
from collections.abc import Callable, Iterable, Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from dsnn import AnswerError, Response, ResponseSeries, checked_answer
from dsnn.frames import frozen
from dsnn.model import SPIKING
from experiments.bench.run.errors import UsageError, short
from experiments.bench.run.models import ConfiguredModel, family
from experiments.bench.run.settings import changed, collect
from experiments.bench.run.user_code import traced


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
    network
        The model's parameters as they are now.
    maps
        Whether it is asked for layer maps; only a model whose ``step`` knows this keyword gives them.
    responses
        The answers so far, with the declared channels alone.
    seconds
        Time that the model has taken for its steps.
    trouble
        The traceback of what it raised, or why an answer is none; empty while nothing went wrong.
    """

    def __init__(self, chosen: ConfiguredModel, shape: tuple[int, int], *, keep: bool = True) -> None:
        self.chosen, self.label = chosen, chosen.label
        self.network: Any = chosen.network
        self.maps = False
        self.responses: list[Response] = []
        self.seconds = 0.0
        self.trouble = ""
        self._shape, self._keep, self._frames = shape, keep, 0
        self._channels = chosen.channels
        model = self._guarded(lambda: chosen.build(shape))
        if not self.trouble and not callable(getattr(model, "step", None)):
            self.trouble = f"TypeError: build returned a {type(model).__name__} without step(frame)"
        self._model: Any = model
        self._has_maps = not self.trouble and _takes_maps(self._model.step)

    @property
    def section(self) -> str:
        """The section of ``--set`` that its parameters are under."""
        return family(self.label, type(self.network))

    def change(self, values: Mapping[str, str]) -> None:
        """Change parameters, as ``--set`` would; the model begins anew with them, and its answers so far stay.

        Parameters
        ----------
        values
            Parameter -> text.

        Raises
        ------
        UsageError
            A value is not legal, or there is no such parameter; nothing has changed then.
        """
        section = self.section
        collected = collect([f"{section}.{name}={text}" for name, text in values.items()], {section: self.network})
        self.network = network = changed(section, self.network, collected.get(section, {}))
        if not self.trouble:
            declared = self.chosen.declared
            self._model = self._guarded(lambda: declared.build(self._shape, network))

    def see(self, luma: npt.NDArray[np.uint8]) -> Response | None:
        """Let the model answer the next frame (R, C); ``None`` once something went wrong."""
        if self.trouble:
            return None
        frame, asked = frozen(luma), self.maps and self._has_maps
        began = time.perf_counter()
        answer = self._guarded(lambda: self._model.step(frame, maps=True) if asked else self._model.step(frame))
        self.seconds += time.perf_counter() - began
        if self.trouble:
            return None
        response: Response | None = self._guarded(
            lambda: checked_answer(answer, self._channels, self._shape if asked else None)
        )
        if response is None:
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
            return call()
        except AnswerError as error:
            self.trouble = f"in frame {self._frames}, {error}"
        except Exception as error:
            self.trouble = traced(error)
        return None


def change(runners: Iterable[ModelRunner], model: str, values: Mapping[str, str]) -> None:
    """Change parameters of one of several models, by its label; see `ModelRunner.change`.

    Raises
    ------
    UsageError
        No such model is shown, or a value is not legal; nothing has changed then.
    """
    runner = next((runner for runner in runners if runner.label == model), None)
    if runner is None:
        raise UsageError(f"no model '{short(model)}' is shown")
    runner.change(values)


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
