"""The look that all figures share: titles that state findings, means with intervals, labels at their lines, saving.

Findings are in words: the order of the means along an axis, as far as intervals tell.
"""

import contextlib
import math
import re
import textwrap
import warnings
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
import polars as pl
from matplotlib.axes import Axes
from matplotlib.colors import to_hex
from matplotlib.figure import Figure, SubFigure
from matplotlib.patheffects import withStroke

from experiments.base import palette
from experiments.base.files import NAME, read_json, replacing
from experiments.judge.tests import LEAST_FOR_INTERVAL, summarise, written
from experiments.settings.parameters import in_words
from experiments.store import provenance

WIDTH, PAGE = 7.16, 11.0
"""Width of a figure (both columns of IEEE's page) and the most that it is high, inches."""
NAME_INCHES = 1.0
"""Width of the names of models left of their rows."""
SMALL, BODY, TITLE = 7.0, 8.0, 9.0
"""Sizes of type, points: labels at lines and ticks; axes; findings."""
LOOK: dict[Any, Any] = {
    "font.size": BODY,
    "axes.titlesize": BODY,
    "axes.titlelocation": "left",
    "xtick.labelsize": SMALL,
    "ytick.labelsize": SMALL,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "lines.linewidth": 1.3,
    "text.parse_math": False,  # a dollar sign in a user's label begins no formula
    "svg.hashsalt": "colias-sim",  # equal tables, equal bytes
    "svg.fonttype": "none",
}
DPI = 200.0
"""Dots per inch of a PNG."""
MOST_WORDS, CAPTION_LINES = 12, 2
"""Words of a title, and lines of a caption."""
MOST_NAMED = 8
"""Parameters that a title names."""
HALO = (withStroke(linewidth=2.0, foreground="white"),)
"""White around text that may lie on a line."""


@contextlib.contextmanager
def look() -> Iterator[None]:
    """Draw in the style, and without a warning for each character of a user's text that the font has not."""
    with warnings.catch_warnings(), mpl.rc_context(LOOK):
        warnings.filterwarnings("ignore", r"Glyph \d+ .*missing from font", UserWarning)
        yield


def tints(levels: Iterable[Any], column: str = "") -> dict[Any, str]:
    """Return a colour for each level of a column: speeds, distances and angles have one palette each in all figures.

    Numbers go from dark for the smallest to light for the largest; signed ones are brown, grey and teal. Words are
    things without an order.
    """
    known = list(dict.fromkeys(levels))
    if isinstance(known[0], str):
        return palette.of_others(known)
    most = max(map(abs, known))
    if "angle" in column or min(known) < 0.0 < max(known):
        blend = mpl.colormaps[palette.SIGNED]
        return {level: to_hex(blend(0.5 + math.copysign(0.2 + 0.3 * abs(level) / most, level))) if level else
                palette.GREY for level in sorted(known)}  # fmt: skip
    name, high = next(ramp for quantity, ramp in palette.RAMPS.items() if quantity in column)
    places = mpl.colormaps[name](np.linspace(0.0, high, max(len(known), 2)))
    return dict(zip(sorted(known, key=abs), map(to_hex, places), strict=False))


def wrapped(text: str, inches: float, points: float = BODY) -> str:
    """Break ``text`` into lines of at most ``inches`` in type of so many points; long labels part at their commas."""
    most = max(int(inches * 72.0 / (0.6 * points)), 8)
    lines = textwrap.wrap(re.sub(r",(?=\S)", ",\x1f ", text), most, break_on_hyphens=False, break_long_words=False)
    return "\n".join(lines).replace("\x1f ", "").replace("\x1f", "")


def title(finding: str, plain: str) -> str:
    """Return a finding as a title, or the plain label where it has more than `MOST_WORDS`."""
    return sentence(finding if len(finding.split()) <= MOST_WORDS else plain)


def finding(axes: Axes, text: str, letter: str = "", label: str = "") -> None:
    """Write the finding of a panel above it, after the panel's letter; below it what its vertical axis is."""
    inches = axes.bbox.width / axes.figure.dpi
    axes.set_title(wrapped(f"{letter}  {text}" if letter else text, inches, TITLE), fontsize=TITLE, fontweight="bold",
                   pad=16.0 if label else None)  # fmt: skip
    axes.annotate(label, (0.0, 1.0), (0.0, 4.0), "axes fraction", "offset points", fontsize=SMALL, color=palette.GREY)


def headline(figure: Figure | SubFigure, text: str) -> None:
    """Write the finding of a figure, or of a part of one, at its upper left."""
    inches = figure.bbox.width / figure.figure.dpi
    figure.suptitle(wrapped(text, inches, TITLE), x=0.01, ha="left", fontsize=TITLE, fontweight="bold")


