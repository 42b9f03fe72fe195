"""Sweeps as figures, a curve over one axis or a map over two, and on the terminal."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure

from experiments.bench.grid import values_of
from experiments.bench.report import style, terminal
from experiments.bench.stats.count import count_of
from experiments.bench.study import TOGETHER

SHARES = LinearSegmentedColormap.from_list("held", (style.HUES[1], "#f4f1ea", style.HUES[0]))
"""Share of the replicates in which a claim holds, 0 to 1."""
SCALE = "viridis"
"""Colours of numbers."""
ACROSS = 3
MOST_WRITTEN = 24
"""Cells of a map of numbers up to which these are written."""


def draw(result: Any) -> Figure:
    """Draw a sweep, an `experiments.bench.sweep.Sweep`.

    One parameter has curves with intervals, two have maps, one for each claim and measure of each model. Claims over
    levels with names are one map: points and models down, claims across.
    """
    plan, number = result.plan, result.plan.study.replicates
    named = bool(result.counts.height) and (not plan.axes or bool(plan.study.axes))
    symbols = (
        "Blue: the claim holds, orange: it fails, k/n: in k of n replicates (h: the DSNN's half); hatched: not judged."
    )
    if not named and len(plan.axes) < 2:
        symbols = "Whiskers: 95 % interval, or the range of replicates."
    judged = ", ".join(filter(None, dict.fromkeys(model for _, model in plan.judged)))
    with style.look():
        figure = _table(result) if named else _panels(result)
        style.headline(figure, finding(result))
        what = f"{plan.study.name}{f' of {judged}' if judged else ''}"
        style.caption(figure, f"{symbols} {style.sentence(what)}: n = {number}, from seed {plan.seed}.")
    return figure


def finding(result: Any) -> str:
    """Say at how many points all claims hold, or between which values a measure lies."""
    if not result.counts.height:
        name, quantity = result.numbers["measure"][0], pl.col("measure").str.split(": ").list.first()
        known = result.numbers.filter(quantity == name.partition(": ")[0])["value"].drop_nulls().to_list()
        what = titles(result)[name]
        return f"{style.sentence(what)}: {min(known):.3g} to {max(known):.3g}" if known else f"{name} has no value"
    claims = [claim.id for claim, _ in result.plan.claims]
    whole: dict[tuple[Any, ...], bool] = {}
    for row in result.counts.filter(pl.col("claim").is_in(claims)).iter_rows(named=True):
        point = (*(row[name] for name in result.plan.axes), row["model"])
        whole[point] = whole.get(point, True) and shown(row)[0] == 1.0
    what = f"All {len(claims)} claims hold" if len(claims) > 1 else f"{titles(result)[claims[0]]} ({claims[0]}): holds"
    return f"{what} in every replicate at {sum(whole.values())} of {len(whole)} points"


def titles(result: Any) -> dict[str, str]:
    """Return claims and measures in words."""
    words = {claim.id: claim.title for claim, _ in result.plan.claims} | {TOGETHER: "All claims"}
    return words | {measure.name: f"{measure.says}, {measure.unit}".rstrip(", ") for measure, _ in result.plan.measures}


def shown(row: Mapping[str, Any]) -> tuple[float, str]:
    """Return the share of the replicates in which a claim holds, NaN where none could be judged, and it in words.

    A claim that depends on another model's unknown constants is shown by the DSNN's half.
    """
    counted = count_of(row)
    half = counted.half or counted
    if not half.judged:
        return math.nan, "-"
    return half.holds / counted.replicates, f"{half.holds}/{counted.replicates}{'h' if counted.half else ''}"


def _cells(result: Any) -> pl.DataFrame:
    """Return a row for each point, model, claim and measure: where it is drawn, its value and interval, its text."""
    rows = []
    for row in (*result.counts.to_dicts(), *result.numbers.to_dicts()):
        value, text = shown(row) if "claim" in row else (row["value"], "")
        ends = (
            ("low", "high") if "claim" in row else ("ci_low", "ci_high") if "ci_low" in row else ("lowest", "highest")
        )
        places = [list(values_of(levels).values()).index(row[name]) for name, levels in result.plan.axes.items()]
        rows.append({
            "what": row.get("claim") or row["measure"], "claim": "claim" in row, "model": row["model"], "value": value,
            "text": text or ("" if value is None else f"{value:.3g}"), "low": row[ends[0]], "high": row[ends[1]],
            "x": (*places, 0)[0], "y": (*places, 0, 0)[1],
        })  # fmt: skip
    return pl.DataFrame(rows, infer_schema_length=None)


def _panels(result: Any) -> Figure:
    """Draw a panel for each claim and measure of each model: the first axis across, a second one up."""
    (across_name, levels), *second = result.plan.axes.items()
    up = list(second[0][1]) if second else []
    words, panels = titles(result), _cells(result).partition_by("what", "model", maintain_order=True)
    several = len({table["model"][0] for table in panels}) > 1
    across = min(ACROSS, len(panels))
    down = math.ceil(len(panels) / across)
    height = min(1.3 + 0.24 * len(up) if up else 1.7, (style.PAGE - 0.9) / down)
    figure = Figure((style.WIDTH, 0.9 + down * height), layout="constrained")
    grid = style.grid(figure, len(panels), across, sharex=True, sharey=bool(up))
    inches = style.WIDTH / across - 0.5
    for panel, table in zip(grid, panels, strict=True):
        _heat(panel, table, (len(up), len(levels))) if up else _curve(panel, table)
        name = table["what"][0]
        who = ", ".join([*([name] if name != TOGETHER else []), *[table["model"][0]] * several])
        panel.set_title(style.wrapped(f"{words[name]} ({who})", inches, style.SMALL), fontsize=style.SMALL)
        panel.set_xticks(range(len(levels)), list(levels), rotation=90 if len(levels) > 6 else 0)
        if up:
            panel.set_yticks(range(len(up)), up)
    for panel in grid[-across:]:
        panel.set_xlabel(style.wrapped(across_name, inches))
    for panel in grid[::across] if up else ():
        panel.set_ylabel(style.wrapped(second[0][0], height))
    return figure


def _curve(panel: Axes, cells: pl.DataFrame) -> None:
    """Draw a claim's share of replicates, or a number, along one axis."""
    style.intervals(panel, cells, cells["x"], ("value", "low", "high"), along="y", fmt="o-", ms=3.5, capsize=2,
                    color=style.INK)  # fmt: skip
    if cells["claim"][0]:
        panel.set(ylim=(-0.05, 1.05), ylabel="share of replicates")


