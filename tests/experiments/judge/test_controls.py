"""Words on whether a response is vision: of broken models, whose words were written first, and of sound ones."""

from itertools import product

import numpy as np
import polars as pl
import pytest

from experiments.declare.clip import Clip, OfflineExperiment
from experiments.judge.controls import MEANS, SEES, measured, word_of
from experiments.judge.tests import holm, paired
from experiments.settings.models import parse_label
from experiments.settings.settings import watchers
from experiments.show.clips import trials_of
from experiments.show.controls import controls
from experiments.show.play import play
from tests.helpers.broken_models import BROKEN, chosen

FRAME = {"rows": 48, "columns": 64, "rest_s": 0.1}
CROSSING = {**FRAME, "width": 12.0, "height": 24.0, "speed": 90.0, "background_speed": 0.0}
CROSSINGS = [Clip(way, "cluttered", {**CROSSING, "motion": way}, jitter_px=0.1) for way in ("rightward", "leftward")]
APPROACHES = [
    Clip(f"{away:g}", "looming", {**FRAME, "l_over_v_s": 0.08, "azimuth_deg": away, "focal_px": 45.0}, jitter_px=0.1)
    for away in (-3.0, 3.0)
]
REPEATS = 4
KINDS = {"direction": CROSSINGS, "looming": APPROACHES}
SOUND = {
    "direction": ("dsnn", "dsnn-onboard", "emd-normalised", "three-arm", "three-arm-4q", "t4t5"),
    "looming": ("lplc2", "mlplc2", "lplc2-gf", "si-lgmd1", "si-lgmd2"),
}
"""Kind of response -> the models that hold C14, or a claim of their own paper about it."""


def words(kind, models, seed):
    """The columns about each model, after its 8 clips and their controls."""
    shown = OfflineExperiment("controls", "for the tests", KINDS[kind], ("dsnn",))
    trials = trials_of(shown, tuple(models), REPEATS, seed, controls=controls)
    frames = pl.concat([play(trial).frames for trial in trials])
    ways = {trial.index: "looming" if kind == "looming" else trial.label() for trial in trials}
    found = measured(frames, ways, models)
    return {model: word_of(values, one) for (model, one), values in found.items() if one == kind}


@pytest.mark.parametrize("kind", KINDS)
def test_broken_models_get_the_words_that_were_written_before_they_ran(kind):
    """At one seed of five; of the hundred judgements of the five seeds none was wrong."""
    own = {name: word for name, (word, channel, _) in BROKEN.items() if (channel == "looming") == (kind == "looming")}
    judged = words(kind, [chosen(name) for name in own], seed=3)
    assert {name: row["word"] for name, row in judged.items()} == own


@pytest.mark.parametrize("kind", KINDS)
def test_sound_models_see(kind):
    """All but one: SI-LGMD1 has no direction in depth, and responds a little more to recession."""
    judged = {name: row["word"] for name, row in words(kind, watchers(SOUND[kind]), seed=0).items()}
    assert judged == dict.fromkeys(SOUND[kind], SEES) | ({"si-lgmd1": "wrong sign"} if kind == "looming" else {})


def row(gain=1.0, n=12, noise=0.01, turned=-1.0):
    """Measures of a direction model: shown, frozen, absent, mirrored, reversed, shuffled."""
    means = np.array([gain, 0.0, 0.0, turned * gain, turned * gain, 0.0])
    return means + noise * np.random.default_rng(n).standard_normal((n, len(MEANS)))


@pytest.mark.parametrize(
    ("values", "random", "word"),
    [
        (row(), True, "sees"), (row(gain=-1.0), True, "wrong sign"), (row(turned=0.0), True, "blind"),
        (row(n=7), True, "not judged"), (row(), False, "not judged"), (row(n=0), True, "not judged"),
        (row(gain=0.0015, noise=1e-5), True, "blind"), (row(n=8), True, "sees"),
    ],
)  # fmt: skip
def test_the_word_needs_pairs_chance_the_margin_and_every_sign(values, random, word):
    assert word_of(values, "direction", random=random)["word"] == word


def test_p_is_the_largest_of_its_tests_after_holm():
    values = row(gain=0.01, noise=0.02)
    shown, frozen, absent, mirrored, backward, _ = values.T
    pairs = ((shown, absent), (shown, frozen), (absent, mirrored), (absent, backward))
    assert word_of(values, "direction")["p"] == max(holm([paired(*pair).p for pair in pairs]))


@pytest.mark.parametrize(
    ("model", "eye", "control"), [*product(("dsnn", "dsnn:w_i=1,n_con=6", "a-b"), ("", "ov7670"), ("", "frozen"))]
)
def test_a_label_is_taken_apart_to_model_eye_and_control(model, eye, control):
    label = f"{model}{eye and '@'}{eye}{control and '~'}{control}"
    assert parse_label(label) == (model, eye, control)
    assert not control or parse_label(label).controlled("absent") == f"{label.removesuffix('~frozen')}~absent"
