"""Sweeps as figures: heat maps of claims and measures over a grid, or one table of coloured cells."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
import polars as pl
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from rich.table import Table

from experiments.bench.engine.terminal import out_console, show_line, show_places, show_table
from experiments.bench.report import style
from experiments.bench.stats.count import count_of
from experiments.bench.study import Axis

HELD, BROKEN, UNJUDGED = style.HUES[0], style.HUES[1], "#d0d0d0"
SHARES = LinearSegmentedColormap.from_list("held", (BROKEN, "#f4f1ea", HELD))
"""Share of the replicates judged in which a claim holds, 0 to 1."""
SCALE, SHADES, DEFAULT = "viridis", "Blues", "#c0392b"
"""Colours of numbers and of counts, and of the marks of defaults and winners."""
ACROSS = 3
MOST_WRITTEN = 60
"""Cells of a panel up to which their numbers are written."""


def draw(
    counts: pl.DataFrame, numbers: pl.DataFrame, axes: Sequence[Axis], titles: Mapping[str, str], about: str
) -> Figure:
    """Draw a sweep.

    Parameters
    ----------
    counts, numbers
        As of `experiments.bench.sweep.Sweep`.
    axes
        The axes of the grid.
    titles
        Claims and measures by name -> their words.
    about
        What was run, for the caption.

    Returns
    -------
    matplotlib.figure.Figure
        A grid of parameters has a heat map for each claim and measure, with a contour where a potential is at the
        model's threshold; triangles mark the defaults. Levels with names are the rows of one table, claims its columns.
    """
    with style.look():
        if axes and all(axis.of_keys for axis in axes):
            figure = _maps(counts, numbers, axes, titles)
        else:
            figure = _table(counts, [axis.name for axis in axes], titles)
        key = [Patch(color=HELD, label="the claim holds"), Patch(color=BROKEN, label="it fails"),
               Patch(color=UNJUDGED, label="not judged")]  # fmt: skip
        if counts.height:
            figure.legend(handles=key, loc="outside upper right", ncols=3, frameon=False, fontsize=style.SMALL)
        style.caption(figure, about)
    return figure


def shown(row: Mapping[str, Any]) -> tuple[float, str]:
    """Return the share of the judged replicates in which a claim holds, NaN where none was judged, and it in words.

    A claim that depends on another model's unknown constants is shown by the DSNN's half.
    """
    counted = count_of(row)
    half = counted.half or counted
    share = half.holds / half.judged if half.judged else math.nan
    return share, f"{half.holds}/{row['replicates']}{'h' if counted.half else ''}"


def _maps(counts: pl.DataFrame, numbers: pl.DataFrame, axes: Sequence[Axis], titles: Mapping[str, str]) -> Figure:
    """Draw a panel for each claim and measure of each model, the first axis across and the second up."""
    panels = [(name, table) for kind, frame in (("claim", counts), ("measure", numbers)) if frame.height
              for (name, _), table in frame.group_by(kind, "model", maintain_order=True)]  # fmt: skip
    several = len({table["model"][0] for _, table in panels}) > 1
    across = min(ACROSS, len(panels))
    down = math.ceil(len(panels) / across)
    height = 1.2 + 0.24 * (len(axes[1].labels) if len(axes) > 1 else 1)
    figure = Figure((style.WIDTH, min(style.PAGE, 0.9 + down * height)), layout="constrained")
    places = figure.subplots(down, across, squeeze=False, sharex=True, sharey=True)
    for panel, (name, table) in zip(places.flat, panels, strict=False):
        who = f", {table['model'][0]}" if several else ""
        finding = (_claim if "claim" in table.columns else _number)(panel, table, axes, figure)
        words = titles.get(str(name), "all claims together" if name == "all" else "")
        text = f"{name}{who}: {words}{': ' if words else ''}{finding}"
        panel.set_title(style.wrapped(text, style.WIDTH / across - 0.5, style.SMALL), fontsize=style.SMALL)
    for panel in list(places.flat)[len(panels) :]:
        panel.set_axis_off()
    for panel in places[-1]:
        panel.set_xlabel(style.wrapped(axes[0].title, style.WIDTH / across - 0.5))
    for panel in places[:, 0] if len(axes) > 1 else ():
        panel.set_ylabel(style.wrapped(axes[1].title, height))
    return figure


def _cells(table: pl.DataFrame, axes: Sequence[Axis], column: Sequence[Any]) -> np.ndarray[Any, np.dtype[Any]]:
    """Return a column by the places of its rows: (levels of the second axis, levels of the first)."""
    cells = np.full((len(axes[1].labels) if len(axes) > 1 else 1, len(axes[0].labels)), np.nan, object)
    for row, value in zip(table.iter_rows(named=True), column, strict=True):
        up = axes[1].values().index(row[axes[1].name]) if len(axes) > 1 else 0
        cells[up, axes[0].values().index(row[axes[0].name])] = value
    return cells


def _claim(panel: Axes, table: pl.DataFrame, axes: Sequence[Axis], _figure: Figure) -> str:
    found = [shown(row) for row in table.iter_rows(named=True)]
    shares = _cells(table, axes, [share for share, _ in found]).astype(float)
    _heat(panel, shares, SHARES, (0.0, 1.0), _cells(table, axes, [text for _, text in found]))
    _ticks(panel, axes)
    return f"in every replicate at {sum(share == 1.0 for share, _ in found)} of {len(found)} points"


def _number(panel: Axes, table: pl.DataFrame, axes: Sequence[Axis], figure: Figure) -> str:
    """Draw the cells of one measure, with a contour at the model's threshold."""
    values = _cells(table, axes, table["value"].to_list()).astype(float)
    texts = _cells(table, axes, ["" if value is None else f"{value:.3g}" for value in table["value"]])
    known = values[np.isfinite(values)]
    low, high = (float(known.min()), float(known.max())) if known.size else (0.0, 1.0)
    image = _heat(panel, values, mpl.colormaps[SCALE], (low, max(high, low + 1e-9)), texts)
    figure.colorbar(image, ax=panel, shrink=0.8, pad=0.02)
    threshold = table["threshold"][0]
    if threshold is not None and min(values.shape) > 1 and low < threshold < high:
        panel.contour(values, [threshold], colors=DEFAULT, linewidths=1.5)
    _ticks(panel, axes)
    above = (
        "" if threshold is None else f", above T = {threshold:g} at {int((known > threshold).sum())} of {values.size}"
    )
    return f"{low:.3g} to {high:.3g}{above}" if known.size else "no value"


