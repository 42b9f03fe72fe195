"""Every colour and its one meaning, for figures, recordings, videos, pages and the terminal.

A hue names a potential, a verdict or a change of a pixel. Models are told apart by row, lane or marker, never by hue.
Hues of one group stay apart in normal vision and under simulated deuteranopia and protanopia (Machado, Oliveira and
Fernandes 2009), and potentials have a contrast of at least 3:1 both on white and on `DARK` (WCAG 2.1, 1.4.11);
`tests/experiments/base/test_palette.py` holds them to it.
"""

import itertools
from collections.abc import Iterable, Mapping
from typing import Any

Colour = tuple[int, int, int]
"""Red, green and blue from 0 to 255."""
WHITE, DARK = "#ffffff", "#121212"
"""Backgrounds on which the potentials are seen."""
INK, GREY = "#222222", "#5f5f5f"
"""Text and marks without another meaning; notes beside them."""
CHANNELS: Mapping[str, str] = {"hs": "#1b58f8", "vs": "#e66300", "looming": "#933d99"}
"""Channel of a model's response -> its hue."""
TITLES: Mapping[str, str] = {"hs": "HS", "vs": "VS", "looming": "looming"}
"""Channel -> what plots call it."""
HUES: Mapping[str, str] = {"hs": "blue", "vs": "orange", "looming": "purple"}
"""Channel -> its hue in words, for headings that stand for a legend."""
THRESHOLD = "#7f7f7f"
"""Of thresholds T, thin and dashed."""
BRIGHTER, DARKER, STILL = "#eedd55", "#d94fb0", "#181a20"
"""Pixels that became brighter, became darker, and did not change."""
TRUE = "#2fd6b5"
"""Arrows of the flow that is true."""
OTHERS: Mapping[str, str] = {"teal": "#177362", "pink": "#cc7ab1", "brown": "#805f26", "olive": "#87996b"}
"""Things without an order and a hue of their own, such as kinds of motion and terms of a reward."""
OBSERVER, STIMULUS = "#8c8c8c", "#191919"
"""Robots from above."""
VERDICTS: Mapping[str, tuple[str, str, str, str]] = {
    "holds": ("#008055", "#91f2ba", "green", "\N{CHECK MARK}"),
    "sometimes": ("#995c00", "#ffcc66", "yellow", "~"),
    "fails": ("#990825", "#d95757", "red", "\N{MULTIPLICATION X}"),
    "unjudged": ("#5a6572", "#9aa7b4", "bright_black", "\N{EN DASH}"),
}
"""State of a verdict -> its colour on white, on a dark page, on a terminal, and its sign: colour alone tells none."""
RAMPS: Mapping[str, tuple[str, float]] = {"speed": ("viridis", 0.78), "distance": ("copper", 0.72), "": ("gray", 0.62)}
"""Quantity in a column's name -> matplotlib's colour map for its levels, and the part of it that they take."""
SIGNED = "BrBG"
"""Colour map of angles and other signed quantities: brown is left or negative, teal right or positive."""


def of_others(names: Iterable[Any]) -> dict[Any, str]:
    """Return a colour of `OTHERS` for each name, in turn; more names than four need markers or panels too."""
    return dict(zip(dict.fromkeys(names), itertools.cycle(OTHERS.values()), strict=False))


def pathways(channel: str) -> tuple[str, str]:
    """Return the colours of a channel's ON and OFF potentials: a lighter and a darker tint of its hue."""
    tints = (mixed(rgb(CHANNELS[channel]), rgb(other), 0.45) for other in (WHITE, "#000000"))
    light, dark = ("#{:02x}{:02x}{:02x}".format(*tint) for tint in tints)
    return light, dark


def css() -> str:
    """Return the colours as declarations of CSS variables, for the pages' ``:root``."""
    plain = {**CHANNELS, "threshold": THRESHOLD, "brighter": BRIGHTER, "darker": DARKER}
    pairs = {state: f"light-dark({light}, {dark})" for state, (light, dark, *_) in VERDICTS.items()}
    return " ".join(f"--{name}: {value};" for name, value in (plain | pairs).items())


def rgb(colour: str) -> Colour:
    """Return ``#rrggbb`` as three numbers from 0 to 255."""
    return int(colour[1:3], 16), int(colour[3:5], 16), int(colour[5:7], 16)


def mixed(colour: Colour, other: Colour, share: float) -> Colour:
    """Return a colour with a ``share`` of another in it."""
    red, green, blue = (round((1 - share) * part + share * more) for part, more in zip(colour, other, strict=True))
    return red, green, blue
