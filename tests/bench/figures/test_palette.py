"""Series stay apart: for colour-blind readers, on white paper, and when there are more of them than hues."""

import itertools

import numpy as np
import pytest

from dsnn import MODELS
from experiments.bench.figures.palette import GREYS, HUES, colours, level_colours, marks

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
# Oklab (Ottosson 2020): from linear sRGB to cones, and from their cube roots to lightness and two opponent axes.
CONES = np.array(
    [[0.4122214708, 0.5363325363, 0.0514459929], [0.2119034982, 0.6806995451, 0.1073969566],
     [0.0883024619, 0.2817188376, 0.6299787005]]
)  # fmt: skip
OPPONENT = np.array(
    [[0.2104542553, 0.7936177850, -0.0040720468], [1.9779984951, -2.4285922050, 0.4505937099],
     [0.0259040371, 0.7827717662, -0.8086757660]]
)  # fmt: skip
LEAST = 0.11
"""Smallest distance of two hues in Oklab; 0.02 is about the smallest that is noticed."""


def linear(tints):
    coded = np.array([[int(tint[i : i + 2], 16) / 255 for i in (1, 3, 5)] for tint in tints])
    return np.where(coded <= 0.04045, coded / 12.92, ((coded + 0.055) / 1.055) ** 2.4)


def closest(tints, vision):
    seen = np.cbrt(np.clip(linear(tints) @ VISIONS[vision].T, 0, 1) @ CONES.T) @ OPPONENT.T
    apart = np.linalg.norm(seen[:, None] - seen[None], axis=-1)
    return apart[~np.eye(len(tints), dtype=bool)].min()


@pytest.mark.parametrize("vision", VISIONS)
def test_hues_stay_apart_in_every_vision(vision):
    assert closest(HUES, vision) >= LEAST
    assert closest([*HUES, GREYS[0]], vision) >= 0.06


def test_the_measure_sees_what_a_deuteranope_does_not():
    """The control: red and green of equal lightness are far apart in normal vision, and nearly one without it."""
    pair = ("#c04040", "#6e7b28")
    assert closest(pair, "normal") > LEAST > closest(pair, "deuteranopia")


def test_hues_are_seen_on_white():
    luminance = linear([*HUES, *GREYS[:2]]) @ np.array([0.2126, 0.7152, 0.0722])
    assert (1.05 / (luminance + 0.05) >= 2.0).all()


def test_greys_are_of_baselines_alone():
    grey = {name for name, tint in colours([*MODELS, "still", "random", "straight", "mine"]).items() if tint in GREYS}
    assert grey == {"flow", "still", "random", "straight"}


@pytest.mark.parametrize("own", [0, 3, 30])
def test_no_two_series_have_both_colour_and_line_in_common(own):
    given = marks([*MODELS, *(f"mine{i}" for i in range(own))])
    assert len({(mark.colour, str(mark.line)) for mark in given.values()}) == len(given)
    assert all(given["dsnn"] == marks([name, "dsnn"])["dsnn"] for name in ("emd", "mine", "flow"))


def test_ten_models_of_a_figure_have_ten_colours_and_the_first_of_them_their_usual_ones():
    usual = {name: marks([name])[name].colour for name in ("dsnn", "emd", "lgmd1", "t4t5")}
    for others in itertools.combinations(["lplc2", "mlplc2", "si-lgmd1", "pon-lgmd", "dsnn-onboard", "mine"], 3):
        given = colours([*others, *usual])
        assert len(set(given.values())) == len(given) and given == given | usual


def test_levels_go_from_dark_to_light_and_words_have_hues():
    tints = list(level_colours([1.0, 2.0, 5.0, 9.0]).values())
    luminance = linear(tints) @ np.array([0.2126, 0.7152, 0.0722])
    assert (np.diff(luminance) > 0.02).all()
    assert set(level_colours(["a", "b"]).values()) <= set(HUES)
