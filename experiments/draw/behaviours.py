"""Behaviours as a figure, each measure with its interval and every episode, and where they drove; and as a table."""

import math
from collections.abc import Mapping
from typing import Any

import polars as pl
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle
from matplotlib.ticker import MaxNLocator

from colias_sim.envs import ENVS, RETURN
from colias_sim.envs.measures import FREE_DISTANCE
from experiments.base import palette
from experiments.base.console import count
from experiments.draw import scoreboard, style
from experiments.judge.scores import summary as summarise
from experiments.store.tables import without_controls
from scenes import ARENA_RADIUS_CM

ACROSS = 5
"""Paths side by side."""
MORE_IS_BETTER = ("time on target", "optomotor gain", FREE_DISTANCE, RETURN)
"""Measures of which more is better; of the others less is."""
ENDS = ("value", "ci_low", "ci_high")
ROW, LEAST_ROW, AROUND = 0.3, 0.165, 1.5
"""Height of a behaviour's row of measures and the least, and of title, axes and caption, inches."""
SYMBOLS = "Dots: values, 95 % intervals; strokes: episodes; arrows: better."
PATHS = "Paths from above (cm), the first in bold: circle, start; cross, end by a collision."


def draw(trials: pl.DataFrame, frames: pl.DataFrame, caption: str) -> Figure:
    """Draw a row for each behaviour and a panel for each measure; below, where each of them drove.

    Parameters
    ----------
    trials, frames
        The run's tables of episodes and of their frames.
    caption
        What was run.
    """
    env = ENVS[trials["env"][0]]
    summary = summarise(trials, trials["env"][0], "")
    names = summary["behaviour"].unique(maintain_order=True).to_list()
    low = (math.ceil(len(names) / ACROSS) if env.draws_paths else 0) * style.WIDTH / ACROSS
    high = AROUND + len(names) * min(ROW, max(LEAST_ROW, (style.PAGE - low - AROUND) / len(names)))
    with style.look():
        figure = Figure((style.WIDTH, min(high + low, style.PAGE)), layout="constrained")
        above: Any = figure
        if env.draws_paths:
            parts: Any = figure.subfigures(2, 1, height_ratios=[high, low])
            above, below = parts
            for axes, name in zip(style.grid(below, len(names), ACROSS, sharex=True, sharey=True), names, strict=True):
                axes.set_title(style.wrapped(name, style.WIDTH / ACROSS - 0.2), fontsize=style.SMALL)
                _ways(axes, trials.filter(model=name), frames)
        _measures(above, summary, trials)
        style.headline(above, finding(summary))
        style.caption(figure, caption, SYMBOLS, PATHS if env.draws_paths else "", env.note)
    return figure


def caption(played: Mapping[str, Any]) -> str:
    """Return what was played, in words, from a run's description."""
    env, changed = played["env"], "".join(f", {name}={value}" for name, value in played["options"].items())
    return f"{env.partition('/')[2]}{changed}, {count(played['episodes'], 'episode')} each from seed {played['seed']}."


