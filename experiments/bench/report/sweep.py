"""Sweeps as figures, heat maps over a grid or one table of coloured cells, and on the terminal."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from rich.table import Table

from experiments.bench.report import style
from experiments.bench.report.terminal import out_console, show_places, show_table
from experiments.bench.stats.count import count_of
from experiments.bench.study import Axis

HELD, BROKEN = style.HUES[0], style.HUES[1]
UNJUDGED: Any = {"facecolor": "white", "edgecolor": "#b0b0b0", "hatch": "////", "lw": 0.0}
SHARES = LinearSegmentedColormap.from_list("held", (BROKEN, "#f4f1ea", HELD))
"""Share of the replicates in which a claim holds, 0 to 1."""
SHADES, SCALE, DEFAULT = "Blues", "viridis", "#c0392b"
"""Colours of counts, of numbers, and of the marks of defaults, winners and thresholds."""
MARK: Any = {"color": DEFAULT, "ms": 4, "ls": ""}
ACROSS = 3
MOST_WRITTEN = 24
"""Cells of a heat map up to which their numbers are written."""


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
        model's threshold; triangles mark the defaults. Levels with names are the rows of one table, claims its columns;
        without claims one or two axes have heat maps too.
    """
    key: list[Any] = []
    with style.look():
        if not counts.height or (axes and all(axis.of_keys for axis in axes)):
            figure = _maps(counts, numbers, axes, titles)
            if any(place(axis) is not None for axis in axes[:2]):
                key.append(Line2D([], [], marker="v", label="default", **MARK))
        else:
            figure = _table(counts, [axis.name for axis in axes])
        if counts.height:
            colours = {"the claim holds": 1.0, "it fails": 0.0}
            colours |= {"in some replicates": 0.5} if counts["replicates"].max() != 1 else {}
            key += [Patch(color=SHARES(share), label=label) for label, share in colours.items()]
            key.append(Patch(label="not judged", **UNJUDGED))
        if key:
            figure.legend(handles=key, loc="outside upper right", ncols=5, frameon=False, fontsize=style.SMALL)
        style.caption(figure, about)
    return figure


def shown(row: Mapping[str, Any]) -> tuple[float, str]:
    """Return the share of the replicates in which a claim holds, NaN where none could be judged, and it in words.

    A claim that depends on another model's unknown constants is shown by the DSNN's half.
    """
    counted = count_of(row)
    half = counted.half or counted
    share = half.holds / counted.replicates if half.judged else math.nan
    return share, f"{half.holds}/{row['replicates']}{'h' if counted.half else ''}"


def _maps(counts: pl.DataFrame, numbers: pl.DataFrame, axes: Sequence[Axis], titles: Mapping[str, str]) -> Figure:
    """Draw a panel for each claim and measure of each model, the first axis across and the second up."""
    panels = [(str(name), str(model), table) for kind, frame in (("claim", counts), ("measure", numbers)) if len(frame)
              for (name, model), table in frame.group_by(kind, "model", maintain_order=True)]  # fmt: skip
    several = len({model for _, model, _ in panels}) > 1
    across = min(ACROSS, len(panels))
    down = math.ceil(len(panels) / across)
    up = axes[1].values() if len(axes) > 1 else ("",)
    height = min(1.3 + 0.24 * len(up), (style.PAGE - 0.9) / down)
    figure = Figure((style.WIDTH, 0.9 + down * height), layout="constrained")
    places = figure.subplots(down, across, squeeze=False, sharex=True, sharey=True)
    for panel, (name, model, table) in zip(places.flat, panels, strict=False):
        order = [(row[axes[1].name] if len(axes) > 1 else "", row[axes[0].name]) for row in table.to_dicts()]
        where = tuple(np.array([(up.index(y), axes[0].values().index(x)) for y, x in order]).T)
        who = f"{titles.get(name, 'All claims')} ({name}{f', {model}' if several else ''})"
        size = len(up), len(axes[0].labels)
        of = _claim(panel, table, where, size) if "claim" in table else _number(panel, table, numbers, where, size)
        text = style.wrapped(f"{who} {of}", style.WIDTH / across - 0.5, style.SMALL)
        panel.set_title(text, fontsize=style.SMALL)
        panel.set_xticks(range(len(axes[0].labels)), axes[0].labels, rotation=90 if len(axes[0].labels) > 6 else 0)
        panel.set_yticks(range(len(up)), axes[1].labels if len(axes) > 1 else up)
        if (x := place(axes[0])) is not None:
            panel.plot(x, 1.0, marker="v", transform=panel.get_xaxis_transform(), clip_on=False, **MARK)
        if len(axes) > 1 and (y := place(axes[1])) is not None:
            panel.plot(1.0, y, marker="<", transform=panel.get_yaxis_transform(), clip_on=False, **MARK)
    for panel in places.flat[len(panels) :]:
        panel.set_axis_off()
    for panel in places[-1]:
        panel.set_xlabel(style.wrapped(axes[0].title, style.WIDTH / across - 0.5))
    for panel in places[:, 0]:
        panel.set_ylabel(style.wrapped(axes[1].title if len(axes) > 1 else "", height))
    return figure


def _claim(panel: Axes, table: pl.DataFrame, where: Any, size: tuple[int, int]) -> str:
    """Draw the cells of one claim; return the finding."""
    shares, texts = zip(*(shown(row) for row in table.to_dicts()), strict=True)
    _heat(panel, size, where, shares, texts if table["replicates"][0] > 1 else (), SHARES, (0.0, 1.0))
    return f"holds in every replicate at {shares.count(1.0)} of {len(shares)} points"


