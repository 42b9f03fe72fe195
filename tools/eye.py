"""Draw docs/eye.png, the pictures of the page on the camera model: ``python -m tools.eye [FOLDER]``."""

from __future__ import annotations

import dataclasses
import math
import sys
from collections.abc import Sequence
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from colias_sim import CameraConfig, Frame, Pose, SceneConfig, Simulation
from experiments.draw.style import BODY, LOOK, WIDTH, tints

DOCS = Path(__file__).parents[1] / "docs"
SPEED = 0.3
"""Speed of the stimulus in the pictures, in m/s: fast, so that what motion does to them can be seen."""
STILL = SceneConfig(light_sd=0, turn_wall=False)
EYE = CameraConfig.preset("ov7670")
PICTURES = {
    "default": CameraConfig(),
    "ov7670": EYE,
    "ov7670, a render a row": dataclasses.replace(EYE, row_bands=EYE.height),
    "ov7670, in a fifth of the light": EYE,
}
"""Title -> camera."""
FIFTH = "ov7670, in a fifth of the light"


def passing(camera: CameraConfig, light: float) -> Frame:
    """Return the frame in which the stimulus has the middle of the view, 8 cm away, on its way to the right."""
    with Simulation(camera=camera, scene=STILL) as sim:
        rng = np.random.default_rng(0)
        lens = camera.forward_cm / 100
        sim.reset({"stimulus": Pose(lens + 0.08, SPEED * 8 / camera.fps, -math.pi / 2)}, rng, light=light)
        robot = sim.robots["stimulus"]
        robot.drive(robot.wheels_for(SPEED, 0.0))
        return [sim.step(rng) for _ in range(8)][-1]


def settling(exposure_ms: float) -> Sequence[Frame]:
    """Return the first 16 frames of a loop that starts cold."""
    camera = dataclasses.replace(EYE, ae_start="cold", exposure_ms=exposure_ms)
    with Simulation(camera=camera, scene=STILL) as sim:
        rng = np.random.default_rng(0)
        sim.reset({"stimulus": Pose(-0.3, 0.0, 0.0)}, rng)
        return [sim.step(rng) for _ in range(16)]


def drawn() -> Figure:
    """Return the pictures above, the loop and the lens below."""
    figure = Figure(figsize=(WIDTH, 4.4), layout="constrained")
    grid = figure.add_gridspec(2, 12)
    for i, (title, camera) in enumerate(PICTURES.items()):
        frame = passing(camera, 0.2 if title == FIFTH else 1.0)
        axes = figure.add_subplot(grid[0, 3 * i : 3 * i + 3])
        axes.imshow(frame.luma, cmap="gray", vmin=0, vmax=255, interpolation="nearest")
        words = title.replace(", ", ",\n")
        axes.set_title(f"{words}\n{frame.exposure_ms:.1f} ms", fontsize=BODY)
        axes.set_axis_off()
    mean, exposure, lens = (figure.add_subplot(grid[1, 4 * i : 4 * i + 4]) for i in range(3))
    for start, colour in tints((0.5, 8.0, 30.0)).items():
        frames = settling(start)
        mean.plot([frame.luma.mean() for frame in frames], ".-", color=colour, label=f"from {start:g} ms")
        exposure.semilogy([frame.exposure_ms for frame in frames], ".-", color=colour)
    mean.axhspan(EYE.ae_target - EYE.ae_zone, EYE.ae_target + EYE.ae_zone, color="#dddddd", label="control zone")
    mean.set(xlabel="frame of the camera", ylabel="mean grey level", ylim=(0, 256), yticks=range(0, 257, 64))
    mean.legend(frameon=False, fontsize=BODY, loc="lower left", bbox_to_anchor=(0.0, 1.0))
    exposure.set(xlabel="frame of the camera", ylabel="exposure (ms)")
    exposure.set_yticks([0.5, 1, 2, 5, 10, 20], ["0.5", "1", "2", "5", "10", "20"])
    exposure.minorticks_off()
    for axes in (mean, exposure):
        axes.set_xticks(range(0, 16, 5))
    f = np.linspace(0.0, 0.5, 100)
    for sd, colour in tints((EYE.blur_px, 0.6, 1.0)).items():
        lens.plot(f, np.exp(sd**2 * (np.cos(2 * np.pi * f) - 1)), color=colour, label=f"blur of {sd:g} px")
    lens.set(xlabel="spatial frequency (cycles/px)", ylabel="transfer of the lens", ylim=(0, 1.02))
    lens.legend(frameon=False, fontsize=BODY, loc="lower left", bbox_to_anchor=(0.0, 1.0))
    return figure


def main(folder: Path) -> None:
    """Draw the picture into ``folder``."""
    with mpl.rc_context(LOOK):
        drawn().savefig(folder / "eye.png", dpi=160)


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else DOCS)
