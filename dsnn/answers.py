"""The one check that every answer of a model passes before it is counted, stored, drawn or steered by."""

from __future__ import annotations

import numbers
import reprlib
from collections.abc import Sequence
from typing import Any

import numpy as np

from dsnn.model import CHANNELS, MAP_SCALES, SPIKING, LayerMaps, Response

LARGEST = 1e9
"""The largest legal size of a potential or of a spike count: sums of squares of such numbers stay finite."""


class AnswerError(ValueError):
    """An answer that is no answer; the message names the value and what is legal."""


def checked_answer(answer: Any, channels: Sequence[str] = CHANNELS, shape: tuple[int, int] | None = None) -> Response:
    """Return ``answer`` as a `dsnn.Response` of plain numbers that holds the declared channels alone.

    Parameters
    ----------
    answer
        What a model's ``step`` returned: a `dsnn.Response`, or any object with the attributes of one.
    channels
        The channels that the model declares (`dsnn.ModelEntry.channels`). Whatever it fills in beside them is dropped:
        these entries of the result are 0.
    shape
        (R, C) of the layer maps if they were asked for; otherwise ``None``, and maps are dropped.

    Returns
    -------
    Response
        The same in Python's own numbers; channels that are not declared are 0.

    Raises
    ------
    AnswerError
        If a declared channel is missing, no number, not finite or beyond 1e9 in size, a spike count is not whole, or
        of looming below 0, or a map has another shape.

    Examples
    --------
    >>> import numpy as np
    >>> from dsnn import Response, checked_answer
    >>> checked_answer(Response(hs=np.float32(0.5), looming=3.0), channels=("hs",)).hs
    0.5
    """
    values: dict[str, Any] = {}
    for channel in channels:
        values[channel] = float(_number(channel, _entry(answer, channel)))
        if channel in SPIKING:
            values[f"{channel}_spikes"] = _count(f"{channel}_spikes", _entry(answer, f"{channel}_spikes"))
    if values.get("looming_spikes", 0) < 0:
        raise AnswerError(f"looming_spikes is {values['looming_spikes']}: expected 0 or more: it has no direction")
    if shape is not None:
        values["maps"] = _maps(getattr(answer, "maps", None), shape)
    return Response(**values)


def _entry(answer: Any, name: str) -> Any:
    try:
        return getattr(answer, name)
    except AttributeError:
        raise AnswerError(f"the answer is a {type(answer).__name__} without {name}: expected a dsnn.Response") from None


def _number(name: str, value: Any) -> Any:
    """Return a Python or NumPy scalar, or what an array without dimensions holds, if it is a number in range."""
    if type(value) is not float and type(value) is not int:
        if type(value) is np.ndarray and value.ndim == 0:  # not a masked one, whose item() is its fill value
            value = value.item()
        if isinstance(value, bool | np.bool_) or not isinstance(value, numbers.Real):
            raise AnswerError(f"{name} is {_in_a_line(value)}: expected a number")
    if not -LARGEST <= value <= LARGEST:  # false for NaN too
        raise AnswerError(f"{name} is {value}: expected a finite number up to {LARGEST:g} in size")
    return value


def _count(name: str, value: Any) -> int:
    if isinstance(value, bool | np.bool_):  # as a comparison with a threshold gives
        return int(value)
    number = _number(name, value)
    if number != int(number):
        raise AnswerError(f"{name} is {number:g}: expected a whole number of spikes")
    return int(number)


def _maps(maps: Any, shape: tuple[int, int]) -> LayerMaps | None:
    if maps is None:
        return None
    layers = {name: _entry(maps, name) for name in MAP_SCALES}
    for name, layer in layers.items():
        if not isinstance(layer, np.ndarray) or layer.shape != shape or layer.dtype.kind not in "fiu":
            raise AnswerError(f"maps.{name} is {_in_a_line(layer)}: expected an array of numbers, {shape}")
    return LayerMaps(**layers)


def _in_a_line(value: Any) -> str:
    return " ".join(reprlib.repr(value).split())
