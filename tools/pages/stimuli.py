"""The page of stimuli: each with frames of it, a slice through space and time, and its parameters."""

from __future__ import annotations

import inspect
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from dsnn.stimuli import STIMULI, StimulusEntry
from experiments.bench.report import style
from tools.pages import markdown

SHOWN = 5
"""Frames of a clip in its picture."""


def write(folder: Path) -> None:
    """Write the page and its pictures into ``folder``."""
    parts = []
    for name, entry in STIMULI.items():
        with style.look():
            file = style.save(_drawn(entry), folder / name).name
        documented = [type(entry.params), *([entry.build] if inspect.isclass(entry.build) else [])]
        parts += [
            f"## {name}\n\n{markdown.sentence(entry.summary)}\n",
            markdown.picture(file, f"Five frames of the stimulus {name}, and a slice through space and time",
                             "Five frames from the first that moves to the last. Below, the row through the object's"
                             " first place, one frame below the other."),
            *map(markdown.autodoc, documented),
        ]  # fmt: skip
    markdown.write(
        folder / "index.md",
        "# Stimuli\n",
        "Synthetic clips with their ground truth, here with their default parameters at seed 0.\n"
        "`colias video NAME --out NAME.avi` writes one, `colias watch NAME` shows it to a model,"
        " and `dsnn.stimuli.stimulus(NAME)` makes it in Python.\n"
        "`--set NAME.PARAMETER=VALUE` sets a parameter.\n"
        "An experiment of your own [declares clips of them](../../how-to/experiments-claims-and-arenas.md).\n",
        *parts,
    )


def _drawn(entry: StimulusEntry) -> Figure:
    """Draw a stimulus as its defaults make it."""
    clip = entry.build(entry.params, 0)
    frames = tuple(clip)
    moving = [index for index, frame in enumerate(frames) if frame.truth.motion != "still"] or range(len(frames))
    box = next((frame.truth.box for frame in frames if frame.truth.box is not None), None)
    rows, columns = clip.shape
    row = int(np.clip(box.top + box.height / 2, 0, rows - 1)) if box else rows // 2
    drawn = Figure(figsize=(style.WIDTH, 2.9), layout="constrained")
    axes = drawn.subplot_mosaic([list(range(SHOWN)), ["slice"] * SHOWN])
    for place, index in enumerate(np.linspace(moving[0], moving[-1], SHOWN).round().astype(int)):
        axes[place].imshow(frames[index].luma, cmap="gray", vmin=0, vmax=255)
        axes[place].set(title=f"{index / clip.fps:.2f} s", xticks=[], yticks=[])
    slice_of_rows = np.stack([frame.luma[row] for frame in frames])
    axes["slice"].imshow(slice_of_rows, cmap="gray", vmin=0, vmax=255, aspect="auto",
                         extent=(0, columns, len(frames) / clip.fps, 0))  # fmt: skip
    axes["slice"].set(xlabel="x (px)", ylabel="time (s)")
    return drawn
