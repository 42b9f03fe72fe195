"""Checks that arguments share. Python counts ``True`` as 1; no argument of an env means it so."""

from __future__ import annotations

import operator
from typing import Any

import numpy as np


def is_flag(value: Any) -> bool:
    """Return whether a value is a truth value, Python's or NumPy's."""
    return isinstance(value, bool | np.bool_)


def whole(value: Any) -> int | None:
    """Return a whole number of any type as an ``int``; ``None`` for anything else, a truth value too."""
    try:
        return None if is_flag(value) else operator.index(value)
    except TypeError:
        return None


def one_line(value: Any) -> str:
    """Return the text of a value in one line of at most 80 characters; that of a long array has several lines."""
    try:
        return " ".join(repr(value).split())[:80]
    except Exception:  # of a number with over 4,300 digits, say
        return f"<{type(value).__name__}>"