def finding(summary: pl.DataFrame) -> str:
    """Return which behaviours are best as far as 95 % intervals tell: of returns, or without these of collisions."""
    env, short = summary["env"][0], summary["env"][0].partition("/")[2]
    summary = without_controls(summary, "behaviour")
    rates = [(rate, "the fewest", "fewer", -1) for rate in ENVS[env].collisions[:1]]
    for measure, most, more, sign in ((RETURN, "the highest", "a higher", 1), *rates):
        rows = summary.filter(measure=measure).sort("value", descending=sign > 0, maintain_order=True)
        names, (near, far) = rows["behaviour"].to_list(), ENDS[1:][::sign]
        if len(names) < 2 or rows["ci_low"].null_count():
            continue
        alike = [name for name, end in rows.select("behaviour", far).rows() if sign * end >= sign * rows[near][0]]
        if len(alike) <= max(2, len(names) // 2):
            return f"{short}: {' or '.join(alike)} has {most} {measure} of {len(names)} behaviours"
        if worse := len(names) - len(alike):
            return f"{short}: {names[0]} has {more} {measure} than {worse} of {len(names) - 1} others"
        return f"{short}: no behaviour's {measure} stands out"
    return f"{short}: return by behaviour"


def _measures(part: Any, summary: pl.DataFrame, trials: pl.DataFrame) -> None:
    """Draw a panel for each of the env's measures; a free distance is the reciprocal of a rate."""
    names, env = style.levels(summary, "behaviour"), ENVS[trials["env"][0]]
    rates = [measure for measure in env.collisions if measure != FREE_DISTANCE]
    columns = {**env.measures, **dict.fromkeys(rates), RETURN: "reward"}
    panels = part.subplots(1, len(columns), squeeze=False, sharey=True)[0]
    for axes, (measure, column) in zip(panels, columns.items(), strict=True):
        arrow = "\N{RIGHTWARDS ARROW}" if measure in MORE_IS_BETTER else "\N{LEFTWARDS ARROW}"
        axes.set_title(style.wrapped(f"{measure} {arrow}", style.WIDTH / len(columns) - 0.5), fontsize=style.BODY)
        if column:
            for model, value in trials.select("model", column).drop_nulls().iter_rows():
                axes.plot(value, names.index(model), "|", color=palette.GREY, alpha=0.5, ms=7.0, mew=0.6)
        for row in summary.filter(measure=measure).drop_nulls("value").partition_by("behaviour"):
            name = row["behaviour"][0]
            style.intervals(axes, row, [names.index(name)], ENDS, ms=4.0, color=palette.INK, elinewidth=1.4)
        if measure in rates:  # a short episode's interval is wide
            sizes = summary.filter(measure=measure).select(pl.concat_list(ENDS).explode()).to_series()
            style.decades(axes, sizes.drop_nulls())
        axes.set_xlabel("logarithmic" * (axes.get_xscale() != "linear"), fontsize=style.SMALL)
        if axes.get_xscale() == "linear":
            axes.xaxis.set_major_locator(MaxNLocator(3, steps=[1, 2, 5, 10]))
        axes.grid(axis="y", lw=0.3)
    panels[0].set_yticks(range(len(names)), names)
    panels[0].set_ylim(len(names) - 0.5, -0.5)


def _ways(axes: Axes, trials: pl.DataFrame, frames: pl.DataFrame) -> None:
    """Draw every episode's path from above, the first on top; a cross where one ended by touching something."""
    axes.add_patch(Circle((0, 0), ARENA_RADIUS_CM, fill=False, color=palette.GREY, lw=1.0))
    for trial, repeat, touched in trials.select("trial", "repeat", "touched").reverse().iter_rows():
        way = frames.filter(trial=trial)
        axes.plot(way["x_cm"], way["y_cm"], lw=0.6 if repeat else 1.5, alpha=0.5 if repeat else 1.0, color=palette.INK)
        axes.plot(way["x_cm"][0], way["y_cm"][0], "o", ms=3.5, mfc="white", mec=palette.INK, mew=0.9, zorder=4)
        if touched:
            axes.plot(
                *way.select("x_cm", "y_cm").row(-1), "x", color=palette.VERDICTS["fails"][0], ms=5, mew=1.4, zorder=5
            )
    reach = ARENA_RADIUS_CM + 2.0
    axes.set(xlim=(-reach, reach), ylim=(-reach, reach), aspect="equal", xticks=[-40, 0, 40], yticks=[-40, 0, 40])


def show(summary: pl.DataFrame, title: str) -> None:
    """Print a row for each behaviour: its measures, with their intervals below them."""
    rows: dict[str, dict[str, Any]] = {}
    for row in summary.iter_rows(named=True):
        name = row["measure"]
        values = {name: row["value"], f"{name}_low": row["ci_low"], f"{name}_high": row["ci_high"]}
        rows.setdefault(row["behaviour"], {"model": row["behaviour"]}).update(values)
    measures = summary["measure"].unique(maintain_order=True).to_list()
    scoreboard.show(pl.DataFrame(list(rows.values()), infer_schema_length=None), measures, title)
