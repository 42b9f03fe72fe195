"""What every registered model keeps beside the laws of ``colias check``, which ``test_check.py`` tries."""

import dataclasses
import json
import warnings

import numpy as np
import pytest

from dsnn import CHANNELS, EMD, MODELS, DSNNParams, FrameError, ResponseSeries
from dsnn.frames import luma
from dsnn.stimuli import stimulus
from tests.conftest import ROOT
from tests.dsnn.clips import SHAPE, approach, oblique

COLUMNS = tuple(field.name for field in dataclasses.fields(ResponseSeries) if field.name != "time_s")
LOOMING = [name for name, entry in MODELS.items() if entry.channels == ("looming",)]
REST = dict.fromkeys(CHANNELS, 0.0) | {"looming": 0.5}
BOUNDS = {"flow": 0.25, "dsnn-onboard": 0.01}
"""How far models may be from symmetry. DIS lays its patches from the upper left corner. The on-board network rounds its
blur along y to 1/128 grey level before that along x; its bound is a twentieth of the threshold of a spike."""
SYMMETRIES = {
    "mirrored": (lambda clip: clip[:, :, ::-1], ("hs", -1), ("vs", 1)),
    "transposed": (lambda clip: clip.transpose(0, 2, 1), ("vs", 1), ("hs", 1)),
}
"""Name -> the picture's change, and which of the first clip's potentials HS and VS become, with their sign.

A turn is both, one after the other.
"""


@pytest.fixture(params=list(MODELS))
def entry(request):
    return MODELS[request.param]


def answered(entry, dark=True):
    """A clip that the model answers: some looming detectors are made to be silent at translation."""
    if "target" in entry.channels:
        clip = stimulus("target", background="even", background_speed=0.0, speed=150.0, direction_deg=20.0)
        frames = np.stack([frame.luma for frame in clip])
        return frames if dark else 255 - frames
    return approach(dark)[60:] if entry.name in LOOMING else oblique(dark)


def assert_same(one: ResponseSeries, other: ResponseSeries):
    for name in COLUMNS:
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name), err_msg=name)


def arrays(thing):
    """Every array of a model's state: its own, and those of its parts."""
    if isinstance(thing, np.ndarray):
        yield thing
    elif isinstance(thing, list | tuple):
        for part in thing:
            yield from arrays(part)
    elif type(thing).__module__.startswith("dsnn.") and hasattr(thing, "__dict__"):
        for part in vars(thing).values():
            yield from arrays(part)


def test_comes_to_rest_when_the_scene_does_without_subnormals(entry):
    """In which states that fade would linger, and take a processor many times longer."""
    frames = np.ascontiguousarray(answered(entry, "off-blocked" not in entry.name)[:, 16:52, 26:74])
    model = entry.build(frames.shape[1:], entry.robot)
    series = model.run([*frames, *[frames[-1]] * 750])
    for channel in entry.channels:
        potential = getattr(series, channel)
        assert np.abs(potential[: len(frames)] - REST[channel]).max() > 0.01
        assert potential[-1] == pytest.approx(REST[channel], abs=1e-6)
    for state in arrays(model):
        if state.dtype == np.float32:
            size = np.abs(state)
            assert not ((size > 0) & (size < np.finfo(np.float32).tiny)).any()


@pytest.mark.parametrize("dark", [True, False])
@pytest.mark.parametrize("symmetry", SYMMETRIES)
def test_a_model_follows_the_symmetries_of_its_picture(entry, symmetry, dark):
    """With both directions weighing the same."""
    change, hs, vs = SYMMETRIES[symmetry]
    params = dataclasses.replace(entry.robot, w_i=1.0) if isinstance(entry.robot, DSNNParams) else entry.robot
    there, other = (
        entry.build(clip.shape[1:], params).run(np.ascontiguousarray(clip))
        for clip in (answered(entry, dark), change(answered(entry, dark)))
    )
    for channel, (before, sign) in (("hs", hs), ("vs", vs), ("looming", ("looming", 1)), ("target", ("target", 1))):
        if channel in entry.channels:
            expected = sign * getattr(there, before)
            # What cancels is larger without FDSR, and the lamina's sign test jumps where a blur is 0 but for rounding.
            bound = BOUNDS.get(entry.name, 1e-4 if abs(expected).max() > 0.1 else 1e-3)
            bound *= max(1.0, abs(expected).max()) if channel == "target" else 1.0
            np.testing.assert_allclose(getattr(other, channel), expected, atol=bound, err_msg=channel)
            if symmetry == "mirrored" and channel != "target":
                spikes = getattr(other, f"{channel}_spikes")
                np.testing.assert_array_equal(spikes, sign * getattr(there, f"{before}_spikes"))
    if "hs" in entry.channels and "blocked" not in entry.name:
        assert there.hs.max() > 0.1 and there.hs.min() > -there.hs.max() / 5, "rightward is positive"


