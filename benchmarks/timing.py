"""Times competitors side by side: in rounds, each once a round, so that a slow moment of the machine hits all."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt


@dataclass(frozen=True, slots=True)
class Rounds:
    """Microseconds per frame of each competitor in each round."""

    taken: Mapping[str, npt.NDArray[np.float64]]

    def us(self, name: str) -> float:
        """The best round: what the machine can do when nothing else wants it."""
        return float(self.taken[name].min())

    def ratio(self, name: str, base: str) -> float:
        """Tell how many times ``base``: the median of the ratios within each round, which a slow spell leaves alone."""
        return float(np.median(self.taken[name] / self.taken[base]))


def interleaved(work: Mapping[str, Callable[[], int]], rounds: int = 15) -> Rounds:
    """Time each piece of ``work``, which returns its number of frames, once a round."""
    taken: dict[str, list[float]] = {name: [] for name in work}
    for _ in range(rounds):
        for name, run in work.items():
            began = time.perf_counter()
            frames = run()
            taken[name].append((time.perf_counter() - began) / frames * 1e6)
    return Rounds({name: np.array(times) for name, times in taken.items()})
