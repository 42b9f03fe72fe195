"""Where the rows of trials come from: the simulation, or a real robot whose log was imported.

Rows of a simulated run have no column `COLUMN`. So every reader asks here, and none guesses from missing values.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from experiments.bench.core.claims.numbers import is_number
from experiments.bench.core.store.rows import group
from experiments.bench.robot.experiment import CONDITION_COLUMNS, Drawing

COLUMN = "provenance"
MEASURED = "measured"
"""The robot measured everything: its own network answered."""
FRAMES_MEASURED = "frames measured, network simulated"
"""The robot's camera took the frames; a model of this bench answered to them."""

Rows = Sequence[Mapping[str, Any]]

DRAWN: Mapping[Drawing, tuple[str, ...]] = {
    "mechanism": ("seconds_in_view", "rate_in_view_hz", "mean_hs_near_axis"),
    "excitation": (),
    "spikes": (),
}
"""Figure -> the columns that it cannot do without."""


def origin(rows: Rows) -> str:
    """Return where rows come from, in words; empty: they are simulated."""
    return "; ".join(dict.fromkeys(row[COLUMN] for row in rows if row.get(COLUMN)))


def is_measured(row: Mapping[str, Any]) -> bool:
    """Return whether a real robot's camera took the frames of a row."""
    return bool(row.get(COLUMN))


def is_tracked(row: Mapping[str, Any]) -> bool:
    """Return whether the poses of the robots are known in a row's frames: of a real robot only from a tracker."""
    return not is_measured(row) or is_number(row["closest_cm"])


def repeats_said(rows: Rows) -> str:
    """Return how many trials each condition has: ``10``, or ``8..10`` where they differ."""
    counts = {len(own) for own in group(rows, "model", *CONDITION_COLUMNS).values()}
    return "..".join(str(count) for count in sorted({min(counts), max(counts)})) if counts else "0"


def caption(name: str, arena: str, repeats: int, rows: Rows) -> tuple[str, str, str]:
    """Return what a figure's title says of a run.

    Parameters
    ----------
    name, arena, repeats
        Of the run, as it was planned.
    rows
        Of its ``trials.parquet``.

    Returns
    -------
    tuple of str
        The name, with the origin of measured rows; the arena, empty where the trials were not simulated; and n.
    """
    said = origin(rows)
    return (f"{name} ({said})", "", repeats_said(rows)) if said else (name, arena, str(repeats))


def drawable(figure: Drawing, rows: Rows) -> Drawing:
    """Return ``figure``, or ``spikes`` where measured rows have no number in a column that it draws."""
    lacking = any(not is_number(row.get(name)) for row in rows if is_measured(row) for name in DRAWN[figure])
    return "spikes" if lacking else figure
