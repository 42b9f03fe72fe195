"""Time that commands take which only tell something, from nothing to their end, beside Python and NumPy alone.

``python -m benchmarks.start`` runs these alone.
"""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable, Mapping, Sequence

import numpy as np
from rich.console import Console
from rich.table import Table

from benchmarks.timing import interleaved

ROUNDS = 10
NOTHING, NUMPY = "python -c pass", "import numpy"
COLIAS = ("-m", "experiments.bench.cli")
WORK: Mapping[str, Sequence[str]] = {
    NOTHING: ("-c", "pass"),
    NUMPY: ("-c", "import numpy"),
    "import colias_sim": ("-c", "import colias_sim"),
    "colias --help": (*COLIAS, "--help"),
    "colias list": (*COLIAS, "list"),
    "colias parameters": (*COLIAS, "parameters"),
}
"""Name of what is timed -> the arguments of Python."""
GOALS = {"colias --help": 0.5, "colias list": 1.0}
"""Seconds that a command may take at most."""


def table() -> Table:
    """Whole processes: the best and the median of the rounds in seconds, and the ratios to the two yardsticks."""
    for arguments in WORK.values():
        _run(arguments)  # once before: files come from memory from then on, and modules have their bytecode
    times = interleaved({name: _running(arguments) for name, arguments in WORK.items()}, ROUNDS)
    goals = ", ".join(f"{name} {seconds:g} s" for name, seconds in GOALS.items())
    result = Table(title=f"Start-up, the whole process, {ROUNDS} rounds (goal: {goals})")
    for name in ("process", "best, s", "median, s", "times python", "times NumPy", "goal"):
        result.add_column(name, justify="left" if name == "process" else "right")
    for name in WORK:
        best = times.us(name) / 1e6
        goal = "" if name not in GOALS else "met" if best <= GOALS[name] else "missed"
        ratios = (f"{times.ratio(name, base):.1f}" for base in (NOTHING, NUMPY))
        result.add_row(name, f"{best:.3f}", f"{np.median(times.taken[name]) / 1e6:.3f}", *ratios, goal)
    return result


def _running(arguments: Sequence[str]) -> Callable[[], int]:
    def run() -> int:
        _run(arguments)
        return 1

    return run


def _run(arguments: Sequence[str]) -> None:
    """Run Python as a shell does; with one thread of BLAS, as ``colias`` itself has, and with bytecode kept."""
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    environment["OPENBLAS_NUM_THREADS"] = "1"
    subprocess.run([sys.executable, *arguments], env=environment, stdout=subprocess.DEVNULL, check=True)


if __name__ == "__main__":
    Console().print(table())