@pytest.mark.parametrize("name", LOOMING)
def test_looming_passes_its_threshold_near_by(name):
    entry, noise = MODELS[name], np.random.default_rng(1).integers(0, 2, (12, *SHAPE)).astype(np.uint8) * 255
    series = entry.build(SHAPE, entry.robot).run([*approach(), *noise])
    assert series.looming[80:100].max() > entry.robot.t_sp > series.looming[:20].max()
    assert series.looming_spikes[67:100].sum() > series.looming_spikes[:67].sum()
    assert series.looming.min() == 0.5 and series.looming.max() <= 1.0


def test_maps_and_refused_frames_leave_no_trace_and_floats_mean_the_same_grey(entry):
    """The layers are the DSNN's; a model without them shows none."""
    frames, model = oblique()[:12], entry.build(SHAPE, entry.robot)
    plain = model.run(frames)
    model.reset()
    answers = []
    for frame in frames:
        with pytest.raises(FrameError):
            model.step(np.full(SHAPE, np.nan))
        answers.append(model.step(frame, maps=True))
    assert_same(plain, ResponseSeries.from_responses(answers))
    kept = answers[10].maps
    if isinstance(entry.robot, DSNNParams) and entry.name != "hybrid":
        assert kept.p.shape == SHAPE
        assert not np.array_equal(kept.p, answers[11].maps.p), "maps are copies, not views of a buffer in use"
    for kind in (np.float64, np.float32):
        other = model.run(frames.astype(kind, order="F"))  # and no frame is contiguous
        for channel in entry.channels:
            np.testing.assert_allclose(getattr(other, channel), getattr(plain, channel), atol=1e-6)


# --- the gate of frames, which all models that ship share -------------------------------------------------------------


def test_a_colour_frame_is_its_luma_in_the_order_that_is_named():
    grey, model = oblique(), EMD(SHAPE)
    assert_same(model.run(np.repeat(grey[..., None], 3, axis=-1), channels="rgb"), model.run(grey))
    rgb = np.stack([grey, grey, 255 - grey], axis=-1)
    there = model.run(rgb, channels="rgb")
    assert_same(there, model.run(rgb[..., ::-1].copy(), channels="bgr"))
    assert not np.array_equal(there.hs, model.run(rgb, channels="bgr").hs)


def test_frames_from_0_to_1_are_warned_of_once():
    clip = oblique()[:3]
    for shown, count in ([clip], 0), ([clip.astype(float), clip / 255], 0), ([clip / 255, clip / 255], 1):
        model = EMD(SHAPE)
        with warnings.catch_warnings(record=True) as given:
            warnings.simplefilter("always")
            for frames in shown:
                model.run(frames)
        assert len(given) == count


@pytest.mark.parametrize(
    "frame",
    [np.zeros((72, 98), np.uint8), np.zeros((72, 99, 3), np.uint8), np.full(SHAPE, np.nan), np.full(SHAPE, 256.0),
     np.full(SHAPE, -1.0), np.zeros(SHAPE, np.int32), [[0] * 99] * 72],
)  # fmt: skip
def test_a_frame_that_cannot_be_taken_is_refused(frame):
    with pytest.raises(FrameError):
        luma(frame, SHAPE)


# --- parameters and constants -----------------------------------------------------------------------------------------

PARAMS = dict.fromkeys(type(params) for entry in MODELS.values() for params in (entry.robot, entry.offline) if params)


@pytest.mark.parametrize("cls", PARAMS, ids=lambda cls: cls.__name__)
def test_parameters_are_frozen_closed_and_bounded(cls):
    """Each number has bounds, and NaN is none."""
    with pytest.raises(dataclasses.FrozenInstanceError):
        cls().new = 1
    with pytest.raises(ValueError, match="n_kon"):
        cls(n_kon=4)
    for field in dataclasses.fields(cls):
        value = getattr(cls(), field.name)
        if isinstance(value, int | float) and not isinstance(value, bool):
            for wrong in (float("nan"), -1e300, 1e300):
                with pytest.raises(ValueError, match=field.name):
                    cls(**{field.name: wrong})


def test_every_model_with_its_own_constants_gives_the_golden_responses(entry):
    """Largest and mean potentials of a crossing and of an approach, so that no constant changes unnoticed."""
    golden = json.loads((ROOT / "tests" / "golden" / "models.json").read_text())[entry.name]
    for preset in ("robot", "offline"):
        for clip, frames in {"crossing": oblique(), "approach": approach()}.items():
            series = entry.build(SHAPE, entry.preset(preset)).run(frames)
            found = [f(np.abs(getattr(series, channel))) for channel in entry.channels for f in (np.max, np.mean)]
            spikes = int(np.abs(series.hs_spikes).sum() + np.abs(series.vs_spikes).sum() + series.looming_spikes.sum())
            assert [*found, spikes] == pytest.approx(golden[f"{preset} {clip}"], rel=1e-4, abs=1e-7)
