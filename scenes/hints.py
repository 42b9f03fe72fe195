"""Suggest a known name for a mistyped one."""

from __future__ import annotations

import difflib
from collections.abc import Iterable

ALIKE = 0.6
"""Least similarity (`difflib.SequenceMatcher.ratio`) for a suggestion; below it suggestions mislead."""


def closest(name: object, known: Iterable[str]) -> str:
    """Find the known name most similar to a name, ignoring case; empty if none is similar."""
    by_lower = {candidate.lower(): candidate for candidate in known}
    matches = difflib.get_close_matches(str(name).lower(), by_lower, n=1, cutoff=ALIKE)
    return by_lower[matches[0]] if matches else ""


def nearest(name: object, known: Iterable[str], before: str = "", after: str = "") -> str:
    """Write a hint with the known name most similar to a name.

    Parameters
    ----------
    name
        What was typed.
    known
        The known names.
    before, after
        Text around the hint, if there is one.

    Returns
    -------
    str
        ``nearest: NAME`` between these texts; empty if no known name is similar.
    """
    match = closest(name, known)
    return f"{before}nearest: {match}{after}" if match else ""