def _heat(panel: Axes, values: Any, colours: Any, limits: tuple[float, float], texts: Any) -> Any:
    panel.set_facecolor(UNJUDGED)
    for cut, number in ((panel.axvline, values.shape[1]), (panel.axhline, values.shape[0])):
        for line in range(number - 1):
            cut(line + 0.5, color="white", lw=1.0)
    image = panel.imshow(values, cmap=colours, vmin=limits[0], vmax=limits[1], origin="lower", aspect="auto")
    if values.size <= MOST_WRITTEN:
        for (up, across), text in np.ndenumerate(texts):
            panel.annotate(
                text, (across, up), ha="center", va="center", fontsize=style.SMALL - 1, path_effects=style.HALO
            )
    return image


def _ticks(panel: Axes, axes: Sequence[Axis]) -> None:
    """Label the levels, and mark the defaults with triangles."""
    panel.set_xticks(range(len(axes[0].labels)), axes[0].labels, rotation=90 if len(axes[0].labels) > 6 else 0)
    panel.set_yticks(range(len(axes[1].labels)) if len(axes) > 1 else [], axes[1].labels if len(axes) > 1 else [])
    look: dict[str, Any] = {"color": DEFAULT, "ms": 4, "clip_on": False, "ls": ""}
    if (x := place(axes[0])) is not None:
        panel.plot(x, 1.0, marker="v", transform=panel.get_xaxis_transform(), **look)
    if len(axes) > 1 and (y := place(axes[1])) is not None:
        panel.plot(1.0, y, marker="<", transform=panel.get_yaxis_transform(), **look)


def place(axis: Axis) -> float | None:
    """Find where the default lies among an axis's levels: 0 at the first, between two levels a fraction.

    ``None`` where there is no default, or it is outside of the levels, or they are texts and it is none of them.
    """
    values = axis.values()
    if axis.default in values:
        return float(values.index(axis.default))
    numbers = [value for value in values if isinstance(value, float)]
    if not isinstance(axis.default, float) or not numbers or not numbers[0] <= axis.default <= numbers[-1]:
        return None
    return float(np.interp(axis.default, numbers, range(len(numbers))))


