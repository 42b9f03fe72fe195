"""Laws of the stimuli: what is painted is what the truth beside it says, to fractions of a pixel."""

import json
import math
from itertools import pairwise

import cv2
import numpy as np
import pytest

from dsnn.stimuli import STIMULI, Jitter, stimulus
from dsnn.stimuli.background import panorama
from tests.conftest import ROOT

SMALL = {"rows": 48, "columns": 80}
DIRECTIONS = {"rightward": (1, 0), "leftward": (-1, 0), "downward": (0, 1), "upward": (0, -1)}


def lumas(clip):
    return np.stack([frame.luma for frame in clip])


def darkness(frame, background):
    """How much darker than the background each pixel is, or lighter."""
    return np.abs(background - frame.luma.astype(float))


def centroid(weights):
    """(x, y) in px, of pixel squares' centres."""
    rows, columns = np.indices(weights.shape) + 0.5
    return (weights * columns).sum() / weights.sum(), (weights * rows).sum() / weights.sum()


# --- every stimulus, beside the laws of ``colias check`` --------------------------------------------------------------


@pytest.mark.parametrize("name", STIMULI)
def test_other_seeds_give_other_frames_where_something_is_random(name):
    one, other = (lumas(stimulus(name, seed=seed, fps=10, **SMALL)) for seed in (1, 2))
    random = name in ("cluttered", "grating", "dots", "reverse-phi", "foliage", "street", "target")
    assert np.array_equal(one, other) != random


@pytest.mark.parametrize("name", ["plain", "grating", "dots", "edge", "bar", "reverse-phi"])
def test_the_rest_is_still_and_the_truth_says_so(name):
    """Not the clutter, whose background is never at rest, nor the wind, which rises."""
    clip = stimulus(name, rest_s=0.5, **SMALL)
    for frame in list(clip)[:15]:
        np.testing.assert_array_equal(frame.luma, clip[0].luma)
    assert {frame.truth.motion for frame in list(clip)[:15]} == {"still"}
    assert clip[18].truth.motion == "rightward"


VARIANTS = {
    **{name: (name, {}) for name in STIMULI},
    "street, cars": ("street", {"kind": "car", "movers": "group"}),
    "looming, a disc": ("looming", {"outline": "disc"}),
    "cluttered, pink": ("cluttered", {"background": "pink"}),
    "grating, square": ("grating", {"waveform": "square"}),
}


@pytest.mark.parametrize("variant", VARIANTS)
def test_a_stimulus_is_the_golden_one(variant):
    """Its length, its mean grey, that of its left half, and its mean change, so that nothing changes unnoticed."""
    name, changes = VARIANTS[variant]
    frames = lumas(stimulus(name, 1, fps=10, **SMALL, **changes)).astype(float)
    numbers = [len(frames), frames.mean(), frames[:, :, :40].mean(), np.abs(np.diff(frames, axis=0)).mean()]
    golden = json.loads((ROOT / "tests" / "golden" / "stimuli.json").read_text())
    assert numbers == pytest.approx(golden[variant], rel=1e-6)


# --- the object -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("motion", "grey", "ground"),
    [("rightward", 40, 200), ("leftward", 255, 10), ("downward", 255, 10), ("upward", 40, 200), ("looming", 255, 10),
     ("receding", 40, 200)],
)  # fmt: skip
def test_the_painted_object_is_the_truth_s_box(motion, grey, ground):
    size = {"width": 23.7, "height": 31.3, "speed": 51.0, "far_scale": 0.3}
    clip = stimulus("plain", motion=motion, grey=grey, background_grey=ground, enters=False, offset=3.4, **size)
    rows, columns = clip.shape
    for frame in list(clip)[::4]:
        box, dark = frame.truth.box, darkness(frame, ground)
        assert min(box.left, box.top, columns - box.left - box.width, rows - box.top - box.height) > -1e-9
        x, y = centroid(dark)
        assert abs(x - (box.left + box.width / 2)) < 0.05
        assert abs(y - (box.top + box.height / 2)) < 0.05
        # Marginal sums over a fully covered row and column are the width and the height.
        assert dark.max(axis=0).sum() / abs(ground - grey) == pytest.approx(box.width, abs=0.05)
        assert dark.max(axis=1).sum() / abs(ground - grey) == pytest.approx(box.height, abs=0.05)


