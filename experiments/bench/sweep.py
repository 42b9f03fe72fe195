"""Grids of parameters: ``--over KEY=V1,V2`` each, every combination one point, all on the same stimuli.

Points that differ in a model's parameters alone ride on one rendering: the models of one trial.
"""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from experiments.bench.declaration import CONDITION_COLUMNS, Experiment
from experiments.bench.figures import AXIS_LABELS, LINES, STYLE, UNITS, plain, save
from experiments.bench.files import UsageError
from experiments.bench.model_option import Shown, look_up
from experiments.bench.models import Chosen
from experiments.bench.plan import Plan
from experiments.bench.results import group, known, varying
from experiments.bench.settings import changed, collect, plan, sections
from experiments.bench.statistics import summarise

Row = Mapping[str, Any]
Values = tuple[tuple[str, str], ...]
"""Keys with their values."""

MOST_POINTS = 1000
MARKERS = ("o", "s", "^", "D", "v", "P", "X", "*")


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


def grid(over: Sequence[str]) -> list[Point]:
    """Every combination of ``KEY=V1,V2,...`` texts; `UsageError` for one that is not of that form."""
    axes: list[tuple[str, list[str]]] = []
    for text in over:
        key, equals, values = text.partition("=")
        levels = [value for value in values.split(",") if value]
        if not equals or not levels:
            raise UsageError(f"--over {text}: expected SECTION.NAME=VALUE,VALUE,... for example dsnn.n_con=4,6,8")
        if len(set(levels)) < len(levels) or key in [k for k, _ in axes]:
            raise UsageError(f"--over {text}: a value or a key is there twice")
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
    for outside, members in _by_rendering(points, {model.section for model in shown}).items():
        common = _planned(experiment, models, assignments, outside, repeats, seed)
        variants, lines = {}, {}
        for model, chosen in zip(shown, common.settings.models, strict=True):
            for point in members:
                own = _own(model, point)
                label = _label(chosen.label, {**dict(outside), **own}, point, len(shown) > 1) if own else chosen.label
                if label not in variants:
                    variants[label] = _variant(chosen, label, own)
                    lines[label] = Line(chosen.label, {k: v if (k, v) in outside or k in own else None
                                                       for k, v in point.values})  # fmt: skip
        settings = dataclasses.replace(common.settings, models=tuple(variants.values()))
        folder = "_".join(f"{key}={value}" for key, value in outside) or "points"
        made.append(Part(folder.replace("/", "-"), dataclasses.replace(common, settings=settings), lines))
    return made


def _check_keys(experiment: Experiment, models: Sequence[str], point: Point, shown: Sequence[Shown]) -> None:
    """Raise `UsageError` for a key that nothing shown has, and for one that its models have settled themselves."""
    collect([f"{key}={value}" for key, value in point.values], sections(experiment, models), option="--over")
    for key, value in point.values:
        owners = [model for model in shown if key.startswith(f"{model.section}.")]
        if owners and not any(_own(model, point).get(key) for model in owners):
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


def _by_rendering(points: Sequence[Point], sections: Collection[str]) -> dict[Values, list[Point]]:
    """Points by their values outside of the models' ``sections``: those that share a rendering."""
    groups: dict[Values, list[Point]] = {}
    for point in points:
        outside = tuple((key, value) for key, value in point.values if key.partition(".")[0] not in sections)
        groups.setdefault(outside, []).append(point)
    return groups


def _own(model: Shown, point: Point) -> dict[str, str]:
    """The point's values that this model takes: of its section, and not settled by ``--model`` itself."""
    names = {field.name for field in dataclasses.fields(model.chosen.network)} - model.asked.own.keys()
    return {key: value for key, value in point.values if key in {f"{model.section}.{name}" for name in names}}


def _label(model: str, values: Mapping[str, str], point: Point, several: bool) -> str:
    """What a varied model is called in its run's tables: by its values, and by name where others are shown too."""
    said = " ".join(f"{key}={value}" for key, value in point.values if key in values)
    return f"{model} {said}" if several else said


def _variant(base: Chosen, label: str, own: Mapping[str, str]) -> Chosen:
    changes = {key.partition(".")[2]: value for key, value in own.items()}
    typed = {key.partition(".")[2]: f"--over {key}={value}" for key, value in own.items()}
    network = changed("", base.network, changes, lambda name, _: typed.get(name, name))
    return dataclasses.replace(base, label=label, network=network)


