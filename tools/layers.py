"""Draw docs/layers.png, the network's layers in one moment of a crossing: ``python -m tools.layers [FOLDER]``."""

from __future__ import annotations

import math
import sys
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure

from colias_sim import Pose, Simulation
from dsnn import DSNN, DSNNParams
from experiments.base import palette
from experiments.draw.style import BODY, LOOK, WIDTH

DOCS = Path(__file__).parents[1] / "docs"
FRAMES, SHOWN, SPEED = 94, 47, 0.06
"""Frames of the crossing, the one whose layers are shown, and the speed, m/s."""
TITLES = "camera frame", "retina: change", "lamina: contrast", "ON and OFF, adapted", "lobula plate: HS, VS"


def drawn() -> Figure:
    """Return five pictures, each an arrow from the next."""
    network = DSNN((72, 99), DSNNParams.robot())
    with Simulation() as sim:
        rng = np.random.default_rng(0)
        sim.reset({"stimulus": Pose(0.1, SPEED * SHOWN / 30, -math.pi / 2)}, rng)
        sim.robots["stimulus"].drive((SPEED, SPEED))
        frames = [sim.step(rng).luma for _ in range(FRAMES)]
    answers = [network.step(frame, maps=number == SHOWN) for number, frame in enumerate(frames)]
    maps = answers[SHOWN].maps
    assert maps is not None, "this network has maps"
    changes = LinearSegmentedColormap.from_list("changes", [palette.DARKER, palette.STILL, palette.BRIGHTER])
    figure = Figure(figsize=(WIDTH, 1.35), layout="constrained")
    panels = figure.subplots(1, 5, gridspec_kw={"wspace": 0.18})
    panels[0].imshow(frames[SHOWN], cmap="gray", vmin=0, vmax=255, interpolation="nearest")
    for axes, layer in zip(panels[1:4], (maps.p, maps.la, maps.f_on - maps.f_off), strict=True):
        most = np.quantile(np.abs(layer), 0.995)
        axes.imshow(layer, cmap=changes, vmin=-most, vmax=most, interpolation="nearest")
    for name in ("hs", "vs"):
        panels[4].plot([getattr(answer, name) for answer in answers], color=palette.CHANNELS[name], lw=1.2)
    panels[4].axhline(DSNNParams.robot().t_sp, color=palette.THRESHOLD, lw=0.8, ls="--")
    panels[4].axvline(SHOWN, color=palette.GREY, lw=0.6)
    panels[4].set(ylim=(-0.2, 0.8), box_aspect=72 / 99)
    for number, (axes, title) in enumerate(zip(panels, TITLES, strict=True)):
        axes.set_title(title, fontsize=BODY)
        axes.set(xticks=[], yticks=[])
        axes.spines[:].set_visible(axes is panels[4])
        if number:
            arrow = {"arrowstyle": "-|>", "color": palette.INK}
            axes.annotate("", (-0.02, 0.5), (-0.22, 0.5), "axes fraction", arrowprops=arrow)
    return figure


def main(folder: Path) -> None:
    """Draw the picture into ``folder``."""
    with mpl.rc_context(LOOK):
        drawn().savefig(folder / "layers.png", dpi=160)


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else DOCS)
