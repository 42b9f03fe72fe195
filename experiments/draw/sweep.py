"""Sweeps as figures, a curve over one axis or a map over two, and on the console."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
import polars as pl
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure

from experiments.base import console, palette
from experiments.declare.study import TOGETHER
from experiments.draw import style
from experiments.draw.style import axis, unit
from experiments.judge.verdict import count_of
from experiments.settings.grid import values_of

_HELD, _FAILED = (palette.VERDICTS[state][0] for state in ("holds", "fails"))
SHARES = LinearSegmentedColormap.from_list("held", (_FAILED, "#ffffff", _HELD))
"""Share of the replicates in which a claim holds, 0 to 1."""
SYMBOLS = {"k/n: holds in k of n": "/", "h: the DSNN's half": "h\\b", "A word: at any seed": "holds|fails",
           "Hatched: not judged": "^-$"}  # fmt: skip
"""What texts of a map's cells mean, and where they occur."""
MEASURE = pl.col("what").str.split(":").list.first()
"""Name of a measure without its condition."""


Described = Mapping[str, Any]
"""A sweep as its ``NAME.json`` has it."""


def draw(sweep: Described, at: Mapping[str, str] | None = None) -> Figure:
    """Draw a sweep.

    One parameter has curves with intervals, two have maps, one for each claim and measure of each model. Claims over
    levels with names are one map: points and models down, claims across.

    Parameters
    ----------
    sweep
        As its ``NAME.json`` has it.
    at
        Axis -> the level of it that alone is drawn.
    """
    sweep = _cut(sweep, at or {})
    named = bool(sweep["counts"]) and sweep["named"]
    cells, symbols = _cells(sweep), []
    if not named and len(sweep["axes"]) == 1:
        symbols.append("Whiskers: 95 % interval, or range")
    elif cells["judged"].any():
        texts = cells.filter("judged")["text"]
        symbols += [words for words, sign in SYMBOLS.items() if texts.str.contains(sign).any()]
    with style.look():
        figure = _table(sweep, cells) if named else _panels(sweep, cells)
        first, _, further = (best(cells) if named else finding(cells)).partition("; ")
        style.headline(figure, style.title(first, "Share of the replicates in which claims hold"))
        fewest = min((count_of(row).replicates for row in sweep["counts"]), default=sweep["replicates"])
        replicates = " to ".join(map(str, sorted({fewest, sweep["replicates"]})))
        what = f"{style.sentence(sweep['summary'])}: n = {replicates}, from seed {sweep['seed']}"
        style.caption(figure, f"{what}.", *[f"{text}." for text in (style.sentence(further), *symbols) if text])
    return figure


def shown(row: Mapping[str, Any]) -> tuple[float, str]:
    """Return the share of the replicates in which a claim holds, NaN where none could be judged, and it in words.

    A claim that depends on another model's unknown constants is shown by the DSNN's half.
    """
    counted = count_of(row)
    half = counted.half or counted
    if not half.judged:
        return math.nan, "-"
    if not half.random:
        return float(half.word == "holds"), f"{half.word}{' (h)' if counted.half else ''}"
    return half.holds / counted.replicates, f"{half.holds}/{counted.replicates}{'h' if counted.half else ''}"


def finding(cells: pl.DataFrame) -> str:
    """Return in how many cells of a sweep claims hold in every replicate, and from where to where its measures reach.

    ``cells`` has a row for each point, model, claim and measure: ``what``, whether it is ``judged``, its ``value``. Of
    a grid that judges several claims their row together counts.
    """
    whole = cells.filter(what=TOGETHER)
    claims, who = (cells.filter("judged"), "Claims hold") if whole.is_empty() else (whole, "All claims hold")
    value = claims["value"].cast(float)
    kept = f"{who} in every replicate in {(value == 1.0).sum()} of {len(value)} cells"
    unjudged = value.is_nan().sum()
    phrases = [*[kept] * (len(value) > 0), *[f"{unjudged} not judged"] * (unjudged > 0)]
    measures = cells.filter(~pl.col("judged")).drop_nulls("value")
    for (name,), of in style.by(measures.with_columns(MEASURE), "what"):
        phrases.append(f"{name} from {of['value'].min():.3g} to {of['value'].max():.3g}")
    return "; ".join(phrases) or "Nothing was measured"