def table(rows: Sequence[Row], keys: Sequence[str]) -> list[dict[str, Any]]:
    """A row per model, point and condition of `Part.tagged` rows: n, mean, and its 95 % interval.

    ``keys`` are those of the grid; a key that is not of the model is empty.
    """
    columns = ("model", *keys, *CONDITION_COLUMNS)
    made = []
    for values, chosen in group(rows, *columns).items():
        summary = summarise([row["spikes"] for row in chosen])
        made.append(
            {
                **dict(zip(columns, values, strict=True)), "n": summary.n,
                "spikes_mean": summary.mean, "ci_low": known(summary.ci_low), "ci_high": known(summary.ci_high),
            }
        )  # fmt: skip
    return made


def telling(rows: Sequence[Row], keys: Sequence[str], varies: str) -> list[str]:
    """The columns that tell lines apart: the model if there are several, the grid's keys, other conditions."""
    by_point = group(rows, "model", *keys).values()
    others = [
        name
        for name in varying(rows, varies)
        if name not in ("model", varies) and any(len({row[name] for row in own}) > 1 for own in by_point)
    ]
    several = len({row["model"] for row in rows}) > 1
    return [*(["model"] if several else []), *keys, *others]


def draw(rows: Sequence[Row], keys: Sequence[str], varies: str, title: str) -> Figure:
    """Mean spikes against the condition, with 95 % intervals: a line per model, point and other condition that differs.

    A colour for each model at each point, a marker for each model, a style for each of the other conditions.
    """
    apart = telling(rows, keys, varies)
    others = [name for name in apart if name not in ("model", *keys)]
    levels = sorted({row[varies] for row in rows})
    points = list(group(rows, "model", *keys))
    shades = dict(zip(points, mpl.colormaps["viridis"](np.linspace(0, 0.92, max(len(points), 2))), strict=False))
    markers = {m: MARKERS[i % len(MARKERS)] for i, m in enumerate(dict.fromkeys(row["model"] for row in rows))}
    styles = {key: LINES[i % len(LINES)] for i, key in enumerate(group(rows, *others))}
    lines = group(rows, "model", *keys, *others)
    with mpl.rc_context(STYLE):
        drawn = Figure(figsize=(8.4, 4.2), layout="constrained")
        axes = drawn.subplots()
        for place, (line, chosen) in enumerate(lines.items()):
            shift = 0.3 * (place / max(len(lines) - 1, 1) - 0.5)
            _line(axes, chosen, varies, levels, shift, color=shades[line[: 1 + len(keys)]],
                  ls=styles[line[1 + len(keys) :]], fmt=markers[line[0]],
                  label=_said(chosen[0], apart, keys))  # fmt: skip
        axes.set_xticks(range(len(levels)), [v if isinstance(v, str) else f"{v:g}" for v in levels])
        axes.set(xlabel=AXIS_LABELS[varies], ylabel="spikes per trial", title=plain(title))
        if len(lines) <= 24:
            drawn.legend(loc="outside right upper", frameon=False, fontsize=7)
    return drawn


def _said(row: Row, apart: Sequence[str], keys: Sequence[str]) -> str:
    """A line in words: its model, the grid's values it has, its other conditions."""
    model = [row["model"]] if "model" in apart else []
    grid = " ".join(f"{key}={row[key]}" for key in keys if row[key] is not None)
    others = [
        f"{row[c]:g} {UNITS[c]}" if c in UNITS and row[c] is not None else str(row[c])
        for c in apart
        if c not in ("model", *keys)
    ]
    return plain(", ".join([*model, *([grid] if grid else []), *others]) or row["model"])


def _line(axes: Axes, rows: Sequence[Row], varies: str, levels: Sequence[Any], shift: float, **style: Any) -> None:
    """Means with intervals at the levels that these rows have."""
    spikes = {tick: [row["spikes"] for row in rows if row[varies] == level] for tick, level in enumerate(levels)}
    summaries = {tick + shift: summarise(values) for tick, values in spikes.items() if values}
    # NaN of a single trial: then no bar is drawn.
    spread = np.array([[s.mean - s.ci_low, s.ci_high - s.mean] for s in summaries.values()]).T
    means = [summary.mean for summary in summaries.values()]
    axes.errorbar(list(summaries), means, yerr=spread, ms=3, lw=1, capsize=2, **style)


def write_figure(drawn: Figure, folder: Path) -> Path:
    """Write the figure into the sweep's folder."""
    return save(drawn, folder)
