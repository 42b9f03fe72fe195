"""Truth values where a number is expected. Python counts ``True`` as 1; no argument of an env means it so."""

from __future__ import annotations

from typing import Any

import numpy as np


def is_flag(value: Any) -> bool:
    """Return whether a value is a truth value, Python's or NumPy's."""
    return isinstance(value, bool | np.bool_)
