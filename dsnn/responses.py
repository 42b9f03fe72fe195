"""The one check that every model's response passes before it is counted, stored, drawn or used for control."""

from __future__ import annotations

import numbers
import reprlib
from collections.abc import Sequence
from typing import Any

import numpy as np

from dsnn.model import CHANNELS, MAP_SCALES, SPIKING, LayerMaps, Response

LARGEST = 1e9
"""Largest size of a potential or of a spike count. Sums of squares of such numbers stay finite."""


class ResponseError(ValueError):
    """A model returned something that is not a valid response. The message names the value and its bound."""


def checked_response(
    response: Any, channels: Sequence[str] = CHANNELS, shape: tuple[int, int] | None = None
) -> Response:
    """Check a model's response and convert it to plain numbers on the declared channels.

    Parameters
    ----------
    response
        What a model's ``step`` returned: a `dsnn.Response`, or any object with the attributes of one.
    channels
        The channels that the model declares (`dsnn.ModelEntry.channels`). Outputs on undeclared channels are ignored.
    shape
        (R, C) of the layer maps, if maps were requested. With ``None`` maps are ignored.

    Returns
    -------
    Response
        The response in Python numbers. Undeclared channels are 0.

    Raises
    ------
    ResponseError
        A declared channel is missing, or is not a number between -1e9 and 1e9. A spike count is not whole, a looming
        count is negative, or a map has another shape.

    Examples
    --------
    >>> import numpy as np
    >>> from dsnn import Response, checked_response
    >>> checked_response(Response(hs=np.float32(0.5), looming=3.0), channels=("hs",)).hs
    0.5
    """
    values: dict[str, Any] = {}
    try:
        for channel in channels:
            values[channel] = float(_number(channel, getattr(response, channel)))
            if channel in SPIKING:
                name = f"{channel}_spikes"
                values[name] = _count(name, getattr(response, name))
    except AttributeError as error:
        given = f"a {type(response).__name__} without {error.name}"
        raise ResponseError(f"step() must return a dsnn.Response, got {given}") from None
    if values.get("looming_spikes", 0) < 0:
        raise ResponseError(f"looming_spikes must be 0 or more, got {values['looming_spikes']}")
    if shape is not None:
        values["maps"] = _maps(getattr(response, "maps", None), shape)
    return Response(**values)


def _number(name: str, value: Any) -> Any:
    """Return a Python or NumPy scalar, or the item of a 0-dimensional array, if it is a number in range."""
    if type(value) is not float and type(value) is not int:
        # Convert before comparing: 1e9 itself is infinite in half precision. Not a masked one: its item() is its fill.
        if isinstance(value, np.floating) or (type(value) is np.ndarray and value.ndim == 0):
            value = value.item()
        if isinstance(value, bool | np.bool_) or not isinstance(value, numbers.Real):
            raise ResponseError(f"{name} must be a number, got {_in_a_line(value)}")
    if not -LARGEST <= value <= LARGEST:  # false for NaN too
        raise ResponseError(f"{name} must be between -{LARGEST:g} and {LARGEST:g}, got {value}")
    return value


def _count(name: str, value: Any) -> int:
    if isinstance(value, bool | np.bool_):  # as a comparison with a threshold gives
        return int(value)
    number = _number(name, value)
    if number != int(number):
        raise ResponseError(f"{name} must be a whole number of spikes, got {float(number):g}")
    return int(number)


def _maps(maps: Any, shape: tuple[int, int]) -> LayerMaps | None:
    if maps is None:
        return None
    layers: dict[str, Any] = {name: getattr(maps, name, None) for name in MAP_SCALES}
    for name, layer in layers.items():
        if not isinstance(layer, np.ndarray) or layer.shape != shape or layer.dtype.kind not in "fiu":
            raise ResponseError(f"maps.{name} must be an array of numbers, {shape}, got {_in_a_line(layer)}")
    return LayerMaps(**layers)


def _in_a_line(value: Any) -> str:
    return " ".join(reprlib.repr(value).split())
