"""Tables of parameters, from the same machinery as ``colias list parameters``: default, legal range, unit, meaning."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Iterator, Mapping, Sequence
from types import MappingProxyType
from typing import Any

from experiments.bench.run.models import PRESET
from experiments.bench.run.settings import Parameter, described
from tools.pages.markdown import code, prose, table


def rows(values: Any) -> Iterator[Parameter]:
    """Yield the parameters of a frozen dataclass, by their names alone. Its presets are no parameter."""
    fields = {field.name for field in dataclasses.fields(values)}
    for parameter in described({"section": values}):
        name = parameter.key.partition(".")[2]
        if name in fields:
            yield dataclasses.replace(parameter, key=name, value=written(getattr(values, name)))


def written(value: Any) -> str:
    """Return a value as it is typed after ``--set``."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, tuple):
        return ",".join(map(written, value))
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def parameters(values: Any, others: Mapping[str, Any] = MappingProxyType({})) -> str:
    """Return a table of the parameters of a class.

    Parameters
    ----------
    values
        The defaults, a frozen dataclass.
    others
        Word -> other values of the same class, which are told where they are not the defaults.
    """
    named = {word: {row.key: row.value for row in rows(section)} for word, section in others.items()}
    lines = []
    for row in rows(values):
        notes = [
            f", {word} {code(section[row.key])}" for word, section in named.items() if section[row.key] != row.value
        ]
        value = f"{code(row.value)}{''.join(notes)}"
        lines.append((code(row.key), value, prose(row.description), _unit_cell(row.unit), _legal_cell(row.legal)))
    drawn = table(("Parameter", "Default", "Meaning", "Unit", "Legal"), lines)
    return f":::{{table}}\n:class: parameters\n\n{drawn}:::\n"


def _legal_cell(legal: str) -> str:
    """Return the legal values in fewer words, for a column that is narrow."""
    words = legal.replace("a whole number", "whole,").replace(", separated by commas, each", ", each")
    return prose(re.sub(r"(^|each )a number (?=from|above)", r"\1", words))


def _unit_cell(unit: str) -> str:
    return code(unit) if unit == "speed_unit" else unit


def changes(values: Any, base: Any) -> Sequence[str]:
    """Return what is set in ``values`` that is otherwise in ``base``, as texts for ``--set``."""
    names = (field.name for field in dataclasses.fields(values) if field.name != PRESET)
    return [f"{n}={written(getattr(values, n))}" for n in names if getattr(values, n) != getattr(base, n)]
