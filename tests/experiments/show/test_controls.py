"""Controls of a trial: which frames they show, with which time and truth, and that the trial itself stays as it was."""

import dataclasses
from pathlib import Path

import numpy as np
import polars as pl
import pytest

from colias_sim import CameraConfig
from experiments import run, watch
from experiments.declare.clip import Clip, OfflineExperiment
from experiments.declare.conditions import Condition
from experiments.settings.models import CONTROLS
from experiments.settings.settings import watchers
from experiments.show.clips import open_clip, trials_of
from experiments.show.controls import Replay, controls
from experiments.show.play import play, show
from experiments.store.tables import without_controls
from tests.experiments.show.test_trial import trial_of

SMALL = {"rows": 40, "columns": 56, "width": 10.0, "height": 16.0, "speed": 120.0, "rest_s": 0.1}
CLIPS = {way: Clip(way, "plain", {**SMALL, "motion": way}) for way in ("rightward", "leftward", "upward")}


def images(samples):
    return np.stack([sample.image for sample in samples])


def controls_of(clip, seed=0):
    source = open_clip(clip, seed)
    samples = list(source)
    return samples, {name: list(one) for name, one in controls(source, samples, seed)}


def test_controls_show_the_first_frame_the_ground_the_mirror_the_reverse_and_a_drawn_order():
    samples, again = controls_of(CLIPS["leftward"])
    frames = images(samples)
    assert list(again) == list(CONTROLS)
    assert (images(again["frozen"]) == frames[0]).all()
    assert (images(again["absent"]) == 200).all()
    np.testing.assert_array_equal(images(again["mirrored"]), frames[:, :, ::-1])
    np.testing.assert_array_equal(images(again["reversed"]), frames[::-1])
    drawn = images(again["shuffled"])
    assert (drawn != frames).any() and sorted(drawn.sum((1, 2))) == sorted(frames.sum((1, 2)))
    for name in ("frozen", "mirrored", "reversed", "shuffled"):
        assert [sample.time_s for sample in again[name]] == [sample.time_s for sample in samples]
    assert [sample.truth for sample in again["reversed"]] == [sample.truth for sample in samples[::-1]]


def test_vertical_motion_is_mirrored_top_to_bottom():
    samples, again = controls_of(CLIPS["upward"])
    np.testing.assert_array_equal(images(again["mirrored"]), images(samples)[:, ::-1])


def test_the_mirror_of_the_mirror_is_the_original_and_turns_the_sign_of_a_symmetric_model():
    source = open_clip(CLIPS["rightward"], 0)
    samples = list(source)
    mirrored = Replay(source, samples, "mirrored", 0)
    np.testing.assert_array_equal(images(Replay(mirrored, list(mirrored), "mirrored", 0)), images(samples))
    trial = dataclasses.replace(clip_trial(CLIPS["rightward"]), controls=controls)
    frames = play(trial).frames
    hs, turned = (frames.filter(model=label)["hs"].to_numpy() for label in ("emd", "emd~mirrored"))
    assert hs.max() > 0.01
    np.testing.assert_allclose(turned, -hs, atol=1e-9)


def clip_trial(clip):
    return trials_of(OfflineExperiment("e", "of the tests", [clip], ("emd",)), watchers(("emd",)), 1, 0)[0]


def test_a_trembling_camera_trembles_when_the_object_is_away_and_the_background_stands():
    clip = Clip("c", "cluttered", {**SMALL, "motion": "rightward", "background_speed": -30.0}, jitter_px=0.5)
    samples, again = controls_of(clip)
    bare = Clip("b", "cluttered", dict(clip.changes) | {"object": "absent", "background_speed": 0.0}, jitter_px=0.5)
    np.testing.assert_array_equal(images(again["absent"]), images(open_clip(bare, 0)))
    assert len(again["absent"]) == len(samples)


def test_without_the_stimulus_a_trial_shows_the_arena_alone_and_the_trial_itself_is_as_without_controls():
    still = CameraConfig(read_noise=0.0, shot_noise=0.0)
    condition = Condition("approach", "straight", 35.0, 8.0, far_cm=20.0, angle_deg=0.0)
    trial = trial_of(condition, 7, camera=still)
    shown, *others = show(dataclasses.replace(trial, controls=controls))
    (before,) = show(trial)
    np.testing.assert_array_equal(images(shown.samples), images(before.samples))
    by_name = dict(zip(CONTROLS, others, strict=True))
    empty = images(by_name["absent"].samples)
    assert (empty == empty[0]).all() and (empty[0] != images(shown.samples)[0]).any()
    assert [sample.time_s for sample in by_name["reversed"].samples] == shown.truth()["time_s"].to_list()
    assert by_name["reversed"].truth()["time_s"].is_sorted()
    assert by_name["reversed"].truth()["stimulus_x_cm"].to_list() == shown.truth()["stimulus_x_cm"].to_list()[::-1]


@pytest.fixture(scope="module")
def both(tmp_path_factory):
    folder: Path = tmp_path_factory.mktemp("controls")
    shown = OfflineExperiment(
        "both", "of the tests", [*CLIPS.values()], ("dsnn", "emd"), ("C1",), repeats=2, recorded=False
    )
    asked = {"quiet": True, "workers": 0, "settings": {"dsnn.n_con": 5}}
    return [run(shown, controls=control, out=folder / str(control), **asked) for control in (False, True)]


def test_claims_figures_and_summaries_of_a_run_leave_controls_out(both):
    plain, controlled = both
    apart = ["wall_s"]
    assert without_controls(controlled.trials).drop(apart).equals(plain.trials.drop(apart))
    assert without_controls(controlled.frames).equals(plain.frames)
    assert controlled.claims.equals(plain.claims) and controlled.summary.equals(plain.summary)
    assert (controlled.folder / "figure.png").read_bytes() == (plain.folder / "figure.png").read_bytes()
    assert not (plain.folder / "controls.csv").exists() and plain.controls.height == 0


def test_a_controls_row_has_its_models_parameters_and_a_word_needs_chance(both):
    _, controlled = both
    names = ("dsnn", *(f"dsnn~{control}" for control in CONTROLS))
    assert set(controlled.trials.filter(pl.col("model").is_in(names))["dsnn.n_con"]) == {5}
    assert controlled.trials["model"].n_unique() == 2 * (1 + len(CONTROLS))
    assert controlled.controls["word"].to_list() == ["not judged", "not judged"]
    assert (controlled.folder / "controls.png").is_file()


def test_footage_has_numbers_of_its_controls_and_no_word(tmp_path):
    seen = watch("plain", settings={f"plain.{name}": value for name, value in SMALL.items()}, controls=True, quiet=True,
                 models=["emd"], only=True, recordings=False, out=tmp_path / "w")  # fmt: skip
    hs = seen.controls.filter(response="hs").row(0, named=True)
    assert hs["word"] is None and hs["absent"] is None and hs["frozen"] == 0.0
    assert hs["mirrored"] == pytest.approx(-hs["shown"], rel=1e-3) and hs["shown"] > 0.0
    assert not any("~" in model for model in seen.summary["model"])


def test_frozen_of_a_still_clip_is_the_clip():
    samples, again = controls_of(Clip("still", "grating", {"rows": 40, "columns": 56, "temporal_hz": 0.0}))
    np.testing.assert_array_equal(images(again["frozen"]), images(samples))