def caption(figure: Figure, text: str, *more: str) -> None:
    """Write below a figure what was run and n; of what symbols mean and how means go, as much as two lines hold."""
    inches, narrow = figure.get_size_inches()[0], 0.86 * SMALL  # long texts have many narrow letters
    for further in filter(None, more):
        longer = f"{text} {further}"
        text = longer if wrapped(longer, inches, narrow).count("\n") < CAPTION_LINES else text
    figure.align_ylabels()
    figure.supxlabel(wrapped(text, inches, narrow), x=0.01, ha="left", fontsize=SMALL, color=palette.GREY)


def legend(figure: Figure, panels: Iterable[Axes]) -> None:
    """Draw the one legend of a figure above its panels: of every label that several curves of a panel need."""
    found: dict[Any, Any] = {}
    for axes in panels:
        handles, labels = axes.get_legend_handles_labels()
        found |= dict(zip(labels, handles, strict=True)) if len(labels) > 1 else {}
    above = len(figure.get_suptitle()) + sum(len(label) + 8 for label in found) < 110  # there is room beside it
    if found:
        figure.legend(found.values(), found, frameon=False,
                      loc="outside upper right" if above else "outside right upper",
                      ncols=len(found) if above else 1, fontsize=SMALL, handlelength=2.0)  # fmt: skip


def levels(table: pl.DataFrame, column: str) -> list[Any]:
    """Return the values of a column, each once, in the order of their first rows."""
    return table[column].unique(maintain_order=True).to_list()


def by(table: pl.DataFrame, *columns: str) -> Any:
    """Return the groups of a table by some columns, in the order of their first rows."""
    return table.group_by(*columns, maintain_order=True)


def sentence(text: str) -> str:
    """Return a text with a capital at its beginning."""
    return text[:1].upper() + text[1:]


def grid(part: Figure | SubFigure, count: int, across: int, **options: Any) -> list[Axes]:
    """Return ``count`` panels, so many side by side; what is left of the last row is blank."""
    panels = part.subplots(math.ceil(count / across), across, squeeze=False, **options)
    for axes in panels.flat[count:]:
        axes.set_visible(False)
    for axes in panels.flat[max(count - across, 0) : count] if options.get("sharex") else ():
        axes.tick_params(labelbottom=True)
    return list(panels.flat[:count])


def intervals(axes: Axes, rows: pl.DataFrame, at: Any, names: Sequence[str], *, along: str = "x", **look: Any) -> None:
    """Draw values with their intervals as dots with whiskers.

    Parameters
    ----------
    rows
        A row for each value.
    at
        The place of each row on the other axis.
    names
        Columns: the value, and the ends of its interval, null where there is none.
    along
        The axis of the values, ``x`` or ``y``.
    look
        As of `matplotlib.axes.Axes.errorbar`.
    """
    value, *ends = (rows[name].cast(float).to_numpy() for name in names)
    reach = np.nan_to_num(np.abs(np.stack(ends) - value))
    places = (value, at) if along == "x" else (at, value)
    axes.errorbar(*places, **{f"{along}err": reach, "fmt": "o", **look})


def means(
    axes: Axes, x: Sequence[float], samples: Sequence[Sequence[float]], colour: str, name: str = "", *,
    line: Any = "-", marker: str = "o", gap: float = 0.0, dots: Sequence[Any] = (),
) -> None:  # fmt: skip
    """Draw trials as dots, their means as a line called ``name``, and the 95 % interval of each mean as a whisker.

    Parameters
    ----------
    x
        Places along the axis.
    samples
        The values of the trials at each place. Fewer than three have no interval.
    line, marker, gap
        Style of the line and of the means; the distance between two places, over which dots are spread.
    dots
        A colour for the trials of each place; otherwise they are open dots in the line's colour.
    """
    summaries = [summarise(values) for values in samples]
    axes.plot(x, [summary.value for summary in summaries], marker, ls=line, lw=1.0, ms=3.0, color=colour,
              label=name or None, zorder=3)  # fmt: skip
    known = [(place, one.low, one.high) for place, one in zip(x, summaries, strict=True) if one.n >= 3]
    if known:
        at, low, high = zip(*known, strict=True)
        axes.plot([at, at], [low, high], color=colour, lw=1.2, solid_capstyle="butt", zorder=3)  # legends avoid lines
    for index, (place, values) in enumerate(zip(x, samples, strict=True)):
        spread = place + gap * np.linspace(-0.22, 0.22, len(values) + 2)[1:-1]
        look = {"color": dots[index], "mec": "none"} if dots else {"mfc": "none", "mec": colour, "mew": 0.6}
        axes.plot(spread, values, "o", ms=2.5, alpha=0.75, zorder=2, clip_on=False, **look)


