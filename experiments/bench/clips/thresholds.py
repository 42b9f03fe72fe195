"""Lines at thresholds, told apart where models differ in theirs, and their keys in words."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from experiments.bench.figures.palette import marks
from experiments.bench.figures.plotting import plain, wrapped

Thresholds = Mapping[str, float | None]
STYLES: tuple[Any, ...] = ("--", "-.", (0, (8, 2)), (0, (3, 1, 1, 1, 1, 1)), (0, (8, 2, 1, 2, 1, 2)))
"""Styles of lines, one for each threshold: none is that of HS, "-", or that of VS, ":"."""
MOST_NAMED = 3
"""Models that a key names."""
KEY_INCHES = 2.2
"""Width of a key's words."""


def owners(thresholds: Thresholds, models: Sequence[str]) -> dict[float, list[str]]:
    """Return the ``models`` with each threshold, the lowest first; those that do not spike are left out."""
    levels = {model: level for model in models if (level := thresholds.get(model)) is not None}
    return {level: [model for model in levels if levels[model] == level] for level in sorted(set(levels.values()))}


def looks(
    thresholds: Thresholds, models: Sequence[str], figure_models: Sequence[str] = ()
) -> dict[float, dict[str, Any]]:
    """Return how the line at each threshold is drawn: of several in its model's colour, where that is but one.

    ``figure_models`` are the models of the whole figure, where ``models`` are some of them.
    """
    by_level, given = owners(thresholds, models), marks(figure_models or models)
    return {
        level: {
            "color": given[names[0]].colour if len(names) == 1 < len(models) and len(by_level) > 1 else "black",
            "ls": STYLES[place % len(STYLES)],
            "lw": 1.0 if len(names) == 1 < len(models) else 0.8,
        }
        for place, (level, names) in enumerate(by_level.items())
    }


def draw(
    axes: Axes,
    thresholds: Thresholds,
    models: Sequence[str],
    figure_models: Sequence[str] = (),
    *,
    signed: bool = False,
) -> None:
    """Draw the thresholds of ``models``, some of ``figure_models``; of either sign where potentials are ``signed``."""
    for level, look in looks(thresholds, models, figure_models).items():
        for sign in (1, -1) if signed else (1,):
            axes.axhline(sign * level, **look)


def keys(
    thresholds: Thresholds, models: Sequence[str], figure_models: Sequence[str] = (), *, sign: str = ""
) -> list[Line2D]:
    """Return a key for each threshold of panels that have several models: its value, and which models have it.

    Before the value stands the ``sign``: "±" where the lines of both signs are drawn.
    """
    drawn, several = looks(thresholds, models, figure_models), len(models) > 1
    words = {
        level: f"threshold {sign}{level:g}{_of(names) if several else ''}"
        for level, names in owners(thresholds, models).items()
    }
    return [Line2D([], [], label=_wrapped(text), **drawn[level]) for level, text in words.items()]


def key_of_panels(thresholds: Thresholds, models: Sequence[str]) -> list[Line2D]:
    """Return the one key of panels of a model each: they have a line each, in the same style."""
    by_level = owners(thresholds, models)
    if not by_level:
        return []
    if len(models) == 1:
        return keys(thresholds, models)
    words = "; ".join(f"{level:g}{_of(names)}" for level, names in by_level.items())
    look = {"color": "black", "ls": STYLES[0], "lw": 0.8}
    return [Line2D([], [], label=_wrapped(f"threshold of the panel's model: {words}"), **look)]


def _of(names: Sequence[str]) -> str:
    """Name the first models, and count the others."""
    more = len(names) - MOST_NAMED
    return " of " + ", ".join(names[:MOST_NAMED]) + (f" and {more} more" if more > 0 else "")


def _wrapped(words: str) -> str:
    return plain(wrapped(words, KEY_INCHES, 8))
