"""Laws that every registered model keeps: one suite over the registry, so a new model is tested the day it is added."""

import dataclasses
import warnings

import numpy as np
import pytest

from dsnn import (
    EMD,
    LGMD1,
    LGMD2,
    LPLC2,
    LPLC2GF,
    MODELS,
    SILGMD1,
    T4T5,
    DSNNParams,
    EMDParams,
    Flow,
    FlowParams,
    FrameError,
    LGMD1Params,
    LGMD2Params,
    ModelEntry,
    Response,
    ResponseSeries,
    VisionModel,
    model_entry,
)
from tests.conftest import crossing

SHAPE = (72, 99)
COLUMNS = tuple(field.name for field in dataclasses.fields(ResponseSeries) if field.name != "time_s")
DIRECTION = [name for name, entry in MODELS.items() if entry.channels == ("hs", "vs")]
LOOMING = [name for name, entry in MODELS.items() if entry.channels == ("looming",)]
FAMILY = [name for name, entry in MODELS.items() if isinstance(entry.robot, DSNNParams)]
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


@pytest.fixture(params=DIRECTION)
def direction(request):
    return MODELS[request.param]


@pytest.fixture(params=LOOMING)
def looming(request):
    return MODELS[request.param]


def balanced(entry):
    """Parameters with which both directions weigh the same."""
    return dataclasses.replace(entry.robot, w_i=1.0) if entry.name in FAMILY else entry.robot


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


def test_says_what_it_is(entry):
    assert entry.summary and "References" in entry.build.__doc__
    assert entry.channels in (("hs", "vs"), ("looming",), ("hs", "vs", "looming", "azimuth"))


def test_offers_the_protocol(model):
    assert isinstance(model, VisionModel)
    assert model.shape == SHAPE


def test_a_still_scene_is_silent(entry, model):
    frame = np.random.default_rng(3).integers(0, 256, SHAPE, np.uint8)
    for _ in range(5):
        answer = model.step(frame)
        for channel, rest in REST.items():
            assert getattr(answer, channel) == (rest if channel in entry.channels else 0.0), channel
        assert (answer.hs_spikes, answer.vs_spikes, answer.looming_spikes) == (0, 0, 0)


def test_comes_to_rest_when_the_scene_does(entry, model):
    frames = answered(entry)
    series = model.run([*frames, *[frames[-1]] * 400])
    for channel in entry.channels:
        potential = getattr(series, channel)
        assert np.abs(potential[: len(frames)] - REST[channel]).max() > 0.01
        assert potential[-1] == pytest.approx(REST[channel], abs=1e-6)


@pytest.mark.parametrize(
    ("cls", "states"),
    [
        (EMD, lambda m: (m._h, m._d)),
        (LGMD2, lambda m: (m._on._states, m._off._states)),
        (T4T5, lambda m: (m._local._signals, m._local._delayed, m._local._cells)),
        (LPLC2, lambda m: (m._signals, m._delayed, m._cells)),
        (LPLC2GF, lambda m: (m._h, m._delayed)),
        (SILGMD1, lambda m: (m._delayed,)),
    ],
)
def test_a_clip_that_goes_still_leaves_no_subnormals(cls, states):
    """In which states that fade would linger, and take a processor many times longer."""
    frames = oblique()[:, 20:44, 30:63]
    model = cls((24, 33))
    model.run([*frames, *[frames[-1]] * 1500])
    for state in states(model):
        size = np.abs(state)
        assert not ((size > 0) & (size < np.finfo(np.float32).tiny)).any()


def test_answers_by_its_own_channels_alone(entry, model):
    series = model.run(oblique())
    for name in COLUMNS:
        if name.removesuffix("_spikes") not in entry.channels:
            assert not getattr(series, name).any(), name


def test_rightward_and_downward_are_positive(direction):
    across = direction.build(SHAPE, direction.robot).run(crossing()).hs
    down = direction.build(SHAPE[::-1], direction.robot).run(crossing().transpose(0, 2, 1)).vs
    for potential in (across, down):
        assert potential.max() > 0.1
        assert potential.min() > -potential.max() / 10


@pytest.mark.parametrize("name", ["dsnn", "dsnn-reference", "dsn2017"])
def test_a_crossing_passes_the_threshold(name):
    series = MODELS[name].build(SHAPE, MODELS[name].robot).run(crossing())
    assert series.hs.max() > MODELS[name].robot.t_sp
    assert series.hs_spikes.max() > 0 <= series.hs_spikes.min()