def row_name(axes: Axes, name: str, level: float | None = None) -> None:
    """Write the name of a model left of its row, with its threshold below."""
    text = wrapped(name, NAME_INCHES, SMALL) + ("" if level is None else f"\nT = {level:.3g}") if name else ""
    axes.set_ylabel(text, rotation=0, ha="right", va="center", fontsize=SMALL)


def threshold(
    axes: Axes, level: float | None, *, signed: bool = False, named: bool = True, most: float = math.inf
) -> None:
    """Draw a threshold T with its number below the line, of either sign where the potential is ``signed``.

    One above ``most`` is named and not drawn, so that the axis fits the data. ``None``: there is none.
    """
    if level is None:
        return
    for sign in () if level > most else (1, -1) if signed else (1,):
        axes.axhline(sign * level, color=palette.THRESHOLD, ls="--", lw=0.8, zorder=1)
    text, place, unit = (" is above", 1.0, "axes fraction") if level > most else ("", level, "data")
    axes.annotate(f"T = {level:.3g}{text}" if named else "", (0.0, place), (2.0, -2.0), ("axes fraction", unit),
                  "offset points", va="top", fontsize=SMALL, color=palette.GREY, zorder=4, path_effects=HALO,
                  in_layout=False)  # fmt: skip


def decades(axes: Axes, values: pl.Series) -> None:
    """Make the x axis logarithmic beyond the smallest values, but for 0, where they span more than two decades."""
    sizes = values.abs().filter(values != 0.0).to_numpy()
    if sizes.size and sizes.max() > 100.0 * sizes.min():
        least = max(sizes.min(), 1e-4 * sizes.max())
        axes.set_xscale("symlog", linthresh=least)
        powers = range(math.ceil(math.log10(least)), math.ceil(math.log10(sizes.max())))
        plain_numbers(axes, [0.0, *(10.0**power for power in powers)])


def plain_numbers(axes: Axes, ticks: Sequence[float] = ()) -> None:
    """Write the numbers of a logarithmic x axis as they are, at its decades or at the ``ticks``."""
    if len(ticks):
        axes.set_xticks(ticks)
    axes.xaxis.set_major_formatter(lambda number, _: written(number))
    axes.xaxis.minorticks_off()


def label_ends(axes: Axes, ends: Sequence[tuple[float, float, str, str]]) -> None:
    """Write names at the ends of lines, clear of each other; ``ends`` are x, y, name and colour, limits are set."""
    ends = sorted(ends, key=lambda end: end[1])
    scale, gap = 72.0 / axes.figure.dpi, 1.2 * SMALL
    heights = [scale * float(axes.transData.transform(end[:2])[1]) for end in ends]
    places = list(heights)
    for _ in range(200):
        for lower in range(len(places) - 1):
            overlap = max(gap - (places[lower + 1] - places[lower]), 0.0)
            places[lower] -= overlap / 2.0
            places[lower + 1] += overlap / 2.0
    for (x, y, name, colour), height, place in zip(ends, heights, places, strict=True):
        axes.annotate(name, (x, y), (5.0, place - height), textcoords="offset points", va="center", color=colour,
                      fontsize=SMALL, fontweight="bold", annotation_clip=False, path_effects=HALO)  # fmt: skip


def save(figure: Figure, path: Path) -> Path:
    """Write a figure as SVG and PNG; equal figures give equal bytes.

    Parameters
    ----------
    path
        Where, without a suffix. Both files note the code and the commit of the run in that folder.

    Returns
    -------
    pathlib.Path
        That of the PNG file.
    """
    source = drawn_from(path.parent)
    noted = {"Source": source} if source else {}
    with look():
        if engine := figure.get_layout_engine():
            engine.execute(figure)  # whose last bits differ from run to run, and with them the names of clip paths
            figure.set_layout_engine(None)
            for axes in figure.axes:
                axes.set_position(tuple(round(side, 6) for side in axes.get_position(original=True).bounds))
        for kind, metadata in (("svg", {"Date": None} | noted), ("png", noted)):
            with replacing(path.with_name(f"{path.name}.{kind}")) as partial:
                figure.savefig(partial, format=kind, dpi=DPI, metadata=metadata)
    return path.with_name(f"{path.name}.png")


def in_title(parameters: Mapping[str, Any]) -> str:
    """Return the part of a figure's title that lists changed parameters; empty if there are none."""
    named = in_words(dict(list(parameters.items())[:MOST_NAMED]))
    more = f" and {len(parameters) - MOST_NAMED} more" if len(parameters) > MOST_NAMED else ""
    return f"; set: {named}{more}" if parameters else ""


def drawn_from(folder: Path) -> str:
    """Return the code and the commit that computed the run in a folder, for the figures there.

    For a run of runs, the code of its first part. Empty where there is no run.
    """
    for place in (folder / NAME, *sorted(folder.glob(f"*/{NAME}"))):
        described = read_json(place) if place.is_file() else {}
        if "source" in described:
            return f"code {described['code']}, commit {provenance.commit(described['source']) or 'unknown'}"
    return ""


