"""Times competitors side by side: in rounds, each once a round, so that a slow moment of the machine hits all."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping


def interleaved(work: Mapping[str, Callable[[], int]], rounds: int = 15) -> dict[str, float]:
    """Microseconds per frame of each piece of ``work``, which returns its number of frames: the best round."""
    taken: dict[str, list[float]] = {name: [] for name in work}
    for _ in range(rounds):
        for name, run in work.items():
            began = time.perf_counter()
            frames = run()
            taken[name].append((time.perf_counter() - began) / frames * 1e6)
    return {name: min(times) for name, times in taken.items()}
