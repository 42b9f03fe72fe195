"""The page of stimuli: each with frames of it, a slice through space and time, and its parameters."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from dsnn.stimuli import STIMULI, StimulusEntry
from experiments.draw import style
from tools.pages import markdown

SHOWN = 5
"""Frames of a clip in its picture."""


def write(folder: Path) -> None:
    """Write the page and its pictures into ``folder``."""
    parts = []
    for name, entry in STIMULI.items():
        with style.look():
            _drawn(entry).savefig(folder / f"{name}.png", dpi=markdown.DPI)
        parts += [
            f"## {name}\n\n{markdown.sentence(entry.summary)}\n",
            markdown.picture(f"{name}.png", f"Five frames of the stimulus {name}, and a slice through space and time",
                             "Five frames from the first that moves to the last. Below, the middle row, one frame below"
                             " the other."),
            *map(markdown.autodoc, (type(entry.params), entry.build)),
        ]  # fmt: skip
    markdown.write(
        folder / "index.md",
        "# Stimuli\n",
        "Synthetic clips with their ground truth, here with their default parameters at seed 0.\n"
        "`colias watch NAME` shows one to a model,"
        " and `dsnn.stimuli.stimulus(NAME)` makes it in Python.\n"
        "`--set NAME.PARAMETER=VALUE` sets a parameter.\n"
        "An experiment of your own [declares clips of them](../../how-to/experiments-claims-and-arenas.md).\n",
        *parts,
    )


def _drawn(entry: StimulusEntry) -> Figure:
    """Draw a stimulus as its defaults make it."""
    clip = entry.build(entry.params, 0)
    frames, (rows, columns) = tuple(clip), clip.shape
    moving = [index for index, frame in enumerate(frames) if frame.truth.motion != "still"] or range(len(frames))
    drawn = Figure(figsize=(style.WIDTH, 2.9), layout="constrained")
    axes = drawn.subplot_mosaic([list(range(SHOWN)), ["slice"] * SHOWN])
    for place, index in enumerate(np.linspace(moving[0], moving[-1], SHOWN).round().astype(int)):
        axes[place].imshow(frames[index].luma, cmap="gray", vmin=0, vmax=255)
        axes[place].set(title=f"{index / clip.fps:.2f} s", xticks=[], yticks=[])
    middle, extent = np.stack([frame.luma[rows // 2] for frame in frames]), (0, columns, len(frames) / clip.fps, 0)
    axes["slice"].imshow(middle, cmap="gray", vmin=0, vmax=255, aspect="auto", extent=extent)
    axes["slice"].set(xlabel="x (px)", ylabel="time (s)")
    return drawn
