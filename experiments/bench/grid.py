"""The grid of a sweep: axes of ``KEY=V1,V2`` texts, points, and what a point sets in an experiment and in a model."""

from __future__ import annotations

import itertools
import math
from collections.abc import Collection, Iterable, Mapping, Sequence
from typing import Any

from dsnn.field_docs import meaning
from experiments.bench.run.errors import UsageError
from experiments.bench.run.models import PRESET
from experiments.bench.run.settings import collect, names, preset_of, unit_of
from experiments.bench.study import Axis

Point = tuple[tuple[str, str], ...]
"""Name of each axis with a level."""
Base = Mapping[str, tuple[Any, ...]]
"""Section of ``--set`` -> its dataclasses: one, but of a stimulus one for each clip that shows it."""

MOST_POINTS, MOST_AXES = 1000, 2
ENDS: Mapping[str, int] = {"first": 0, "last": -1}
"""Suffix of a key -> the place, in a parameter of several values, of the value that it means."""
LONGEST_TITLE = 60
"""Letters of a parameter's meaning above which its name stands in labels."""


def keys_of(name: str) -> tuple[str, ...]:
    """Return the keys of the parameters that have one value, from ``KEY`` or ``KEY+KEY``."""
    return tuple(name.split("+"))


def apart(key: str) -> tuple[str, str]:
    """Split a key into that of the parameter and the end of it that is meant: ``first``, ``last`` or empty."""
    parameter, _, end = key.rpartition(".")
    return (parameter, end) if end in ENDS and "." in parameter else (key, "")


def take(text: str, taken: set[str], fixed: Collection[str] = ()) -> None:
    """Add the keys of an ``--over`` text to those ``taken``; `UsageError` where one is there twice or ``fixed``.

    The two ends of one parameter are two keys, and a parameter as a whole has both.
    """
    for key in keys_of(text.partition("=")[0]):
        whole = apart(key)[0]
        if key in fixed or any(key in (other, apart(other)[0]) or whole == other for other in taken):
            raise UsageError(f"--over {text}: {key} is there twice, or --set settles it")
        taken.add(key)


def levels_of(over: Sequence[str], assignments: Iterable[str] = ()) -> dict[str, list[str]]:
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
        points.
    """
    axes: dict[str, list[str]] = {}
    fixed, taken = {text.partition("=")[0] for text in assignments}, set[str]()
    for text in over:
        key, _, values = text.partition("=")
        levels = [value for value in values.split(",") if value]
        if not levels or len(set(levels)) < len(levels):
            raise UsageError(f"--over {text}: expected SECTION.NAME=VALUE,VALUE,... for example dsnn.n_con=4,6,8")
        take(text, taken, fixed)
        axes[key] = levels
    if not 0 < (number := math.prod(map(len, axes.values())) if axes else 0) <= MOST_POINTS:
        raise UsageError(f"--over must be there once or more, with up to {MOST_POINTS} points, got {number}")
    return axes


def points_of(axes: Mapping[str, Iterable[str]]) -> list[Point]:
    """Return every combination of the levels of axes, by name; the last axis goes fastest."""
    return [tuple(zip(axes, levels, strict=True)) for levels in itertools.product(*axes.values())]


def knows(base: Base, key: str) -> bool:
    """Tell whether ``--set`` knows a key there; one of an end, too."""
    section, _, name = apart(key)[0].partition(".")
    return section in base and name in names(base[section][0])


def present(base: Base, key: str) -> Any:
    """Return the value of a parameter; ``None`` where clips have several."""
    section, _, name = key.partition(".")
    values = {preset_of(value) if name == PRESET else getattr(value, name) for value in base[section]}
    return values.pop() if len(values) == 1 else None


def check_keys(texts: Iterable[str], bases: Sequence[Base], option: str) -> None:
    """Raise `UsageError` for a ``KEY=VALUE`` text whose key none of the experiments has."""
    for text in texts:
        key, equals, value = text.partition("=")
        if not equals or not any(knows(base, key) for base in bases):
            sections = {section: values[0] for base in bases for section, values in base.items()}
            collect([f"{apart(key)[0]}{equals}{value}"], sections, option=option)


def axes_of(over: Sequence[str], bases: Sequence[Base], assignments: Sequence[str]) -> list[Axis]:
    """Return the axes of ``KEY=V1,V2`` texts, checked against the experiments that they move.

    The order in which values were typed changes neither the numbers of trials nor the tables.

    Raises
    ------
    UsageError
        There are more than `MOST_AXES`, a key is of no experiment or model; or as of `levels_of`.
    """
    axes = levels_of(over, assignments)
    if len(axes) > MOST_AXES:
        raise UsageError(f"--over must be there once or {MOST_AXES} times, got {len(axes)}")
    return [_axis(name, labels, bases) for name, labels in axes.items()]


def _axis(name: str, labels: list[str], bases: Sequence[Base]) -> Axis:
    keys = keys_of(name)
    check_keys([f"{key}={labels[0]}" for key in keys], bases, "--over")
    values = Axis(name, dict.fromkeys(labels, ())).values
    if isinstance(values[labels[0]], float):
        labels.sort(key=float)
    defaults = {_default(key, bases) for key in keys}
    title = " and ".join(dict.fromkeys(title_of(key, bases) for key in keys))
    levels = {label: tuple(f"{key}={label}" for key in keys) for label in labels}
    return Axis(name, levels, title, defaults.pop() if len(defaults) == 1 else None)


def _default(key: str, bases: Sequence[Base]) -> float | str | None:
    """Return the value without the axis; ``None`` where experiments differ or it has several."""
    name, end = apart(key)
    values = {present(base, name) for base in bases if knows(base, name)}
    if end and not any(isinstance(value, tuple) for value in values):
        raise UsageError(f"--over {key}: {name} has one value, neither a first nor a last")
    value = values.pop() if len(values) == 1 else None
    if isinstance(value, tuple) and (end or len(value) == 1):
        value = value[ENDS.get(end, 0)]
    if value is None or isinstance(value, tuple):
        return None
    return str(value).lower() if isinstance(value, bool) else float(value) if isinstance(value, int | float) else value


def title_of(key: str, bases: Sequence[Base]) -> str:
    """Return what a parameter means in a few words, with the end of it that moves and its unit."""
    parameter, end = apart(key)
    section, _, name = parameter.partition(".")
    value = next(base[section][0] for base in bases if knows(base, parameter))
    words = meaning(type(value), name).partition(" (")[0].partition(",")[0].partition(";")[0].partition(":")[0]
    unit = unit_of(value, name)
    title = words if 0 < len(words) <= LONGEST_TITLE else name.replace("_", " ")
    return f"{title}{f', {end}' if end else ''}{f' ({unit})' if unit else ''}"


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
            parts = values.setdefault(parameter, [str(part) for part in present(base, parameter)])
            parts[ENDS[end]] = value
        else:
            values[parameter] = [value]
    return {parameter: ",".join(parts) for parameter, parts in values.items()}


def moves(axis: Axis, base: Base, fixed: Collection[str] = ()) -> bool:
    """Tell whether an axis moves anything there but the ``fixed`` keys."""
    keys = [apart(text.partition("=")[0])[0] for texts in axis.levels.values() for text in texts]
    return any(knows(base, key) and key not in fixed for key in keys)
