"""Motion outward from a centre, summed over the four quadrants about it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from dsnn.retina import Floats


def by_quadrant(
    x: Sequence[Floats], y: Sequence[Floats], rows: npt.NDArray[np.float64], columns: npt.NDArray[np.float64]
) -> npt.NDArray[np.float64]:
    """Return the sums over the quadrants, in a fixed order of additions.

    Parameters
    ----------
    x, y
        What counts as outward to the left and to the right; upward and downward. Each two of (R, C).
    rows, columns
        The share of each row in the upper and in the lower half, (2, R); of each column in the left and right, (2, C).

    Returns
    -------
    numpy.ndarray
        (2, 2): upper and lower, left and right.
    """
    along_x = [((rows[:, :, np.newaxis] * factor).sum(axis=1) * half).sum(axis=1)
               for factor, half in zip(x, columns, strict=True)]  # fmt: skip
    along_y = [((half[:, np.newaxis] * factor).sum(axis=0) * columns).sum(axis=1)
               for factor, half in zip(y, rows, strict=True)]  # fmt: skip
    return np.asarray(np.stack(along_x, axis=1) + np.stack(along_y))
