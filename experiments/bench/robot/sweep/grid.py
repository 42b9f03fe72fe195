"""Grids of parameters: ``--over KEY=V1,V2`` each, every combination one point, all on the same stimuli.

Points that differ in a model's parameters alone ride on one rendering: the models of one trial.
"""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from experiments.bench.engine.errors import UsageError
from experiments.bench.engine.models import PRESET, ConfiguredModel, Shown, look_up
from experiments.bench.engine.settings import changed, collect
from experiments.bench.robot.experiment import Experiment
from experiments.bench.robot.plan import Plan, plan, sections
from experiments.bench.robot.sweep.figure import Row

Values = tuple[tuple[str, str], ...]
"""Keys with their values."""

MOST_POINTS = 1000


@dataclass(frozen=True, slots=True)
class Point:
    """One combination of the grid's values."""

    values: Values


@dataclass(frozen=True, slots=True)
class Line:
    """A model at one point of the grid: ``values`` are those of all keys, None where a key is not of this model."""

    model: str
    values: Mapping[str, str | None]


@dataclass(frozen=True, slots=True)
class Part:
    """Points that share a rendering: one run. ``lines`` says which model, at which point, each of its labels is."""

    folder: str
    plan: Plan
    lines: Mapping[str, Line]

    def tagged(self, rows: Iterable[Row]) -> list[dict[str, Any]]:
        """The rows of its trials with the grid's values, and the model's own name as ``model``."""
        lines = ((row, self.lines[row["model"]]) for row in rows)
        return [{**row, **line.values, "model": line.model} for row, line in lines]


def grid(over: Sequence[str], assignments: Iterable[str]) -> list[Point]:
    """Every combination of ``KEY=V1,V2,...`` texts; `UsageError` for one that is not of that form.

    ``assignments`` are the ``KEY=VALUE`` texts of ``--set`` that hold at every point: `UsageError` for one whose key
    the grid varies, as it would hold at none.
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
        clash = next((settled[name] for name in key.split("+") if name in settled), None)
        if clash is not None:
            raise UsageError(f"--set {clash}: --over {text} sets that at every point; give one of them")
        axes.append((key, levels))
    points = [
        Point(tuple(zip([k for k, _ in axes], levels, strict=True)))
        for levels in itertools.product(*(levels for _, levels in axes))
    ]
    if not axes or len(points) > MOST_POINTS:
        raise UsageError(f"--over: {len(points)} points; legal is one --over or more, up to {MOST_POINTS} points")
    return points


def parts(
    experiment: Experiment, models: Sequence[str], points: Sequence[Point], assignments: Sequence[str],
    repeats: int | None, seed: int,
) -> list[Part]:  # fmt: skip
    """The runs of a grid, checked; `UsageError` for an illegal value, before anything runs.

    A key may belong to any of the ``models``, or to robot, camera, scene or experiment. A model that a point does not
    vary is shown once in each rendering, under its own name.
    """
    shown = look_up(models)
    _check_keys(experiment, models, points[0], shown)
    made = []
    for outside, members in by_rendering(points, {model.section for model in shown}).items():
        common = _planned(experiment, models, assignments, outside, repeats, seed)
        variants, lines = {}, {}
        for model, chosen in zip(shown, common.settings.models, strict=True):
            for point in members:
                own = own_values(model, point)
                label = _label(chosen.label, {**dict(outside), **own}, point, len(shown) > 1) if own else chosen.label
                if label not in variants:
                    variants[label] = variant(chosen, label, own)
                    lines[label] = Line(chosen.label, {k: v if (k, v) in outside or k in own else None
                                                       for k, v in point.values})  # fmt: skip
        settings = dataclasses.replace(common.settings, models=tuple(variants.values()))
        folder = "_".join(f"{key}={value}" for key, value in outside) or "points"
        made.append(Part(folder.replace("/", "-"), dataclasses.replace(common, settings=settings), lines))
    return made


def _check_keys(experiment: Experiment, models: Sequence[str], point: Point, shown: Sequence[Shown]) -> None:
    """Raise `UsageError` for a key that nothing shown has, and for one that its models have settled themselves."""
    collect([f"{key}={value}" for key, value in point.values], sections(experiment, models), option="--over")
    check_settled(point, shown)


def check_settled(point: Point, shown: Sequence[Shown]) -> None:
    """Raise `UsageError` for a key of a point that the models have settled themselves, as ``dsnn:n_con=4`` does."""
    for key, value in point.values:
        section, _, name = key.partition(".")
        if name == PRESET and section in {model.section for model in shown}:
            instead = f"--model {section}:{PRESET}={value} shows it"
            raise UsageError(f"--over {key}={value}: a preset of a model is not varied; {instead}")
        owners = [model for model in shown if key.startswith(f"{model.section}.")]
        if owners and not any(own_values(model, point).get(key) for model in owners):
            raise UsageError(f"--over {key}={value}: --model {owners[0].asked.text} has settled that itself")


def _planned(
    experiment: Experiment, models: Sequence[str], assignments: Sequence[str], outside: Values, repeats: int | None,
    seed: int,
) -> Plan:  # fmt: skip
    """The plan of one rendering; a refusal names the option that its value came by."""
    over = [f"{key}={value}" for key, value in outside]
    try:
        return plan(experiment, models, [*assignments, *over], repeats, seed)
    except UsageError as error:
        said = str(error)
        if any(said.startswith(f"--set {text}:") for text in over):
            said = said.replace("--set", "--over", 1)
        raise UsageError(said) from None


def by_rendering(points: Sequence[Point], sections: Collection[str]) -> dict[Values, list[Point]]:
    """Points by their values outside of the models' ``sections``: those that share a rendering."""
    groups: dict[Values, list[Point]] = {}
    for point in points:
        outside = tuple((key, value) for key, value in point.values if key.partition(".")[0] not in sections)
        groups.setdefault(outside, []).append(point)
    return groups


def own_values(model: Shown, point: Point) -> dict[str, str]:
    """The point's values that this model takes: of its section, and not settled by ``--model`` itself."""
    names = {field.name for field in dataclasses.fields(model.chosen.network)} - model.asked.own.keys()
    return {key: value for key, value in point.values if key in {f"{model.section}.{name}" for name in names}}


def _label(model: str, values: Mapping[str, str], point: Point, several: bool) -> str:
    """What a varied model is called in its run's tables: by its values, and by name where others are shown too."""
    said = " ".join(f"{key}={value}" for key, value in point.values if key in values)
    return f"{model} {said}" if several else said


def variant(base: ConfiguredModel, label: str, own: Mapping[str, str]) -> ConfiguredModel:
    """A model under another label, with values typed after ``--over``; `UsageError` if one is not legal."""
    changes = {key.partition(".")[2]: value for key, value in own.items()}
    typed = {key.partition(".")[2]: f"--over {key}={value}" for key, value in own.items()}
    network = changed("", base.network, changes, lambda name, _: typed.get(name, name))
    return dataclasses.replace(base, label=label, network=network)
