"""Draw docs/speed.png, the README's picture, from a finished run: ``python -m tools.picture RUN_FOLDER``.

Above, the scene from outside and what the observer's camera sees; below, the run's own figure.
"""

from __future__ import annotations

import math
import sys
from pathlib import Path

import cv2
import mujoco
import numpy as np
from PIL import Image
from PIL.PngImagePlugin import PngInfo

from colias_sim import Pose, Simulation
from colias_sim.offscreen import Offscreen
from experiments.bench.store.files import drawn_from

DOCS = Path(__file__).parents[1] / "docs"
HEIGHT = 360


def scene() -> np.ndarray:
    """Outside view and camera view side by side, BGR."""
    with Simulation() as sim:
        sim.model.vis.global_.offwidth, sim.model.vis.global_.offheight = 1280, 720
        rng = np.random.default_rng(4)
        sim.reset({"stimulus": Pose(0.0995, 0.022, -math.pi / 2)}, rng)
        eye = sim.step(rng).luma
        outside = mujoco.MjvCamera()
        outside.lookat[:], outside.distance = [0.09, 0.0, 0.02], 0.33
        outside.azimuth, outside.elevation = 35, -24
        view = Offscreen(sim.model, HEIGHT, 2 * HEIGHT).render(sim.data, outside, mujoco.MjvOption())[::-1, :, ::-1]
    seen = cv2.resize(eye, (HEIGHT * 99 // 72, HEIGHT), interpolation=cv2.INTER_NEAREST)
    gap = np.full((HEIGHT, 12, 3), 255, np.uint8)
    return np.hstack([view, gap, cv2.cvtColor(seen, cv2.COLOR_GRAY2BGR)])


def main(run: Path) -> None:
    """Put the scene above the figure of ``run``. The picture notes the rows that the figure is drawn from."""
    above, figure = scene(), cv2.imread(str(run / "figure.png"))
    above = cv2.resize(
        above, (figure.shape[1], above.shape[0] * figure.shape[1] // above.shape[1]), interpolation=cv2.INTER_AREA
    )
    DOCS.mkdir(exist_ok=True)
    picture = Image.fromarray(np.vstack([above, np.full_like(above[:16], 255), figure])[:, :, ::-1])
    noted = PngInfo()
    noted.add_text("Source", drawn_from(run))
    picture.save(DOCS / "speed.png", pnginfo=noted, optimize=True)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
