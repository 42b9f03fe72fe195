"""The axes of a map: ``--over KEY=V1,V2``, several keys that move together, one end of a parameter with two values."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from experiments.bench.engine.errors import UsageError
from experiments.bench.engine.settings import PRESET, collect, names, preset_of, unit_of
from experiments.bench.robot.sweep import grid
from experiments.bench.robot.sweep.grid import Point, Values
from experiments.bench.store.parameters import Parameters

MOST_AXES = 2
ENDS: Mapping[str, int] = {"first": 0, "last": -1}
"""Suffix of a key -> the place, in a parameter of several values, of the value that it means."""


@dataclass(frozen=True, slots=True)
class Axis:
    """One axis of a map.

    Parameters
    ----------
    name
        What was typed before the ``=``: one key, or several joined by ``+``, which move together.
    levels
        Its values, as typed: ascending if all are numbers.
    default
        The value without ``--over``; ``None`` where there is no single one.
    unit
        Unit of the values; empty where none is known.
    """

    name: str
    levels: tuple[str, ...]
    default: float | str | None = None
    unit: str = ""

    @property
    def keys(self) -> tuple[str, ...]:
        """The keys that it moves."""
        return tuple(self.name.split("+"))

    def values(self) -> tuple[float | str, ...]:
        """The levels as numbers if all of them are finite ones, otherwise as typed."""
        try:
            numbers = tuple(float(level) for level in self.levels)
        except ValueError:
            return self.levels
        return numbers if all(map(math.isfinite, numbers)) else self.levels

    def words(self) -> list[str]:
        """The axis in words: its keys, one each, then their unit and the default, if there are any."""
        keys = [*(f"{key} +" for key in self.keys[:-1]), self.keys[-1]]
        default = "" if self.default is None else f"default {said(self.default)}"
        more = ", ".join(filter(None, (self.unit, default)))
        return [*keys, *([f"({more})"] if more else [])]


@dataclass(frozen=True, slots=True)
class Base:
    """One experiment of a map without the grid's values, as the keys of ``--over`` and ``--set`` see it.

    Parameters
    ----------
    name
        The experiment's name.
    model
        Label of the model judged.
    values
        Section of ``--set`` -> its dataclasses. There is one, but of a stimulus one for each clip that shows it.
    """

    name: str
    model: str
    values: Mapping[str, tuple[Any, ...]]

    @property
    def sections(self) -> dict[str, Any]:
        """One dataclass for each section."""
        return {section: values[0] for section, values in self.values.items()}

    def knows(self, key: str) -> bool:
        """Whether a key is one of this experiment's."""
        section, _, name = key.partition(".")
        return section in self.values and name in names(self.values[section][0])

    def present(self, key: str) -> Any:
        """The value of a parameter; ``None`` where clips have several."""
        section, _, name = key.partition(".")
        found = {preset_of(value) if name == PRESET else getattr(value, name) for value in self.values[section]}
        return found.pop() if len(found) == 1 else None

    def applying(self, assignments: Iterable[str]) -> list[str]:
        """Those ``KEY=VALUE`` texts whose key the experiment has."""
        return [text for text in assignments if self.knows(text.partition("=")[0])]


def check_assignments(bases: Sequence[Base], assignments: Iterable[str], option: str = "--set") -> None:
    """Raise `UsageError` for a ``KEY=VALUE`` text whose key none of the experiments has."""
    for text in assignments:
        key = text.partition("=")[0]
        if not any(base.knows(key) for base in bases) or "=" not in text:
            collect([text], bases[0].sections, option=option)


def apart(key: str) -> tuple[str, str]:
    """Split a key into that of the parameter, and the end of it that is meant: ``first``, ``last`` or empty."""
    parameter, _, end = key.rpartition(".")
    return (parameter, end) if end in ENDS and "." in parameter else (key, "")


def ordered(
    over: Sequence[str], bases: Sequence[Base], assignments: Sequence[str]
) -> tuple[list[Point], tuple[Axis, ...]]:
    """The points of a grid, in the order of its axes' levels, and the axes; parameters and errors as of `axes`.

    The order in which values were typed thus changes neither the numbers of trials nor the tables. ``assignments`` are
    the texts of ``--set``: `experiments.bench.robot.sweep.grid.grid` refuses one that an axis varies.
    """
    points = grid.grid(over, assignments)
    found = axes(points, bases)
    points.sort(key=lambda point: [axis.levels.index(v) for axis, (_, v) in zip(found, point.values, strict=True)])
    return points, found


