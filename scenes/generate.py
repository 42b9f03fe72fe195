"""Generate the scenes' textures and the wall: ``python -m scenes.generate [FOLDER]``.

``scenes/arena_wall.xml`` and the files in ``scenes/assets`` come entirely from this script with the seeds below.
"""

from __future__ import annotations

import sys
from pathlib import Path

import cv2
import numpy as np
import numpy.typing as npt

from scenes import ARENA_RADIUS_CM, FOLDER, WALL_HEIGHT_CM, WALL_PANELS

SEEDS = {"clutter": 2018, "leaves": 2019}
"""Seed of each picture's stream. The files in ``scenes/assets`` depend on them: never change one."""
WIDTH, HEIGHT = 1024, 192  # texels around and up the wall: about three per camera pixel
STRIPES = 12
FINER, LEAVES, SMALLEST, LARGEST = 2, 9000, 4.0, 90.0  # texels, two per millimetre and more, of the leaves
RADIUS, WALL_HEIGHT, PANELS = ARENA_RADIUS_CM / 100, WALL_HEIGHT_CM / 100, WALL_PANELS  # metres, metres


def clutter() -> npt.NDArray[np.uint8]:
    """Draw a seamless grey panorama (HEIGHT, WIDTH): 1/f mottling under pale soft-edged shapes."""
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
    """Draw noise of unit variance with a 1/f amplitude spectrum, periodic along both axes, (HEIGHT, WIDTH)."""
    fy, fx = np.fft.fftfreq(HEIGHT)[:, None], np.fft.rfftfreq(WIDTH)[None, :]
    radius = np.hypot(fx, fy)
    radius[0, 0] = np.inf
    phase = rng.uniform(0, 2 * np.pi, radius.shape)
    noise = np.fft.irfft2(np.exp(1j * phase) / radius, s=(HEIGHT, WIDTH))
    return np.asarray(noise / noise.std())


def leaves() -> npt.NDArray[np.uint8]:
    """Draw overlapping dark and light discs of all sizes, (HEIGHT, WIDTH), seamless around.

    Sizes are scale free (probability 1 / r^3), so that the wall has as much detail from near as from far.
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
    """Draw dark and light stripes (8, WIDTH), `STRIPES` of each around, with edges as soft as behind a lens."""
    phase = np.arange(WIDTH) * 2 * np.pi * STRIPES / WIDTH
    edge = np.tanh(6.0 * np.sin(phase))
    return np.tile(np.rint(140.0 + 100.0 * edge).astype(np.uint8), (8, 1))


def wall() -> str:
    """Write the wall as MJCF: an open cylinder of flat panels that face inward, with the texture wrapped once around.

    MuJoCo reads MJCF in every locale, unlike a mesh in Wavefront OBJ.
    """
    vertices, normals, texels, faces = [], [], [], []
    for turn in (i / PANELS for i in range(PANELS + 1)):
        x, y = RADIUS * np.cos(2 * np.pi * turn), RADIUS * np.sin(2 * np.pi * turn)
        vertices += [f"{x:.6f} {y:.6f} 0", f"{x:.6f} {y:.6f} {WALL_HEIGHT}"]
        normals += 2 * [f"{-x / RADIUS:.6f} {-y / RADIUS:.6f} 0"]
        texels += [f"{1 - turn:.6f} 1", f"{1 - turn:.6f} 0"]
    for a in range(0, 2 * PANELS, 2):  # a panel's lower corner; its upper one is the next, then those of the next panel
        faces += [f"{a} {a + 1} {a + 2}", f"{a + 2} {a + 1} {a + 3}"]
    lists = {"vertex": vertices, "normal": normals, "texcoord": texels, "face": faces}
    mesh = "\n".join(f'      {name}="{"  ".join(values)}"' for name, values in lists.items())
    return (
        "<!-- Written by scenes/generate.py: the arena's wall, seen from inside. -->\n"
        f'<mujocoinclude>\n  <asset>\n    <mesh name="wall"\n{mesh}/>\n  </asset>\n</mujocoinclude>\n'
    )


def main(folder: Path = FOLDER) -> None:
    """Write ``arena_wall.xml``, and the walls' textures in ``assets``, into ``folder``."""
    assets = folder / "assets"
    assets.mkdir(parents=True, exist_ok=True)
    cv2.imwrite(str(assets / "clutter.png"), clutter())
    cv2.imwrite(str(assets / "leaves.png"), leaves())
    cv2.imwrite(str(assets / "stripes.png"), stripes())
    (folder / "arena_wall.xml").write_text(wall(), encoding="utf-8")


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:2]))
