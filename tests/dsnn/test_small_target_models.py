"""ESTMD and DSTMD: a plain second form by the published equations, the Gamma filters' law, and their tuning."""

import math

import numpy as np
import pytest
from scipy.ndimage import correlate

from dsnn import DSTMD, ESTMD, DSTMDParams, ESTMDParams
from dsnn.small_target.layers import Gamma
from dsnn.stimuli import stimulus

FORMS = {"estmd": (ESTMD, ESTMDParams), "dstmd": (DSTMD, DSTMDParams)}
STEPS = [(0, 1), (1, 1), (1, 0), (1, -1), (0, -1), (-1, -1), (-1, 0), (-1, 1)]
"""Rows and columns towards each preferred direction, from rightward on clockwise."""


# --- the second form: whole clips at once, in float64, every filter as a sum over the past --------------------------


def gamma(clip, order, tau, fps):
    """Each frame's sum over all before it, by the weights of m low-passes in a row, each with (1 - p) p^k."""
    m, p = order + 1, tau / order / (tau / order + 1000.0 / fps)
    found = np.zeros_like(clip)
    for now in range(len(clip)):
        for ago in range(now + 1):
            found[now] += math.comb(ago + m - 1, ago) * (1 - p) ** m * p**ago * clip[now - ago]
    return found


def inhibited(picture, q):
    kernel = np.empty((15, 15))
    for row in range(-7, 8):
        for column in range(-7, 8):
            one, other = (math.exp(-(row**2 + column**2) / (2 * s**2)) / (2 * math.pi * s**2)
                          for s in (q.sigma_centre, q.sigma_surround))  # fmt: skip
            kernel[row + 7, column + 7] = max(one - other, 0.0) - q.inhibition * max(other - one, 0.0)
    found = correlate(picture, kernel, mode="constant")
    return np.where(found > 1e-3, found, 0.0)


def polarities(frames, q):
    line = np.exp(-0.5 * (np.arange(-math.ceil(4 * q.sigma), math.ceil(4 * q.sigma) + 1) / q.sigma) ** 2)
    light = frames.astype(float) - frames[0]  # the filters begin settled on the first frame
    light = np.stack([correlate(each, np.outer(line, line) / line.sum() ** 2, mode="nearest") for each in light])
    band = gamma(light, 2, q.tau_fast, q.fps) - gamma(light, 3, q.tau_slow, q.fps)
    return np.where(band > 1e-3, band, 0.0), np.where(band < -1e-3, -band, 0.0)


def plain_estmd(frames, q):
    on, off = (np.stack([inhibited(each, q) for each in x]) for x in polarities(frames, q))
    return on * gamma(off, 12, q.tau_off, q.fps), None


def plain_dstmd(frames, q):
    on, off = polarities(frames, q)
    delayed = gamma(on, 3, q.tau_on, q.fps), gamma(off, 5, q.tau_off, q.fps), gamma(off, 8, q.tau_first, q.fps)
    zero = math.sqrt(2 * math.log(2) / (1 / 1.5**2 - 1 / 3**2))
    at = [k * zero / 2 for k in range(3)] + [zero + k * (math.sqrt(3) - 1) * zero for k in (1, 2)]
    weight = [math.exp(-x * x / 4.5) / 1.5 - math.exp(-x * x / 18) / 3 for x in at]
    weight = [w / math.sqrt(2 * math.pi) for w in [*weight, weight[3], weight[2], weight[1]]]
    weight[4] *= 2
    every = []
    for t in range(len(frames)):
        single = []
        for down, right in STEPS:
            reach = q.spacing if 0 in (down, right) else round(q.spacing / math.sqrt(2))
            found = np.zeros(frames.shape[1:])
            for r in range(q.spacing, found.shape[0] - q.spacing):
                for c in range(q.spacing, found.shape[1] - q.spacing):
                    a = r - reach * down, c - reach * right
                    found[r, c] = on[t, r, c] * (delayed[1][t, r, c] + delayed[0][t][a]) * delayed[2][t][a]
            single.append(inhibited(found, q))
        every.append([sum(weight[(i - j) % 8] * single[j] for j in range(8)) for i in range(8)])
    every = np.maximum(every, 0.0)
    return every.max(axis=1), every


