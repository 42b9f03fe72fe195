"""Rendered street footage with known motion: people with swinging limbs before swaying foliage, camera noise."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

FPS = 30.0
SHAPE = (180, 320)
_FRACTION = 4  # bits below the pixel in OpenCV's drawing calls


@dataclass(frozen=True)
class Walker:
    """A person crossing at ``speed`` px per frame, rightward positive, who enters at the frame ``enters``."""

    speed: float
    enters: int = 0
    height: float = 140.0
    coat: tuple[int, int, int] = (20, 18, 16)
    legs: tuple[int, int, int] = (40, 30, 26)

    @property
    def half(self) -> float:
        """Half of the width that swinging limbs sweep, px."""
        return 0.2 * self.height

    def x(self, frame: int) -> float:
        """Column of the body's middle at a frame."""
        gone = abs(self.speed) * (frame - self.enters) - self.half
        return gone if self.speed > 0 else SHAPE[1] - gone

    def seen_s(self) -> tuple[float, float]:
        """From when to when the body's middle is in the picture."""
        first = self.enters + self.half / abs(self.speed)
        return first / FPS, (first + SHAPE[1] / abs(self.speed)) / FPS


def street(walkers: Iterable[Walker], frames: int, seed: int = 0) -> Iterator[np.ndarray]:
    """Frames of the street, each (180, 320, 3) uint8 BGR; equal arguments give equal frames."""
    rng = np.random.default_rng(seed)
    wall, foliage = _wall(rng), _foliage(rng)
    for i in range(frames):
        picture = wall.copy()
        _grow(picture, foliage, i)
        for walker in walkers:
            _draw(picture, walker, i)
        noisy = picture + 2.0 * rng.standard_normal(picture.shape, np.float32)
        yield np.clip(np.rint(noisy), 0, 255).astype(np.uint8)


def write(path: Path, frames: Iterable[np.ndarray], fps: float = FPS, codec: str = "MJPG") -> Path:
    """Write BGR frames of one size through OpenCV."""
    writer = None
    for frame in frames:
        if writer is None:
            writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*codec), fps, frame.shape[1::-1])
            assert writer.isOpened()
        writer.write(frame)
    assert writer is not None
    writer.release()
    return path


def _clutter(rng: np.random.Generator, shape: tuple[int, int], grain: float, mean: float, sd: float) -> np.ndarray:
    noise = cv2.GaussianBlur(rng.standard_normal(shape, np.float32), (0, 0), grain)
    return mean + sd * noise / noise.std()


def _wall(rng: np.random.Generator) -> np.ndarray:
    """A pale wall with windows above a pavement, (R, C, 3) float32."""
    rows, columns = SHAPE
    grey = _clutter(rng, SHAPE, 3.0, 185.0, 10.0)
    for left in range(18, columns, 62):
        grey[18:62, left : left + 30] = _clutter(rng, grey[18:62, left : left + 30].shape, 5.0, 95.0, 12.0)
    grey[150:] = _clutter(rng, (rows - 150, columns), 1.5, 125.0, 9.0)
    return np.stack([0.92 * grey, grey, 1.04 * grey], axis=-1).astype(np.float32)


def _foliage(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Leaves (R, C, 3) and where they are (R, C), 0..1: two crowns and a hedge."""
    leaves = _clutter(rng, SHAPE, 1.6, 80.0, 26.0)
    cover = np.zeros(SHAPE, np.float32)
    for centre, axes in (((52, 40), (48, 34)), ((262, 46), (55, 38)), ((160, 158), (150, 12))):
        cv2.ellipse(cover, centre, axes, 0, 0, 360, 1.0, -1, cv2.LINE_AA)
    cover *= np.clip(0.7 + _clutter(rng, SHAPE, 4.0, 0.2, 0.3), 0, 1)  # ragged
    return np.stack([0.55 * leaves, 1.1 * leaves, 0.75 * leaves], axis=-1).astype(np.float32), cover


def _grow(picture: np.ndarray, foliage: tuple[np.ndarray, np.ndarray], i: int) -> None:
    """Draw the foliage as the wind has it: up to 1.5 px either way at about 0.7 Hz, branch after branch."""
    y, x = np.mgrid[: SHAPE[0], : SHAPE[1]].astype(np.float32)
    phase = 2 * math.pi * 0.7 * i / FPS
    dx = 1.5 * np.sin(phase + x / 23 + y / 31)
    dy = 0.6 * np.sin(1.3 * phase + x / 17)
    leaves, cover = (cv2.remap(image, x - dx, y - dy, cv2.INTER_LINEAR) for image in foliage)
    picture += cover[..., np.newaxis] * (leaves - picture)


def _draw(picture: np.ndarray, walker: Walker, i: int) -> None:
    """A person in profile: head, coat, arms and legs that swing once in a stride of 0.9 heights."""
    h, way = walker.height, math.copysign(1.0, walker.speed)
    x, ground = walker.x(i), 168.0
    if not -walker.half <= x <= SHAPE[1] + walker.half:
        return
    swing = math.sin(2 * math.pi * abs(walker.speed) * i / (0.9 * h))
    hip, shoulder = (x, ground - 0.48 * h), (x, ground - 0.80 * h)
    for side in (1.0, -1.0):
        knee = _limb(picture, hip, 0.24 * h, 0.45 * side * swing * way, 0.085 * h, walker.legs)
        _limb(picture, knee, 0.24 * h, 0.3 * side * swing * way - 0.2 * way, 0.07 * h, walker.legs)
    cv2.line(picture, _fixed(*hip), _fixed(*shoulder), walker.coat, round(0.17 * h), cv2.LINE_AA, _FRACTION)
    elbow = _limb(picture, shoulder, 0.18 * h, -0.5 * swing * way, 0.06 * h, walker.legs)
    _limb(picture, elbow, 0.16 * h, -0.5 * swing * way + 0.4 * way, 0.05 * h, (120, 140, 175))
    head = _fixed(x + 0.02 * h * way, ground - 0.92 * h)
    cv2.circle(picture, head, round(0.07 * h * 2**_FRACTION), (110, 130, 165), -1, cv2.LINE_AA, _FRACTION)


def _limb(
    picture: np.ndarray, top: tuple[float, float], length: float, angle: float, width: float, colour: tuple[int, ...]
) -> tuple[float, float]:
    """Draw a limb that hangs at ``angle`` from ``top``; return its other end."""
    end = top[0] + length * math.sin(angle), top[1] + length * math.cos(angle)
    cv2.line(picture, _fixed(*top), _fixed(*end), colour, max(round(width), 1), cv2.LINE_AA, _FRACTION)
    return end


def _fixed(x: float, y: float) -> tuple[int, int]:
    return round(x * 2**_FRACTION), round(y * 2**_FRACTION)
