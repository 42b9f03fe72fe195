"""Series stay apart: for colour-blind readers, and on white and on dark."""

from itertools import product

import cv2
import numpy as np
import pytest

from experiments.base.palette import DARK, HUES, WHITE
from experiments.draw import style

# Machado, Oliveira and Fernandes 2009, severity 1, on linear RGB.
VISIONS = {
    "normal": np.eye(3),
    "deuteranopia": np.array(
        [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]]
    ),
    "protanopia": np.array(
        [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]]
    ),
}
LEAST = {"normal": 28.0, "deuteranopia": 18.0, "protanopia": 15.0}
"""Smallest distance of two hues in CIELAB; 2.3 is about the smallest that is noticed."""
LEAST_CONTRAST = 3.0
"""WCAG 2.1, 1.4.11: of what must be seen to understand a picture."""


def linear(tints):
    coded = np.array([[int(tint[i : i + 2], 16) / 255 for i in (1, 3, 5)] for tint in tints])
    return np.where(coded <= 0.04045, coded / 12.92, ((coded + 0.055) / 1.055) ** 2.4)


def closest(tints, vision):
    seen = np.clip(linear(tints) @ VISIONS[vision].T, 0, 1).astype(np.float32)
    (seen,) = cv2.cvtColor(seen[None], cv2.COLOR_LRGB2Lab)
    apart = np.linalg.norm(seen[:, None] - seen[None], axis=-1)
    return apart[~np.eye(len(tints), dtype=bool)].min()


def contrast(tint, ground):
    """WCAG 2.1: the ratio of relative luminances, each with 5 % of white for stray light."""
    darker, lighter = sorted(linear([tint, ground]) @ np.array([0.2126, 0.7152, 0.0722]) + 0.05)
    return lighter / darker


@pytest.mark.parametrize("vision", VISIONS)
def test_hues_stay_apart_in_every_vision(vision):
    assert closest(HUES, vision) >= LEAST[vision]


@pytest.mark.parametrize(("tint", "ground"), [*product(HUES, (WHITE, DARK)), *product(style.HUES, (WHITE,))])
def test_every_colour_is_seen_on_white_and_on_dark(tint, ground):
    assert contrast(tint, ground) >= LEAST_CONTRAST


@pytest.mark.parametrize("count", [1, 2, 5, 9])
def test_shades_rise_with_the_level(count):
    tints = style.shades(np.random.default_rng(0).permutation(count))
    darkness = [contrast(tints[level], WHITE) for level in range(count)]
    assert darkness == sorted(darkness, reverse=True) and len(set(darkness)) == count