@pytest.mark.parametrize("name", ["dsnn", "dsnn-reference"])
def test_the_other_axis_is_quiet(name):
    """The DSNN's; its forerunner without FDSR answers by both axes, as the paper says of it (C6)."""
    series = MODELS[name].build(SHAPE, MODELS[name].robot).run(crossing())
    assert np.abs(series.vs).max() < series.hs.max() / 2


def test_without_fdsr_the_other_axis_answers_too():
    series = MODELS["dsn2017"].build(SHAPE, MODELS["dsn2017"].robot).run(crossing())
    assert np.abs(series.vs).max() > MODELS["dsn2017"].robot.t_sp


def test_blocked_pathways_sum_to_the_intact_model():
    """And each gives 40 to 60 % of the peak (C4)."""
    intact, on, off = (
        MODELS[name].build(SHAPE, MODELS[name].robot).run(oblique())
        for name in ("dsnn", "dsnn-off-blocked", "dsnn-on-blocked")
    )
    np.testing.assert_allclose(on.hs + off.hs, intact.hs, atol=1e-6)
    np.testing.assert_allclose(on.vs + off.vs, intact.vs, atol=1e-6)
    assert 0.4 < on.hs.max() / intact.hs.max() < 0.6


def test_a_blocked_pathway_adds_nothing():
    """A scene that only brightens has no OFF signal, so with ON blocked it is black."""
    brightening = np.repeat(np.arange(0, 200, 10, dtype=np.uint8), 72 * 99).reshape(20, *SHAPE)
    brightening += np.random.default_rng(0).integers(0, 40, SHAPE, np.uint8)
    brightening[:, :, 50:] //= 2
    blocked = MODELS["dsnn-on-blocked"].build(SHAPE, MODELS["dsnn-on-blocked"].robot).run(brightening)
    intact = MODELS["dsnn"].build(SHAPE, MODELS["dsnn"].robot).run(brightening)
    assert np.abs(intact.hs).max() > 0 == np.abs(blocked.hs).max()


@pytest.mark.parametrize("dark", [True, False])
def test_mirror_left_right_swaps_the_sign_of_hs_and_keeps_vs(direction, dark):
    model, frames = direction.build(SHAPE, balanced(direction)), oblique(dark)
    there, back = model.run(frames), model.run(frames[:, :, ::-1])
    near = NEARLY.get(direction.name, 0.0)
    np.testing.assert_allclose(back.hs, -there.hs, atol=near or 1e-4)
    np.testing.assert_allclose(back.vs, there.vs, atol=near or 1e-3)  # what cancels is larger without FDSR
    np.testing.assert_array_equal(back.hs_spikes, -there.hs_spikes)
    assert np.abs(there.hs).max() > max(0.1, 4 * near)


def test_mirror_up_down_swaps_the_sign_of_vs_and_keeps_hs(direction):
    model, frames = direction.build(SHAPE[::-1], balanced(direction)), oblique().transpose(0, 2, 1)
    there, back = model.run(frames), model.run(frames[:, ::-1])
    near = NEARLY.get(direction.name, 0.0)
    np.testing.assert_allclose(back.vs, -there.vs, atol=near or 1e-4)
    np.testing.assert_allclose(back.hs, there.hs, atol=near or 1e-3)
    np.testing.assert_array_equal(back.vs_spikes, -there.vs_spikes)
    assert np.abs(there.vs).max() > max(0.1, 4 * near)


def test_transposing_the_image_swaps_hs_and_vs(direction):
    frames = oblique()
    upright = direction.build(SHAPE, direction.robot).run(frames)
    turned = direction.build(SHAPE[::-1], direction.robot).run(frames.transpose(0, 2, 1))
    near = (NEARLY | TURNED).get(
        direction.name, 1e-4
    )  # the lamina's sign test jumps where a blur is zero but for rounding
    np.testing.assert_allclose(turned.vs, upright.hs, atol=near)
    np.testing.assert_allclose(turned.hs, upright.vs, atol=near)


