"""Origin of the rows of trials: the simulation, or a log that was imported.

Rows of a simulated run have no column `COLUMN`. So every reader asks here, and none guesses from missing values.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

COLUMN = "provenance"
MEASURED = "measured"
"""The robot measured everything: its own network answered."""
FRAMES_MEASURED = "frames measured, network simulated"
"""The robot's camera took the frames; a model of this bench answered to them."""
LOG_OF_SIMULATION = "log of a simulated run"
"""``colias firmware log`` wrote the log: nothing of it was measured."""
FRAMES_OF_SIMULATION = "frames from the log of a simulated run"


def origin(rows: Sequence[Mapping[str, Any]]) -> str:
    """Return where rows come from, in words; empty: they are simulated."""
    return "; ".join(dict.fromkeys(row[COLUMN] for row in rows if row.get(COLUMN)))


def is_imported(row: Mapping[str, Any]) -> bool:
    """Return whether a row is from a log: of the stimulus's speed and path nothing is known then."""
    return bool(row.get(COLUMN))
