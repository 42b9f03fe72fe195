"""Sweeps as figures, curves or heat maps over parameters or a table of named levels, and on the terminal."""

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

from experiments.bench.report import style, terminal
from experiments.bench.stats.count import count_of
from experiments.bench.study import TOGETHER, Axis

SHARES = LinearSegmentedColormap.from_list("held", (style.HUES[1], "#f4f1ea", style.HUES[0]))
"""Share of the replicates in which a claim holds, 0 to 1."""
SCALE, DEFAULT = "viridis", "#c0392b"
"""Colours of numbers, and of the marks of defaults, winners and thresholds."""
ACROSS = 3
MOST_WRITTEN = 24
"""Cells of a heat map up to which their numbers are written."""


def draw(result: Any) -> Figure:
    """Draw a sweep, an `experiments.bench.sweep.Sweep`.

    One parameter has curves with intervals, two have heat maps with a contour where a potential is at the model's
    threshold, one for each claim and measure; triangles mark the defaults. Levels with names are the rows of one table,
    claims its columns.
    """
    plan, number = result.plan, result.plan.study.replicates
    named = result.counts.height and not (plan.axes and all(axis.title for axis in plan.axes))
    cell = f"Blue: the claim holds, orange: it fails, k/n: in k of n = {number} replicates; hatched: not judged."
    symbols = [cell if named or (len(plan.axes) > 1 and result.counts.height) else ""]
    if not named and len(plan.axes) < 2:
        symbols.append(
            f"Whiskers: 95 % interval, or the range of n = {number} replicates." if number > 1 else "n = 1 replicate."
        )
    if not named and any(place(axis) is not None for axis in plan.axes):
        symbols.append("Triangles: defaults.")
    if "unknown constants" in result.counts.columns and result.counts["unknown constants"].sum():
        symbols.append("Of a claim that hangs on another model's unknown constants the DSNN's half is shown (h).")
    if any(measure.has_threshold for measure, _ in plan.measures):
        symbols.append("Red: the spiking threshold T.")
    with style.look():
        figure = _table(result) if named else _panels(result)
        style.headline(figure, finding(result))
        repeats = f", repeats of each condition: {max(plan.repeats)}" if plan.things == "trials" else ""
        judged = ", ".join(filter(None, dict.fromkeys(model for _, model in plan.judged)))
        what = f"{style.sentence(plan.study.name)}{f' of {judged}' if judged else ''}: from seed {plan.seed}{repeats}."
        style.caption(figure, " ".join(filter(None, (*symbols, what))))
    return figure


def finding(result: Any) -> str:
    """Say at how many points all claims hold, or between which values a measure lies."""
    if not result.counts.height:
        name, quantity = result.numbers["measure"][0], pl.col("measure").str.split(": ").list.first()
        known = result.numbers.filter(quantity == name.partition(": ")[0])["value"].drop_nulls().to_list()
        what = titles(result)[name]
        return f"{style.sentence(what)}: {min(known):.3g} to {max(known):.3g}" if known else f"{name} has no value"
    claims = [claim.id for claim, _ in result.plan.claims]
    axes = [axis.name for axis in result.plan.axes]
    whole: dict[tuple[Any, ...], bool] = {}
    for row in result.counts.filter(pl.col("claim").is_in(claims)).iter_rows(named=True):
        point = (*(row[name] for name in axes), row["model"])
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


def place(axis: Axis) -> float | None:
    """Find where the default lies among an axis's levels: 0 at the first, between two levels a fraction.

    ``None`` where there is no default, or it is outside of the levels, or they are texts and it is none of them.
    """
    values = list(axis.values.values())
    if axis.default in values:
        return float(values.index(axis.default))
    numbers = [value for value in values if isinstance(value, float)]
    if not isinstance(axis.default, float) or not numbers or not numbers[0] <= axis.default <= numbers[-1]:
        return None
    return float(np.interp(axis.default, numbers, range(len(numbers))))


def _cells(result: Any) -> pl.DataFrame:
    """Return a row for each point, model, claim and measure: what is drawn, its interval, the ends of its scales."""
    rows = []
    for row in (*result.counts.to_dicts(), *result.numbers.to_dicts()):
        if "claim" in row:
            value, text = shown(row)
            cell = {"what": row["claim"], "value": value, "text": text, "low": row["low"], "high": row["high"]}
        else:
            ends = (row.get("ci_low", row["lowest"]), row.get("ci_high", row["highest"]))
            text = "" if row["value"] is None else f"{row['value']:.3g}"
            cell = {"what": row["measure"], "value": row["value"], "text": text, "low": ends[0], "high": ends[1],
                    "threshold": row["threshold"]}  # fmt: skip
        places = [list(axis.values.values()).index(row[axis.name]) for axis in result.plan.axes]
        rows.append({**cell, "claim": "claim" in row, "model": row["model"], "x": places[0] if places else 0,
                     "y": places[1] if len(places) > 1 else 0})  # fmt: skip
    table, measure = pl.DataFrame(rows, infer_schema_length=None), pl.col("what").str.split(": ").list.first()
    least, most = (pl.when("claim").then(end).otherwise(pl.col("value")) for end in (0.0, 1.0))
    return table.with_columns(
        least=least.min().over(measure), most=most.max().over(measure),
        lowest=pl.min_horizontal("value", "low").min().over(measure),
        highest=pl.max_horizontal("value", "high").max().over(measure),
    )  # fmt: skip


