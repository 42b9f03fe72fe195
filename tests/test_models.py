"""Laws that every registered model keeps: one suite over the registry, so a new model is tested the day it is added."""

import dataclasses

import numpy as np
import pytest

from dsnn import MODELS, FrameError, VisionModel, model_entry
from tests.conftest import crossing

SHAPE = (72, 99)


@pytest.fixture(params=list(MODELS))
def entry(request):
    return MODELS[request.param]


@pytest.fixture
def model(entry):
    return entry.build(SHAPE, entry.robot)


def test_offers_the_protocol(model):
    assert isinstance(model, VisionModel)
    assert model.shape == SHAPE


def test_a_still_scene_is_silent(model):
    frame = np.random.default_rng(3).integers(0, 256, SHAPE, np.uint8)
    for _ in range(5):
        answer = model.step(frame)
    assert (answer.hs, answer.vs, answer.hs_spikes, answer.vs_spikes) == (0, 0, 0, 0)


def test_rightward_is_positive(model):
    series = model.run(crossing())
    assert series.hs.max() > model.params.t_sp
    assert series.hs.min() > -model.params.t_sp / 10


@pytest.mark.parametrize("name", ["dsnn", "dsnn-reference"])
def test_the_other_axis_is_quiet(name):
    """The DSNN's; its forerunner without FDSR answers by both axes, as the paper says of it (C6)."""
    series = MODELS[name].build(SHAPE, MODELS[name].robot).run(crossing())
    assert np.abs(series.vs).max() < series.hs.max() / 2


def test_without_fdsr_the_other_axis_answers_too():
    series = MODELS["dsn2017"].build(SHAPE, MODELS["dsn2017"].robot).run(crossing())
    assert np.abs(series.vs).max() > MODELS["dsn2017"].robot.t_sp


@pytest.mark.parametrize("dark", [True, False])
def test_mirror_left_right_swaps_the_sign_of_hs_and_keeps_vs(entry, dark):
    model = entry.build(SHAPE, dataclasses.replace(entry.robot, w_i=1.0))  # balanced, so exactly odd
    frames = crossing(dark=dark)
    there, back = model.run(frames), model.run(frames[:, :, ::-1])
    np.testing.assert_allclose(back.hs, -there.hs, atol=1e-4)
    np.testing.assert_allclose(back.vs, there.vs, atol=1e-3)  # what cancels is a hundred times larger without FDSR
    np.testing.assert_array_equal(back.hs_spikes, -there.hs_spikes)
    assert np.abs(there.hs).max() > 0.2


def test_mirror_up_down_keeps_hs(model):
    frames = crossing()
    frames[:, :20] = 128  # an image that is not its own mirror
    there, back = model.run(frames), model.run(frames[:, ::-1])
    np.testing.assert_allclose(back.hs, there.hs, atol=1e-5)


def test_transposing_the_image_swaps_hs_and_vs(entry):
    frames = crossing()
    upright = entry.build(SHAPE, entry.robot).run(frames)
    turned = entry.build(SHAPE[::-1], entry.robot).run(frames.transpose(0, 2, 1))
    np.testing.assert_allclose(turned.vs, upright.hs, atol=1e-5)
    np.testing.assert_allclose(turned.hs, upright.vs, atol=1e-5)


def test_reset_makes_runs_repeat_and_run_equals_steps(model):
    frames = np.random.default_rng(1).integers(0, 256, (12, *SHAPE), np.uint8)
    first = model.run(frames)
    model.reset()
    stepped = [model.step(frame) for frame in frames]
    np.testing.assert_array_equal(first.hs, [a.hs for a in stepped])
    np.testing.assert_array_equal(first.hs, model.run(iter(frames)).hs)
    assert len(first.vs) == len(first.hs_spikes) == len(first.vs_spikes) == 12


def test_asking_for_maps_changes_no_answer(model):
    frames = crossing(count=20)
    plain = model.run(frames)
    model.reset()
    answers = [model.step(frame, maps=True) for frame in frames]
    np.testing.assert_array_equal(plain.hs, [a.hs for a in answers])
    kept = answers[10].maps
    assert kept is not None and kept.p.shape == SHAPE
    assert not np.array_equal(kept.p, answers[11].maps.p), "maps are copies, not views of a buffer in use"


def test_colour_and_float_frames_mean_the_same_grey(model):
    grey = crossing(count=10)
    series = model.run(grey)
    np.testing.assert_allclose(model.run(grey.astype(np.float64)).hs, series.hs, atol=1e-6)
    np.testing.assert_allclose(model.run(grey.astype(np.float32)).hs, series.hs, atol=1e-6)
    colour = np.repeat(grey[..., None], 3, axis=-1)
    np.testing.assert_array_equal(model.run(colour, channels="rgb").hs, series.hs)


def test_rgb_and_bgr_differ_by_their_order(model):
    rng = np.random.default_rng(2)
    rgb = rng.integers(120, 136, (8, *SHAPE, 3), np.uint8)  # faint: none saturates
    there = model.run(rgb, channels="rgb")
    np.testing.assert_array_equal(there.hs, model.run(rgb[..., ::-1].copy(), channels="bgr").hs)
    assert not np.array_equal(there.hs, model.run(rgb, channels="bgr").hs)


@pytest.mark.parametrize(
    ("frame", "says"),
    [
        (np.zeros((72, 98), np.uint8), "(72, 98)"),
        (np.zeros((72, 99, 3), np.uint8), "channels="),
        (np.full(SHAPE, np.nan), "finite"),
        (np.full(SHAPE, np.inf), "0..255"),
        (np.full(SHAPE, 256.0), "256"),
        (np.full(SHAPE, -1.0), "-1"),
        (np.zeros(SHAPE, np.int32), "int32"),
        ([[0] * 99] * 72, "list"),
    ],
)
def test_a_frame_it_cannot_take_is_a_clear_error(model, frame, says):
    model.step(np.zeros(SHAPE, np.uint8))
    with pytest.raises(FrameError) as caught:
        model.step(frame)
    assert says in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_refused_frame_leaves_no_trace(model):
    frames = crossing(count=12)
    clean = model.run(frames)
    model.reset()
    hs = []
    for frame in frames:
        with pytest.raises(FrameError):
            model.step(np.full(SHAPE, np.nan))
        hs.append(model.step(frame).hs)
    np.testing.assert_array_equal(hs, clean.hs)


@pytest.mark.parametrize("shape", [(72,), (0, 5), (1, 99), "ab", (72.0, "x")])
def test_a_shape_it_cannot_take_is_a_clear_error(entry, shape):
    with pytest.raises(FrameError):
        entry.build(shape, entry.robot)


def test_an_unknown_name_is_answered_with_the_nearest():
    with pytest.raises(ValueError, match="nearest: dsnn"):
        model_entry("dsn")
