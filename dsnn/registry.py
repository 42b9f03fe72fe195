"""The models by name. A new one is a file with its class and a line in `_ENTRIES` below."""

from __future__ import annotations

import difflib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

from dsnn.model import VisionModel
from dsnn.network import DSNN
from dsnn.params import DSNNParams
from dsnn.reference import ReferenceDSNN


@dataclass(frozen=True, slots=True)
class ModelEntry:
    """A registered model: how to build it for frames of shape (R, C), and its parameters on the robot."""

    name: str
    summary: str
    build: Callable[[tuple[int, int], Any], VisionModel]
    robot: Any
    """The parameters of the on-board trials: a frozen, validated dataclass."""


_ENTRIES = (
    ModelEntry("dsnn", "directionally selective neural network (Fu et al. 2018)", DSNN, DSNNParams.robot()),
    ModelEntry("dsn2017", "its forerunner (Fu and Yue 2017): no FDSR", DSNN, DSNNParams.robot(fdsr=False)),
    ModelEntry("dsnn-reference", "the same, plain float64 form to test against", ReferenceDSNN, DSNNParams.robot()),
)


def _by_name(entries: tuple[ModelEntry, ...]) -> Mapping[str, ModelEntry]:
    table = {entry.name: entry for entry in entries}
    if len(table) != len(entries):
        raise ValueError(f"two models share a name in {[entry.name for entry in entries]}")
    return MappingProxyType(table)


MODELS = _by_name(_ENTRIES)


def model_entry(name: str) -> ModelEntry:
    """The entry of ``name``; ``ValueError`` with the nearest known name otherwise."""
    if name not in MODELS:
        near = difflib.get_close_matches(name, MODELS, n=1, cutoff=0.0)[0]
        raise ValueError(f"unknown model '{name}': known are {', '.join(MODELS)} (nearest: {near})")
    return MODELS[name]