def best(cells: pl.DataFrame) -> str:
    """Return at which points most claims hold in every replicate, and how many; ``cells`` as for `finding`."""
    judged = cells.filter("judged")
    held = judged.group_by("point", maintain_order=True).agg((pl.col("value").cast(float) == 1.0).sum())
    most, number = max(held["value"].to_list(), default=0), judged["what"].n_unique()
    points = held.filter(value=most)["point"].to_list()
    where = points[0] if len(points) == 1 else f"{len(points)} of {len(held)} points"
    phrases = [f"At most {most} of {number} claims hold, at {where}", *points[: len(points) * (1 < len(points) < 4)]]
    return "; ".join(phrases) if most else "No claim holds in every replicate"


def _cut(sweep: Described, at: Mapping[str, str]) -> Described:
    """Return what a sweep has at levels of some axes, without these axes."""
    values = {name: values_of(sweep["axes"][name])[level] for name, level in at.items()}
    rows = {name: [row for row in sweep[name] if all(row[axis] == value for axis, value in values.items())]
            for name in ("counts", "numbers")}  # fmt: skip
    return {**sweep, **rows, "axes": {name: levels for name, levels in sweep["axes"].items() if name not in at}}


def _cells(sweep: Described) -> pl.DataFrame:
    """Return a row for each point, model, claim and measure: its value and interval, its text, where it is drawn.

    ``point`` is the point in words, with the model where there are several.
    """
    rows, axes = [], sweep["axes"]
    models = {row["model"] for row in (*sweep["counts"], *sweep["numbers"])}
    names = [*axes, *(["model"] if len(models) > 1 or not axes else [])]
    for row in (*sweep["counts"], *sweep["numbers"]):
        claim, value = "claim" in row, row.get("value")
        value, text = shown(row) if claim else (value, "" if value is None else f"{value:.3g}")
        ends = ("low", "high") if claim else ("ci_low", "ci_high") if "ci_low" in row else ("lowest", "highest")
        places = [list(values_of(levels).values()).index(row[name]) for name, levels in axes.items()]
        rows.append({
            **{name: row[name] for name in (*axes, "model")}, "what": row["claim" if claim else "measure"],
            "point": ", ".join(f"{row[name]:g}" if isinstance(row[name], float) else row[name] for name in names),
            "judged": claim, "value": value, "text": text, "low": row[ends[0]], "high": row[ends[1]],
            "x": (*places, 0)[0], "y": (*places, 0, 0)[1],
        })  # fmt: skip
    return pl.DataFrame(rows, infer_schema_length=None)


def _panels(sweep: Described, cells: pl.DataFrame) -> Figure:
    """Draw a panel for each claim and measure of each model: the first axis across, a second one up."""
    (across_name, levels), *second = sweep["axes"].items()
    up = list(second[0][1]) if second else []
    value = pl.col("value").cast(float)
    scaled = cells.with_columns(least=value.min().over(MEASURE), most=value.max().over(MEASURE))
    panels = scaled.partition_by("what", "model", maintain_order=True)
    titles = {claim: f"{title} ({claim})" for claim, title in sweep["titles"].items()} | {TOGETHER: "All claims"}
    across = min(3, len(panels))
    down = math.ceil(len(panels) / across)
    height = min(1.3 + 0.24 * len(up) if up else 1.7, (style.PAGE - 0.9) / down)
    figure = Figure((style.WIDTH, 0.9 + down * height), layout="constrained")
    grid = style.grid(figure, len(panels), across, sharex=True, sharey=bool(up))
    inches = style.WIDTH / across - 0.5
    for panel, table in zip(grid, panels, strict=True):
        what, model = table.select("what", "model").row(0)
        if up:
            _heat(panel, table, (len(up), len(levels)))
            panel.set_yticks(range(len(up)), up)
        else:
            style.intervals(panel, table, table["x"], ("value", "low", "high"), along="y", fmt="o-", ms=3.5,
                            capsize=2, color=palette.INK)  # fmt: skip
            panel.set_ylabel("share of replicates" if table["judged"][0] else "")
        title = ", ".join(filter(None, (titles.get(what, in_words(what)), model)))
        panel.set_title(style.wrapped(title, inches, style.TITLE), fontsize=style.TITLE)
        panel.set_xticks(range(len(levels)), list(levels), rotation=90 if len(levels) > 6 else 0)
    for panel in grid[::across] if up else ():
        panel.set_ylabel(with_unit(second[0][0]), fontsize=style.TITLE)
    for panel in grid[-across:]:
        panel.set_xlabel(style.wrapped(with_unit(across_name), inches, style.TITLE), fontsize=style.TITLE)
    return figure