UNITS = {"_cm_s2": "cm/s²", "_cm_s": "cm/s", "_deg_s": "°/s", "_hz": "Hz", "_deg": "°", "_cm": "cm"}
"""End of a column's name -> unit."""
POSITIVE = {"angle_deg": "right positive", "observer_turn_deg_s": "left positive"}
NO_BREAK, MINUS = "\N{NO-BREAK SPACE}", "\N{MINUS SIGN}"
Curve = tuple[list[Any], list[list[float]]]
"""Levels of a condition, numbers in order, and the values at each."""


def unit(column: str) -> tuple[str, str]:
    """Return what a column is called, and its unit."""
    end = next((end for end in UNITS if column.endswith(end)), "")
    return column.removesuffix(end).replace("_", " "), UNITS.get(end, "")


def axis(column: str) -> str:
    """Return the label of a column's axis."""
    noun, of = unit(column)
    more = ", ".join(filter(None, (of, POSITIVE.get(column))))
    return f"{noun} ({more})" if more else noun


def level_text(level: Any, of: str = "") -> str:
    """Return a level, in a unit, as keys and titles show it."""
    if level is None or isinstance(level, str):
        return level or "default"
    return f"{level:g}{'' if of[:1] in '°' else NO_BREAK}{of}".replace("-", MINUS)


def curve(rows: pl.DataFrame, along: str, column: str) -> Curve:
    """Return the levels of one column, and the values of another at each."""
    rows = rows.drop_nulls(column)
    table = by(rows if rows[along].dtype == pl.String else rows.sort(along), along).agg(column)
    return table[along].to_list(), table[column].to_list()


def order(levels: Sequence[Any], samples: Sequence[Sequence[float]], along: str, of: str = "") -> str:
    """Say what the 95 % intervals of means tell about their order, and no more.

    Parameters
    ----------
    levels
        Levels of a condition, in its order.
    samples
        The values at each level. Fewer than three are taken as exact.
    along, of
        What the condition is called, and its unit.

    Returns
    -------
    str
        One mean is called larger than another only where its interval lies above the other's.
    """
    summaries, count = [summarise(values) for values in samples], len(levels)
    exact = [len(values) < LEAST_FOR_INTERVAL for values in samples]
    if count == 1:
        between = "" if exact[0] else " [{0.low:.3g}, {0.high:.3g}]"
        return f"is {{0.value:.3g}}{between}".format(*summaries)
    if not any(map(any, samples)):
        return "is 0 throughout"
    low, high = ([one.value if known else getattr(one, end) for one, known in zip(summaries, exact, strict=True)]
                 for end in ("low", "high"))  # fmt: skip
    above = np.greater.outer(low, high)
    words, ends = isinstance(levels[0], str), []
    for verb, beyond in (("rises", above.T), ("falls", above)):
        if not words and np.diagonal(beyond, 1).all():
            return f"{verb} with {along}"
    means = [summary.value for summary in summaries]
    for word, beyond, end in (("largest", above, int(np.argmax(means))), ("least", above.T, int(np.argmin(means)))):
        alike = [level_text(level, of) for level, less in zip(levels, beyond[end], strict=True) if not less]
        if len(alike) <= min(2, count // 2):
            place = "for" if words else "at" if of else f"at {along}"
            ends.append(f"{word} {place} {' or '.join(alike)}")
    return f"is {' and '.join(ends)}" if ends else "shows no clear order"


def orders(curves: Iterable[Curve], along: str, of: str = "") -> list[str]:
    """Return the `order` of each curve that has more than one level, or of each where none has more."""
    known = [one for one in curves if one[0]]
    most = max((len(levels) for levels, _ in known), default=0)
    return [order(levels, samples, along, of) for levels, samples in known if len(levels) > 1 or most == 1]


def commonest(noun: str, found: Sequence[str]) -> str:
    """Return the commonest of some `orders`, and how many curves have it."""
    common, so = Counter(found or ["is not known"]).most_common()[0]
    return f"{noun} {common} in {so} of {len(found)} curves" if len(found) > 1 else f"{noun} {common}"


def shared(noun: str, found: Sequence[str], along: str) -> str:
    """Return a title: the order that all curves have; a plain label where they disagree, or it is too long."""
    same = found[0] if len({*found}) == 1 else f"by {along}"
    terse = same.removeprefix("is ").replace(" and ", ", ")
    return title(f"{noun}: {terse}" if " and " in same else f"{noun} {same}", f"{noun} by {along}")


def drawn_of(what: str, n: int) -> str:
    """Name what is drawn without a finding; n, one or two trials of each condition, carries none."""
    return what + {1: ", one trial each", 2: ", two trials each"}.get(n, "")
