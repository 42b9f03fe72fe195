"""Grids of parameters: ``--over KEY=V1,V2`` each, every combination one point, all on the same stimuli.

Points that differ in a model's parameters alone ride on one rendering: the models of one trial.
"""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from experiments.bench.declaration import CONDITION_COLUMNS, Experiment
from experiments.bench.figures import AXIS_LABELS, LINES, STYLE, UNITS, save
from experiments.bench.files import UsageError
from experiments.bench.models import Chosen, choose, family
from experiments.bench.plan import Plan
from experiments.bench.results import group, varying
from experiments.bench.settings import changed, plan
from experiments.bench.statistics import summarise

MOST_POINTS = 1000


@dataclass(frozen=True, slots=True)
class Point:
    """One combination of the grid's values."""

    values: tuple[tuple[str, str], ...]

    @property
    def label(self) -> str:
        """``dsnn.n_con=4 dsnn.d=1``."""
        return " ".join(f"{key}={value}" for key, value in self.values)


@dataclass(frozen=True, slots=True)
class Part:
    """Points that share a rendering: one run, whose models are named by their points."""

    folder: str
    plan: Plan


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
    experiment: Experiment, model: str, points: Sequence[Point], assignments: Sequence[str], repeats: int | None,
    seed: int,
) -> list[Part]:  # fmt: skip
    """The runs of a grid, checked; `UsageError` for an illegal value, before anything runs."""
    base = choose(model)
    section = family(base.label)
    made = []
    for outside, members in _by_rendering(points, section).items():
        common = plan(experiment, [model], [*assignments, *outside], repeats, seed)
        (network,) = common.settings.models
        models = tuple(_variant(network, section, point) for point in members)
        settings = dataclasses.replace(common.settings, models=models)
        folder = "_".join(outside) or "points"
        made.append(Part(folder.replace("/", "-"), dataclasses.replace(common, settings=settings)))
    return made


def _by_rendering(points: Sequence[Point], section: str) -> dict[tuple[str, ...], list[Point]]:
    groups: dict[tuple[str, ...], list[Point]] = {}
    for point in points:
        outside = tuple(f"{k}={v}" for k, v in point.values if not k.startswith(f"{section}."))
        groups.setdefault(outside, []).append(point)
    return groups


def _variant(base: Chosen, section: str, point: Point) -> Chosen:
    known = [field.name for field in dataclasses.fields(base.network)]
    changes = {}
    for key, value in point.values:
        owner, _, name = key.partition(".")
        if owner == section:
            if name not in known:
                raise UsageError(f"--over {key}={value}: no parameter '{key}' (all: colias parameters)")
            changes[name] = value
    return dataclasses.replace(base, label=point.label, network=changed(section, base.network, changes))


def table(rows: Sequence[Mapping[str, Any]], points: Sequence[Point]) -> list[dict[str, Any]]:
    """A row per point and condition: the point's values, the condition, n, mean, and its 95 % interval."""
    values = {point.label: dict(point.values) for point in points}
    made = []
    for (label, *condition), chosen in group(rows, "model", *CONDITION_COLUMNS).items():
        summary = summarise([row["spikes"] for row in chosen])
        made.append(
            {
                **values[label], **dict(zip(CONDITION_COLUMNS, condition, strict=True)), "n": summary.n,
                "spikes_mean": summary.mean, "ci_low": summary.ci_low, "ci_high": summary.ci_high,
            }
        )  # fmt: skip
    return made


def other_conditions(rows: Sequence[Mapping[str, Any]], varies: str) -> list[str]:
    """The columns, beside ``varies``, that tell trials of one point apart."""
    by_point = group(rows, "model").values()
    return [
        name
        for name in varying(rows, varies)
        if name not in ("model", varies) and any(len({row[name] for row in own}) > 1 for own in by_point)
    ]


def draw(rows: Sequence[Mapping[str, Any]], points: Sequence[Point], varies: str, title: str) -> Figure:
    """Mean spikes against the condition, with 95 % intervals: a line per point and other condition that differs."""
    others = other_conditions(rows, varies)
    lines = group(rows, "model", *others)
    levels = sorted({row[varies] for row in rows})
    shades = mpl.colormaps["viridis"](np.linspace(0, 0.92, max(len(points), 2)))
    colours = {point.label: shade for point, shade in zip(points, shades, strict=False)}
    styles = {key: LINES[i % len(LINES)] for i, key in enumerate(dict.fromkeys(key[1:] for key in lines))}
    with mpl.rc_context(STYLE):
        drawn = Figure(figsize=(8.4, 4.2), layout="constrained")
        axes = drawn.subplots()
        for place, ((point, *rest), chosen) in enumerate(lines.items()):
            shift = 0.3 * (place / max(len(lines) - 1, 1) - 0.5)
            said = [f"{v:g} {UNITS[c]}" if c in UNITS and v is not None else str(v)
                    for c, v in zip(others, rest, strict=True)]  # fmt: skip
            _line(axes, chosen, varies, levels, shift, color=colours[point], ls=styles[tuple(rest)],
                  label=", ".join([point, *said]))  # fmt: skip
        axes.set_xticks(range(len(levels)), [v if isinstance(v, str) else f"{v:g}" for v in levels])
        axes.set(xlabel=AXIS_LABELS[varies], ylabel="HS spikes per trial", title=title)
        if len(lines) <= 24:
            drawn.legend(loc="outside right upper", frameon=False, fontsize=7)
    return drawn


def _line(
    axes: Axes, rows: Sequence[Mapping[str, Any]], varies: str, levels: Sequence[Any], shift: float, **style: Any
) -> None:
    """Means with intervals at the levels that these rows have."""
    spikes = {tick: [row["spikes"] for row in rows if row[varies] == level] for tick, level in enumerate(levels)}
    summaries = {tick + shift: summarise(values) for tick, values in spikes.items() if values}
    # NaN of a single trial: then no bar is drawn.
    spread = np.array([[s.mean - s.ci_low, s.ci_high - s.mean] for s in summaries.values()]).T
    means = [summary.mean for summary in summaries.values()]
    axes.errorbar(list(summaries), means, yerr=spread, fmt="o", ms=3, lw=1, capsize=2, **style)


def write_figure(drawn: Figure, folder: Path) -> Path:
    """Write the figure into the sweep's folder."""
    return save(drawn, folder)