def _number(panel: Axes, table: pl.DataFrame, numbers: pl.DataFrame, where: Any, size: tuple[int, int]) -> str:
    """Draw a measure's cells on the scale of all its panels, a contour at the threshold; return the finding."""
    values, threshold = np.array(table["value"].to_list(), float), table["threshold"][0]
    known = values[np.isfinite(values)]
    if not known.size:
        return "has no value"
    low, high = float(known.min()), float(known.max())
    texts = [f"{value:.3g}" for value in values]
    kind = pl.col("measure").str.split(":").list.first()
    alike = numbers.filter(kind == table["measure"][0].partition(":")[0])["value"].cast(pl.Float64).to_numpy()
    least, most = np.nanmin(alike), np.nanmax(alike)
    image = _heat(panel, size, where, values, texts, SCALE, (least, max(most, least + 1e-9)))
    panel.figure.colorbar(image, ax=panel, shrink=0.8, pad=0.02)
    if threshold is None:
        return f"is {low:.3g} to {high:.3g}"
    if min(size) > 1 and low < threshold < high:
        panel.contour(image.get_array(), [threshold], colors=DEFAULT, linewidths=1.5)
    return f"is {low:.3g} to {high:.3g}, above T = {threshold:g} (red line) at {(known > threshold).sum()} points"


def _heat(
    panel: Axes, size: tuple[int, int], where: Any, values: Sequence[float] | np.ndarray[Any, Any],
    texts: Sequence[str], colours: Any, limits: tuple[float, float],
) -> Any:  # fmt: skip
    """Draw cells, (rows, columns) of them, whose places ``where`` has; write the texts of few."""
    cells = np.full(size, np.nan)
    cells[where] = values
    panel.patch.set(**UNJUDGED)
    image = panel.imshow(cells, cmap=colours, vmin=limits[0], vmax=limits[1], origin="lower", aspect="auto")
    for draw_line, number in ((panel.axvline, size[1]), (panel.axhline, size[0])):
        for line in range(number - 1):
            draw_line(line + 0.5, color="white", lw=1.0)
    for up, along, text in zip(*where, texts, strict=False) if cells.size <= MOST_WRITTEN or limits[1] == 1.0 else ():
        panel.annotate(text, (along, up), ha="center", va="center", fontsize=style.SMALL - 1, path_effects=style.HALO)
    return image


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


def _table(counts: pl.DataFrame, names: Sequence[str]) -> Figure:
    """Draw points and models down, claims across."""
    columns = [*names, *(["model"] if counts["model"].n_unique() > 1 or not names else [])]
    rows = counts.select(columns).unique(maintain_order=True).rows()
    claims = counts["claim"].unique(maintain_order=True).to_list()
    shares, texts = zip(*(shown(row) for row in counts.to_dicts()), strict=True)
    where = ([rows.index(row) for row in counts.select(columns).rows()], list(map(claims.index, counts["claim"])))
    figure = Figure((style.WIDTH, min(style.PAGE, 1.2 + 0.2 * len(rows))), layout="constrained")
    panel = figure.subplots()
    cells = _heat(panel, (len(rows), len(claims)), where, shares, texts, SHARES, (0.0, 1.0)).get_array()
    panel.invert_yaxis()
    panel.set_xticks(range(len(claims)), claims, fontsize=style.SMALL)
    panel.set_yticks(range(len(rows)), [", ".join(map(str, row)) for row in rows])
    panel.set_ylabel(", ".join(columns))
    whole = int((cells.filled(0.0) == 1.0).all(axis=1).sum())
    style.headline(figure, f"All {len(claims)} claims hold in every replicate at {whole} of {len(rows)} points")
    return figure


def show(result: Any, folder: Path) -> None:
    """Print a sweep: a row for each point and model, at how many points each claim holds, and where its files are."""
    plan = result.plan
    names = [axis.name for axis in plan.axes] + (["model"] if len({model for _, model in plan.judged}) > 1 else [])
    rows: dict[tuple[Any, ...], dict[str, Any]] = {}
    found: dict[str, list[float]] = {}
    for row in (*result.counts.to_dicts(), *result.numbers.to_dicts()):
        cells = rows.setdefault(tuple(row[name] for name in names), {name: row[name] for name in names})
        if "measure" in row:
            cells[row["measure"]] = row["value"]
        else:
            share, cells[row["claim"]] = shown(row)
            found.setdefault(row["claim"], []).append(share)
    judged = f"claims that hold in k of {plan.replicates} replicates" if result.counts.height else ""
    show_rows(", and ".join(filter(None, (judged, "numbers" if result.numbers.height else ""))), list(rows.values()))
    for claim, shares in found.items():
        text = f"{claim}: holds in every replicate at {shares.count(1.0)} of {len(shares)} points"
        unjudged = sum(map(math.isnan, shares))
        out_console.print(f"{text}{f'; not judged at {unjudged}' if unjudged else ''}", markup=False)
    for title, further in result.tables.items():
        show_rows(title, further)
    show_places({"figure": folder / f"{plan.study.name}.png", "table": folder / "counts.csv"})


def show_rows(title: str, rows: Sequence[Mapping[str, Any]]) -> None:
    """Print a table."""
    table = Table(box=None, header_style="bold", pad_edge=False)
    for name in rows[0] if rows else ():
        table.add_column(name, justify="left" if isinstance(rows[0][name], str) else "right")
    for row in rows:
        table.add_row(*(cell_text(row.get(name)) for name in rows[0]))
    out_console.print(f"\n{title}", markup=False, style="bold")
    show_table(table)


def cell_text(value: Any) -> str:
    """Return a value as a table shows it: three digits of a number, several with commas."""
    if value is None:
        return "-"
    if isinstance(value, float):
        return f"{value:.3g}"
    return ", ".join(map(cell_text, value)) if isinstance(value, list | tuple) else str(value)
