"""Draw the scenes' textures and the wall mesh anew: ``python -m scenes.generate [FOLDER]``.

The files in ``scenes/assets`` came from exactly this script (seeds below); nothing in them is from elsewhere.
"""

from __future__ import annotations

import sys
from pathlib import Path

import cv2
import numpy as np
import numpy.typing as npt

from scenes import ARENA_RADIUS_CM, WALL_HEIGHT_CM, WALL_PANELS

ASSETS = Path(__file__).parent / "assets"
SEEDS = {"clutter": 2018, "leaves": 2019}
"""Seeds of each picture's own stream. The files in ``scenes/assets`` came from these: never change one."""
WIDTH, HEIGHT = 1024, 192  # texels around and up the wall: about three per camera pixel
STRIPES = 12
FINER, LEAVES, SMALLEST, LARGEST = 2, 9000, 4.0, 90.0  # texels, two per millimetre and more, of the leaves
RADIUS, WALL_HEIGHT, PANELS = ARENA_RADIUS_CM / 100, WALL_HEIGHT_CM / 100, WALL_PANELS  # metres, metres


def clutter() -> npt.NDArray[np.uint8]:
    """A grey panorama (HEIGHT, WIDTH), seamless around: 1/f mottling under pale soft-edged shapes."""
    rng = np.random.default_rng(SEEDS["clutter"])
    canvas = np.full((HEIGHT, 3 * WIDTH), 246.0, np.float32)
    for _ in range(150):
        x, y = int(rng.integers(WIDTH)), int(rng.integers(HEIGHT))
        size = rng.uniform(6, 46, 2).tolist()
        turn, grey = float(rng.uniform(0, 180)), float(rng.uniform(196, 255))
        for wrap in range(3):  # drawn three times side by side; the middle third has no seam
            box = ((x + wrap * WIDTH, y), size, turn)
            if size[0] > size[1]:
                cv2.ellipse(canvas, box, grey, cv2.FILLED)
            else:
                cv2.fillPoly(canvas, [cv2.boxPoints(box).astype(np.int32)], grey)
    middle = cv2.GaussianBlur(canvas, (0, 0), 1.2)[:, WIDTH : 2 * WIDTH]
    return np.clip(middle + 5.0 * mottle(rng), 0, 255).astype(np.uint8)


def mottle(rng: np.random.Generator) -> npt.NDArray[np.float64]:
    """Noise of unit variance with a 1/f amplitude spectrum, periodic along both axes, (HEIGHT, WIDTH)."""
    fy, fx = np.fft.fftfreq(HEIGHT)[:, None], np.fft.rfftfreq(WIDTH)[None, :]
    radius = np.hypot(fx, fy)
    radius[0, 0] = np.inf
    phase = rng.uniform(0, 2 * np.pi, radius.shape)
    noise = np.fft.irfft2(np.exp(1j * phase) / radius, s=(HEIGHT, WIDTH))
    return np.asarray(noise / noise.std())


def leaves() -> npt.NDArray[np.uint8]:
    """Dark and light discs of every size, one over another, (HEIGHT, WIDTH), seamless around.

    Sizes are scale free (probability as 1 / r^3), so that the wall has as much to see from near as from far.
    """
    rng = np.random.default_rng(SEEDS["leaves"])
    canvas = np.full((FINER * HEIGHT, 3 * FINER * WIDTH), 128, np.uint8)
    for _ in range(LEAVES):
        low, high = SMALLEST**-2, LARGEST**-2
        radius = int(np.ceil((low + rng.random() * (high - low)) ** -0.5))
        x, y = int(rng.integers(FINER * WIDTH)), int(rng.integers(FINER * HEIGHT))
        grey = int(rng.integers(16, 240))
        for wrap in range(3):
            cv2.circle(canvas, (x + wrap * FINER * WIDTH, y), radius, grey, cv2.FILLED)
    return canvas[:, FINER * WIDTH : 2 * FINER * WIDTH]


def stripes() -> npt.NDArray[np.uint8]:
    """Dark and light stripes (8, WIDTH), `STRIPES` of each around, edges as soft as a lens would make them."""
    phase = np.arange(WIDTH) * 2 * np.pi * STRIPES / WIDTH
    edge = np.tanh(6.0 * np.sin(phase))
    return np.tile(np.rint(140.0 + 100.0 * edge).astype(np.uint8), (8, 1))


def wall() -> str:
    """The wall as Wavefront OBJ: an open cylinder of flat panels that face inward, its texture wrapped once around."""
    lines = ["# Written by scenes/generate.py: the arena's wall, seen from inside."]
    turns = [i / PANELS for i in range(PANELS + 1)]
    for turn in turns:
        x, y = RADIUS * np.cos(2 * np.pi * turn), RADIUS * np.sin(2 * np.pi * turn)
        lines += [f"v {x:.6f} {y:.6f} 0", f"v {x:.6f} {y:.6f} {WALL_HEIGHT}"]
        lines += [f"vt {1 - turn:.6f} 0", f"vt {1 - turn:.6f} 1", f"vn {-x / RADIUS:.6f} {-y / RADIUS:.6f} 0"]
    for i in range(PANELS):
        a, b, n, m = 2 * i + 1, 2 * i + 3, i + 1, i + 2  # lower corners now and next; their normals
        lines.append(f"f {a}/{a}/{n} {a + 1}/{a + 1}/{n} {b}/{b}/{m}")
        lines.append(f"f {b}/{b}/{m} {a + 1}/{a + 1}/{n} {b + 1}/{b + 1}/{m}")
    return "\n".join(lines) + "\n"


def main(folder: Path = ASSETS) -> None:
    """Write the walls' textures and ``wall.obj`` into ``folder``."""
    folder.mkdir(parents=True, exist_ok=True)
    cv2.imwrite(str(folder / "clutter.png"), clutter())
    cv2.imwrite(str(folder / "leaves.png"), leaves())
    cv2.imwrite(str(folder / "stripes.png"), stripes())
    (folder / "wall.obj").write_text(wall())


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:2]))