def _panels(result: Any) -> Figure:
    """Draw a panel for each claim and measure of each model: the first axis across, a second one up."""
    axes, words = result.plan.axes, titles(result)
    tables = _cells(result).partition_by("what", "model", maintain_order=True)
    panels = [table for table in tables if table["claim"][0] or table["value"].count()] or tables[:1]
    several = len({table["model"][0] for table in panels}) > 1
    across = min(ACROSS, len(panels))
    down = math.ceil(len(panels) / across)
    up = list(axes[1].levels) if len(axes) > 1 else []
    height = min(1.3 + 0.24 * len(up) if up else 1.7, (style.PAGE - 0.9) / down)
    figure = Figure((style.WIDTH, 0.9 + down * height), layout="constrained")
    grid = style.grid(figure, len(panels), across, sharex=True, sharey=bool(up))
    inches = style.WIDTH / across - 0.5
    for panel, table in zip(grid, panels, strict=True):
        _heat(panel, table, (len(up), len(axes[0].levels))) if up else _curve(panel, table)
        name = table["what"][0]
        head, _, condition = name.partition(": ")  # spikes have one, of which some columns say nothing
        parts = [part for part in condition.split(", ") if not part.endswith("=None")] if condition else [head]
        who = ", ".join([*(parts if name != TOGETHER else ()), *[table["model"][0]] * several])
        title = style.wrapped(f"{words[name]}{f' ({who})' if who else ''}", inches, style.SMALL)
        panel.set_title(title, fontsize=style.SMALL)
        for axis, ticks, mark in zip(axes, (panel.set_xticks, panel.set_yticks), ("v", "<"), strict=False):
            steep: dict[str, Any] = {"rotation": 90} if mark == "v" and len(axis.levels) > 6 else {}
            ticks(range(len(axis.levels)), list(axis.levels), **steep)
            if (at := place(axis)) is not None:
                where, of = ((at, 1.0), "x") if mark == "v" else ((1.0, at), "y")
                transform = getattr(panel, f"get_{of}axis_transform")()
                panel.plot(*where, mark, ms=4, color=DEFAULT, transform=transform, clip_on=False)
    for panel in grid[-across:]:
        panel.set_xlabel(style.wrapped(axes[0].title or axes[0].name, inches))
    for panel in grid[::across]:
        panel.set_ylabel(style.wrapped(axes[1].title or axes[1].name, height) if up else panel.get_ylabel())
    return figure


def _curve(panel: Axes, cells: pl.DataFrame) -> None:
    """Draw a claim's share of replicates, or a number, along one axis."""
    style.intervals(panel, cells, cells["x"], ("value", "low", "high"), along="y", fmt="o-", ms=3.5, capsize=2,
                    color=style.INK)  # fmt: skip
    if cells["claim"][0]:
        panel.set(ylim=(-0.05, 1.05), ylabel="share of replicates")
    else:  # panels of one quantity have one scale
        low, high, level = cells.select("lowest", "highest", "threshold").row(0)
        if level is not None:
            panel.axhline(level, color=DEFAULT, lw=1.0)
            low, high = min(low, level), max(high, level)
        margin = 0.06 * (high - low) or 0.5
        panel.set_ylim(low - margin, high + margin)


def _heat(panel: Axes, table: pl.DataFrame, size: tuple[int, int]) -> None:
    """Draw cells at their ``x`` and ``y``, of (rows, columns); write the texts of few, and draw the threshold."""
    cells = np.full(size, np.nan)
    cells[table["y"].to_numpy(), table["x"].to_numpy()] = table["value"].cast(float).to_numpy()
    panel.patch.set(facecolor="white", edgecolor="#b0b0b0", hatch="////", lw=0.0)
    looks: Any = {"cmap": SHARES if table["claim"][0] else SCALE, "vmin": table["least"][0], "vmax": table["most"][0]}
    image = panel.imshow(cells, origin="lower", aspect="auto", **looks)
    panel.set_xticks(np.arange(1, size[1]) - 0.5, minor=True)
    panel.set_yticks(np.arange(1, size[0]) - 0.5, minor=True)
    panel.grid(which="minor", color="white", lw=1.0)
    panel.tick_params(which="minor", length=0)
    several = table["claim"][0] and bool(((cells > 0.0) & (cells < 1.0)).any())  # otherwise the colours say it
    for row in table.to_dicts() if cells.size <= MOST_WRITTEN or several else ():
        panel.annotate(row["text"], (row["x"], row["y"]), ha="center", va="center", fontsize=style.SMALL - 1,
                       path_effects=style.HALO, annotation_clip=True)  # fmt: skip
    if not table["claim"][0]:
        panel.figure.colorbar(image, ax=panel, shrink=0.8, pad=0.02)
        level = table["threshold"][0]
        if level is not None and np.nanmin(cells) < level < np.nanmax(cells):
            panel.contour(cells, [level], colors=DEFAULT, linewidths=1.5)


def _table(result: Any) -> Figure:
    """Draw points and models down, claims across."""
    counts = result.counts
    names = [axis.name for axis in result.plan.axes]
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
    names = [axis.name for axis in plan.axes] + (["model"] if len({model for _, model in plan.judged}) > 1 else [])
    rows: dict[tuple[Any, ...], dict[str, Any]] = {}
    for row in (*result.counts.to_dicts(), *result.numbers.to_dicts()):
        cells = rows.setdefault(tuple(row[name] for name in names), {name: row[name] for name in names})
        cells[row.get("claim") or row["measure"]] = shown(row)[1] if "claim" in row else row["value"]
    judged = f"Claims: in how many of {plan.study.replicates} replicates they hold" if result.counts.height else ""
    terminal.show(pl.DataFrame(list(rows.values()), infer_schema_length=None), judged)
    terminal.show_line(finding(result))
    for title, further in result.tables.items():
        terminal.show(pl.DataFrame(further, infer_schema_length=None), title)
    terminal.show_places({"figure": folder / f"{plan.study.name}.png", "table": folder / "counts.csv"})
