"""Colours that tell the models of a recording, a video or a live page apart.

The eight hues were found by a search for colours that stay apart in normal vision and under simulated deuteranopia and
protanopia (Machado, Oliveira and Fernandes 2009), and that have a contrast of at least 3:1 both on white and on
`DARK` (WCAG 2.1, 1.4.11); `tests/experiments/base/test_palette.py` holds them to it.
"""

from __future__ import annotations

from collections.abc import Iterable

HUES: tuple[str, ...] = (
    "#3848f8", "#f86010", "#00a868", "#a810b8", "#f840c0", "#985000", "#207070", "#1098f8",
)  # fmt: skip
WHITE, DARK = "#ffffff", "#121212"
"""Backgrounds on which every hue is seen."""


def colours(names: Iterable[str]) -> dict[str, str]:
    """Return a colour for each name in turn, ``#rrggbb``; no two alike up to eight."""
    return {name: HUES[place % len(HUES)] for place, name in enumerate(dict.fromkeys(names))}