def axes(points: Sequence[Point], bases: Sequence[Base]) -> tuple[Axis, ...]:
    """The axes of a grid, checked against the experiments that it moves.

    Parameters
    ----------
    points
        From `experiments.bench.robot.sweep.grid.grid`; their keys are names of axes.
    bases
        One for each experiment.

    Raises
    ------
    UsageError
        There are more than `MOST_AXES`, a key is of no experiment or model, or it is there twice.
    """
    names = [name for name, _ in points[0].values]
    if len(names) > MOST_AXES:
        raise UsageError(f"--over: {len(names)} axes; a map has 1 or {MOST_AXES}")
    whole = [apart(key)[0] for name in names for key in name.split("+") if not apart(key)[1]]
    keys = [key for name in names for key in name.split("+")]
    for key in keys:
        clash = keys.count(key) > 1 or (bool(apart(key)[1]) and apart(key)[0] in whole)
        if clash:
            raise UsageError(f"--over {key}: that parameter is moved twice")
    return tuple(_axis(place, name, points, bases) for place, name in enumerate(names))


def _axis(place: int, name: str, points: Sequence[Point], bases: Sequence[Base]) -> Axis:
    levels = list(dict.fromkeys(point.values[place][1] for point in points))
    bare = Axis(name, tuple(levels))
    for key in bare.keys:
        _check(key, levels[0], bases)
    if isinstance(bare.values()[0], float):
        levels.sort(key=float)
    defaults = {_default(key, bases) for key in bare.keys}
    units = dict.fromkeys(filter(None, (_unit(key, bases) for key in bare.keys)))
    default = defaults.pop() if len(defaults) == 1 else None
    return Axis(name, tuple(levels), default, ", ".join(units))


def _check(key: str, level: str, bases: Sequence[Base]) -> None:
    """Raise `UsageError` for a key that none of the experiments has, and for an end of a single value."""
    name, end = apart(key)
    check_assignments(bases, [f"{name}={level}"], "--over")
    knowing = next(base for base in bases if base.knows(name))
    if end and not isinstance(knowing.present(name), tuple):
        raise UsageError(f"--over {key}={level}: {name} has one value, neither a first nor a last")


def expanded(values: Values, base: Base) -> Values:
    """What a point sets in one experiment: parameters with their texts, each once, those that it lacks left out.

    Parameters
    ----------
    values
        Names of axes with a level each.
    base
        The experiment. It has the other end of a parameter of which one end moves.
    """
    made: dict[str, list[str]] = {}
    for name, level in values:
        for parameter, end in map(apart, name.split("+")):
            if not base.knows(parameter):
                continue
            if end:
                parts = made.setdefault(parameter, [str(value) for value in base.present(parameter)])
                parts[ENDS[end]] = level
            else:
                made[parameter] = [level]
    return tuple((parameter, ",".join(parts)) for parameter, parts in made.items())


def moves(axis: Axis, base: Base) -> bool:
    """Whether an axis moves anything in one experiment."""
    return any(base.knows(apart(key)[0]) for key in axis.keys)


def label(point: Point, axes_: Sequence[Axis], base: Base, model: str = "") -> str:
    """What a model is called at a point in the trials of one experiment: by the values that move something there.

    ``model`` begins it; without one it is the model judged, which goes by the values alone.
    """
    values = [f"{name}={value}" for axis, (name, value) in zip(axes_, point.values, strict=True) if moves(axis, base)]
    return " ".join(filter(None, (model, *values))) or base.model


def columns(
    points: Sequence[Point], axes_: Sequence[Axis], bases: Sequence[Base], beside: Iterable[str] = ()
) -> Parameters:
    """The grid's values as columns of the table of trials: name of an axis -> label of a model -> value.

    ``beside`` are the models shown beside the one judged.
    """
    found: dict[str, dict[str, Any]] = {axis.name: {} for axis in axes_}
    for point in points:
        for base in bases:
            for axis, (_, level) in zip(axes_, point.values, strict=True):
                value = axis.values()[axis.levels.index(level)] if moves(axis, base) else None
                for model in ("", *beside):
                    found[axis.name][label(point, axes_, base, model)] = value
    return found


def said(value: float | str) -> str:
    """A value of an axis in words."""
    return f"{value:g}" if isinstance(value, float) else value


def _default(key: str, bases: Sequence[Base]) -> float | str | None:
    """What a key stands for in the experiments, as an axis has it; ``None`` where they differ or it has several."""
    name, end = apart(key)
    values = {base.present(name) for base in bases if base.knows(name)}
    value = values.pop() if len(values) == 1 else None
    if end and value is not None:
        value = value[ENDS[end]]
    elif isinstance(value, tuple) and len(value) == 1:
        value = value[0]
    if value is None or isinstance(value, tuple):
        return None
    return str(value).lower() if isinstance(value, bool) else float(value) if isinstance(value, int | float) else value


def _unit(key: str, bases: Sequence[Base]) -> str:
    """The unit that a parameter declares; empty where it has none."""
    name, _ = apart(key)
    knowing = next(base for base in bases if base.knows(name))
    section, _, parameter = name.partition(".")
    return unit_of(knowing.sections[section], parameter)