def test_looming_knows_no_direction(looming):
    frames = approach()
    there = looming.build(SHAPE, looming.robot).run(frames)
    for same in (frames[:, :, ::-1], frames[:, ::-1], frames.transpose(0, 2, 1)):
        other = looming.build(same.shape[1:], looming.robot).run(same)
        np.testing.assert_allclose(other.looming, there.looming, atol=1e-4)
        np.testing.assert_array_equal(other.looming_spikes, there.looming_spikes)
    assert there.looming_spikes.sum() > 0


def test_a_looming_dark_object_passes_the_threshold_near_by(looming):
    series = looming.build(SHAPE, looming.robot).run(approach())
    assert series.looming[-20:].max() > looming.robot.t_sp > series.looming[:20].max()
    assert series.looming_spikes[-33:].sum() > series.looming_spikes[:-33].sum()


def test_the_potential_of_looming_stays_in_its_range(looming):
    noise = np.random.default_rng(1).integers(0, 2, (12, *SHAPE)).astype(np.uint8) * 255
    potential = looming.build(SHAPE, looming.robot).run([*approach(), *noise]).looming
    least = 0.9 if looming.name in SATURATING else looming.robot.t_sp
    assert 0.5 == potential.min() < least < potential.max() <= 1.0


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


def test_lgmd1_by_hand():
    """One cell of 100 grey levels, then its neighbour: from the equations, with pencil and paper."""
    frames = np.zeros((3, 9, 11), np.uint8)
    frames[1:, 4, 5] = 100
    frames[2, 4, 6] = 100
    _, first, second = LGMD1((9, 11)).run(frames).looming

    def k(s):
        ce = s / 9
        return 1 / (1 + np.exp(-(s * ce / (0.01 + ce / 4)) / 99))

    assert first == pytest.approx(k(100.0), rel=1e-6)
    assert second == pytest.approx(k(100.0 - 0.6 * 0.25 * 100.0), rel=1e-6)


def test_lgmd2_by_hand():
    """A cell that darkens by 100 grey levels: the OFF pathway loses its own delayed signal, then adapts."""
    frames = np.full((2, 9, 11), 200, np.uint8)
    frames[1, 4, 5] = 100
    model, dt = LGMD2((9, 11)), 1000 / 30
    s = 100.0 - 0.5 * 1.0 * 100.0 * dt / (dt + 60)  # PM is a few tenths of a grey level: the least weight, 0.5
    ce = s / 9
    k = 1 / (1 + np.exp(-(s * ce / (0.01 + ce / 4)) / 99))
    assert model.run(frames).looming[1] == pytest.approx(800 / (800 + dt) * k, rel=1e-5)


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


@pytest.mark.parametrize(("cls", "needed"), [(LGMD1, 5), (LGMD2, 8)])
def test_collision_after_enough_spikes(cls, needed):
    """In the approach it is announced near its end, and a reset takes it back."""
    model, count, seen = cls(SHAPE), 0, []
    for frame in approach():
        spikes = model.step(frame).looming_spikes
        count = count + spikes if spikes else 0
        seen.append(model.collision)
        assert model.collision == (count >= needed)
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


def test_reset_makes_runs_repeat_and_run_equals_steps(entry, model):
    frames = np.random.default_rng(1).integers(0, 256, (12, *SHAPE), np.uint8)
    first = model.run(frames)
    model.reset()
    assert_same(first, ResponseSeries.from_responses(model.step(frame) for frame in frames))
    assert_same(first, model.run(iter(frames)))
    assert_same(first, entry.build(SHAPE, entry.robot).run(frames))
    for name in COLUMNS:
        column = getattr(first, name)
        assert (len(column), column.dtype.kind) == (12, "i" if name.endswith("spikes") else "f")


def test_asking_for_maps_changes_no_answer(entry, model):
    """The layers are the DSNN's; a model without them shows none."""
    frames = crossing(count=20)
    plain = model.run(frames)
    model.reset()
    answers = [model.step(frame, maps=True) for frame in frames]
    assert_same(plain, ResponseSeries.from_responses(answers))
    kept = answers[10].maps
    if entry.name in FAMILY:
        assert kept is not None and kept.p.shape == SHAPE
        assert not np.array_equal(kept.p, answers[11].maps.p), "maps are copies, not views of a buffer in use"
    else:
        assert kept is None


