"""Tables of parameters, from the same machinery as ``colias list parameters``: default, legal range, unit, meaning."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

from experiments.bench.run.models import PRESET
from experiments.bench.run.settings import described
from tools.pages.markdown import code, prose, table


@dataclass(frozen=True, slots=True)
class Row:
    """A parameter.

    Attributes
    ----------
    name
        After its section's.
    value
        As it is typed.
    unit
        Empty where it is a pure number, or where the meaning alone says what it counts.
    """

    name: str
    value: str
    legal: str
    unit: str
    meaning: str


def rows(values: Any) -> Iterator[Row]:
    """Yield the parameters of a frozen dataclass. Its presets are no parameter."""
    fields = {field.name for field in dataclasses.fields(values)}
    for parameter in described({"section": values}):
        name = parameter.key.partition(".")[2]
        if name in fields:
            present = getattr(values, name)
            yield Row(name, written(present), parameter.legal, parameter.unit, parameter.description)


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
    named = {word: {row.name: row.value for row in rows(section)} for word, section in others.items()}
    lines = []
    for row in rows(values):
        notes = [
            f", {word} {code(section[row.name])}" for word, section in named.items() if section[row.name] != row.value
        ]
        value = f"{code(row.value)}{''.join(notes)}"
        lines.append((code(row.name), value, prose(row.meaning), _unit_cell(row.unit), _legal_cell(row.legal)))
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