@pytest.mark.parametrize(("name", "fps", "changes"), [
    ("estmd", 30.0, {}), ("estmd", 400.0, {"inhibition": 1.0, "sigma_surround": 2.0}), ("dstmd", 250.0, {}),
    ("dstmd", 60.0, {"spacing": 2, "tau_first": 20.0}),
])  # fmt: skip
def test_a_model_is_its_equations(name, fps, changes):
    clip = stimulus("target", 2, rows=24, columns=31, fps=fps, duration_s=24 / fps, background="pink", width=3.0,
                    height=3.0, speed=0.3 * fps, background_speed=0.2 * fps, direction_deg=30.0)  # fmt: skip
    frames, (model, params) = np.stack([frame.luma for frame in clip]), FORMS[name]
    q = params(fps=fps, **changes)
    series, (responses, every) = (
        model((24, 31), q).run(frames),
        {"estmd": plain_estmd, "dstmd": plain_dstmd}[name](frames, q),
    )
    np.testing.assert_allclose(series.target, responses.max(axis=(1, 2)), rtol=1e-3, atol=1e-5)
    assert series.target[-1] > 1e-3
    for t in range(4, len(frames)):
        r, c = np.unravel_index(responses[t].argmax(), (24, 31))
        assert (series.azimuth[t], series.elevation[t]) == pytest.approx(((2 * c + 1) / 31 - 1, (2 * r + 1) / 24 - 1))
        if every is not None:
            x, y = (sum(every[t, i, r, c] * f(i * math.pi / 4) for i in range(8)) for f in (math.cos, math.sin))
            assert series.target_direction[t] == pytest.approx(math.degrees(math.atan2(y, x)), abs=0.1)


@pytest.mark.parametrize(("order", "tau"), [(2, 3.0), (3, 6.0), (12, 25.0)])
def test_a_gamma_filter_is_the_published_kernel_at_a_high_rate(order, tau):
    """And its delay is the same at the robot's rate."""
    responses = {}
    for fps in (20_000.0, 30.0):
        filtered, pulse = Gamma((1, 1), order, tau, fps), np.ones((1, 1), np.float32)
        count = int(12 * tau * fps / 1000) + 60
        responses[fps] = np.array([float(filtered.step(pulse * (k == 0))[0, 0]) for k in range(count)])
        time_ms = np.arange(count) * 1000 / fps
        assert (responses[fps] * time_ms).sum() == pytest.approx(tau * (order + 1) / order, rel=1e-3)
        if fps > 30.0:
            kernel = (order * time_ms) ** order * np.exp(-order * time_ms / tau) * order
            kernel /= math.factorial(order) * tau ** (order + 1)
            assert np.abs(responses[fps] - kernel * 1000 / fps).sum() < 0.05


# --- what they are tuned to -------------------------------------------------------------------------------------------


def shown(name, *, fps=250.0, duration_s=0.4, **changes):
    model, params = FORMS[name]
    common = {"background": "even", "background_speed": 0.0, "speed": 200.0, "fps": fps, "duration_s": duration_s}
    clip = stimulus("target", **common | changes)
    return clip, model(clip.shape, params(fps=fps)).run(frame.luma for frame in clip)


def test_estmd_prefers_dark_targets_of_a_few_pixels_at_some_speed():
    peak = {height: shown("estmd", height=float(height))[1].target.max() for height in (1, 3, 5, 6, 12, 15)}
    best = max(peak, key=peak.get)
    assert best in (5, 6) and peak[1] < 0.2 * peak[best] and max(peak[12], peak[15]) < 0.5 * peak[best]
    assert shown("estmd", width=15.0, height=15.0)[1].target.max() < 0.01 * peak[5]
    slow, fast = (shown("estmd", speed=speed)[1].target.max() for speed in (20.0, 1500.0))
    assert max(slow, fast) < 0.1 * peak[5]
    assert shown("estmd", grey=255.0, background_grey=55.0)[1].target.max() < 0.01 * peak[5]


@pytest.mark.parametrize("turn", range(0, 360, 45))
def test_dstmd_says_where_a_target_is_and_which_way_it_goes(turn):
    clip, series = shown("dstmd", direction_deg=float(turn), duration_s=0.2, rows=48, columns=48)
    box = clip[40].truth.box
    assert series.target[40] > 100.0
    for position, first, extent, size in (("azimuth", box.left, 5.0, 48), ("elevation", box.top, 5.0, 48)):
        assert abs((getattr(series, position)[40] + 1) / 2 * size - first - extent / 2) < 6.0
    assert abs((series.target_direction[40] - turn + 180) % 360 - 180) < 22.5, "half a step"
