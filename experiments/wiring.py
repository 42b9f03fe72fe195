"""Wiring of `colias_sim` to what users write: the envs' neural observations to models, arenas to Python files."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from dsnn import CHANNELS, ModelEntry, Response, ResponseError, checked_response, model_entry
from dsnn.frames import frozen
from experiments.base.errors import UsageError
from experiments.base.user_code import declared, is_file
from experiments.settings.models import load_model


class CheckedModel:
    """A model, ``inner``, whose answers are checked, and which sees frames that it cannot change.

    ``step`` raises `dsnn.ResponseError` for an answer that is none, naming the model, and whatever the model raises.
    """

    def __init__(self, name: str, model: Any, channels: Sequence[str], thresholds: Mapping[str, float | None]) -> None:
        self.name, self.inner, self.channels, self.thresholds = name, model, tuple(channels), thresholds
        self.senses = getattr(model, "senses", "frames")

    def step(self, frame: npt.NDArray[np.uint8] | npt.NDArray[np.void]) -> Response:
        """Answer the next frame (R, C), or the events since the last."""
        try:
            return checked_response(self.inner.step(frozen(frame)), self.channels)
        except ResponseError as error:
            raise ResponseError(f"model {self.name}: {error}") from None

    def reset(self) -> None:
        """Forget every frame."""
        self.inner.reset()

    def get_state(self) -> bytes:
        """Save what the model keeps; ``ValueError`` if it has no such method."""
        return bytes(self._savable().get_state())

    def set_state(self, state: bytes) -> None:
        """Restore what `get_state` saved."""
        self._savable().set_state(state)

    def _savable(self) -> Any:
        if not (hasattr(self.inner, "get_state") and hasattr(self.inner, "set_state")):
            raise ValueError(f"model {self.name} cannot be saved: give it get_state() and set_state(state)")
        return self.inner


def build(model: Any, shape: tuple[int, int]) -> CheckedModel:
    """Build a model with its parameters for the robot, for frames of ``shape`` (R, C).

    Parameters
    ----------
    model
        A registered model's name, the path of a .py file that declares ``MODEL``, a `dsnn.ModelEntry`, or a factory
        that is called with ``shape`` as its only argument; of what that makes, every channel counts as declared.

    Raises
    ------
    ValueError
        On an unknown name, naming the nearest; on a file that declares no model; on what is none of these.
    """
    if isinstance(model, str | Path):
        model = load_model(str(model)) if is_file(str(model)) else model_entry(str(model))
    if isinstance(model, ModelEntry):
        thresholds = {channel: model.threshold(channel, model.robot) for channel in model.channels}
        return CheckedModel(model.name, model.build(shape, model.robot), model.channels, thresholds)
    if not callable(model):
        legal = "a model's name, a .py file, a dsnn.ModelEntry, or a factory that takes the tuple (rows, columns)"
        raise ValueError(f"model must be {legal}, got {model!r}")
    return CheckedModel(getattr(model, "__name__", type(model).__name__), model(shape), CHANNELS, {})


def arena_text(path: Path) -> str:
    """Take an arena's MJCF from a user's Python file.

    Parameters
    ----------
    path
        The file, which is executed. Its ``ARENA`` is the MJCF, or a function without arguments that returns it, always
        the same.

    Returns
    -------
    str
        The MJCF.

    Raises
    ------
    ValueError
        The file declares no ``ARENA``, or that is something else.
    Exception
        Whatever the file raises.
    """
    arena = declared(path, "ARENA", object)
    text = arena() if callable(arena) else arena
    if not isinstance(text, str):
        raise UsageError(f"{path}: ARENA must be MJCF, as a text, got {type(text).__name__}")
    return text
