"""Style of figures, colours, and saving."""

from __future__ import annotations

import contextlib
import math
import re
import textwrap
import warnings
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import matplotlib as mpl
from matplotlib import font_manager
from matplotlib.axes import Axes
from matplotlib.figure import Figure, SubFigure
from matplotlib.ticker import MaxNLocator, NullFormatter

from experiments.bench.figures.media import sheet
from experiments.bench.stats.scores import Score, Standing, written
from experiments.bench.store.files import TABLE, drawn_from
from experiments.bench.store.places import replacing

WIDTH, COLUMN = 7.16, 3.5
"""Widths of figures, inches: of a page of two columns (IEEE), and of one column."""
PAGE = 11.0
"""Height of a page, inches, which figures of as many models as ship keep to."""
TYPE, TITLE = 8.0, 9.0
"""Sizes of type, in points where a figure is `WIDTH` inches wide: the smallest of all, and that of titles."""

STYLE: dict[Any, Any] = {
    "font.size": TYPE,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "figure.autolayout": False,
    "figure.constrained_layout.use": False,
    "svg.hashsalt": "colias-sim",  # equal runs, equal bytes
    "svg.fonttype": "none",
}


BOX = "\N{WHITE SQUARE}"
"""Sign that stands in a figure for a character that cannot be printed."""


@contextlib.contextmanager
def drawing(style: Mapping[Any, Any] = STYLE) -> Iterator[None]:
    """Draw in a style, and without a warning for each character of a user's text that the font has not.

    In pixels such a character is an empty box. In an SVG file the text is whole, and the viewer's font may have it.
    """
    with warnings.catch_warnings(), mpl.rc_context(dict(style)):
        warnings.filterwarnings("ignore", r"Glyph \d+ .*missing from font", UserWarning)
        yield


def without_glyph(text: str) -> list[str]:
    """Return the characters of ``text`` that the figures' font cannot draw, each once."""
    odd = [character for character in dict.fromkeys(text) if character != "\n" and not " " <= character <= "~"]
    if not odd:
        return []
    families = [font_manager.FontProperties(family=[name]) for name in font_manager.FontProperties().get_family()]
    fonts = [font_manager.get_font(font_manager.findfont(family)) for family in families]
    return [character for character in odd if not any(font.get_char_index(ord(character)) for font in fonts)]


def plain(text: str) -> str:
    """Words as they are: a dollar sign in a label of the user's begins no formula, and nothing steers a viewer."""
    return "".join(character if character.isprintable() or character == "\n" else BOX for character in text).replace(
        "$", r"\$"
    )


LETTER = 0.58
"""Mean width of a letter of titles and keys, as a share of the type's size."""
JOINT = "\N{INFORMATION SEPARATOR ONE}"
"""Character that stands, while a text is broken into lines, where it has no space but may be broken."""


def headline(place: Figure | SubFigure, text: str, size: float = TITLE) -> None:
    """Write ``text`` as the title of a figure, from its left edge, in as many lines as it takes."""
    whole = place.figure if isinstance(place, SubFigure) else place
    assert isinstance(whole, Figure)
    place.suptitle(plain(wrapped(text, whole.get_size_inches()[0], size)), fontsize=size, x=0.01, ha="left")


def wrapped(text: str, inches: float, size: float) -> str:
    """Break ``text`` into lines of at most ``inches``, in type of ``size`` points."""
    most = max(int(inches * 72.0 / (LETTER * size)), 8)
    breakable = re.sub(r",(?=\S)", f",{JOINT} ", text)  # a model's settings part at their commas, not in a number
    lines = (
        part for line in breakable.split("\n") for part in textwrap.wrap(line, most, break_on_hyphens=False) or [""]
    )
    return re.sub(f"{JOINT} ?", "", "\n".join(lines))


