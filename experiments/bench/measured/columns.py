"""The columns of a robot's log, and their legal values. docs/back-from-the-robot.md is their documentation."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping

from experiments.bench.sources.conditions import CONDITION_COLUMNS

INDEX = ("trial", "model", "seed", "origin")
TIME = "time_s"
CHANNELS: Mapping[str, str] = {"hs": "hs_spikes", "vs": "vs_spikes", "looming": "looming_spikes", "azimuth": ""}
"""Channel -> its column of spikes; the azimuth has none."""
POTENTIALS: Mapping[str, tuple[float, float]] = {
    "hs": (-1.0, 1.0), "vs": (-1.0, 1.0), "looming": (0.0, 1.0), "azimuth": (-1.0, 1.0)
}  # fmt: skip
"""Channel -> the range of its potential."""
POSES = (
    "stimulus_bearing_deg", "stimulus_x_cm", "stimulus_y_cm", "stimulus_heading_deg", "observer_x_cm",
    "observer_y_cm", "observer_heading_deg",
)  # fmt: skip
"""Columns that a tracker over the arena may add; all of them or none."""
FARTHEST = 1e4
"""cm and degrees of a pose; one beyond it is a damaged line."""
ANSWERS = tuple(name for channel, spikes in CHANNELS.items() for name in (channel, spikes) if name)
KNOWN = (*INDEX, *CONDITION_COLUMNS, TIME, *ANSWERS, *POSES)
"""All columns, in the order in which a log is written."""
WHOLE = frozenset({"trial", "seed", *(spikes for spikes in CHANNELS.values() if spikes)})
ROBOT, SIMULATION = "robot", "simulation"
"""Values that ``origin`` may have; blank is ``robot``. ``colias export --to log`` writes ``simulation``."""
TEXTS = frozenset({"model", "origin", "motion", "direction"})
SPELT = {True: re.compile(r"[+-]?[0-9]+"), False: re.compile(r"[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?")}
"""Spelling in a cell of a whole number, and any. Python alone would take 1_0 for 10, and the digits of every script."""
LONGEST = 400
"""Characters of a number."""
EXAMPLES = {True: "12", False: "-0.25 or 2.5e-1"}
MOST_SPIKES = 1000
"""Spikes of one frame; a count beyond it is a damaged line."""


def parse(name: str, text: str) -> str | int | float | None:
    """Return the value of a cell.

    Parameters
    ----------
    name
        Its column, one of `KNOWN`.
    text
        The cell; blank is ``None``.

    Raises
    ------
    ValueError
        In words, what is wrong with it and what is legal.
    """
    text = text.strip()
    if not text:
        return None
    if name == "origin" and text not in (ROBOT, SIMULATION):
        raise ValueError(f"origin={text[:40]!r}: legal is {ROBOT}, {SIMULATION}")
    if name in TEXTS:
        return text
    whole = name in WHOLE
    kind = "a whole number" if whole else "a number"
    if not SPELT[whole].fullmatch(text) or len(text) > LONGEST:
        raise ValueError(f"{name}={text[:40]!r}: legal is {kind} in digits, as {EXAMPLES[whole]}")
    value: int | float = int(text) if whole else float(text)
    if not math.isfinite(value):
        raise ValueError(f"{name}={text[:40]!r}: legal is a number that is not too large")
    low, high = _range(name)
    if not low <= value <= high:
        raise ValueError(f"{name}={text[:40]}: legal is {kind} from {low:g} to {high:g}")
    return value


def _range(name: str) -> tuple[float, float]:
    if name in POTENTIALS:
        return POTENTIALS[name]
    for channel, spikes in CHANNELS.items():
        if name == spikes:
            return MOST_SPIKES * POTENTIALS[channel][0], MOST_SPIKES
    if name in POSES:
        return -FARTHEST, FARTHEST
    return (0, 2**53) if name in ("trial", "seed", TIME) else (-math.inf, math.inf)
