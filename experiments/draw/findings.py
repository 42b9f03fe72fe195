"""Titles of figures: what means along an ordered condition show, and no more than their intervals do."""

from collections import Counter
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
import polars as pl

from experiments.draw import style
from experiments.judge.tests import LEAST_FOR_INTERVAL, summarise

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
    table = style.by(rows if rows[along].dtype == pl.String else rows.sort(along), along).agg(column)
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
    return style.title(f"{noun}: {terse}" if " and " in same else f"{noun} {same}", f"{noun} by {along}")


def drawn_of(what: str, n: int) -> str:
    """Name what is drawn without a finding; n, one or two trials of each condition, carries none."""
    return what + {1: ", one trial each", 2: ", two trials each"}.get(n, "")
