"""Scenes: the statistics of natural images that are published, no seam, and nothing but kind and seed in them."""

import hashlib

import cv2
import numpy as np
import pytest

from dsnn.stimuli import SCENES, contrasts, scene, spectrum_slope, stimulus
from dsnn.stimuli.background import panorama
from dsnn.stimuli.scenes import _power_law

PUBLISHED = (-1.5, -0.8)
"""Slopes of the amplitude spectra of 135 photographs (Tolhurst, Tadmor and Chao 1992)."""
SHAPE = (180, 540)


def noise(exponent, seed=0):
    """Noise whose amplitude is frequency to the power ``exponent``."""
    rng = np.random.default_rng(seed)
    frequency = np.hypot(np.fft.fftfreq(SHAPE[0])[:, None], np.fft.rfftfreq(SHAPE[1]))
    frequency[0, 0] = np.inf
    waves = np.fft.irfft2(np.fft.rfft2(rng.standard_normal(SHAPE)) * frequency**exponent, SHAPE)
    return np.clip(np.rint(128 + 30 * waves / waves.std()), 0, 255).astype(np.uint8)


@pytest.mark.parametrize("kind", [*SCENES, "photograph"])
def test_a_scene_has_the_spectrum_and_contrast_of_natural_images(kind):
    photograph = contrasts(panorama("photograph", SHAPE, 0).view(0.0))["rms"]
    for seed in (1, 2):
        picture = scene(kind, SHAPE, seed) if kind in SCENES else panorama(kind, SHAPE, seed).view(0.0)
        assert picture.shape == SHAPE and picture.dtype == np.uint8
        assert PUBLISHED[0] < spectrum_slope(picture) < PUBLISHED[1]
        assert photograph / 2 < contrasts(picture)["rms"] < 2 * photograph


@pytest.mark.parametrize("exponent", [0.0, -0.5, -1.0, -1.5])
def test_a_slope_is_that_of_noise_whose_slope_is_known(exponent):
    assert spectrum_slope(noise(exponent)) == pytest.approx(exponent, abs=0.1)


def test_contrasts_are_those_of_a_picture_whose_contrasts_are_known():
    stripes = np.tile(np.repeat(np.array([50, 150], np.uint8), 4), (64, 8))
    contrast = contrasts(stripes)
    assert contrast == pytest.approx({"rms": 0.5, "log_rms": np.log(3) / 2, "michelson": 0.5, "local_range": 1.0})


def step_at_border(picture):
    """The share of a picture's steps from column to column that the step from its last to its first exceeds."""
    around = np.concatenate([picture, picture[:, :1]], axis=1).astype(float)
    steps = np.abs(np.diff(around, axis=1)).mean(axis=0)
    return float((steps[:-1] < steps[-1]).mean())


@pytest.mark.parametrize("kind", SCENES)
def test_a_scene_meets_itself_without_a_seam(kind):
    """The step where it does is any step's; where half a scene would meet itself it stands out."""
    pictures = [scene(kind, (60, 240), seed) for seed in range(20)]
    assert 0.2 < np.mean([step_at_border(picture) for picture in pictures]) < 0.8  # 0.5 +- 0.065 of any column
    assert np.mean([step_at_border(picture[:, :120]) for picture in pictures]) > 0.85


@pytest.mark.parametrize(
    "kind, digest",
    [("dead-leaves", "4e1ca20ebf825d35"), ("pink", "1677ed932184c838"), ("foliage", "f5623736a718220a"),
     ("street", "0451572550ae213f")],
)  # fmt: skip
def test_a_scene_is_the_one_of_published_numbers(kind, digest):
    assert hashlib.sha256(scene(kind, SHAPE, 1).tobytes()).hexdigest()[:16] == digest


def test_sizes_of_dead_leaves_have_the_probability_of_one_over_their_cube():
    """So N(> r) falls as 1 / r^2: a quarter is left at twice the size (Lee, Mumford and Huang 2001)."""
    sizes = _power_law(200_000, 4.0, 1e6, np.random.default_rng(0))
    larger = [(sizes > size).mean() for size in (4, 8, 16, 32)]
    np.testing.assert_allclose(larger, [1.0, 1 / 4, 1 / 16, 1 / 64], rtol=0.05)


# --- a picture of one's own -------------------------------------------------------------------------------------------


def test_a_picture_of_one_s_own_is_the_background(tmp_path):
    """As it is where it is as high as the frame; beside it its mirror image; then it again."""
    rng = np.random.default_rng(0)
    picture = cv2.GaussianBlur(rng.integers(0, 256, (48, 60)).astype(np.uint8), (0, 0), 2)
    cv2.imwrite(str(tmp_path / "own.png"), picture)
    size = {"rows": 48, "columns": 200, "background": str(tmp_path / "own.png"), "object": "absent", "start": 0.0}
    frame = stimulus("cluttered", background_speed=0.0, **size)[0].luma.astype(int)
    assert np.abs(frame[:, :60] - picture).max() <= 1
    assert np.abs(frame[:, 60:120] - picture[:, ::-1]).max() <= 1
    assert np.abs(frame[:, 120:180] - picture).max() <= 1


def test_a_picture_keeps_its_proportions_and_may_have_colours(tmp_path):
    colours = np.zeros((96, 240, 3), np.uint8)
    colours[:, 120:] = (0, 0, 255)
    cv2.imwrite(str(tmp_path / "own.png"), colours)
    whole = panorama(str(tmp_path / "own.png"), (48, 100), 0)
    assert whole.period == 2 * 120  # half as high and half as wide, beside its mirror image
    assert whole.view(0.0)[24, [20, 90]].tolist() == [0, 76]  # the luma of red: 0.299 * 255
