"""The grid of a sweep: axes of ``KEY=V1,V2`` texts, points, and what a point sets in an experiment and in a model."""

from __future__ import annotations

import itertools
import math
from collections.abc import Collection, Iterable, Mapping, Sequence
from typing import Any

from experiments.base.errors import UsageError
from experiments.base.values import key_values
from experiments.declare.study import Levels
from experiments.settings.models import names
from experiments.settings.settings import by_section

Point = tuple[tuple[str, str], ...]
"""Name of each axis with a level."""
Base = Mapping[str, Any]
"""Section of ``--set`` -> its dataclass; of a stimulus that of the first clip that shows it."""

MOST_AXES = 2
ENDS: Mapping[str, int] = {"first": 0, "last": -1}
"""Suffix of a key -> the place, in a parameter of several values, of the value that it means."""


def apart(key: str) -> tuple[str, str]:
    """Split a key into that of the parameter and the end of it that is meant: ``first``, ``last`` or empty."""
    parameter, _, end = key.rpartition(".")
    return (parameter, end) if end in ENDS and "." in parameter else (key, "")


def take(text: str, taken: set[str], fixed: Collection[str] = ()) -> None:
    """Add the keys of an ``--over`` text to those ``taken``; `UsageError` where one is there twice or ``fixed``.

    The two ends of one parameter are two keys, and a parameter as a whole has both.
    """
    for key in text.partition("=")[0].split("+"):
        whole = apart(key)[0]
        if key in fixed or any(key in (other, apart(other)[0]) or whole == other for other in taken):
            raise UsageError(f"--over {text}: {key} is there twice, or --set settles it")
        taken.add(key)


def levels_of(over: Sequence[str], assignments: Iterable[str] = ()) -> dict[str, Levels]:
    """Return the levels of each axis from ``KEY=V1,V2,...`` texts.

    Parameters
    ----------
    over
        The texts, one for each axis.
    assignments
        The ``KEY=VALUE`` texts of ``--set`` that hold at every point.

    Raises
    ------
    UsageError
        A text is not of that form, something is there twice, ``--set`` sets what an axis varies, or there are too many
        axes.
    """
    axes: dict[str, Levels] = {}
    fixed, taken = {text.partition("=")[0] for text in assignments}, set[str]()
    for text in over:
        name, _, values = text.partition("=")
        levels = [value for value in values.split(",") if value]
        if not levels or len(set(values_of(levels).values())) < len(levels):
            raise UsageError(f"--over {text}: expected SECTION.NAME=VALUE,VALUE,... for example dsnn.n_con=4,6,8")
        take(text, taken, fixed)
        axes[name] = {level: tuple(f"{key}={level}" for key in name.split("+")) for level in levels}
    if len(axes) > MOST_AXES:
        raise UsageError(f"--over must be there once or {MOST_AXES} times, got {len(axes)}")
    return axes


def values_of(levels: Iterable[str]) -> dict[str, float | str]:
    """Return level -> its value: the numbers if all levels are finite ones, otherwise the texts."""
    try:
        numbers = {level: float(level) for level in levels}
    except ValueError:
        return {level: level for level in levels}
    return dict(numbers) if all(map(math.isfinite, numbers.values())) else {level: level for level in numbers}


def points_of(axes: Mapping[str, Iterable[str]]) -> list[Point]:
    """Return every combination of the levels of axes, by name; the last axis goes fastest."""
    return [tuple(zip(axes, levels, strict=True)) for levels in itertools.product(*axes.values())]


def knows(base: Base, key: str) -> bool:
    """Tell whether ``--set`` knows a key there; one of an end, too."""
    section, _, name = apart(key)[0].partition(".")
    return section in base and name in names(base[section])


def check_keys(texts: Iterable[str], bases: Sequence[Base], option: str) -> None:
    """Raise `UsageError` for a ``KEY=VALUE`` text whose key none of the experiments has."""
    for key, value in key_values(texts, option).items():
        if not any(knows(base, key) for base in bases):
            sections = {section: present for base in bases for section, present in base.items()}
            by_section({apart(key)[0]: value}, sections, option)


def sets(texts: Iterable[str], base: Base) -> dict[str, str]:
    """Return what the ``KEY=VALUE`` texts of a point set: parameters with their values.

    Keys that are not in ``base`` are ignored. A parameter of which an end moves has the other end as it is.
    """
    values: dict[str, list[str]] = {}
    for text in texts:
        key, _, value = text.partition("=")
        parameter, end = apart(key)
        if not knows(base, parameter):
            continue
        if end:
            section, _, name = parameter.partition(".")
            present = getattr(base[section], name, None)
            if not isinstance(present, tuple):
                raise UsageError(f"--over {key}: {parameter} has one value, neither a first nor a last")
            values.setdefault(parameter, [str(part) for part in present])[ENDS[end]] = value
        else:
            values[parameter] = [value]
    return {parameter: ",".join(parts) for parameter, parts in values.items()}


def moves(levels: Levels, base: Base, fixed: Collection[str] = ()) -> bool:
    """Tell whether an axis moves anything there but the ``fixed`` keys."""
    keys = [apart(text.partition("=")[0])[0] for texts in levels.values() for text in texts]
    return any(knows(base, key) and key not in fixed for key in keys)
