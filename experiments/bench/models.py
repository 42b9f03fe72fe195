"""The models of a run: registered ones by name, a user's own by the path of the file that declares it."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from dsnn import ModelEntry, Response, ResponseSeries, VisionModel, model_entry
from experiments.bench.files import UsageError, declared, is_file


@dataclass(frozen=True, slots=True)
class Chosen:
    """A model with its parameters, under the ``label`` that tables and figures show.

    It crosses to other processes as its source and the values of its parameters, so that a user's own file is
    found there too.
    """

    label: str
    source: str
    """A registered name, or the absolute path of a .py file."""
    network: Any
    """Its parameters, a frozen dataclass."""

    @property
    def threshold(self) -> float | None:
        """The spiking threshold on its membrane potentials; ``None`` where it has none."""
        own = getattr(self.network, "t_sp", None)
        return None if own is None else float(own)

    @property
    def channels(self) -> tuple[str, ...]:
        """The potentials it answers by: ``hs`` and ``vs``, or ``looming``."""
        return load_model(self.source).channels

    def build(self, shape: tuple[int, int]) -> VisionModel:
        """The model itself, for frames of ``shape`` (R, C)."""
        return load_model(self.source).build(shape, self.network)

    def __reduce__(self) -> tuple[Any, ...]:
        fields = {
            field.name: getattr(self.network, field.name) for field in dataclasses.fields(self.network) if field.init
        }
        return _again, (self.label, self.source, fields)


def _again(label: str, source: str, fields: Mapping[str, Any]) -> Chosen:
    return Chosen(label, source, dataclasses.replace(load_model(source).robot, **fields))


def load_model(source: str) -> ModelEntry:
    """The registered model called ``source``, or the one that the file ``source`` declares as ``MODEL``.

    Raises `UsageError` on an unknown name, and on a file that declares no `dsnn.ModelEntry`.
    """
    if not is_file(source):
        try:
            return model_entry(source)
        except ValueError as error:
            raise UsageError(f"--model {source}: {error}, or a .py file") from None
    entry = declared(Path(source), "MODEL")
    if not isinstance(entry, ModelEntry):
        raise UsageError(f"{source}: MODEL is a {type(entry).__name__}, expected a dsnn.ModelEntry")
    if not dataclasses.is_dataclass(entry.robot) or isinstance(entry.robot, type):
        raise UsageError(f"{source}: MODEL.robot is a {type(entry.robot).__name__}, expected a frozen dataclass")
    return entry


def choose(source: str, tests: Literal["robot", "offline"] = "robot") -> Chosen:
    """The model ``source`` with its parameters for the robot's tests, or for the off-line ones."""
    entry = load_model(source)
    return Chosen(entry.name, str(Path(source).resolve()) if is_file(source) else source, entry.preset(tests))


def family(name: str) -> str:
    """The section of ``--set`` that a model's parameters are under: ``dsnn-reference`` is one of the ``dsnn``.

    ``name`` may be a label with settings (``dsnn:w_i=1``).
    """
    return name.partition(":")[0].split("-")[0]


class Watching:
    """One model at its work. Whatever it raises ends its own part, not that of others beside it.

    ``trouble`` says what went wrong; empty while nothing has.
    """

    def __init__(self, chosen: Chosen, shape: tuple[int, int]) -> None:
        self.chosen, self.label = chosen, chosen.label
        self.responses: list[Response] = []
        self.trouble = ""
        try:
            self._model = chosen.build(shape)
        except (Exception, SystemExit) as error:
            self._broke(error)

    def see(self, luma: npt.NDArray[np.uint8], *, maps: bool = False) -> None:
        """Let it answer the next frame."""
        if not self.trouble:
            try:
                self.responses.append(self._model.step(luma, maps=maps))
            except (Exception, SystemExit) as error:
                self._broke(error)

    def series(self) -> ResponseSeries | None:
        """Its answers to all frames; ``None`` if it broke, or answered with something else than numbers."""
        if self.trouble:
            return None
        try:
            return _finite(ResponseSeries.from_responses(self.responses))
        except Exception as error:
            self._broke(error)
            return None

    def _broke(self, error: BaseException) -> None:
        said = " ".join(str(error).split())
        self.trouble = f"{type(error).__name__}: {said}" if said else type(error).__name__


def _finite(series: ResponseSeries) -> ResponseSeries:
    for field in dataclasses.fields(series):
        values = getattr(series, field.name)
        wrong = np.flatnonzero(~np.isfinite(values))
        if wrong.size:
            raise ValueError(f"{field.name} is {values[wrong[0]]} in frame {wrong[0]}")
    return series
