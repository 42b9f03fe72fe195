"""Parameters of a run that differ from their defaults, and their columns in ``trials.parquet``."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from experiments.settings.models import EVERY_FRAME, ConfiguredModel, families, without_control

if TYPE_CHECKING:
    import polars as pl

Parameters = Mapping[str, Mapping[str, Any]]
"""Key, as ``--set`` has it -> label of a model -> its value; ``None`` of a model that has no such parameter."""


def differing(
    models: Sequence[ConfiguredModel], *, offline: bool = False, others: Mapping[str, tuple[Any, Any]] | None = None
) -> Parameters:
    """Find the parameters of a run that differ from their defaults.

    Parameters
    ----------
    models
        The run's models.
    offline
        Whether their defaults are those for off-line tests.
    others
        Section of ``--set`` -> its defaults and its values, of what all models share.

    Returns
    -------
    Parameters
        In order of section, then as declared. A column has one type: texts where the values are of several kinds.
        A sequence is the text that ``--set`` takes.
    """
    named = families(models)
    defaults = [model.declared.preset("offline" if offline else "robot") for model in models]
    keys: dict[str, None] = {}
    for section, default, model in zip(named, defaults, models, strict=True):
        keys |= dict.fromkeys(f"{section}.{name}" for name in _differing(default, model.network))
    changed: dict[str, dict[str, Any]] = {}
    for key in keys:
        section, _, name = key.partition(".")
        changed[key] = {
            model.label: getattr(model.network, name, None) if model_section == section else None
            for model_section, model in zip(named, models, strict=True)
        }
    if any(model.processor != EVERY_FRAME for model in models):
        changed["processor.every"] = {model.label: model.processor.every for model in models}
    for section, (default, value) in (others or {}).items():
        for name in _differing(default, value):
            changed[f"{section}.{name}"] = {model.label: getattr(value, name) for model in models}
    return {key: _of_one_kind(values) for key, values in changed.items()}


def _differing(default: Any, value: Any) -> Iterable[str]:
    """Return the fields of a dataclass that differ from those of another of its class."""
    names = [field.name for field in dataclasses.fields(value) if field.init]
    return [name for name in names if getattr(default, name, None) != getattr(value, name)]


def _of_one_kind(values: Mapping[str, Any]) -> dict[str, Any]:
    cells = {label: cell(value) for label, value in values.items()}
    kinds = {type(cell) for cell in cells.values() if cell is not None}
    if len(kinds) < 2:
        return cells
    whole = float if kinds == {int, float} else str
    return {label: None if cell is None else whole(cell) for label, cell in cells.items()}


def cell(value: Any) -> Any:
    """Return a value as a table has it: a sequence is the text that ``--set`` takes."""
    if isinstance(value, tuple | list):
        return ",".join(_number(item) for item in value)
    return value if value is None or isinstance(value, bool | int | float | str) else str(value)


def _number(value: Any) -> str:
    short = f"{value:g}" if isinstance(value, float) else str(value)
    return short if not isinstance(value, float) or float(short) == value else str(value)


def with_columns(schema: pl.Schema, parameters: Parameters) -> pl.Schema:
    """Return the schema of a table with a column more for each parameter."""
    import polars as pl  # not before: what only lists studies loads no tables

    kinds = {
        key: next((type(value) for value in values.values() if value is not None), str)
        for key, values in parameters.items()
    }
    return schema | pl.Schema(kinds)


def of_model(parameters: Parameters, model: str) -> dict[str, Any]:
    """Return what a row of ``model`` has in those columns: that of a control what its model has."""
    return {key: values.get(without_control(model)) for key, values in parameters.items()}


def in_words(parameters: Mapping[str, Mapping[str, Any]]) -> str:
    """Return parameters in a line: ``dsnn.n_con=4|6, camera.read_noise=0``."""
    texts = {key: dict.fromkeys(_number(value) for value in values.values() if value is not None)
             for key, values in parameters.items()}  # fmt: skip
    return ", ".join(f"{key}={'|'.join(values)}" for key, values in texts.items())
