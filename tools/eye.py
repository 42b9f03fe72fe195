"""Draw docs/eye.png, of the camera model, and docs/layers.png, of the network: ``python -m tools.eye [FOLDER]``."""

from __future__ import annotations

import dataclasses
import math
import sys
from collections.abc import Sequence
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure

from colias_sim import CameraConfig, Frame, Pose, SceneConfig, Simulation
from dsnn import DSNN, DSNNParams
from experiments.base import palette
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
FRAMES, SHOWN, CROSSING = 94, 47, 0.06
"""Frames of a crossing, the one whose layers are shown, and the speed, m/s."""
LAYERS = "camera frame", "retina: change", "lamina: contrast", "ON and OFF, adapted", "lobula plate: HS, VS"


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


def layers() -> Figure:
    """Return the network's layers in one moment of a crossing: pictures with an arrow from each to the next."""
    network = DSNN((72, 99), DSNNParams.robot())
    with Simulation() as sim:
        rng = np.random.default_rng(0)
        sim.reset({"stimulus": Pose(0.1, CROSSING * SHOWN / 30, -math.pi / 2)}, rng)
        sim.robots["stimulus"].drive((CROSSING, CROSSING))
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
    for number, (axes, title) in enumerate(zip(panels, LAYERS, strict=True)):
        axes.set_title(title, fontsize=BODY)
        axes.set(xticks=[], yticks=[])
        axes.spines[:].set_visible(axes is panels[4])
        if number:
            axes.annotate("", (-0.02, 0.5), (-0.22, 0.5), "axes fraction", arrowprops={"arrowstyle": "-|>"})
    return figure


def main(folder: Path) -> None:
    """Draw the pictures into ``folder``."""
    with mpl.rc_context(LOOK):
        drawn().savefig(folder / "eye.png", dpi=160)
        layers().savefig(folder / "layers.png", dpi=160)


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else DOCS)
