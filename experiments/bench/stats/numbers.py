"""Test of a table's values: whether they are numbers that a claim can be judged by."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any


def is_number(value: Any) -> bool:
    """Return whether a table's value is a finite number; ``None``, NaN and infinities are not."""
    return value is not None and math.isfinite(value)


def unreadable(rows: Iterable[Mapping[str, Any]], columns: Sequence[str]) -> str:
    """Return how many of the rows lack a number in which of the ``columns``, in words; empty if none does."""
    listed = list(rows)
    counts = {name: sum(not is_number(row[name]) for row in listed) for name in columns}
    return "; ".join(f"{count} of {len(listed)} have no number in {name}" for name, count in counts.items() if count)
