"""The axes of a map: ``--over KEY=V1,V2``, several keys that move together, one end of a parameter with two values."""

from __future__ import annotations

import dataclasses
import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from experiments.bench.core.errors import UsageError
from experiments.bench.core.settings import PRESET, collect, described, preset_of
from experiments.bench.robot.experiment import Experiment
from experiments.bench.robot.plan import Plan, sections
from experiments.bench.robot.sweep.grid import Point, Values

MOST_AXES = 2
ENDS: Mapping[str, int] = {"first": 0, "last": -1}
"""Suffix of a key -> the place, in a parameter of several values, of the value that it means."""

_SUFFIXES: Mapping[str, str] = {
    "_cm_s2": "cm/s2", "_deg_s": "degrees/s", "_cm_s": "cm/s", "_cm": "cm", "_mm": "mm", "_deg": "degrees",
    "_ms": "ms",
}  # fmt: skip
_IN_WORDS = re.compile(r", (ms|px)\b")
"""A unit in a parameter's description."""


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


def apart(key: str) -> tuple[str, str]:
    """Split a key into that of the parameter, and the end of it that is meant: ``first``, ``last`` or empty."""
    parameter, _, end = key.rpartition(".")
    return (parameter, end) if end in ENDS and "." in parameter else (key, "")


def axes(points: Sequence[Point], plans: Sequence[Plan], models: Sequence[str]) -> tuple[Axis, ...]:
    """The axes of a grid, checked against the plans that it moves.

    Parameters
    ----------
    points
        From `experiments.bench.robot.sweep.grid.grid`; their keys are names of axes.
    plans
        One for each experiment, without the grid's values.
    models
        The models shown.

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
    return tuple(_axis(place, name, points, plans, models) for place, name in enumerate(names))


def _axis(place: int, name: str, points: Sequence[Point], plans: Sequence[Plan], models: Sequence[str]) -> Axis:
    levels = list(dict.fromkeys(point.values[place][1] for point in points))
    bare = Axis(name, tuple(levels))
    for key in bare.keys:
        _check(key, levels[0], plans, models)
    if isinstance(bare.values()[0], float):
        levels.sort(key=float)
    defaults = {_default(key, plans) for key in bare.keys}
    units = dict.fromkeys(filter(None, (_unit(key, plans, models) for key in bare.keys)))
    default = defaults.pop() if len(defaults) == 1 else None
    return Axis(name, tuple(levels), default, ", ".join(units))


def _check(key: str, level: str, plans: Sequence[Plan], models: Sequence[str]) -> None:
    """Raise `UsageError` for a key that none of the experiments has, and for an end of a single value."""
    name, end = apart(key)
    knowing = [plan for plan in plans if knows(plan.experiment, name)]
    known = sections((knowing or plans)[0].experiment, models)
    collect([f"{name}={level}"], known, option="--over")
    if end and not isinstance(present((knowing or plans)[0], name), tuple):
        raise UsageError(f"--over {key}={level}: {name} has one value, neither a first nor a last")


def knows(experiment: Experiment, key: str) -> bool:
    """Whether a key can be one of this experiment: any key but that of a parameter that its design lacks."""
    section, _, name = key.partition(".")
    fields = dataclasses.fields(experiment.design)  # type: ignore[arg-type]
    return section != "experiment" or name in {field.name for field in fields}


def applying(experiment: Experiment, assignments: Iterable[str]) -> list[str]:
    """Those ``KEY=VALUE`` texts whose key the experiment can have."""
    return [text for text in assignments if knows(experiment, text.partition("=")[0])]


def present(plan: Plan, key: str) -> Any:
    """The value that a parameter has in a plan of one model."""
    section, _, name = key.partition(".")
    settings = plan.settings
    owners = {"robot": settings.robot, "camera": settings.camera, "scene": settings.scene,
              "experiment": plan.experiment.design}  # fmt: skip
    owner = owners.get(section, settings.models[0].network)
    return preset_of(owner) if name == PRESET else getattr(owner, name)


def expanded(values: Values, plan: Plan) -> Values:
    """What a point sets in one experiment: parameters with their texts, each once, those that it lacks left out.

    Parameters
    ----------
    values
        Names of axes with a level each.
    plan
        The experiment's plan without the grid's values. It has the other end of a parameter of which one end moves.
    """
    made: dict[str, list[str]] = {}
    for name, level in values:
        for parameter, end in map(apart, name.split("+")):
            if not knows(plan.experiment, parameter):
                continue
            if end:
                parts = made.setdefault(parameter, [str(value) for value in present(plan, parameter)])
                parts[ENDS[end]] = level
            else:
                made[parameter] = [level]
    return tuple((parameter, ",".join(parts)) for parameter, parts in made.items())


def moves(axis: Axis, plan: Plan) -> bool:
    """Whether an axis moves anything in one experiment."""
    return any(knows(plan.experiment, apart(key)[0]) for key in axis.keys)


def said(value: float | str) -> str:
    """A value of an axis in words."""
    return f"{value:g}" if isinstance(value, float) else value


def _default(key: str, plans: Sequence[Plan]) -> float | str | None:
    """What a key stands for in the plans, as an axis has it; ``None`` where they differ or it is no single value."""
    name, end = apart(key)
    values = {present(plan, name) for plan in plans if knows(plan.experiment, name)}
    if len(values) != 1:
        return None
    value = values.pop()
    if end:
        value = value[ENDS[end]]
    elif isinstance(value, tuple) and len(value) == 1:
        value = value[0]
    if isinstance(value, tuple):
        return None
    return str(value).lower() if isinstance(value, bool) else float(value) if isinstance(value, int | float) else value


def _unit(key: str, plans: Sequence[Plan], models: Sequence[str]) -> str:
    """The unit of a parameter, from the end of its name or from its description; empty where neither has one."""
    name, _ = apart(key)
    known = [plan.experiment for plan in plans if knows(plan.experiment, name)]
    said = next(each.description for each in described(sections(known[0], models)) if each.key == name)
    in_words = _IN_WORDS.search(said)
    if in_words:
        return in_words[1]
    return next((unit for suffix, unit in _SUFFIXES.items() if name.endswith(suffix)), "")
