"""The page of scenes: how each is made, what they look like, their spectra and contrasts beside published ones."""

from __future__ import annotations

import statistics
from collections.abc import Mapping
from pathlib import Path

import matplotlib as mpl
import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from dsnn.stimuli import SCENES, Contrasts, amplitude_spectrum, contrasts, scene, spectrum_slope, stimulus
from experiments.bench.report.style import LOOK
from tools.pages import docstring_text, drawing, markdown
from tools.pages.drawing import INCHES, SIZE
from tools.pages.markdown import code, table

SHAPE = (180, 540)
SEEDS = tuple(range(1, 9))
"""Seeds that the table is of; the picture shows the first."""
PHOTOGRAPH = "photograph"
COLOURS = ("#222222", "#0077bb", "#ee7733", "#009988", "#cc3311")
GAP, SPECTRUM_HIGH = 0.22, 2.6
"""Inches from a scene in the picture to the next, and of the spectra."""
TICKS = (0.02, 0.05, 0.1, 0.2, 0.4)
PUBLISHED = (
    (
        "slope of the amplitude spectrum",
        "-1.2 on the average of 135 photographs of natural scenes, -0.8 to -1.5 of single ones",
        "Tolhurst, Tadmor and Chao 1992, Ophthalmic Physiol. Opt. 12:229",
    ),
    ("the same", "about -1", "Field 1987, J. Opt. Soc. Am. A 4:2379"),
    (
        "the same",
        "-0.9: the power of images of the woods falls as 1 / f to the power 1.81",
        "Ruderman and Bialek 1994, Phys. Rev. Lett. 73:814",
    ),
    (
        "95 % range of local RMS contrast in an image",
        "somewhat more than a factor of 10, in calibrated 12-bit images",
        "Frazor and Geisler 2006, Vision Res. 46:1585",
    ),
)
"""Quantity, what is published of natural images, and where."""


def write(folder: Path) -> None:
    """Write the page and its picture into ``folder``."""
    pictures = {PHOTOGRAPH: _photograph(), **{kind: scene(kind, SHAPE, SEEDS[0]) for kind in SCENES}}
    draw(pictures, folder / "scenes.png")
    caption = (
        "The photograph, and a scene of each kind at seed 1. Below, their amplitude spectra, averaged over"
        " orientations. Grey: slopes from -0.8 to -1.5. Dotted: white noise with the photograph's contrast."
    )
    markdown.write(
        folder / "index.md",
        "# Scenes\n",
        "What is behind the object of [`cluttered`](../stimuli/cluttered.md).\n"
        "Replicate 0 of an experiment has the photograph. Replicates from 1 on go through the kinds below, each made by"
        " the replicate's seed.\n"
        "[Footage](../../how-to/footage-and-stimuli.md#choose-the-background) uses them, or your pictures.\n",
        "`dsnn.stimuli.scene(KIND, SHAPE, SEED)` makes one. It repeats along x without a seam.\n",
        markdown.picture("scenes.png", "A photograph and four scenes, and their amplitude spectra", caption),
        "## How each is made\n",
        *(f"**{code(kind)}**: {text}\n" for kind, make in SCENES.items()
          for text in [" ".join(docstring_text.paragraphs(make))]),
        "## Their statistics\n",
        f"Of scenes of {SHAPE[1]}x{SHAPE[0]} px at {len(SEEDS)} seeds: the median, and the least and the largest."
        " The slope is fitted from 0.02 to 0.4 cycles/px.\n",
        _statistics(),
        "RMS is the standard deviation of grey levels over their mean, log RMS the standard deviation of ln(grey)."
        " Michelson is (H - L) / (H + L) of the 99th and the 1st percentile, H and L."
        " The local range is the 97.5th percentile of RMS contrast in patches of 32 px over the 2.5th."
        " The Weber contrast of a black object, grey 0, is -1 before any of them.\n",
        "## What is published of natural images\n",
        table(("Quantity", "Natural images", "Source"), PUBLISHED),
        "Every slope of the table above lies within the range of photographs; white noise has 0.\n"
        "The contrasts are of 8-bit luma, which a camera has compressed, and those that are published are mostly of"
        " calibrated luminance. So they are not held against each other number by number: the scenes are near the"
        " photograph, by choice.\n"
        "The local range of noise and leaves is below natural images, as no region of them lies in shade. For"
        " dead leaves it is infinite (inf) where a disc fills the flattest patches.\n"
        "The exponent 3 of dead leaves is from Lee, Mumford and Huang 2001 (Int. J. Comput. Vision 41:35), the one"
        " that makes a picture alike at every scale. Sizes and greys of leaves and houses are assumptions.\n",
    )  # fmt: skip


