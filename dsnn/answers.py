"""The one check that every answer of a model passes before it is counted, stored, drawn or steered by."""

from __future__ import annotations

import math
import numbers
from collections.abc import Sequence
from typing import Any

import numpy as np

from dsnn.model import CHANNELS, SPIKING, LayerMaps, Response

LARGEST = 1e9
"""The largest legal size of a potential or of a spike count: sums of squares of such numbers stay finite."""
MAPS = ("p", "la", "f_on", "f_off")


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
    if not isinstance(channels, tuple | list) or not all(isinstance(channel, str) for channel in channels):
        raise AnswerError(f"channels is {_said(channels)}: expected a sequence of some of {', '.join(CHANNELS)}")
    for channel in channels:
        values[channel] = _potential(channel, _entry(answer, channel))
        if channel in SPIKING:
            count = _count(f"{channel}_spikes", _entry(answer, f"{channel}_spikes"))
            if count < 0 and channel == "looming":
                raise AnswerError(f"looming_spikes is {count}: expected 0 or more, as looming has no direction")
            values[f"{channel}_spikes"] = count
    if shape is not None:
        values["maps"] = _maps(getattr(answer, "maps", None), shape)
    return Response(**values)


def _entry(answer: Any, name: str) -> Any:
    try:
        return getattr(answer, name)
    except AttributeError:
        raise AnswerError(f"the answer is a {type(answer).__name__} without {name}: expected a dsnn.Response") from None


def _potential(name: str, value: Any) -> float:
    if type(value) is not float:
        value = _number(name, value)
    if not -LARGEST <= value <= LARGEST:  # false for NaN too
        raise AnswerError(f"{name} is {value}: expected a finite number up to {LARGEST:g} in size")
    return float(value)


def _number(name: str, value: Any) -> float:
    """Return the value of a Python or NumPy scalar, or of an array without dimensions."""
    if type(value) is np.ndarray and value.ndim == 0:  # not a masked one, whose item() is its fill value
        value = value.item()
    if isinstance(value, bool | np.bool_) or not isinstance(value, numbers.Real):
        raise AnswerError(f"{name} is {_said(value)}: expected a number")
    return float(value)


def _count(name: str, value: Any) -> int:
    if type(value) is int:
        whole = value
    elif isinstance(value, bool | np.bool_):  # as a comparison with a threshold gives
        whole = int(value)
    else:
        number = _number(name, value)
        if not math.isfinite(number) or number != math.floor(number):
            raise AnswerError(f"{name} is {number:g}: expected a whole number of spikes")
        whole = int(number)
    if not -LARGEST <= whole <= LARGEST:
        raise AnswerError(f"{name} is out of range: expected a whole number up to {LARGEST:g} in size")
    return whole


def _maps(maps: Any, shape: tuple[int, int]) -> LayerMaps | None:
    if maps is None:
        return None
    layers = {name: _entry(maps, name) for name in MAPS}
    for name, layer in layers.items():
        if not isinstance(layer, np.ndarray) or layer.shape != shape or layer.dtype.kind not in "fiu":
            raise AnswerError(f"maps.{name} is {_said(layer)}: expected an array of numbers, {shape}")
    return LayerMaps(**layers)


def _said(value: Any) -> str:
    """Return a value in a few words; a long one by its kind alone."""
    if isinstance(value, np.ndarray):
        return f"an array of shape {value.shape} and type {value.dtype}"
    text = " ".join(repr(value).split())
    return f"{text} ({type(value).__name__})" if len(text) <= 40 else f"a {type(value).__name__}"
