"""Times competitors side by side: in rounds, each once a round, so that a slow moment of the machine hits all."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping

import numpy as np
import numpy.typing as npt


def interleaved(work: Mapping[str, Callable[[], int]], rounds: int = 15) -> dict[str, npt.NDArray[np.float64]]:
    """Time each piece of ``work``, which returns its number of frames, once a round.

    Returns for each piece its times, (rounds,), in microseconds per frame. The best round of a piece is
    what the machine can do when nothing else wants it. The median of the ratios of two pieces within each round is one
    that a slow spell leaves alone.
    """
    taken: dict[str, list[float]] = {name: [] for name in work}
    for _ in range(rounds):
        for name, run in work.items():
            began = time.perf_counter()
            frames = run()
            taken[name].append((time.perf_counter() - began) / frames * 1e6)
    return {name: np.array(times) for name, times in taken.items()}


def ratio(one: npt.NDArray[np.float64], other: npt.NDArray[np.float64]) -> float:
    """Compute the median of the ratios of two pieces' times within each round."""
    return float(np.median(one / other))