def draw(pictures: Mapping[str, npt.NDArray[np.uint8]], path: Path) -> None:
    """Draw pictures one below another, and their spectra below them."""
    wide = INCHES - 0.04
    high = wide * SHAPE[0] / SHAPE[1]
    with mpl.rc_context(LOOK):
        drawn = Figure(figsize=(INCHES, len(pictures) * (high + GAP) + SPECTRUM_HIGH + 0.62))
        for number, (kind, picture) in enumerate(pictures.items()):
            axes = drawing.place(drawn, 0.02, GAP + number * (high + GAP), wide, high)
            drawing.show_frame(axes, picture, f"{kind}, slope {spectrum_slope(picture):.2f}")
        below = len(pictures) * (high + GAP) + GAP
        _spectra(drawing.place(drawn, 0.62, below, INCHES - 0.72, SPECTRUM_HIGH - 0.1), pictures)
        drawing.save(drawn, path)


def _spectra(axes: Axes, pictures: Mapping[str, npt.NDArray[np.uint8]]) -> None:
    for (kind, picture), colour in zip(pictures.items(), COLOURS, strict=True):
        axes.loglog(*amplitude_spectrum(picture), color=colour, lw=1.4, label=kind)
    first = next(iter(pictures.values()))
    frequencies, amplitudes = amplitude_spectrum(first)
    white = np.random.default_rng(0).normal(first.mean(), first.std(), first.shape)
    noise = amplitude_spectrum(np.clip(np.rint(white), 0, 255).astype(np.uint8))
    axes.loglog(*noise, color="#666666", lw=1.2, ls=":", label="white noise")
    middle = len(frequencies) // 2
    low, high = (amplitudes[middle] * (frequencies / frequencies[middle]) ** slope for slope in (-0.8, -1.5))
    axes.fill_between(frequencies, low, high, color="#dddddd", lw=0, zorder=0)
    axes.set_xticks(TICKS, [f"{tick:g}" for tick in TICKS])
    axes.set_xticks([], minor=True)
    axes.set_xlabel("spatial frequency (cycles/px)", fontsize=SIZE)
    axes.set_ylabel("amplitude (grey levels)", fontsize=SIZE)
    axes.tick_params(labelsize=SIZE)
    axes.legend(fontsize=SIZE - 1, frameon=False, loc="lower left")


def _photograph() -> npt.NDArray[np.uint8]:
    return stimulus("cluttered", object="absent", start=0.0)[0].luma


def _statistics() -> str:
    rows = [(code(PHOTOGRAPH), *_measured([_photograph()]))]
    rows += [(code(kind), *_measured([scene(kind, SHAPE, seed) for seed in SEEDS])) for kind in SCENES]
    return table(("Scene", "Slope", "RMS", "Log RMS", "Michelson", "Local range"), rows)


def _measured(pictures: list[npt.NDArray[np.uint8]]) -> list[str]:
    contrast: list[Contrasts] = [contrasts(picture) for picture in pictures]
    columns = [[spectrum_slope(picture) for picture in pictures], [of_one.rms for of_one in contrast],
               [of_one.log_rms for of_one in contrast], [of_one.michelson for of_one in contrast]]  # fmt: skip
    texts = [_range(column, ".2f") for column in columns]
    return [*texts, _range([of_one.local_range for of_one in contrast], ".1f")]


def _range(values: list[float], form: str) -> str:
    middle = format(statistics.median_low(values), form)
    return middle if len(values) == 1 else f"{middle} ({min(values):{form}} to {max(values):{form}})"
