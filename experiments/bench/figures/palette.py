"""Marks that tell the models of a figure apart: a colour, a marker and a line style for each.

The ten hues were found by a search for colours that stay apart in normal vision and under simulated deuteranopia and
protanopia (Machado, Oliveira and Fernandes 2009); `tests/bench/figures/test_palette.py` holds them to it. Up to ten
series have a hue each; more share hues, and differ in line style. Greys are of baselines alone.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

HUES: tuple[str, ...] = (
    "#1137b1", "#fe8706", "#278100", "#85225e", "#dd3d74", "#7b5de6", "#118ca8", "#c19af7", "#5cc28a", "#004700",
)  # fmt: skip
GREYS: tuple[str, ...] = ("#989898", "#383838", "#c8c8c8")
"""Colour of models and behaviours that a figure shows for comparison alone."""
MARKERS = ("o", "s", "^", "D", "v", "P", "X", "*")
LINES = ("-", ":", "--", "-.", (0, (3, 1, 1, 1, 1, 1)), (0, (1, 3)), (0, (6, 3)), (0, (6, 2, 1, 2)))
BASELINES = ("flow", "still", "random", "straight", "random-walk")
"""Models and behaviours that are drawn in grey; so are behaviours whose name begins with `PRIVILEGED`."""
PRIVILEGED = "oracle-"
"""Colour of behaviours that are told the state of the world."""
NAMED = (
    "dsnn", "dsn2017", "emd", "lgmd1", "lgmd2", "hybrid", "dsnn-on-blocked", "dsnn-off-blocked", "dsnn-reference",
    "t4t5", "lplc2", "mlplc2", "lplc2-gf", "si-lgmd1", "si-lgmd2", "pon-lgmd", "dsnn-onboard",
    "emd-normalised", "three-arm", "three-arm-4q",
)  # fmt: skip
"""Models that have the same mark in every figure, the first ten of them the hues in their order.

The others take hues of models that the figure does not show, the first that is free from a place of their own on.
"""


@dataclass(frozen=True, slots=True)
class Mark:
    """Colour, marker and line style of a series.

    Parameters
    ----------
    colour
        As ``#rrggbb``.
    marker, line
        As matplotlib has them.
    """

    colour: str
    marker: str
    line: Any


def marks(names: Iterable[str]) -> dict[str, Mark]:
    """Return a mark for each name: ten series have ten colours, and no two have colour and line style in common.

    Parameters
    ----------
    names
        Labels of models or behaviours. Those in `NAMED` come first in the choice of hues, in its order. Others take
        the hues that no model of this figure has; then hues come again with another line style.

    Returns
    -------
    dict of str to Mark
        In the order of ``names``.
    """
    listed = list(dict.fromkeys(names))
    slots: dict[str, int] = {}
    free = list(range(len(HUES) * len(LINES)))
    for name in sorted(filter(NAMED.__contains__, listed), key=NAMED.index):
        place = NAMED.index(name)
        first = place if place < len(HUES) else place + 1 - len(HUES)  # not that of `dsnn`
        slots[name] = min(free, key=lambda slot: (slot // len(HUES), (slot - first) % len(HUES)))
        free.remove(slots[name])
    unused = iter(free)
    greys = iter(range(len(GREYS) * len(LINES)))
    by_name: dict[str, Mark] = {}
    for name in listed:
        if name in BASELINES or name.startswith(PRIVILEGED):
            slot, colours = next(greys), GREYS
        else:
            slot, colours = slots[name] if name in slots else next(unused), HUES
        turn, hue = divmod(slot, len(colours))
        by_name[name] = Mark(colours[hue], MARKERS[(slot + turn) % len(MARKERS)], LINES[turn])
    return by_name


def colours(names: Iterable[str]) -> dict[str, str]:
    """Return the colour of each name's mark, for figures with a panel or a row for each."""
    return {name: mark.colour for name, mark in marks(names).items()}


def level_colours(levels: Sequence[Any]) -> dict[Any, str]:
    """Return a colour for each level of a condition: numbers from dark to light, words in hues; none twice."""
    if all(isinstance(level, str) for level in levels) and len(levels) <= len(HUES):
        return dict(zip(levels, HUES, strict=False))
    import matplotlib as mpl  # not before: workers, which need the palette for recordings, do without

    shades = mpl.colormaps["viridis"](np.linspace(0.0, 0.88, max(len(levels), 2)))
    return {level: mpl.colors.to_hex(shade) for level, shade in zip(levels, shades, strict=False)}
