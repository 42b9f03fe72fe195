"""The known name that a mistyped one may have been meant for."""

from __future__ import annotations

import difflib
from collections.abc import Iterable

ALIKE = 0.6
"""Likeness (`difflib.SequenceMatcher.ratio`) from which a name is taken for a mistyped one: below it hints mislead."""


def closest(name: object, known: Iterable[str]) -> str:
    """Find the known name that is most like one, whatever the case; empty where none is alike."""
    by_lower = {candidate.lower(): candidate for candidate in known}
    matches = difflib.get_close_matches(str(name).lower(), by_lower, n=1, cutoff=ALIKE)
    return by_lower[matches[0]] if matches else ""


def nearest(name: object, known: Iterable[str], before: str = "", after: str = "") -> str:
    """Say which known name is most like one.

    Parameters
    ----------
    name
        What was typed.
    known
        The names that there are.
    before, after
        Text around the hint, where there is one.

    Returns
    -------
    str
        ``nearest: NAME`` between these texts; empty where no known name is alike.
    """
    match = closest(name, known)
    return f"{before}nearest: {match}{after}" if match else ""
