"""Colours that tell the models of a picture apart.

The eight hues were found by a search for colours that stay apart in normal vision and under simulated deuteranopia and
protanopia (Machado, Oliveira and Fernandes 2009), and that have a contrast of at least 3:1 both on white and on
`DARK` (WCAG 2.1, 1.4.11); `tests/bench/report/test_palette.py` holds them to it. Grey is for baselines alone.
"""

from __future__ import annotations

from collections.abc import Iterable

HUES: tuple[str, ...] = (
    "#3848f8", "#f86010", "#00a868", "#a810b8", "#f840c0", "#985000", "#207070", "#1098f8",
)  # fmt: skip
GREY = "#808080"
"""Colour of models that a picture shows for comparison alone."""
WHITE, DARK = "#ffffff", "#121212"
"""Backgrounds on which every hue and grey is seen."""
BASELINES = ("flow",)
"""Models that are drawn in grey."""
NAMED = (
    "dsnn", "dsn2017", "emd", "lgmd1", "lgmd2", "hybrid", "dsnn-on-blocked", "dsnn-off-blocked", "dsnn-reference",
    "t4t5", "lplc2", "mlplc2", "lplc2-gf", "si-lgmd1", "si-lgmd2", "pon-lgmd", "dsnn-onboard",
    "emd-normalised", "three-arm", "three-arm-4q",
)  # fmt: skip
"""Models that have a colour of their own, which they have in every picture where no model before them has it."""


def colours(names: Iterable[str]) -> dict[str, str]:
    """Return a colour for each name, ``#rrggbb``; no two alike up to eight.

    Parameters
    ----------
    names
        Labels of models. One of `NAMED` keeps its own colour; others are next in line.
    """
    listed = list(dict.fromkeys(names))
    given: dict[str, str] = {}
    for name in sorted(listed, key=lambda name: NAMED.index(name) if name in NAMED else len(NAMED)):
        place = NAMED.index(name) if name in NAMED else 0
        home = HUES[place if place < len(HUES) else 1 + (place - len(HUES)) % (len(HUES) - 1)]
        used = list(given.values())
        free = min(HUES, key=used.count)
        given[name] = GREY if name in BASELINES else home if name in NAMED and home not in used else free
    return {name: given[name] for name in listed}