def _table(counts: pl.DataFrame, names: Sequence[str], titles: Mapping[str, str]) -> Figure:
    """Draw points and models down, claims across."""
    several = counts["model"].n_unique() > 1
    columns = [*names, *(["model"] if several else [])]
    rows = counts.select(columns).unique(maintain_order=True).rows() if columns else [()]
    claims = counts["claim"].unique(maintain_order=True).to_list()
    shares, texts = (np.full((len(rows), len(claims)), fill, object) for fill in (np.nan, ""))
    for row in counts.iter_rows(named=True):
        where = rows.index(tuple(row[name] for name in columns)), claims.index(row["claim"])
        shares[where], texts[where] = shown(row)
    figure = Figure((style.WIDTH, min(style.PAGE, 1.2 + 0.2 * len(rows))), layout="constrained")
    panel = figure.subplots()
    _heat(panel, shares.astype(float), SHARES, (0.0, 1.0), texts)
    panel.invert_yaxis()
    panel.set_xticks(range(len(claims)), claims, fontsize=style.SMALL)
    panel.set_yticks(range(len(rows)), [", ".join(map(str, row)) or titles[claims[0]] for row in rows])
    panel.set_ylabel(", ".join(columns))
    whole = sum(bool(row.size) and bool((row.astype(float) == 1.0).all()) for row in shares)
    style.headline(figure, f"All {len(claims)} claims hold in every replicate at {whole} of {len(rows)} points")
    return figure


LONG = 60
"""Letters from which a text of a further table is printed as a line of its own."""


def show(result: Any, folder: Path) -> None:
    """Print a sweep: a row for each point and model, at how many points each claim holds, and where its files are."""
    plan = result.plan
    frames = [(result.counts, "claim"), (result.numbers, "measure")]
    names = [axis.name for axis in plan.axes] + (["model"] if len({model for _, model in plan.judged}) > 1 else [])
    rows: dict[tuple[Any, ...], dict[str, Any]] = {}
    for frame, kind in frames:
        for row in frame.iter_rows(named=True):
            cells = rows.setdefault(tuple(row[name] for name in names), {name: row[name] for name in names})
            cells[row[kind]] = shown(row)[1] if kind == "claim" else row["value"]
    show_rows(f"claims that hold in k of {plan.replicates} replicates, and numbers", list(rows.values()))
    if result.counts.height:
        for (claim,), table in result.counts.group_by("claim", maintain_order=True):
            found = [shown(row)[0] for row in table.iter_rows(named=True)]
            whole, unjudged = sum(share == 1.0 for share in found), sum(math.isnan(share) for share in found)
            more = f"; not judged at {unjudged}" if unjudged else ""
            out_console.print(
                f"{claim}: holds in every replicate at {whole} of {len(found)} points{more}", markup=False
            )
    for title, further in result.tables.items():
        show_rows(title, further)
    show_places({"figure": folder / f"{plan.study.name}.png", "table": folder / "counts.csv"})


def show_rows(title: str, rows: Sequence[Mapping[str, Any]]) -> None:
    """Print a table; a column of long texts comes below it, a line for each row."""
    if not rows:
        return
    names = list(rows[0])
    long = [name for name in names if any(len(cell_text(row.get(name))) > LONG for row in rows)]
    out_console.print(f"\n{title}", markup=False, style="bold")
    table = Table(box=None, header_style="bold", pad_edge=False)
    for name in (name for name in names if name not in long):
        table.add_column(name, justify="left" if isinstance(rows[0][name], str) else "right")
    for row in rows:
        table.add_row(*(cell_text(row.get(name)) for name in names if name not in long))
    show_table(table)
    for row in rows:
        first = [cell_text(row[name]) for name in names if name not in long and isinstance(row[name], str)][:2]
        for name in (name for name in long if row[name]):
            show_line(f"{', '.join(first)}: {row[name]}", 4)


def cell_text(value: Any) -> str:
    """Return a value as a table shows it: three digits of a number, several with commas."""
    if value is None:
        return "-"
    if isinstance(value, float):
        return f"{value:.3g}"
    return ", ".join(map(cell_text, value)) if isinstance(value, list | tuple) else str(value)