@pytest.mark.parametrize(("motion", "speed"), [*zip(DIRECTIONS, (21.0, 120.0, 333.3, 50.0), strict=True)])
def test_the_object_moves_at_the_speed_commanded(motion, speed):
    clip = stimulus("plain", motion=motion, speed=speed, width=30.5, height=20.25, enters=False, rest_s=0.1)
    moving = [frame.truth for frame in clip if frame.truth.motion == motion][:-1]  # the last step may be a part of one
    places = np.array([(truth.box.left, truth.box.top) for truth in moving])
    expected = np.array(DIRECTIONS[motion]) * speed
    np.testing.assert_allclose(np.diff(places, axis=0) * clip.fps, np.tile(expected, (len(moving) - 1, 1)), atol=1e-6)
    assert len(moving) > 5 and {truth.velocity for truth in moving} == {tuple(expected)}


@pytest.mark.parametrize("motion", DIRECTIONS)
def test_a_crossing_begins_and_ends_outside_without_a_flash(motion):
    clip = stimulus("plain", motion=motion, speed=90.0)
    first, last = clip[0], clip[-1]
    assert first.truth.box is last.truth.box is None
    assert (first.luma == 200).all() and (last.luma == 200).all()
    swept = [np.abs(b - a).sum() / 160 for a, b in pairwise(lumas(clip).astype(float))]
    edges = 2 * (90 if DIRECTIONS[motion][0] else 50)  # the leading and the trailing one, px
    assert 0 < max(swept) < 1.02 * edges * 90.0 / 30
    assert swept[:9] == [0] * 9


def test_size_times_time_to_contact_is_constant():
    clip = stimulus("plain", motion="looming", far_scale=0.3, near_scale=1.9)
    moving = [frame for frame in clip if frame.truth.motion == "looming"]
    painted = [darkness(frame, 200).max(axis=0).sum() / 160 for frame in moving]
    products = [width * frame.truth.time_to_contact_s for width, frame in zip(painted, moving, strict=True)]
    np.testing.assert_allclose(products, products[0], rtol=3e-3)
    np.testing.assert_allclose(np.diff([frame.truth.time_to_contact_s for frame in moving]), -1 / 30)
    assert painted[0] == pytest.approx(0.3 * 50, abs=0.05)
    assert clip[-1].truth.box.width == pytest.approx(1.9 * 50)


# --- the background ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("image", "speed"), [("photograph", -10.0), ("pink", -2.0), ("photograph", 37.5)])
def test_the_background_shifts_as_commanded(image, speed):
    """By whole pixels in a whole number of frames: the same columns, but for what rounding to greys does."""
    clip = stimulus("cluttered", background=image, background_speed=speed, object="absent", seed=4)
    apart, px = (60, round(2 * speed))
    before, after = (clip[i].luma.astype(int) for i in (7, 7 + apart))
    same = (before[:, -px:], after[:, :px]) if px < 0 else (before[:, :-px], after[:, px:])
    assert np.abs(same[0] - same[1]).max() <= 1
    assert {clip[i].truth.background_velocity for i in (0, 40, 90)} == {(speed, 0.0)}
    assert {frame.truth.box for frame in clip} == {None}


@pytest.mark.parametrize("motion", ["rightward", "looming"])
def test_speeds_by_the_frame_are_those_by_the_second(motion):
    """Of the object and of the background."""
    clips = [
        lumas(stimulus("cluttered", rows=40, columns=80, fps=25.0, motion=motion, duration_s=0.4, **speeds))
        for speeds in (
            {"speed": 100.0, "background_speed": -50.0},
            {"speed": 4.0, "background_speed": -2.0, "speed_unit": "px/frame"},
        )
    ]
    np.testing.assert_array_equal(*clips)


