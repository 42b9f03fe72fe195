"""Still scenes with the statistics of natural images, each made from a kind and a seed.

Outdoor images share two statistics, whatever they show. First, their amplitude falls about as one over spatial
frequency. The slope of 135 photographs was -0.8 to -1.5 in log-log coordinates, on average -1.2 (Tolhurst, Tadmor and
Chao 1992, Ophthalmic Physiol. Opt. 12:229). Field 1987, J. Opt. Soc. Am. A 4:2379, has about -1. Second, they have
edges, as near things occlude far ones (Ruderman and Bialek 1994, Phys. Rev. Lett. 73:814; Lee, Mumford and Huang 2001,
Int. J. Comput. Vision 41:35). The kinds produce these statistics in different ways; `dsnn.stimuli.scene_statistics`
measures them.

Shapes are drawn with whole numbers at twice the resolution, and four of these pixels are averaged into one. Only the
noise passes a Fourier transform, in double precision, and is then rounded to grey levels. So equal seeds give equal
bytes on any machine. The only exception is noise within the transform's error (some 1e-13) of half a grey level.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping
from types import MappingProxyType

import cv2
import numpy as np
import numpy.typing as npt

from dsnn.registry import look_up
from dsnn.stimuli.stimulus import Luma
from dsnn.stimuli.streams import stream

SMALLEST_PX = 8
"""Least side of a scene, as for a clip's frames."""
FINER = 2
"""Pixels of a drawing per pixel of the scene, along each axis."""
COVER = 8.0
"""Area of all discs over the scene's area. Overlapping discs leave a share exp(-8) uncovered."""

DISC_PX, DISC_GREYS = 1.5, (16, 240)
"""Smallest radius of a disc (the largest is half the scene's height), and the range of its uniform grey."""

LEAF_PX, LEAF_SLENDER, LEAF_COVER = (5.0, 45.0), 3, 1.8
"""Half lengths of a leaf, its length over its width, and the area of all leaves over the scene's area."""
LEAF_AREA = 2.19
"""Area of a leaf over its half length times its half width, for the six corners below."""
LEAF_LIT, LEAF_GREY_SD, LEAF_HALVES, LEAF_DROOP = (18, 170), 26, 14, 9
"""Greys of the deepest and the nearest leaf, their standard deviation, and half the difference of a leaf's two halves.
The last number is the spread of directions, in 64ths of a turn.
"""

PINK_MEAN, PINK_SD = 110.0, 45.0
"""Grey levels: near the photograph's own, 103 and 57, with room for the tails."""

Floats = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]

_DIRECTIONS = np.rint(
    1024 * np.stack([np.cos(np.arange(64) * np.pi / 32), np.sin(np.arange(64) * np.pi / 32)], axis=-1)
).astype(np.int64)
"""Unit vectors in 64 directions, times 1024."""


def scene(kind: str, shape: tuple[int, int], seed: int = 0) -> Luma:
    """Make a scene that repeats along x without a seam.

    Parameters
    ----------
    kind
        One of `SCENES`.
    shape
        (R, C), px, of at least 8 each.
    seed
        Seed of all random numbers, 0 or more. Equal seeds give equal bytes.

    Returns
    -------
    numpy.ndarray
        (R, C) uint8, grey levels.

    Raises
    ------
    ValueError
        The kind is unknown, or the shape is too small.

    Examples
    --------
    >>> from dsnn.stimuli import scene
    >>> scene("dead-leaves", (180, 540), seed=1).shape
    (180, 540)
    """
    if min(shape) < SMALLEST_PX:
        raise ValueError(f"shape must be {SMALLEST_PX} px or more along each side, got {shape}")
    return look_up("scene", kind, SCENES)(shape, seed)


def pink(shape: tuple[int, int], rng: np.random.Generator) -> npt.NDArray[np.float32]:
    """Make noise of 1/f amplitude in 0..255, (R, C) float32, that repeats along x and y without a seam."""
    noise = _unit_noise(rng.standard_normal(shape))
    return np.asarray(np.clip(PINK_MEAN + PINK_SD * noise, 0.0, 255.0), np.float32)


def _unit_noise(white: Floats) -> Floats:
    """Divide the amplitude of noise by frequency, and scale it to a standard deviation of 1."""
    rows, columns = white.shape
    frequency = np.hypot(np.fft.fftfreq(rows)[:, np.newaxis], np.fft.rfftfreq(columns))
    frequency[0, 0] = np.inf  # no constant part
    noise = np.fft.irfft2(np.fft.rfft2(white) / frequency, white.shape)
    return np.asarray(noise / noise.std())


def noise_scene(shape: tuple[int, int], seed: int) -> Luma:
    """Make noise with random phases and an amplitude of one over frequency: the natural spectrum, without edges."""
    return _grey(pink(shape, stream("background.pink", seed)))


