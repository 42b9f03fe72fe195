"""What every registered model keeps beside the laws of ``colias check``, and what single ones are known for.

The laws themselves are tried on all in tests/bench/check.
"""

import dataclasses
import json
import warnings

import numpy as np
import pytest

from dsnn import (
    EMD,
    LGMD1,
    LGMD2,
    MODELS,
    DSNNParams,
    EMDParams,
    Flow,
    FlowParams,
    FrameError,
    Hybrid,
    HybridParams,
    LGMD1Params,
    LGMD2Params,
    ResponseSeries,
)
from dsnn.frames import luma
from tests.conftest import ROOT, crossing

SHAPE = (72, 99)
COLUMNS = tuple(field.name for field in dataclasses.fields(ResponseSeries) if field.name != "time_s")
DIRECTION = [name for name, entry in MODELS.items() if entry.channels == ("hs", "vs")]
LOOMING = [name for name, entry in MODELS.items() if entry.channels == ("looming",)]
REST = {"hs": 0.0, "vs": 0.0, "looming": 0.5, "azimuth": 0.0}
SATURATING = ("lgmd1", "lgmd2")
"""Looming detectors whose potential comes near 1; others have a scale of their own, or are silenced by noise."""
NEARLY = {"flow": 0.25}
"""px per frame: DIS lays its patches from the upper left corner, so a mirrored clip is answered only nearly alike."""
TURNED = {"dsnn-onboard": 0.01}
"""Its blur along y is rounded to 1/128 grey level before that along x, so a cell whose P_e or P_i is nearly 0 may fall
on either side of it. The bound is a twentieth of the threshold of a spike."""


@pytest.fixture(params=list(MODELS))
def entry(request):
    return MODELS[request.param]


@pytest.fixture
def model(entry):
    return entry.build(SHAPE, entry.robot)


