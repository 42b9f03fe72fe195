"""The grid of a study: its axes and points, and what a point sets in an experiment and in a model.

Points that differ in a model's parameters alone share a rendering: they are models of the same trials.
"""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from experiments.bench.run.errors import UsageError
from experiments.bench.run.models import PRESET, ConfiguredModel, SelectedModel
from experiments.bench.run.settings import changed, collect, names, preset_of, unit_of
from experiments.bench.store.parameters import Parameters
from experiments.bench.studies.study import Axis, Level, keys_of

Values = tuple[tuple[str, str], ...]
"""Keys with their values."""

MOST_POINTS, MOST_AXES = 1000, 2
ENDS: Mapping[str, int] = {"first": 0, "last": -1}
"""Suffix of a key -> the place, in a parameter of several values, of the value that it means."""


@dataclass(frozen=True, slots=True)
class Point:
    """One combination of levels: names of axes with a label each."""

    values: Values = ()


@dataclass(frozen=True, slots=True)
class Base:
    """An experiment before one model without the grid's values, as the keys of ``--over`` and ``--set`` see it.

    Parameters
    ----------
    name
        The experiment's name.
    model
        Label of the model.
    values
        Section of ``--set`` -> its dataclasses. There is one, but of a stimulus one for each clip that shows it.
    settled
        Keys that the model has settled itself, as ``dsnn:n_con=4`` does: no point moves them.
    """

    name: str
    model: str
    values: Mapping[str, tuple[Any, ...]]
    settled: frozenset[str] = frozenset()

    @property
    def sections(self) -> dict[str, Any]:
        """One dataclass for each section."""
        return {section: values[0] for section, values in self.values.items()}

    def knows(self, key: str) -> bool:
        """Tell whether a key is one of this experiment's."""
        section, _, name = key.partition(".")
        return section in self.values and name in names(self.values[section][0])

    def takes(self, key: str) -> bool:
        """Tell whether a point's value for a key counts here."""
        return self.knows(key) and key not in self.settled

    def present(self, key: str) -> Any:
        """Return the value of a parameter; ``None`` where clips have several."""
        section, _, name = key.partition(".")
        values = {preset_of(value) if name == PRESET else getattr(value, name) for value in self.values[section]}
        return values.pop() if len(values) == 1 else None

    def applying(self, assignments: Iterable[str]) -> list[str]:
        """Return those ``KEY=VALUE`` texts whose key the experiment has."""
        return [text for text in assignments if self.knows(text.partition("=")[0])]


def product(over: Sequence[str], assignments: Iterable[str] = ()) -> list[Point]:
    """Return every combination of ``KEY=V1,V2,...`` texts.

    Parameters
    ----------
    over
        The texts, one for each axis.
    assignments
        The ``KEY=VALUE`` texts of ``--set`` that hold at every point.

    Raises
    ------
    UsageError
        A text is not of that form, something is there twice, an axis varies what ``--set`` settles, or there are no
        axes or too many points.
    """
    axes: list[tuple[str, list[str]]] = []
    settled = {text.partition("=")[0]: text for text in assignments}
    for text in over:
        key, equals, values = text.partition("=")
        levels = [value for value in values.split(",") if value]
        if not equals or not levels:
            raise UsageError(f"--over {text}: expected SECTION.NAME=VALUE,VALUE,... for example dsnn.n_con=4,6,8")
        if len(set(levels)) < len(levels) or key in [k for k, _ in axes]:
            raise UsageError(f"--over {text}: a value or a key is there twice")
        clash = next((settled[name] for name in keys_of(key) if name in settled), None)
        if clash is not None:
            raise UsageError(f"--set {clash}: --over {text} sets that at every point; give one of them")
        axes.append((key, levels))
    points = points_of(axes)
    if not axes or len(points) > MOST_POINTS:
        raise UsageError(f"--over: {len(points)} points; legal is one --over or more, up to {MOST_POINTS} points")
    return points


def points_of(axes: Sequence[tuple[str, Sequence[str]]]) -> list[Point]:
    """Return every combination of labels, of axes with their labels; the last axis goes fastest."""
    keys = [key for key, _ in axes]
    return [
        Point(tuple(zip(keys, labels, strict=True))) for labels in itertools.product(*(labels for _, labels in axes))
    ]