def with_unit(key: str) -> str:
    """Return a parameter's name, in words and with its unit where the name has one."""
    return axis(key.rpartition(".")[2]) if unit(key)[1] else key


def in_words(measure: str) -> str:
    """Return a measure's name with its condition in words: ``spikes: speed_cm_s=2`` is spikes at speed 2 cm/s."""
    name, _, condition = measure.partition(":")
    words = (" ".join((unit(key)[0], level, unit(key)[1])).rstrip()
             for key, _, level in (part.strip().partition("=") for part in condition.split(",") if part))  # fmt: skip
    return f"{name} at {', '.join(words)}" if "=" in condition else measure


def _heat(panel: Axes, table: pl.DataFrame, size: tuple[int, int]) -> None:
    """Draw cells at their ``x`` and ``y``, of (rows, columns), and the texts of claims."""
    cells = np.full(size, np.nan)
    cells[table["y"].to_numpy(), table["x"].to_numpy()] = table["value"].cast(float).to_numpy()
    panel.patch.set(facecolor=palette.WHITE, edgecolor=palette.VERDICTS["unjudged"][1], hatch="////", lw=0.0)
    if not table["judged"][0]:
        least, most = table.select("least", "most").row(0)  # one scale for all panels of a measure
        image = panel.imshow(cells, origin="lower", aspect="auto", cmap="Greys", vmin=least, vmax=most)
        panel.figure.colorbar(image, ax=panel, shrink=0.8, pad=0.02)
        return
    panel.imshow(cells, origin="lower", aspect="auto", cmap=SHARES, vmin=0.0, vmax=1.0)
    for x, y, text in table.select("x", "y", "text").rows():
        panel.annotate(text, (x, y), ha="center", va="center", path_effects=style.HALO, annotation_clip=True,
                       fontsize=min(style.TITLE, 66.0 / size[1]))  # fmt: skip  # the more columns, the narrower


def _table(sweep: Described, cells: pl.DataFrame) -> Figure:
    """Draw points and models down, claims across."""
    cells = cells.filter("judged")
    points, claims = (list(dict.fromkeys(cells[name])) for name in ("point", "what"))
    places = {"x": list(map(claims.index, cells["what"])), "y": list(map(points.index, cells["point"]))}
    figure = Figure((style.WIDTH, min(style.PAGE, 2.6 + 0.2 * len(points))), layout="constrained")
    panel = figure.subplots()
    _heat(panel, cells.with_columns(pl.Series(name, at) for name, at in places.items()), (len(points), len(claims)))
    panel.invert_yaxis()
    titles = [style.wrapped(f"{sweep['titles'].get(claim, '')} ({claim})", 1.4, style.TITLE) for claim in claims]
    panel.set_xticks(range(len(claims)), titles, rotation=90, fontsize=style.TITLE)
    panel.set_yticks(range(len(points)), points)
    panel.set_ylabel(", ".join(sweep["axes"]) or "model")
    return figure


def show(sweep: Described) -> None:
    """Print a sweep: a row for each point and model, at how many points each claim holds, and its further tables."""
    wide = _cells(sweep).pivot("what", index=[*sweep["axes"], "model"], values="text", maintain_order=True)
    title = f"Replicates of {sweep['replicates']} in which claims hold; a word: at any seed"
    console.show(wide, title if sweep["titles"] else "")
    for claim, why in sorted(sweep["unjudged"].items()):
        console.out_console.print(f"{claim} not judged: {why}")
    for title, further in sweep["tables"].items():
        console.show(pl.DataFrame(further, infer_schema_length=None), title)
