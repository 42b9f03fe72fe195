"""Encode a delayed signal D in 8 bits: linearly, or companded in segments whose step doubles."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

Ints = npt.NDArray[np.int64]

MANTISSA = 5
"""Bits of a companded code within its segment: steps are 1/32 to 1/64 of the value."""
UNIT = 3
"""The two lowest segments have steps of 2 to the power 3 units of F; all 256 codes reach 2 to the power 15."""
LINEAR = 7
"""A linear code counts steps of 2 to the power 7 units of F."""
EXTRA = 15
"""Fractional bits of D beyond those of F before it is coded."""


def decoded(codes: Ints, companding: bool) -> Ints:
    """Decode ``codes``, 0..255, to D in units of F."""
    if not companding:
        return codes << LINEAR
    segment = np.maximum((codes >> MANTISSA) - 1, 0)
    values: Ints = (codes - (segment << MANTISSA)) << segment << UNIT
    return values


def coded(values: Ints, companding: bool, truncate: bool) -> Ints:
    """Find the code nearest to D, or the next below. ``values`` are D, 0 or more, with `EXTRA` more fractional bits."""
    if companding:
        lowest = EXTRA + UNIT
        length = np.frexp((values >> lowest).astype(np.float64))[1].astype(np.int64)  # bits of a whole number
        segment = np.maximum(length - MANTISSA - 1, 0)
    else:
        lowest, segment = EXTRA + LINEAR, np.zeros_like(values)
    bias = 0 if truncate else (1 << (lowest + segment - 1)) - 1
    codes: Ints = (segment << MANTISSA) + ((values + bias) >> (lowest + segment))
    return codes