def oblique(dark=True):
    """A clip that is no mirror image of itself: fast to the right, slowly down."""
    return np.stack([np.roll(frame, i // 2, axis=0) for i, frame in enumerate(crossing(dark=dark))])


def approach(dark=True, shape=SHAPE, size=4.0, focal=70.7):
    """A square of 4 cm coming at constant speed from 25 cm to 5 cm, off the field's centre, (100, R, C) uint8."""
    rows, columns = shape
    field, thing = (240.0, 20.0) if dark else (20.0, 240.0)
    frames = []
    for distance in np.linspace(25.0, 5.0, 100):
        half = focal * size / 2 / distance
        down, across = (
            np.clip(at + 1 + half, 0, 1) * np.clip(half - at, 0, 1)
            for at in (np.arange(rows) - rows / 2 + 3, np.arange(columns) - columns / 2 - 5)
        )
        frames.append(np.rint(field + (thing - field) * np.outer(down, across)))
    return np.stack(frames).astype(np.uint8)


def answered(entry):
    """A clip that the model answers: some looming detectors are made to be silent at translation."""
    return approach()[40:] if entry.name in LOOMING else oblique(dark="off-blocked" not in entry.name)


def texture(shape=SHAPE, seed=4):
    """A blurred random pattern from 0 to 255, float64, that meets itself at the border."""
    rows, columns = shape
    down, across = np.fft.fftfreq(rows)[:, None], np.fft.fftfreq(columns)
    smooth = np.exp(-0.5 * (2 * np.pi * 2.0) ** 2 * (down**2 + across**2))
    pattern = np.fft.ifft2(np.fft.fft2(np.random.default_rng(seed).normal(size=shape)) * smooth).real
    return np.interp(pattern, (pattern.min(), pattern.max()), (0.0, 255.0))


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
    frames = np.ascontiguousarray(answered(entry)[:, 16:52, 26:74])
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
@pytest.mark.parametrize("name", DIRECTION)
def test_direction_follows_mirror_and_transposition(name, dark):
    """With both directions weighing the same."""
    entry = MODELS[name]
    params = dataclasses.replace(entry.robot, w_i=1.0) if isinstance(entry.robot, DSNNParams) else entry.robot
    frames = oblique(dark)

    def answer(clip):
        return entry.build(clip.shape[1:], params).run(np.ascontiguousarray(clip))

    there, back = answer(frames), answer(frames[:, :, ::-1])
    down, up = (answer(clip.transpose(0, 2, 1)) for clip in (frames, frames[:, :, ::-1]))
    near = NEARLY.get(name, 0.0)
    if "blocked" not in name:
        assert there.hs.max() > max(0.1, 4 * near) and there.hs.min() > -there.hs.max() / 5, "rightward is positive"
    np.testing.assert_allclose(back.hs, -there.hs, atol=near or 1e-4)
    np.testing.assert_allclose(back.vs, there.vs, atol=near or 1e-3)  # what cancels is larger without FDSR
    np.testing.assert_array_equal(back.hs_spikes, -there.hs_spikes)
    np.testing.assert_allclose(up.vs, -down.vs, atol=near or 1e-4)
    np.testing.assert_allclose(up.hs, down.hs, atol=near or 1e-3)
    np.testing.assert_array_equal(up.vs_spikes, -down.vs_spikes)
    turned = (NEARLY | TURNED).get(name, 1e-4)  # the lamina's sign test jumps where a blur is zero but for rounding
    np.testing.assert_allclose(down.vs, there.hs, atol=turned)
    np.testing.assert_allclose(down.hs, there.vs, atol=turned)


@pytest.mark.parametrize("name", LOOMING)
def test_looming_knows_no_direction_and_passes_its_threshold_near_by(name):
    entry, frames = MODELS[name], approach()
    noise = np.random.default_rng(1).integers(0, 2, (12, *SHAPE)).astype(np.uint8) * 255
    whole = entry.build(SHAPE, entry.robot).run([*frames, *noise])
    near, before = whole.looming[80:100].max(), whole.looming[:20].max()
    assert near > entry.robot.t_sp > before
    assert whole.looming_spikes[67:100].sum() > whole.looming_spikes[:67].sum()
    least = 0.9 if name in SATURATING else entry.robot.t_sp
    assert 0.5 == whole.looming.min() < least < whole.looming.max() <= 1.0
    part = frames[60:]
    there = entry.build(SHAPE, entry.robot).run(part)
    for same in (part[:, :, ::-1], part[:, ::-1], part.transpose(0, 2, 1)):
        other = entry.build(same.shape[1:], entry.robot).run(np.ascontiguousarray(same))
        np.testing.assert_allclose(other.looming, there.looming, atol=1e-4)
        np.testing.assert_array_equal(other.looming_spikes, there.looming_spikes)
    assert there.looming_spikes.sum() > 0


def test_maps_and_refused_frames_leave_no_trace_and_floats_mean_the_same_grey(entry, model):
    """The layers are the DSNN's; a model without them shows none."""
    frames = oblique()[:12]
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
        other = model.run(frames.astype(kind))
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


@pytest.mark.parametrize(
    "frame",
    [np.zeros((72, 98), np.uint8), np.zeros((72, 99, 3), np.uint8), np.full(SHAPE, np.nan), np.full(SHAPE, np.inf),
     np.full(SHAPE, 256.0), np.full(SHAPE, -1.0), np.zeros(SHAPE, np.int32), [[0] * 99] * 72],
    ids=lambda frame: f"{getattr(frame, 'dtype', '')}{np.shape(frame)}",
)  # fmt: skip
def test_a_frame_that_cannot_be_taken_is_refused(frame):
    with pytest.raises(FrameError):
        luma(frame, SHAPE)


def test_frames_from_0_to_1_are_warned_of_once():
    clip = oblique()[:3]
    for shown, count in ([clip], 0), ([clip.astype(float), clip / 255], 0), ([clip / 255, clip / 255], 1):
        model = EMD(SHAPE)
        with warnings.catch_warnings(record=True) as given:
            warnings.simplefilter("always")
            for frames in shown:
                model.run(frames)
        assert len(given) == count


# --- the DSNN's family ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["dsnn", "dsnn-reference", "dsn2017"])
def test_a_crossing_passes_the_threshold_and_only_fdsr_keeps_the_other_axis_quiet(name):
    """Without it the forerunner answers by both axes, as the paper says of it (C6)."""
    entry = MODELS[name]
    series = entry.build(SHAPE, entry.robot).run(crossing())
    assert series.hs.max() > entry.robot.t_sp
    assert series.hs_spikes.max() > 0 <= series.hs_spikes.min()
    other = np.abs(series.vs).max()
    assert other > entry.robot.t_sp if name == "dsn2017" else other < series.hs.max() / 2


def test_blocked_pathways_sum_to_the_intact_model():
    """And each gives 40 to 60 % of the peak (C4)."""
    intact, on, off = (
        MODELS[name].build(SHAPE, MODELS[name].robot).run(oblique())
        for name in ("dsnn", "dsnn-off-blocked", "dsnn-on-blocked")
    )
    np.testing.assert_allclose(on.hs + off.hs, intact.hs, atol=1e-6)
    np.testing.assert_allclose(on.vs + off.vs, intact.vs, atol=1e-6)
    assert 0.4 < on.hs.max() / intact.hs.max() < 0.6


def test_the_hybrid_s_looming_spikes_silence_the_others_for_the_time_of_its_gate():
    """6 frames of 200 ms after each; only the approach passes so high a threshold."""
    frames = np.concatenate([oblique()[:20], approach()[90:], oblique()])
    params = HybridParams.robot(lgmd_t_sp=0.9999)
    hybrid, dsnn = Hybrid(SHAPE, params).run(frames), MODELS["dsnn"].build(SHAPE, MODELS["dsnn"].robot).run(frames)
    held = np.array([hybrid.looming_spikes[max(0, i - 6) : i + 1].any() for i in range(len(frames))])
    assert 0.1 < held.mean() < 0.6 and dsnn.hs_spikes[held].any()
    np.testing.assert_array_equal(hybrid.hs_spikes, np.where(held, 0, dsnn.hs_spikes))
    assert hybrid.hs_spikes.any()


def test_lgmd1_takes_dark_and_light_alike():
    """Yue and Rind's excitation is |P|: a photographic negative looms just as much."""
    model = LGMD1(SHAPE)
    assert_same(model.run(approach()), model.run(255 - approach()))


def test_lgmd2_prefers_dark_looming():
    """To light approaching and dark receding objects, whose edges brighten, it hardly answers (Fu, Hu and Yue)."""
    model = LGMD2(SHAPE)
    preferred = model.run(approach()).looming_spikes.sum()
    for other in (approach(dark=False), approach()[::-1]):
        assert model.run(other).looming_spikes.sum() < preferred / 10


def test_lgmd2_adapts_to_a_steady_translation():
    """A potential that does not rise fades within 0.8 s; one that rises does not."""
    frames = [np.roll(crossing(step=0.0, count=1)[0], 2 * i, axis=1) for i in range(30)]
    adapting, lasting = (LGMD2(SHAPE, LGMD2Params(tau_sfa=tau)).run(frames).looming for tau in (800.0, 10_000.0))
    assert lasting[5] > 0.78
    assert adapting[25] < 0.6 < 0.8 * lasting[25]


def test_feed_forward_inhibition_silences_lgmd1_while_the_whole_field_moves():
    """From the second moving frame on: the veto comes from the last frame's change."""
    frames = [np.roll(texture(), 2 * max(i - 2, 0), axis=1) for i in range(12)]
    assert LGMD1(SHAPE).run(frames).looming_spikes.tolist() == [0, 0, 0, 1] + [0] * 8
    deaf = LGMD1(SHAPE, LGMD1Params(t_ffi=255.0))
    assert deaf.run(frames).looming_spikes.tolist() == [0, 0, 0] + [1] * 9


def ring_sum(x, centre, side, corner):
    """A cell's, its sides' and its corners' weighted sum, nothing beyond the border."""
    weights = {0: centre, 1: side, 2: corner}
    rows, columns = x.shape
    beyond = np.pad(x, 1)
    return sum(
        weights[abs(i) + abs(j)] * beyond[1 + i : 1 + i + rows, 1 + j : 1 + j + columns]
        for i in (-1, 0, 1)
        for j in (-1, 0, 1)
    )


def grouped(s, t_g=30.0):
    ce = ring_sum(s, 1 / 9, 1 / 9, 1 / 9)
    g = s * ce / (0.01 + ce.max() / 4)
    return 1 / (1 + np.exp(-np.where(g >= t_g, g, 0).sum() / s.size))


def plain_lgmd1(frames):
    changes = np.diff(frames.astype(float), axis=0, prepend=frames[:1])
    before = np.concatenate([changes[:1], changes[:-1]])
    return [
        grouped(np.maximum(abs(p) - 0.6 * abs(ring_sum(b, 0, 0.25, 0.125)), 0))
        for p, b in zip(changes, before, strict=True)
    ]


def plain_lgmd2(frames):
    dt, pm, k_before, adapted, potentials = 1000 / 30, 0.0, 0.5, 0.5, []
    pathways = [(1, (2.0, 0.5, 0.25), (15, 30, 45), 1.0), (-1, (1.0, 0.25, 0.125), (60, 120, 180), 0.5)]
    signals, delayed = np.zeros((2, *frames[0].shape)), np.zeros((2, 3, *frames[0].shape))
    for p in np.diff(frames.astype(float), axis=0, prepend=frames[:1]):
        pm += dt / (dt + 90) * (abs(p).mean() - pm)
        s = []
        for i, (sign, weights, taus, least) in enumerate(pathways):
            signals[i] = np.maximum(sign * p, 0) + 0.1 * signals[i]
            for j, tau in enumerate(taus):
                delayed[i, j] += dt / (dt + tau) * (signals[i] - delayed[i, j])
            rings = np.diag(weights)
            inhibition = sum(ring_sum(d, *w) for d, w in zip(delayed[i], rings, strict=True))
            s.append(np.maximum(signals[i] - max(least, pm / 8) * inhibition, 0))
        k = grouped(s[0] + s[1] + s[0] * s[1])
        rise, k_before = k - k_before, k
        adapted = max(0.5, 800 / (800 + dt) * (adapted + rise if rise <= 0.003 else k))
        potentials.append(adapted)
    return potentials


@pytest.mark.parametrize(("cls", "plain"), [(LGMD1, plain_lgmd1), (LGMD2, plain_lgmd2)])
@pytest.mark.parametrize("clip", ["noise", "approach", "crossing"])
def test_looming_detectors_are_their_equations(cls, plain, clip):
    noise = np.random.default_rng(7).integers(100, 130, (20, 24, 31), np.uint8)
    noise[8:, :6] //= 2  # along the border
    frames = {"noise": noise, "approach": approach()[60:], "crossing": oblique()}[clip]
    series = cls(frames.shape[1:]).run(frames)
    np.testing.assert_allclose(series.looming, plain(frames), atol=2e-4)
    assert series.looming.max() > 0.52


def test_collision_after_enough_spikes():
    """In the approach it is announced near its end, and a reset takes it back."""
    model, count, seen = LGMD2(SHAPE), 0, []
    for frame in approach():
        spikes = model.step(frame).looming_spikes
        count = count + spikes if spikes else 0
        seen.append(model.collision)
        assert model.collision == (count >= 8)
    assert not any(seen[:50]) and any(seen[50:])
    model.reset()
    assert not model.collision


def plain_emd(frames, q):
    """The array as its equations read, in float64: mean opponent output along x and y, (T, 2)."""
    hp, lp = (1000 / q.fps / (1000 / q.fps + tau) for tau in (q.tau_hp, q.tau_lp))
    mean, delayed, outputs = frames[0].astype(float), None, []
    for frame in frames.astype(float):
        mean = mean + hp * (frame - mean)
        h = frame - mean if q.tau_hp else frame
        delayed = h if delayed is None else delayed + lp * (h - delayed)
        s = q.spacing
        x = (delayed[:, :-s] * h[:, s:] - h[:, :-s] * delayed[:, s:]).sum()
        y = (delayed[:-s] * h[s:] - h[:-s] * delayed[s:]).sum()
        outputs.append((x / frame.size, y / frame.size))
    return np.array(outputs)


@pytest.mark.parametrize("changes", [{}, {"tau_hp": 0.0}, {"spacing": 3, "tau_lp": 20.0, "fps": 60.0}])
def test_emd_is_its_equations(changes):
    q = EMDParams(log=False, **changes)
    frames = np.random.default_rng(6).integers(0, 256, (15, 20, 31), np.uint8)
    series = EMD((20, 31), q).run(frames)
    expected = plain_emd(frames, q) / 255**2
    np.testing.assert_allclose(np.column_stack([series.hs, series.vs]), expected, atol=2e-7)
    assert np.abs(expected).max() > 1e-4
    logarithmic = EMD((20, 31), dataclasses.replace(q, log=True)).run(frames).hs
    np.testing.assert_allclose(
        logarithmic, np.sign(series.hs) * np.log1p(np.abs(series.hs) * 255**2) / np.log1p(255**2), atol=1e-6
    )


@pytest.mark.parametrize("speed", [0.5, 1.0, 2.0, 3.0])
def test_emd_tells_temporal_frequency_as_reichardt_s_does(speed):
    """A drifting grating of wavelength w: A^2 sin(2 pi s / w) times the quadrature part of the delay's gain."""
    wave, amplitude, columns = 12, 80.0, 96
    q = EMDParams(log=False, tau_hp=0.0)
    phase = 2 * np.pi * (np.arange(columns) - speed * np.arange(240)[:, None]) / wave
    frames = np.repeat(128 + amplitude * np.sin(phase)[:, None], 40, axis=1)
    alpha, turn = (1000 / 30) / (1000 / 30 + q.tau_lp), 2 * np.pi * speed / wave
    gain = alpha / (1 - (1 - alpha) * np.exp(-1j * turn))
    expected = amplitude**2 * np.sin(2 * np.pi / wave) * -gain.imag * (columns - 1) / columns
    settled = EMD((40, columns), q).run(frames).hs[-120:] * 255**2  # whole periods at each speed
    assert settled.mean() == pytest.approx(expected, rel=0.01)


@pytest.mark.parametrize("shift", [1, 2])
def test_flow_is_in_px_per_frame(shift):
    frames = [np.roll(texture(), (-shift * i, 2 * shift * i), axis=(0, 1)) for i in range(8)]
    series = Flow(SHAPE, FlowParams("medium")).run(frames)
    assert np.median(series.hs[1:]) == pytest.approx(2 * shift, rel=0.15)
    assert np.median(series.vs[1:]) == pytest.approx(-shift, rel=0.15)


@pytest.mark.parametrize("shape", [(31, 99), (72, 8), (2, 2)])
def test_flow_refuses_images_that_would_crash_it(shape):
    with pytest.raises(FrameError, match="at least 32"):
        Flow(shape)


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