def axes_of(over: Sequence[str], bases: Sequence[Base], assignments: Sequence[str]) -> tuple[Axis, ...]:
    """Return the axes of ``KEY=V1,V2`` texts, checked against the experiments that they move.

    The order in which values were typed changes neither the numbers of trials nor the tables.

    Raises
    ------
    UsageError
        There are more than `MOST_AXES`, a key is of no experiment or model, or is there twice; or as of `product`.
    """
    points = product(over, assignments)
    named = [name for name, _ in points[0].values]
    if len(named) > MOST_AXES:
        raise UsageError(f"--over: {len(named)} axes; a map has 1 or {MOST_AXES}")
    whole = [apart(key)[0] for name in named for key in keys_of(name) if not apart(key)[1]]
    keys = [key for name in named for key in keys_of(name)]
    for key in keys:
        if keys.count(key) > 1 or (apart(key)[1] and apart(key)[0] in whole):
            raise UsageError(f"--over {key}: that parameter is moved twice")
    return tuple(
        _axis(name, list(dict.fromkeys(point.values[place][1] for point in points)), bases)
        for place, name in enumerate(named)
    )


def _axis(name: str, labels: list[str], bases: Sequence[Base]) -> Axis:
    keys = keys_of(name)
    for key in keys:
        _check(key, labels[0], bases)
    levels = tuple(Level(label, tuple(f"{key}={label}" for key in keys)) for label in labels)
    bare = Axis(name, levels, of_keys=True)
    if isinstance(bare.values()[0], float):
        levels = tuple(sorted(levels, key=lambda level: float(level.label)))
    defaults = {_default(key, bases) for key in keys}
    units = dict.fromkeys(filter(None, (_unit(key, bases) for key in keys)))
    return Axis(name, levels, defaults.pop() if len(defaults) == 1 else None, ", ".join(units), of_keys=True)


def check_assignments(bases: Sequence[Base], assignments: Iterable[str], option: str = "--set") -> None:
    """Raise `UsageError` for a ``KEY=VALUE`` text whose key none of the experiments has."""
    for text in assignments:
        key = text.partition("=")[0]
        if not any(base.knows(key) for base in bases) or "=" not in text:
            collect([text], {name: value for base in bases for name, value in base.sections.items()}, option=option)


def apart(key: str) -> tuple[str, str]:
    """Split a key into that of the parameter, and the end of it that is meant: ``first``, ``last`` or empty."""
    parameter, _, end = key.rpartition(".")
    return (parameter, end) if end in ENDS and "." in parameter else (key, "")


def _check(key: str, level: str, bases: Sequence[Base]) -> None:
    """Raise `UsageError` for a key that none of the experiments has, and for an end of a single value."""
    name, end = apart(key)
    check_assignments(bases, [f"{name}={level}"], "--over")
    knowing = next(base for base in bases if base.knows(name))
    if end and not isinstance(knowing.present(name), tuple):
        raise UsageError(f"--over {key}={level}: {name} has one value, neither a first nor a last")


def check_levels(axes: Sequence[Axis], bases: Sequence[Base], name: str, columns_there: Collection[str]) -> None:
    """Raise `UsageError` for a setting of a level that is no key of any experiment and model of the study.

    An axis is a column of the table of trials too: its name may be none of ``columns_there``.
    """
    for axis in axes:
        if axis.name in columns_there:
            raise UsageError(f"study {name}: axis {axis.name}: the table of trials has that column; give it another")
        for level in axis.levels:
            pairs = (text.partition("=") for text in level.settings)
            whole = [f"{apart(key)[0]}{equals}{value}" for key, equals, value in pairs]  # ends of several values too
            check_assignments(bases, whole, f"study {name}: axis {axis.name}: {level.label}:")