@pytest.mark.parametrize("image", ["photograph", "pink"])
def test_the_background_repeats_without_a_seam(image):
    """No step between neighbouring columns stands out, where the image meets itself least of all."""
    view = panorama(image, (180, 540), 0)
    around = np.concatenate([view.view(0.0), view.view(540.0), view.view(view.period)[:, :1]], axis=1).astype(float)
    assert around.shape[1] == view.period + 1
    steps = np.abs(np.diff(around, axis=1)).mean(axis=0)
    for seam in (539, 1079):
        assert steps[seam] <= np.quantile(steps, 0.95)


def test_sub_pixel_shifts_keep_mean_and_sharpness():
    """Interpolation between whole pixels would blur at each half pixel, and the texture would flicker."""
    view = panorama("photograph", (180, 540), 0)
    sharpness = [
        cv2.Laplacian(view.view(100 + f).astype(float), cv2.CV_64F)[4:-4, 4:-4].std() for f in np.linspace(0, 1, 17)
    ]
    assert max(sharpness) / min(sharpness) < 1.05
    means = [view.view(200 + f)[:, 2:-2].mean() for f in np.linspace(0, 1, 17)]
    assert np.ptp(means) < 0.5


def test_the_object_hides_the_background():
    common = {"seed": 2, "background_speed": -10}
    whole, alone = stimulus("cluttered", **common), stimulus("cluttered", object="absent", **common)
    index = len(whole) // 2
    box = whole[index].truth.box
    inside = np.zeros(whole.shape, bool)
    inside[math.ceil(box.top) : int(box.top + box.height), math.ceil(box.left) : int(box.left + box.width)] = True
    assert (whole[index].luma[inside] == 0).all()
    outside = ~cv2.dilate(inside.astype(np.uint8), np.ones((3, 3))).astype(bool)
    np.testing.assert_array_equal(whole[index].luma[outside], alone[index].luma[outside])


# --- the others -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("waveform", "direction"), [("sine", 0), ("square", 40), ("sine", 90), ("square", 180)])
def test_a_grating_has_its_period_its_frequency_and_its_direction(waveform, direction):
    clip = stimulus("grating", waveform=waveform, direction_deg=direction, period_px=16, temporal_hz=3, rest_s=0)
    frames = lumas(clip)[:60].astype(float)  # 2 s, six periods
    spectrum = np.fft.fft(frames - frames.mean(axis=0), axis=0)
    assert np.abs(spectrum).sum(axis=(1, 2))[:31].argmax() == 6
    phase = np.angle(spectrum[6])  # advances against the drift
    turn = math.radians(direction)
    for axis, wave in ((1, math.cos(turn) / 16), (0, math.sin(turn) / 16)):
        advance = np.angle(np.exp(1j * np.diff(phase, axis=axis)).mean()) / (2 * np.pi)
        assert advance == pytest.approx(-wave, abs=2e-4)
    assert np.hypot(*clip[5].truth.background_velocity) == pytest.approx(48)


def test_a_grating_has_its_contrast_and_mean():
    frames = lumas(stimulus("grating", contrast=0.5, mean_grey=100, period_px=64))
    assert (frames.min(), frames.max()) == (50, 150)
    assert frames.mean() == pytest.approx(100, abs=0.5)
    assert np.ptp(lumas(stimulus("grating", contrast=0))) == 0


@pytest.mark.parametrize("coherence", [0.0, 0.3, 1.0])
def test_dots_move_together_as_much_as_asked_for(coherence):
    clip = stimulus("dots", coherence=coherence, count=150, size=3, speed=150, rest_s=0, duration_s=3, seed=1)
    dark = 200.0 - lumas(clip)
    dark -= dark.mean(axis=(1, 2), keepdims=True)
    moved = [(np.roll(a, 5, axis=1) * b).mean() for a, b in pairwise(dark)]  # 5 px a frame
    assert np.mean(moved) / dark.var() == pytest.approx(coherence, abs=0.03)


def test_dots_are_of_the_number_and_size_asked_for():
    clip = stimulus("dots", count=40, size=3.5, seed=1)
    covered = (200.0 - lumas(clip)).sum(axis=(1, 2)) / 160
    assert covered.max() == pytest.approx(40 * 3.5**2, rel=2e-2)  # less where dots overlap
    assert covered.min() > 0.9 * 40 * 3.5**2


