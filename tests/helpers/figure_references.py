"""Small pictures of figures, to tell when one has changed: grey cells, coarse enough for another release of matplotlib.

``python -m tests.helpers.figure_references`` draws all figures of `figure_list` anew and stores them, which is to be
done after their change was looked at.
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import numpy.typing as npt
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from PIL import Image
from PIL.PngImagePlugin import PngInfo

STORED = Path(__file__).parent / "figure_references.png"
"""All pictures below each other, and in the file's text the name and the height of each."""
ACROSS, STEP = 32, 4
"""Cells in a row, and the step of the stored grey levels, of 256."""
MOST_MEAN, MOST_CELL = 2.0, 24.0
"""Largest difference, in grey levels: of all cells in the mean, and of one cell. Type that is 2 % larger stays below
half of both."""

Cells = npt.NDArray[np.float64]


def cells(figure: Figure) -> Cells:
    """Return a figure's grey levels, (R, `ACROSS`), from 0 (black) to 255."""
    figure.set_dpi(72)
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    picture = Image.fromarray(np.asarray(canvas.buffer_rgba())).convert("RGB").convert("L")
    down = max(round(ACROSS * picture.height / picture.width), 1)
    small = picture.resize((ACROSS, down), Image.Resampling.BOX)
    return np.asarray(small, np.float64)


def differences(drawn: Cells, stored: Cells) -> str:
    """Say in words how a picture differs from the stored one; empty where it does not."""
    if drawn.shape != stored.shape:
        return f"{drawn.shape} cells, {stored.shape} stored"
    apart = np.abs(drawn - stored)
    if apart.mean() <= MOST_MEAN and apart.max() <= MOST_CELL:
        return ""
    row, column = np.unravel_index(int(apart.argmax()), apart.shape)
    return f"{apart.mean():.2f} grey levels in the mean, {apart.max():.1f} at row {row}, column {column}"


def load() -> dict[str, Cells]:
    """Return the stored pictures, by the figure's name."""
    with Image.open(STORED) as image:
        heights = json.loads(image.info["heights"])
        rows = np.asarray(image.convert("L"), np.float64)
    ends = np.cumsum(list(heights.values()))
    return dict(zip(heights, np.split(rows, ends[:-1]), strict=True))


def store(pictures: dict[str, Cells]) -> None:
    """Write pictures into one file of a few kB."""
    rows = np.round(np.vstack(list(pictures.values())) / STEP) * STEP
    text = PngInfo()
    text.add_text("heights", json.dumps({name: len(picture) for name, picture in pictures.items()}))
    Image.fromarray(np.clip(rows, 0, 255).astype(np.uint8)).save(STORED, optimize=True, pnginfo=text)


if __name__ == "__main__":
    from tests.helpers.figure_list import FIGURES
    from tests.helpers.figure_rows import MODELS_SHOWN

    store({name: cells(draw(MODELS_SHOWN["one"])) for name, draw in FIGURES.items()})
