"""Marks that tell the models of a picture apart: a colour and a marker for each.

The eight hues were found by a search for colours that stay apart in normal vision and under simulated deuteranopia and
protanopia (Machado, Oliveira and Fernandes 2009), and that have a contrast of at least 3:1 both on white and on
`DARK` (WCAG 2.1, 1.4.11); `tests/bench/figures/test_palette.py` holds them to it. One palette serves light and dark
pages. More models than hues share hues and differ in their markers. Line styles tell HS from VS, and one condition
from another; they never tell models apart. Grey is of baselines alone.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

HUES: tuple[str, ...] = (
    "#3848f8", "#f86010", "#00a868", "#a810b8", "#f840c0", "#985000", "#207070", "#1098f8",
)  # fmt: skip
GREYS: tuple[str, ...] = ("#808080",)
"""Colour of models that a picture shows for comparison alone."""
MOST_LINES = len(HUES)
"""Series of one picture that have a hue each; more share hues and differ in their markers."""
WHITE, DARK = "#ffffff", "#121212"
"""Backgrounds on which every hue and grey is seen."""
MARKERS = ("o", "s", "^", "D", "v", "P", "X", "*")
BASELINES = ("flow",)
"""Models that are drawn in grey."""
NAMED = (
    "dsnn", "dsn2017", "emd", "lgmd1", "lgmd2", "hybrid", "dsnn-on-blocked", "dsnn-off-blocked", "dsnn-reference",
    "t4t5", "lplc2", "mlplc2", "lplc2-gf", "si-lgmd1", "si-lgmd2", "pon-lgmd", "dsnn-onboard",
    "emd-normalised", "three-arm", "three-arm-4q",
)  # fmt: skip
"""Models that have a mark of their own, which they have in every picture but as `marks` says."""


@dataclass(frozen=True, slots=True)
class Mark:
    """Colour and marker of a series.

    Parameters
    ----------
    colour
        As ``#rrggbb``.
    marker
        As matplotlib has it.
    """

    colour: str
    marker: str


def marks(names: Iterable[str]) -> dict[str, Mark]:
    """Return a mark for each name, no two alike while there are free ones. Up to `MOST_LINES` series have a hue each.

    Parameters
    ----------
    names
        Labels of models. One of `NAMED` has its own mark in every picture; where few
        models are shown and its hue is another's, it takes a free hue and keeps its marker. Other names are next in
        line, in their order.

    Returns
    -------
    dict of str to Mark
        In the order of ``names``.
    """
    listed = list(dict.fromkeys(names))
    grey = [name for name in listed if name in BASELINES]
    coloured = [name for name in listed if name not in grey]
    known = sorted((name for name in coloured if name in NAMED), key=NAMED.index)
    given: dict[str, Mark] = {}
    for name in [*known, *(name for name in coloured if name not in known)]:
        given[name] = _next(_home(name), list(given.values()), apart=len(coloured) <= MOST_LINES)
    for place, name in enumerate(grey):
        turn, marker = divmod(place, len(MARKERS))
        given[name] = Mark(GREYS[turn % len(GREYS)], MARKERS[marker])
    return {name: given[name] for name in listed}


def _home(name: str) -> Mark | None:
    """Return the mark of one of `NAMED`. After one round of hues that of `dsnn`, which all are compared with, is left
    out.
    """
    if name not in NAMED:
        return None
    place = NAMED.index(name)
    if place < len(HUES):
        return Mark(HUES[place], MARKERS[place % len(MARKERS)])
    turn, hue = divmod(place - len(HUES), len(HUES) - 1)
    return Mark(HUES[hue + 1], MARKERS[(hue + turn + 2) % len(MARKERS)])


def _next(home: Mark | None, given: Sequence[Mark], *, apart: bool) -> Mark:
    """Return the mark of a model beside those ``given``; where hues are kept ``apart``, of a hue that none has."""
    used = [mark.colour for mark in given]
    if home is not None and not (apart and home.colour in used):
        return home
    first = HUES.index(home.colour) if home else 0
    colour = min(HUES, key=lambda hue: (used.count(hue), (HUES.index(hue) - first) % len(HUES)))
    if home is not None:
        return Mark(colour, home.marker)
    start = HUES.index(colour) % len(MARKERS)
    markers = [*MARKERS[start:], *MARKERS[:start]]
    elsewhere, here = {mark.marker for mark in given}, {mark.marker for mark in given if mark.colour == colour}
    # Nor that of a model that ships, for which it would be taken beside another picture.
    shipped = {mark.marker for mark in map(_home, NAMED) if mark is not None and mark.colour == colour}
    free = [marker for marker in markers if marker not in elsewhere | shipped] if apart else []
    left = [marker for marker in markers if marker not in here]
    return Mark(colour, [*free, *(marker for marker in left if marker not in shipped), *left, *markers][0])


def colours(names: Iterable[str]) -> dict[str, str]:
    """Return the colour of each name's mark, for figures with a panel or a row for each."""
    return {name: mark.colour for name, mark in marks(names).items()}
