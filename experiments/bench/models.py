"""The models of a run: registered ones by name, a user's own by the path of the file that declares it."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from dsnn import ModelEntry, VisionModel, model_entry
from dsnn.model import SPIKING
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
    def channels(self) -> tuple[str, ...]:
        """The channels it declares: any of ``hs``, ``vs``, ``looming``, ``azimuth``."""
        return load_model(self.source).channels

    @property
    def counted(self) -> str:
        """The channel whose spikes are those of a trial: ``hs``, or ``looming`` where no direction is declared."""
        own = self.channels
        return next((channel for channel in SPIKING if channel in own), "")

    @property
    def thresholds(self) -> dict[str, float | None]:
        """Each declared channel's spiking threshold on its potential; ``None`` where it has none."""
        entry = load_model(self.source)
        return {channel: entry.threshold(channel, self.network) for channel in entry.channels}

    @property
    def threshold(self) -> float | None:
        """The spiking threshold of the `counted` channel; ``None`` where it has none."""
        return self.thresholds.get(self.counted)

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
    for preset in (entry.robot, entry.offline or entry.robot):
        for channel in entry.channels:
            try:
                entry.threshold(channel, preset)
            except (TypeError, ValueError):
                name = entry.thresholds.get(channel, "t_sp")
                raise UsageError(f"{source}: MODEL's parameter {name} is a threshold: legal is a number") from None
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
