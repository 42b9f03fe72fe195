"""The models from whose potentials excitation and inhibition of HS are put together."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

WHOLE = "dsnn"
BALANCED = "dsnn:w_i=1"
"""The network whose inhibition weighs as much as its excitation."""
EXCITED = ("dsnn-off-blocked:w_i=0", "dsnn-on-blocked:w_i=0")
"""The ON pathway and the OFF pathway, each alone, with excitation alone."""
OPPOSED = ("dsnn-off-blocked:w_i=1", "dsnn-on-blocked:w_i=1")
"""Parts of the network with inhibition of weight 1."""
PARTS = (*EXCITED, *OPPOSED)
NEEDED = (WHOLE, BALANCED, *PARTS)
"""The models that an experiment with this figure declares."""


def without_parts(rows: Sequence[Any]) -> list[Any]:
    """Return the rows of whole networks: `PARTS` are there to be put together, not to be compared."""
    return [row for row in rows if row["model"] not in PARTS]