def _heat(panel: Axes, table: pl.DataFrame, size: tuple[int, int]) -> None:
    """Draw cells at their ``x`` and ``y``, of (rows, columns), and the texts of claims or of few numbers."""
    cells, claim = np.full(size, np.nan), table["claim"][0]
    cells[table["y"].to_numpy(), table["x"].to_numpy()] = table["value"].cast(float).to_numpy()
    panel.patch.set(facecolor="white", edgecolor="#b0b0b0", hatch="////", lw=0.0)
    looks: Any = {"cmap": SHARES, "vmin": 0.0, "vmax": 1.0} if claim else {"cmap": SCALE}
    image = panel.imshow(cells, origin="lower", aspect="auto", **looks)
    for row in table.to_dicts() if claim or cells.size <= MOST_WRITTEN else ():
        panel.annotate(row["text"], (row["x"], row["y"]), ha="center", va="center", fontsize=style.SMALL - 1,
                       path_effects=style.HALO, annotation_clip=True)  # fmt: skip
    if not claim:
        panel.figure.colorbar(image, ax=panel, shrink=0.8, pad=0.02)


def _table(result: Any) -> Figure:
    """Draw points and models down, claims across."""
    counts, names = result.counts, list(result.plan.axes)
    columns = [*names, *(["model"] if counts["model"].n_unique() > 1 or not names else [])]
    points = counts.select(columns).rows()
    rows, claims = list(dict.fromkeys(points)), list(dict.fromkeys(counts["claim"]))
    places = {"x": list(map(claims.index, counts["claim"])), "y": list(map(rows.index, points))}
    cells = _cells(result).filter("claim").with_columns(pl.Series(name, at) for name, at in places.items())
    figure = Figure((style.WIDTH, min(style.PAGE, 1.2 + 0.2 * len(rows))), layout="constrained")
    panel = figure.subplots()
    _heat(panel, cells, (len(rows), len(claims)))
    panel.invert_yaxis()
    panel.set_xticks(range(len(claims)), claims)
    panel.set_yticks(range(len(rows)), [", ".join(map(str, row)) for row in rows])
    panel.set_ylabel(", ".join(columns))
    return figure


def show(result: Any, folder: Path) -> None:
    """Print a sweep: a row for each point and model, at how many points each claim holds, and where its files are."""
    plan = result.plan
    names = [*plan.axes, "model"]
    rows: dict[tuple[Any, ...], dict[str, Any]] = {}
    for row in (*result.counts.to_dicts(), *result.numbers.to_dicts()):
        cells = rows.setdefault(tuple(row[name] for name in names), {name: row[name] for name in names})
        cells[row.get("claim") or row["measure"]] = shown(row)[1] if "claim" in row else row["value"]
    judged = f"Claims: in how many of {plan.study.replicates} replicates they hold" if result.counts.height else ""
    terminal.show(pl.DataFrame(list(rows.values()), infer_schema_length=None), judged)
    terminal.out_console.print(finding(result))
    for title, further in result.tables.items():
        terminal.show(pl.DataFrame(further, infer_schema_length=None), title)
    terminal.show_places({"figure": folder / f"{plan.study.name}.png", "table": folder / "counts.csv"})