def test_the_caller_may_reuse_its_frame_buffer(model):
    frames = crossing(count=15)
    buffer = np.empty_like(frames[0])
    clean = model.run(frames)
    model.reset()
    reused = []
    for frame in frames:
        buffer[:] = frame
        reused.append(model.step(buffer))
        buffer[:] = 0
    assert_same(ResponseSeries.from_responses(reused), clean)


def test_colour_and_float_frames_mean_the_same_grey(entry, model):
    grey = oblique()[:10]
    series = model.run(grey)
    for kind in (np.float64, np.float32):
        other = model.run(grey.astype(kind))
        for channel in entry.channels:
            np.testing.assert_allclose(getattr(other, channel), getattr(series, channel), atol=1e-6)
    colour = np.repeat(grey[..., None], 3, axis=-1)
    assert_same(model.run(colour, channels="rgb"), series)


def frames_seen(model, *shown) -> int:
    """How many warnings a model gives that is shown these frames, twice over."""
    with warnings.catch_warnings(record=True) as given:
        warnings.simplefilter("always")
        for frames in (*shown, *shown):
            model.run(frames)
    return len(given)


def test_frames_from_0_to_1_are_warned_of_once(entry):
    clip = oblique()[:3]
    masks = (clip > 128).astype(float)
    for frames in (clip, clip.astype(float), masks, np.zeros(clip.shape)):
        assert frames_seen(entry.build(SHAPE, entry.robot), frames) == 0
    for shown in ([clip / 255], [clip, clip / 255], [masks, clip / 255]):
        assert frames_seen(entry.build(SHAPE, entry.robot), *shown) == 1
    dark = [clip.astype(float), clip / 255]  # levels above 1 came before, so these are of the same scale
    assert frames_seen(entry.build(SHAPE, entry.robot), *dark) == 0


def test_rgb_and_bgr_differ_by_their_order(entry, model):
    grey = answered(entry)
    rgb = np.stack([grey, grey, 255 - grey], axis=-1)
    there = model.run(rgb, channels="rgb")
    assert_same(there, model.run(rgb[..., ::-1].copy(), channels="bgr"))
    swapped = model.run(rgb, channels="bgr")
    assert any(not np.array_equal(getattr(there, c), getattr(swapped, c)) for c in entry.channels)


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
    answers = []
    for frame in frames:
        with pytest.raises(FrameError):
            model.step(np.full(SHAPE, np.nan))
        answers.append(model.step(frame))
    assert_same(ResponseSeries.from_responses(answers), clean)


@pytest.mark.parametrize("shape", [(72,), (0, 5), (1, 99), "ab", (72.0, "x")])
def test_a_shape_it_cannot_take_is_a_clear_error(entry, shape):
    with pytest.raises(FrameError):
        entry.build(shape, entry.robot)


def test_an_unknown_name_is_answered_with_the_nearest():
    with pytest.raises(ValueError, match="nearest: dsnn"):
        model_entry("dsn")


def test_presets():
    """The DSNN's threshold is lower off line (0.16 for 0.2); a model with one set of parameters has it everywhere."""
    assert (MODELS["dsnn"].preset("robot").t_sp, MODELS["dsnn"].preset("offline").t_sp) == (0.2, 0.16)
    assert not MODELS["dsn2017"].preset("offline").fdsr
    assert MODELS["emd"].preset("offline") == MODELS["emd"].robot


def test_a_user_s_entry_needs_no_more_than_four_fields():
    entry = ModelEntry("mine", "of a user", LGMD1, LGMD1Params())
    assert entry.preset("offline") is entry.robot
    assert entry.channels == ("hs", "vs")
    assert Response(0.1, -0.2, 3, -4) == Response(hs=0.1, vs=-0.2, hs_spikes=3, vs_spikes=-4, looming=0.0)


@pytest.mark.parametrize(
    ("cls", "name", "value"),
    [(EMDParams, "tau_lp", -1.0), (EMDParams, "spacing", 0), (FlowParams, "preset", "quick"),
     (LGMD1Params, "t_sp", 0.5), (LGMD1Params, "n_sp", 0), (LGMD1Params, "c_w", 0.0),
     (LGMD2Params, "tau_on", (1.0, 2.0)), (LGMD2Params, "t_pm", 0.0), (LGMD2Params, "sigma", 1.0)],
)  # fmt: skip
def test_a_parameter_out_of_range_is_named(cls, name, value):
    with pytest.raises(ValueError, match=name):
        cls(**{name: value})
