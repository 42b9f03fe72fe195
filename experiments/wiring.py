"""Wiring of `colias_sim` to what users write: the envs' neural observations to models, arenas to Python files."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from dsnn import CHANNELS, ModelEntry, Response, ResponseError, checked_response, model_entry
from dsnn.frames import frozen
from experiments.bench.run.errors import UsageError
from experiments.bench.run.models import load_model
from experiments.bench.run.user_code import declared, is_file


class CheckedModel:
    """A model, ``inner``, whose answers are checked, and which sees frames that it cannot change.

    ``step`` raises `dsnn.ResponseError` for an answer that is none, naming the model, and whatever the model raises.
    """

    def __init__(
        self, name: str, model: Any, channels: Sequence[str], thresholds: Mapping[str, float | None] | None = None
    ) -> None:
        self.name, self.channels = name, tuple(channels)
        self.thresholds = dict(thresholds or {})
        self.inner = model

    def step(self, frame: npt.NDArray[np.uint8]) -> Response:
        """Answer the next frame (R, C)."""
        answer = self.inner.step(frozen(frame))
        try:
            return checked_response(answer, self.channels)
        except ResponseError as error:
            raise ResponseError(f"model {self.name}: {error}") from None

    def reset(self) -> None:
        """Forget every frame."""
        self.inner.reset()


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
    entry = _entry(model)
    thresholds: dict[str, float | None] = {}
    if entry is not None:
        thresholds = {channel: entry.threshold(channel, entry.robot) for channel in entry.channels}
        name, channels, built = entry.name, entry.channels, entry.build(shape, entry.robot)
    elif callable(model):
        name, channels = getattr(model, "__name__", type(model).__name__), CHANNELS
        built = model(shape)
    else:
        raise ValueError(
            f"model={model!r}: expected a model's name, a .py file, a dsnn.ModelEntry,"
            " or a factory that takes one argument, the tuple (rows, columns)"
        )
    if not (callable(getattr(built, "step", None)) and callable(getattr(built, "reset", None))):
        raise ValueError(f"model={model!r} made {built!r}: expected an object with step(frame) and reset()")
    return CheckedModel(name, built, channels, thresholds)


def arena_text(path: Path) -> str:
    """Take an arena's MJCF from a user's Python file.

    Parameters
    ----------
    path
        The file, which is executed. Its ``ARENA`` is the MJCF, or a function without arguments that returns it.

    Returns
    -------
    str
        The MJCF.

    Raises
    ------
    ValueError
        The file declares no ``ARENA``, or that is something else, or answers otherwise when it is called again.
    Exception
        Whatever the file raises.
    """
    arena = declared(path, "ARENA")
    text, again = (arena(), arena()) if callable(arena) else (arena, arena)
    if not isinstance(text, str):
        what = "ARENA returns" if callable(arena) else "ARENA is"
        raise UsageError(f"{path}: {what} of the type {type(text).__name__}: expected MJCF, as a text")
    if text != again:
        raise UsageError(f"{path}: ARENA returns another text when it is called again: draw nothing at random in it")
    return text


def _entry(model: Any) -> ModelEntry | None:
    """Return the entry that a name, a path or an entry means; ``None`` for anything else."""
    if isinstance(model, Path) or (isinstance(model, str) and is_file(model)):
        try:
            return load_model(str(model))
        except UsageError as error:
            raise ValueError(f"model={str(model)!r}: {error}") from None
    if isinstance(model, str):
        return model_entry(model)
    return model if isinstance(model, ModelEntry) else None