def expanded(point: Point, axes: Sequence[Axis], base: Base) -> Values:
    """Return what a point sets in one experiment: parameters with their texts, each once.

    Those that the experiment lacks are left out. Of a parameter of which one end moves it has the other end.
    """
    values: dict[str, list[str]] = {}
    for axis, (_, label) in zip(axes, point.values, strict=True):
        for text in axis.level(label).settings:
            key, _, value = text.partition("=")
            parameter, end = apart(key)
            if not base.takes(parameter):
                continue
            if end:
                parts = values.setdefault(parameter, [str(part) for part in base.present(parameter)])
                parts[ENDS[end]] = value
            else:
                values[parameter] = [value]
    return tuple((parameter, ",".join(parts)) for parameter, parts in values.items())


def moves(axis: Axis, base: Base) -> bool:
    """Tell whether an axis moves anything in one experiment before one model."""
    return any(base.takes(apart(text.partition("=")[0])[0]) for level in axis.levels for text in level.settings)


def label(point: Point, axes: Sequence[Axis], base: Base, model: str = "") -> str:
    """Return what a model is called at a point in the trials of one experiment: by the values that move it there.

    ``model`` begins it; without one it goes by the values alone, and by its own name where nothing moves it.
    """
    values = [
        f"{name}={value}" if axis.of_keys else value
        for axis, (name, value) in zip(axes, point.values, strict=True)
        if moves(axis, base)
    ]
    return " ".join(filter(None, (model, *values))) or base.model


def columns(called: Iterable[tuple[str, Point, Base]], axes: Sequence[Axis]) -> Parameters:
    """Return the grid's values as columns of the table of trials: name of an axis -> label of a model -> value.

    ``called`` has each label with its point, and with the experiment before that model.
    """
    table: dict[str, dict[str, Any]] = {axis.name: {} for axis in axes}
    for name, point, base in called:
        for axis, (_, value) in zip(axes, point.values, strict=True):
            table[axis.name][name] = axis.value(value) if moves(axis, base) else None
    return table


def by_rendering(values: Iterable[Values], sections: Collection[str]) -> dict[Values, list[Values]]:
    """Group what points set by their values outside of the models' ``sections``: those that share a rendering."""
    groups: dict[Values, list[Values]] = {}
    for point_values in dict.fromkeys(values):
        outside = tuple((key, value) for key, value in point_values if key.partition(".")[0] not in sections)
        groups.setdefault(outside, []).append(point_values)
    return groups


def check_settled(values: Values, selected: Sequence[SelectedModel]) -> None:
    """Raise `UsageError` for a key of a point that the models have settled themselves, as ``dsnn:n_con=4`` does."""
    for key, value in values:
        section, _, name = key.partition(".")
        if name == PRESET and section in {model.section for model in selected}:
            instead = f"--model {section}:{PRESET}={value} shows it"
            raise UsageError(f"--over {key}={value}: a preset of a model is not varied; {instead}")
        owners = [model for model in selected if key.startswith(f"{model.section}.")]
        if owners and not any(own_values(model, values).get(key) for model in owners):
            raise UsageError(f"--over {key}={value}: --model {owners[0].asked.text} has settled that itself")


def own_values(model: SelectedModel, values: Values) -> dict[str, str]:
    """Return those values of a point that a model takes: of its section, and not settled by ``--model`` itself."""
    fields = {field.name for field in dataclasses.fields(model.chosen.network)} - model.asked.values.keys()
    return {key: value for key, value in values if key in {f"{model.section}.{name}" for name in fields}}


def variant(base: ConfiguredModel, called: str, texts: Mapping[str, str]) -> ConfiguredModel:
    """Return a model under another label, with values typed after ``--over``; `UsageError` if one is not legal."""
    changes = {key.partition(".")[2]: value for key, value in texts.items()}
    typed = {key.partition(".")[2]: f"--over {key}={value}" for key, value in texts.items()}
    network = changed("", base.network, changes, lambda name, _: typed.get(name, name))
    return dataclasses.replace(base, label=called, network=network)


def _default(key: str, bases: Sequence[Base]) -> float | str | None:
    """Find what a key stands for in experiments, as an axis has it; ``None`` where they differ or it has several."""
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
    """Return the unit that a parameter declares; empty where it has none."""
    name, _ = apart(key)
    knowing = next(base for base in bases if base.knows(name))
    section, _, parameter = name.partition(".")
    return unit_of(knowing.sections[section], parameter)
