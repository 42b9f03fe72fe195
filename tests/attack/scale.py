"""How much of the attack to make: a part in some minutes, or with ``COLIAS_ATTACK_FULL=1`` all of it."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import TypeVar

Case = TypeVar("Case")

FULL = "COLIAS_ATTACK_FULL" in os.environ


def some(cases: Sequence[Case], count: int) -> list[Case]:
    """``count`` of the cases, evenly spread; all of them in the full attack."""
    if FULL or len(cases) <= count:
        return list(cases)
    return [cases[i * len(cases) // count] for i in range(count)]
