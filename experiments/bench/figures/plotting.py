"""Style of figures, colours, and saving."""

from __future__ import annotations

import contextlib
import re
import warnings
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import matplotlib as mpl
from matplotlib import font_manager
from matplotlib.figure import Figure

from experiments.bench.figures.media import sheet
from experiments.bench.store.files import TABLE, drawn_from
from experiments.bench.store.places import replacing

WIDTH = 7.16
"""Width of a figure, inches: of a page of two columns (IEEE)."""
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


INCHES_A_ROW = 0.34
"""Height of a row of bars."""
