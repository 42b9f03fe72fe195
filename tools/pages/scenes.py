"""Scenes, for docs/reference/api/stimuli.md: their picture and the table of their statistics."""

from __future__ import annotations

import statistics
from pathlib import Path

from matplotlib.figure import Figure

from dsnn.stimuli import SCENES, contrasts, scene, spectrum_slope, stimulus
from experiments.draw import style
from tools.pages import markdown

SHAPE, SEEDS = (180, 540), range(1, 9)
"""Rows and columns, and the seeds that the table is of; the picture shows the first."""


def write(folder: Path) -> None:
    """Write picture and table into ``folder``."""
    photograph = stimulus("cluttered", object="absent", start=0.0)[0].luma
    pictures = {"photograph": [photograph]} | {kind: [scene(kind, SHAPE, seed) for seed in SEEDS] for kind in SCENES}
    rows = []
    with style.look():
        drawn = Figure(figsize=(style.WIDTH / 2, 7.5), layout="constrained")
        for (kind, made), axes in zip(pictures.items(), drawn.subplots(len(pictures)), strict=True):
            columns = zip(*((spectrum_slope(one), *contrasts(one).values()) for one in made), strict=True)
            rows.append((f"`{kind}`", *(f"{statistics.median_low(column):.2f}" for column in columns)))
            axes.imshow(made[0], cmap="gray", vmin=0, vmax=255)
            axes.set(title=kind, xticks=[], yticks=[])
        drawn.savefig(folder / "scenes.png", dpi=markdown.DPI)
    heads = ("Scene", "Slope", "RMS", "Log RMS", "Michelson", "Local range")
    markdown.write(folder / "table.md", markdown.table(heads, rows))