def dead_leaves(shape: tuple[int, int], seed: int) -> Luma:
    """Draw overlapping opaque discs with radii of probability 1 / r^3, which look alike at every scale.

    This is the model of Lee, Mumford and Huang (2001), where the exponent 3 makes the picture independent of scale. The
    uniform distribution of greys is an assumption of this project.
    """
    rng, canvas = stream("scene.dead-leaves", seed), _canvas(shape, 128)
    smallest, largest = FINER * DISC_PX, max(FINER * shape[0] / 2, 2 * FINER * DISC_PX)
    area = 2 * np.pi * smallest**2 * np.log(largest / smallest)
    count = _count(canvas, largest, area, COVER)
    radii = _power_law(count, smallest, largest, rng)
    x, y = _places(count, canvas, largest, rng)
    greys = rng.integers(*DISC_GREYS, count)
    width = canvas.shape[1]
    for column, row, radius, grey in zip(x.tolist(), y.tolist(), radii.tolist(), greys.tolist(), strict=True):
        cv2.circle(canvas, (column, row), radius, grey, cv2.FILLED)
        if column < radius:  # a disc cut by the left border continues at the right, and vice versa
            cv2.circle(canvas, (column + width, row), radius, grey, cv2.FILLED)
        if column + radius >= width:
            cv2.circle(canvas, (column - width, row), radius, grey, cv2.FILLED)
    return _halved(canvas)