@pytest.mark.parametrize(("motion", "polarity"), [*zip(DIRECTIONS, ("on", "off", "off", "on"), strict=True)])
def test_an_edge_only_brightens_or_only_darkens(motion, polarity):
    sign = 1 if polarity == "on" else -1
    clip = stimulus("edge", motion=motion, polarity=polarity, speed=77.0, dark_grey=50, light_grey=180)
    change = sign * np.diff(lumas(clip).astype(int), axis=0)
    assert change.min() == 0
    assert (change.sum(axis=0) == 130).all()  # and it passes every pixel


@pytest.mark.parametrize("motion", DIRECTIONS)
def test_a_bar_has_an_edge_of_either_polarity(motion):
    clip = stimulus("bar", motion=motion, thickness=12.5, speed=90.0, dark_grey=50, light_grey=180)
    frame = clip[len(clip) // 2]
    light = frame.luma.astype(float) - 50
    assert light.sum() / 130 == pytest.approx(
        12.5 * (clip.shape[0] if DIRECTIONS[motion][0] else clip.shape[1]), rel=2e-3
    )
    box = frame.truth.box
    assert centroid(light) == pytest.approx((box.left + box.width / 2, box.top + box.height / 2), abs=0.05)
    assert (clip[0].luma == 50).all() and (clip[-1].luma == 50).all()


@pytest.mark.parametrize(("motion", "sign"), [*zip(DIRECTIONS, (-1, 1, -1, 1), strict=True)])
def test_reverse_phi_reverses_contrast_at_each_displacement(motion, sign):
    kind = "reversed" if sign < 0 else "kept"
    clip = stimulus("reverse-phi", contrast_at_a_step=kind, motion=motion, step_px=4, step_frames=3, rest_s=0)
    x, y = DIRECTIONS[motion]
    pictures = lumas(clip).astype(int) - 120
    for before, after in zip(pictures[:-3:3], pictures[3::3], strict=True):
        np.testing.assert_array_equal(after, sign * np.roll(before, (4 * y, 4 * x), axis=(0, 1)))
    assert np.array_equal(pictures[0], pictures[1]) and np.array_equal(pictures[0], pictures[2])
    assert clip[0].truth.background_velocity == (40 * x, 40 * y)


PAIRS = ("on-on", "off-off", "on-off", "off-on")


@pytest.mark.parametrize(("motion", "polarity"), [*zip(DIRECTIONS, PAIRS, strict=True)])
def test_apparent_motion_is_two_steps_of_the_signs_asked_for(motion, polarity):
    """Each step changes its own bars alone, by the amplitude, and they stay; the second is a spacing further on.

    The truth moves from the one step to the other.
    """
    size = {"width_px": 3, "spacing_px": 6, "rows": 90, "columns": 130}
    clip = stimulus("apparent", motion=motion, polarity=polarity, delay_frames=3, rest_s=0.2, **size)
    frames = lumas(clip).astype(int)
    change = np.diff(frames, axis=0)
    assert np.flatnonzero(np.abs(change).sum(axis=(1, 2))).tolist() == [5, 8]  # steps at frames 6 and 9
    first, second = (change[i] for i in (5, 8))
    signs = {"on": 80, "off": -80}
    assert [sorted({*np.unique(step)}) for step in (first, second)] == [
        sorted({0, signs[sign]}) for sign in polarity.split("-")
    ]
    x, y = DIRECTIONS[motion]
    np.testing.assert_array_equal(np.roll(first != 0, (6 * y, 6 * x), axis=(0, 1)), second != 0)
    pairs = 3 if x else 2  # those of 40 px that are whole inside the frame
    assert (first != 0).sum() == pairs * 3 * (90 if x else 130)
    assert (frames[0] == 120).all()
    truths = [(frame.truth.motion, frame.truth.background_velocity) for frame in clip]
    assert truths[6:9] == [(motion, (60.0 * x, 60.0 * y))] * 3, "6 px in 3 frames"
    assert {*truths[:6], *truths[9:]} == {("still", (0.0, 0.0))}


def test_foliage_sways_in_its_band_and_goes_nowhere():
    wind = {"low_hz": 1.0, "high_hz": 2.0, "amplitude_px": (1.5, 1.0)}
    clip = stimulus("foliage", **wind, duration_s=8, rest_s=0, seed=1, rows=96, columns=96)
    trace = lumas(clip)[:240].astype(float)
    spectrum = (np.abs(np.fft.rfft(trace - trace.mean(axis=0), axis=0)) ** 2).sum(axis=(1, 2))
    hertz = np.fft.rfftfreq(240, 1 / 30)
    # A texture turns a sway into harmonics of it, but little of it falls below the band.
    assert spectrum[hertz < 0.7].sum() < 0.25 * spectrum.sum()
    assert spectrum[(hertz > 0.7) & (hertz < 5)].sum() > 0.7 * spectrum.sum()
    moved = np.array([clip._sway.places(i, 30.0) for i in range(240)]) - clip._sway.places(0, 30.0, wind=0.0)
    assert np.abs(moved.mean(axis=0)).mean() < 0.5, "on the average it is where it was"
    about_their_mean = np.sqrt(moved.var(axis=(2, 3)).mean(axis=0))
    assert about_their_mean == pytest.approx([1.5, 1.0], rel=0.1)


def test_jitter_moves_image_and_truth_by_the_same_fraction_of_a_pixel():
    still = stimulus("plain", width=30, height=40, speed=50, enters=False)
    clip = Jitter(still, 0.4, seed=9)
    for frame in list(clip)[15:-15]:  # not where it touches the border
        x, y = centroid(darkness(frame, 200)[10:-10])
        box = frame.truth.box
        assert (x, y + 10) == pytest.approx((box.left + box.width / 2, box.top + box.height / 2), abs=0.06)
    assert clip.shifts.std() == pytest.approx(0.4, rel=0.2)
    assert clip[7].truth.box == still[7].truth.box.shifted(*clip.shifts[7])


# --- what is refused --------------------------------------------------------------------------------------------------

REFUSED = {
    "plain": ({"speed": math.nan}, {"motion": "sideways"}, {"width": 400, "enters": False}, {"speeed": 3}),
    "edge": ({"dark_grey": 220},),
    "apparent": ({"width_px": 5}, {"amplitude": 121}),
}


@pytest.mark.parametrize("name", REFUSED)
def test_a_value_that_is_not_legal_is_named(name):
    for changes in REFUSED[name]:
        with pytest.raises(ValueError, match=next(iter(changes))):
            stimulus(name, **changes)


@pytest.mark.parametrize(("turn", "shift"), [(0.0, 0.0), (0.0, 45.0), (135.0, -30.0), (270.0, 60.0)])
def test_a_target_is_painted_at_its_box_and_its_speed_is_relative_to_the_clutter(turn, shift):
    """By what it changes in the picture; having left the frame on one side it enters it on the other."""
    common = {"direction_deg": turn, "background_speed": shift, "width": 4.0, "height": 2.5, "speed": 90.0}
    with_it, without = (stimulus("target", 3, object=kind, **common) for kind in ("present", "absent"))
    places, outside = [], 0
    for frame, bare in zip(with_it, without, strict=True):
        box, changed = frame.truth.box, np.abs(frame.luma.astype(float) - bare.luma)
        outside += box is None
        assert bare.truth.box is None and (changed.sum() > 0) == (box is not None)
        if box and min(box.left, box.top, 99 - box.left - box.width, 72 - box.top - box.height) > 0:
            x, y = centroid(changed / np.maximum(bare.luma, 1.0))
            assert abs(x - (box.left + 2.0)) < 0.35 and abs(y - (box.top + 1.25)) < 0.35
            places.append((box.left, box.top))
    steps = np.diff(places, axis=0)
    angle = math.radians(turn)
    expected = np.array([90.0 * math.cos(angle) + shift, 90.0 * math.sin(angle)]) / 30.0
    alike = np.abs(steps - expected).max(axis=1) < 1e-9
    assert outside and alike.sum() > len(alike) - 6, "but for its entries"
    moved = with_it[1].truth
    assert moved.background_velocity == (shift, 0.0)
    assert np.subtract(moved.velocity, expected * 30.0) == pytest.approx([0.0, 0.0], abs=1e-8)