def grid_of_panels(
    drawn: Figure | SubFigure, blocks: int, per_block: int, across: int, **options: Any
) -> list[list[Axes]]:
    """Return panels for ``blocks`` of ``per_block`` panels each, at most ``across`` in a row; a block begins a row.

    The lowest panel of each column has the numbers of the axis below it; see `lowest`.
    """
    across = min(per_block, across)
    down = -(-per_block // across)
    places = drawn.subplots(blocks * down, across, squeeze=False, **options)
    for axes in places.flat:
        axes.set_visible(False)
    panels = []
    for block in range(blocks):
        block_panels = list(places[block * down : (block + 1) * down].flat)[:per_block]
        for axes in block_panels:
            axes.set_visible(True)
        panels.append(block_panels)
    for axes in lowest(panels):
        axes.tick_params(labelbottom=True)
    return panels


def lowest(panels: Sequence[Sequence[Axes]]) -> list[Axes]:
    """Return the lowest panel of each column."""
    columns: dict[int, Axes] = {}
    for block in panels:
        for axes in block:
            spec = axes.get_subplotspec()
            assert spec is not None
            columns[spec.colspan.start] = axes
    return list(columns.values())


def leftmost(panels: Sequence[Sequence[Axes]]) -> list[Axes]:
    """Return the panels at the left edge."""
    return [axes for block in panels for axes in block if (spec := axes.get_subplotspec()) and spec.is_first_col()]


def save(drawn: Figure, folder: Path, name: str = "figure") -> Path:
    """Write ``NAME.svg`` and ``NAME.png`` atomically, with their `drawn_from`; return the path of the latter.

    It is drawn from the folder's own table of trials.
    Both are as large as `media.sheet` says: a figure of `WIDTH` is as wide as it, and its type grows with it.
    """
    source, scale = drawn_from([folder / TABLE]), sheet().inches / WIDTH
    noted = {"Source": source} if source else {}
    with drawing():
        _settle(drawn)
        for kind, metadata in (("svg", {"Date": None} | noted), ("png", noted)):
            with replacing(folder / f"{name}.{kind}") as partial:
                drawn.savefig(partial, format=kind, dpi=sheet().dpi * scale, metadata=metadata)
                if kind == "svg":
                    _enlarge(partial, scale)
    return folder / f"{name}.png"


def _enlarge(path: Path, scale: float) -> None:
    """Have an SVG file be drawn ``scale`` times as large, whatever is in it."""
    sides = re.compile(r'width="([\d.]+)pt" height="([\d.]+)pt"')

    def larger(match: re.Match[str]) -> str:
        width, height = (scale * float(side) for side in match.groups())
        return f'width="{width:.6g}pt" height="{height:.6g}pt"'

    enlarged = sides.sub(larger, path.read_text(encoding="utf-8"), count=1)
    path.write_text(enlarged, encoding="utf-8")


def _settle(drawn: Figure) -> None:
    """Lay a figure out, and put its panels at whole millionths of it.

    The order in which the layout's solver takes its terms depends on addresses in memory, so its last bits differ from
    run to run, and with them the names of clip paths in an SVG file.
    """
    engine = drawn.get_layout_engine()
    if engine is None:
        return
    engine.execute(drawn)
    drawn.set_layout_engine(None)  # "none" sets one that does nothing, for which each `savefig` draws twice
    for axes in drawn.axes:
        axes.set_position(tuple(round(part, 6) for part in axes.get_position(original=True).bounds))


@dataclass(frozen=True, slots=True)
class Panel:
    """One panel of a scoreboard.

    Parameters
    ----------
    title
        Its heading.
    measure
        The measure that is drawn.
    log, share
        Whether the axis is logarithmic, or goes from 0 to 1.
    column
        The column of each row's value, drawn as a tick; empty where the measure is of all rows together.
    """

    title: str
    measure: str
    log: bool = False
    share: bool = False
    column: str = ""


INCHES_A_ROW, DENSE_ROW, LEAST_ROW = 0.34, 0.24, 0.165
"""Heights of a row of a scoreboard: of up to `MANY_ROWS`, and of more; and the least, of a line of type."""
MANY_ROWS = 12
DOT, DOT_IN_LEAST = 5.0, 3.6
"""Sizes of dots, points."""
MISSING = "#777777"
NOT_APPLYING = "does not apply"


def rows_inches(rows: int, most: float = math.inf) -> float:
    """Return the height of so many rows of a scoreboard: ``most``, or what lower rows take, if they need not less."""
    return min(rows * (INCHES_A_ROW if rows <= MANY_ROWS else DENSE_ROW), max(rows * LEAST_ROW, most))


def scoreboard(
    axes: Sequence[Axes],
    panels: Sequence[Panel],
    standings: Sequence[Standing],
    tints: Mapping[str, str],
    high: float = math.inf,
) -> None:
    """Draw a row for each standing, the first on top, and a panel for each kind of measure.

    Parameters
    ----------
    axes
        One for each panel, side by side, with a common y axis.
    panels, standings
        What is drawn: dots with 95 % intervals; words where a measure does not apply or is infinite.
    tints
        Standing -> its colour.
    high
        Height of all rows, inches: dots are small where rows are low.
    """
    low = high / max(len(standings), 1) < DENSE_ROW - 1e-9
    for place, panel in zip(axes, panels, strict=True):
        _panel(place, panel, standings, tints, low=low)
    axes[0].set_yticks(range(len(standings)), [plain(standing.name) for standing in standings])
    axes[0].set_ylim(len(standings) - 0.5, -0.5)


def _panel(axes: Axes, panel: Panel, standings: Sequence[Standing], tints: Mapping[str, str], *, low: bool) -> None:
    for row in range(0, len(standings), 2):
        axes.axhspan(row - 0.5, row + 0.5, color="black", alpha=0.04, lw=0)
    for row, standing in enumerate(standings):
        _row(axes, panel, row, standing, tints[standing.name], low=low)
    if panel.log:
        axes.set_xscale("log")
        ticks = log_ticks(*axes.get_xlim())
        axes.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
        axes.xaxis.set_minor_formatter(NullFormatter())
    elif panel.share:
        axes.set_xlim(-0.04, 1.04)
        axes.set_xticks([0, 0.25, 0.5, 0.75, 1], ["0", "¼", "½", "¾", "1"])
    else:
        axes.xaxis.set_major_locator(MaxNLocator(3))
    axes.tick_params(axis="y", length=0)
    axes.set_title(panel.title, fontsize=8, loc="left")


def _row(axes: Axes, panel: Panel, row: int, standing: Standing, tint: str, *, low: bool) -> None:
    score = standing.scores.get(panel.measure)
    if score is None or not math.isfinite(score.value):
        text = NOT_APPLYING if score is None or math.isnan(score.value) else f"over {written(score.low)} (95 %)"
        axes.annotate(text, (0.02, row), xycoords=("axes fraction", "data"), ha="left", va="center", color=MISSING,
                      fontsize=8, fontstyle="italic", bbox={"fc": "white", "lw": 0, "pad": 0.5})  # fmt: skip
    if panel.column:
        values = [value for one in standing.rows if (value := one[panel.column]) is not None]
        axes.plot(values, [row + 0.3] * len(values), "|", color=tint, alpha=0.45, ms=5)
    if score is not None and math.isfinite(score.value):
        _dot(axes, score, row, tint, DOT_IN_LEAST if low else DOT)


def _dot(axes: Axes, score: Score, height: float, tint: str, size: float) -> None:
    """Draw a score with its interval; an infinite end is left out."""
    ends = [end if math.isfinite(end) else score.value for end in (score.low, score.high)]
    axes.plot(ends, [height, height], color=tint, lw=1.4, solid_capstyle="butt", zorder=2)
    axes.plot(score.value, height, "o", ms=size, mfc=tint, mec=tint, mew=1.2, zorder=3, clip_on=False)


def log_ticks(low: float, high: float) -> list[float]:
    """Return two or three round numbers from ``low`` to ``high``, both above 0, for a logarithmic axis."""
    decades = range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
    ticks: list[float] = []
    for steps in ((1.0,), (1.0, 3.0), (1.0, 2.0, 5.0), (1.0, 1.5, 2.0, 3.0, 5.0, 7.0)):
        ticks = [tick for decade in decades for step in steps if low <= (tick := step * 10.0**decade) <= high]
        if len(ticks) >= TICKS:
            break
    every = -(-len(ticks) // TICKS)
    return ticks[:: max(every, 1)] if len(ticks) > 1 else [float(f"{low:.2g}"), float(f"{high:.2g}")]


TICKS = 3
"""Ticks of a logarithmic axis, at most; two where more are thinned out."""