def foliage(shape: tuple[int, int], seed: int) -> Luma:
    """Draw overlapping leaves, lighter the nearer they are, each with a lit and a shaded half.

    A leaf is a polygon with six corners. Lengths have the probability 1 / r^3, as in dead leaves. Shapes, greys and
    their gradient with depth, which models the fading light, are assumptions of this project.
    """
    rng, canvas = stream("scene.foliage", seed), _canvas(shape, LEAF_LIT[0])
    smallest = FINER * LEAF_PX[0]
    largest = max(FINER * min(LEAF_PX[1], shape[0] / 3), 2 * smallest)
    mean_square = 2 * smallest**2 * np.log(largest / smallest)
    count = _count(canvas, largest, LEAF_AREA * mean_square / LEAF_SLENDER, LEAF_COVER)
    half = _power_law(count, smallest, largest, rng)
    x, y = _places(count, canvas, largest, rng)
    droop = np.rint(LEAF_DROOP * rng.standard_normal(count)).astype(np.int64)
    along = _DIRECTIONS[(16 + droop) % 64] * half[:, np.newaxis]
    across = along[:, ::-1] * (-1, 1) // LEAF_SLENDER
    depth = np.arange(count) * (LEAF_LIT[1] - LEAF_LIT[0]) // count + LEAF_LIT[0]
    grey = depth + np.rint(LEAF_GREY_SD * rng.standard_normal(count)).astype(np.int64)
    middle = np.stack([x, y], axis=-1) * 1024
    # Base, then half way, then the tip: the halves share the midrib.
    outline = np.stack([-along, -along * 3 // 8 + across * 7 // 8, along * 1 // 4 + across, along], axis=1)
    other = np.stack([-along, -along * 3 // 8 - across * 7 // 8, along * 1 // 4 - across, along], axis=1)
    light = np.clip(np.stack([grey + LEAF_HALVES, grey - LEAF_HALVES], axis=-1), 0, 255)
    reach = half + half // LEAF_SLENDER
    width = canvas.shape[1]
    parts = np.stack([(middle[:, np.newaxis] + part) // 1024 for part in (outline, other)], axis=1).astype(np.int32)
    for corners, greys, column, far in zip(parts, light.tolist(), x.tolist(), reach.tolist(), strict=True):
        shifts = (0, *((width,) if column < far else ()), *((-width,) if column + far >= width else ()))
        for shift, (part, grey) in itertools.product(shifts, zip(corners, greys, strict=True)):
            cv2.fillConvexPoly(canvas, part + np.array((shift, 0), np.int32), grey)
    return _halved(canvas)


def street(shape: tuple[int, int], seed: int) -> Luma:
    """Draw adjacent house fronts with windows, doors and sills, under a sky and above a pavement and a road.

    Houses have several storeys, and are 1/4 to 1/2 of the scene's height wide; every wall has its own grey. Plaster,
    paving and clouds are noise of 1/f amplitude. All sizes and greys are assumptions of this project.
    """
    rng = stream("scene.street", seed)
    rows, columns = FINER * shape[0], FINER * shape[1]
    texture = np.rint(_unit_noise(rng.integers(-512, 513, shape).astype(np.float64)) * 64).astype(np.int64)
    rough = np.full((rows, columns), 20, np.int64)  # halves of a grey level of a standard deviation of the noise
    canvas = np.empty((rows, columns), np.int64)
    canvas[:] = 225 - np.arange(rows)[:, np.newaxis] * 25 // rows
    ground = rows * 80 // 100
    left = 0
    while left < columns:
        width = int(rng.integers(rows // 4, rows // 2))
        right = columns if columns - left - width < rows // 4 else left + width
        _house(canvas, rough, (left, right, ground), rng)
        left = right
    canvas[ground:] = int(rng.integers(120, 170))
    kerb = rows * 88 // 100
    canvas[kerb : kerb + rows // 90 + 1] = 205
    canvas[kerb + rows // 90 + 1 :] = int(rng.integers(60, 95))
    rough[ground:] = 14
    for post in range(int(rng.integers(rows)) // 2, columns - rows // 30, rows * 5 // 4):
        canvas[rows * 30 // 100 : kerb, post : post + rows // 60 + 1] = 40
        canvas[rows * 29 // 100 : rows * 31 // 100, post : post + rows // 14] = 40
    fine = np.repeat(np.repeat(texture, FINER, axis=0), FINER, axis=1)
    whole = _halved(np.clip(canvas + (fine * rough >> 7), 0, 255).astype(np.uint8))
    return np.roll(whole, int(rng.integers(shape[1])), axis=1)  # so that the first column is no house's border


def _house(canvas: Integers, rough: Integers, place: tuple[int, int, int], rng: np.random.Generator) -> None:
    """Draw one front with its parts, from column ``left`` to ``right`` and down to row ``ground``."""
    left, right, ground = place
    rows = canvas.shape[0]
    wall, storeys = int(rng.integers(70, 215)), int(rng.integers(3, 6))
    storey = int(rng.integers(rows * 14 // 100, rows * 19 // 100))
    top = max(ground - storeys * storey - rows // 24, 0)
    canvas[top:ground, left:right] = wall
    rough[top:ground, left:right] = int(rng.integers(10, 30))
    canvas[top : top + rows // 50 + 1, left:right] = max(wall - 60, 20)  # the eaves
    canvas[top:ground, left : left + rows // 120 + 1] = max(wall - 45, 15)  # the joint between two houses
    across = int(rng.integers(2, 5))
    pitch = (right - left) // across
    wide, high = pitch * int(rng.integers(35, 60)) // 100, storey * int(rng.integers(50, 70)) // 100
    frame = max(rows // 120, 1)
    for number in range(storeys * across):
        floor, place_along = divmod(number, across)
        x = left + place_along * pitch + (pitch - wide) // 2
        y = ground - (floor + 1) * storey + (storey - high) // 2
        if y < top + rows // 25:
            continue
        pane = int(rng.integers(10, 80)) if rng.integers(4) else int(rng.integers(120, 200))  # some have curtains
        if floor == 0 and place_along == across // 2:  # the door
            canvas[y:ground, x : x + wide] = int(rng.integers(25, 110))
            continue
        canvas[y - frame : y + high + frame, x - frame : x + wide + frame] = min(wall + 45, 245)
        canvas[y : y + high, x : x + wide] = pane
        canvas[y : y + high, x + wide // 2 : x + wide // 2 + frame] = min(wall + 45, 245)
        canvas[y + high + frame : y + high + 3 * frame, x - 2 * frame : x + wide + 2 * frame] = max(wall - 50, 15)


def _canvas(shape: tuple[int, int], grey: int) -> Luma:
    return np.full((FINER * shape[0], FINER * shape[1]), grey, np.uint8)


def _count(canvas: Luma, largest: float, area: float, cover: float) -> int:
    """Count the shapes of a mean area, px of the drawing, that cover the canvas ``cover`` times (see `_places`)."""
    rows, columns = (int(side) for side in canvas.shape)
    return round(cover * columns * (rows + 2 * int(largest)) / area)


def _power_law(count: int, smallest: float, largest: float, rng: np.random.Generator) -> Integers:
    """Draw sizes with the probability 1 / r^3. Root and quotient are exact to the last bit on every machine."""
    low, high = 1 / (smallest * smallest), 1 / (largest * largest)
    return np.ceil(1.0 / np.sqrt(low + rng.random(count) * (high - low))).astype(np.int64)


def _places(count: int, canvas: Luma, largest: float, rng: np.random.Generator) -> tuple[Integers, Integers]:
    """Draw columns and rows of shapes; shapes above and below the canvas reach into it."""
    rows, columns = canvas.shape
    reach = int(largest)
    return rng.integers(columns, size=count), rng.integers(-reach, rows + reach, count)


def _halved(canvas: Luma) -> Luma:
    """Average `FINER` x `FINER` pixels into one, in whole numbers."""
    rows, columns = (side // FINER for side in canvas.shape)
    sums = canvas.reshape(rows, FINER, columns, FINER).sum(axis=(1, 3), dtype=np.uint16)
    return np.asarray((sums + FINER * FINER // 2) // (FINER * FINER), np.uint8)


def _grey(image: npt.NDArray[np.floating]) -> Luma:
    return np.asarray(np.clip(np.rint(image), 0.0, 255.0), np.uint8)


SCENES: Mapping[str, Callable[[tuple[int, int], int], Luma]] = MappingProxyType(
    {"dead-leaves": dead_leaves, "pink": noise_scene, "foliage": foliage, "street": street}
)
"""The kinds of scenes: name -> function that makes one from its shape (R, C) and a seed."""
