"""The table of claims over eyes and drives as a picture."""

from __future__ import annotations

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from experiments.bench.figures.plotting import STYLE
from experiments.bench.reproduction.eye import fidelity
from experiments.bench.reproduction.eye.fidelity import CELLS, Fidelity


def draw(table: Fidelity) -> Figure:
    """Draw in how many replicates each claim held in each cell; a ``v`` marks cells where it is vacuous in some."""
    held = np.array([[table.counted(cell, claim) / table.replicates for claim in fidelity.CLAIMS] for cell in CELLS])
    with mpl.rc_context(STYLE):
        drawn = Figure(figsize=(8.4, 2.6), layout="constrained")
        axes = drawn.subplots()
        axes.imshow(held, cmap="Blues", vmin=0.0, vmax=1.15, aspect="auto")
        for row, cell in enumerate(CELLS):
            for column, claim in enumerate(fidelity.CLAIMS):
                vacuous = "v" if table.counted(cell, claim, "vacuous") else ""
                axes.text(column, row, f"{table.counted(cell, claim)}{vacuous}", ha="center", va="center",
                          color="white" if held[row, column] > 0.6 else "black")  # fmt: skip
        axes.set_xticks(range(len(fidelity.CLAIMS)), fidelity.CLAIMS)
        axes.set_yticks(range(len(CELLS)), [cell.name for cell in CELLS])
        axes.tick_params(length=0)
        counted = f"replicates of {table.replicates} in which a claim held (v: vacuous in some)"
        design = f"{table.repeats} repeats each, from seed {table.seed}"
        drawn.suptitle(f"{counted}; {design}", fontsize=9, x=0.01, ha="left")
    return drawn
