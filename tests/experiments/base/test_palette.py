"""Colours of one group stay apart: for colour-blind readers, and on white and on dark; pages have no others."""

import re
from itertools import product
from pathlib import Path

import cv2
import numpy as np
import pytest

from experiments.base import palette
from experiments.base.palette import BRIGHTER, CHANNELS, DARK, DARKER, OTHERS, STILL, VERDICTS, WHITE
from experiments.draw import style
from experiments.paper import page
from tools.pages import playground

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
GROUPS = {
    "potentials": [*CHANNELS.values()], "potentials and others": [*CHANNELS.values(), *OTHERS.values()],
    "pixels": [BRIGHTER, DARKER, STILL], "pixels and potentials": [BRIGHTER, *CHANNELS.values()],
    "verdicts on white": [tints[0] for tints in VERDICTS.values()],
    "verdicts on dark": [tints[1] for tints in VERDICTS.values()],
    **{f"{name} and its pathways": [hue, *palette.pathways(name)] for name, hue in CHANNELS.items()},
}  # fmt: skip
"""Colours that stand beside each other."""
LEAST = 20.0
"""Smallest distance of two of a group in CIELAB; 2.3 is about the smallest that is noticed."""
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
@pytest.mark.parametrize("group", GROUPS)
def test_colours_of_a_group_stay_apart_in_every_vision(group, vision):
    assert closest(GROUPS[group], vision) >= LEAST


@pytest.mark.parametrize(("tint", "ground"), [
    *product((*CHANNELS.values(), *OTHERS.values()), (WHITE, DARK)), (BRIGHTER, STILL), (DARKER, STILL),
    (palette.INK, WHITE),
    *((tints[place], ground) for tints in VERDICTS.values() for place, ground in enumerate((WHITE, DARK))),
])  # fmt: skip
def test_every_colour_is_seen_on_its_ground(tint, ground):
    assert contrast(tint, ground) >= LEAST_CONTRAST


@pytest.mark.parametrize("channel", CHANNELS)
def test_on_is_a_lighter_and_off_a_darker_tint_of_a_system_s_hue(channel):
    on, off = palette.pathways(channel)
    assert contrast(on, WHITE) < contrast(CHANNELS[channel], WHITE) < contrast(off, WHITE)


def test_the_pages_take_their_colours_from_here():
    """Every colour of potentials, pixels and verdicts is a variable of both, and neither sets one of its own."""
    named = dict(re.findall(r"--([\w-]+): ([^;]+);", palette.css()))
    assert {name: named[name] for name in CHANNELS} == CHANNELS
    assert (named["brighter"], named["darker"]) == (BRIGHTER, DARKER)
    for state, (light, dark, *_) in VERDICTS.items():
        assert re.findall("#[0-9a-f]{6}", named[state]) == [light, dark]
    report = Path(page.__file__).parent
    for style_sheet, html in ((report / "page.css", report / "page.html.j2"),
                              (playground.SOURCES / "style.css", playground.SOURCES / "page.html")):  # fmt: skip
        own = dict(re.findall(r"--([\w-]+): ([^;]+);", style_sheet.read_text()))
        assert not own.keys() & named.keys() and ":root { {{ colours }} }" in html.read_text()
        used = set(re.findall(r"var\(--([\w-]+)\)", style_sheet.read_text()))
        assert {"holds", "fails"} <= used <= own.keys() | named.keys() | {"least"}
    assert '["brighter", "darker"].map(colourOf)' in (playground.SOURCES / "drawing.js").read_text()


@pytest.mark.parametrize("column", ["speed_cm_s", "distance_cm", "grey"])
@pytest.mark.parametrize("count", [1, 2, 5, 9])
def test_tints_rise_with_the_level(count, column):
    tints = style.tints(np.random.default_rng(0).permutation(count).tolist(), column)
    darkness = [contrast(tints[level], WHITE) for level in range(count)]
    assert darkness == sorted(darkness, reverse=True) and len(set(darkness)) == count


@pytest.mark.parametrize("levels", [(-30.0, -15.0, 0.0, 15.0, 30.0), (-5.0, 2.5)])
def test_signed_levels_diverge_brown_to_the_left_and_teal_to_the_right(levels):
    tints = {level: palette.rgb(tint) for level, tint in style.tints(levels, "angle_deg").items()}
    for level, (red, _, blue) in tints.items():
        assert np.sign(blue - red) == np.sign(level)
    assert len(set(tints.values())) == len(levels)
