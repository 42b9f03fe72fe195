"""Models by their equations: plain float64 beside the fast forms, with SciPy's filters, over noise and what moves."""

import itertools
import math

import numpy as np
import pytest
from scipy.ndimage import correlate, uniform_filter
from scipy.special import expit

import dsnn
from dsnn.stimuli import stimulus

WAYS = {"right": (0, 1), "left": (0, -1), "down": (1, 0), "up": (-1, 0)}


# --- clips ------------------------------------------------------------------------------------------------------------


def drifting(shape=(9, 11), count=12, greys=(0, 256)):
    """Noise that shifts obliquely, with a dark part."""
    picture = np.random.default_rng(5).integers(*greys, shape)
    picture[shape[0] // 3 : -4, shape[1] // 3 : -5] = 20
    return np.stack([np.roll(picture, (i // 3, i), (0, 1)) for i in range(count)]).astype(np.uint8)


def flickering(shape=(12, 15), count=10, seed=1):
    """Noise, then a part of it that changes much: cells that move and cells that hardly do."""
    rng = np.random.default_rng(seed)
    pixels = rng.integers(100, 104, (count, *shape))
    pixels[3:, 2:9, 3:12] += rng.integers(0, 80, (count - 3, 7, 9))
    return pixels.astype(np.uint8)


def growing(shape, count=9, seed=6):
    """A dark square that grows before a picture."""
    frames = np.repeat(np.random.default_rng(seed).integers(150, 250, (1, *shape)), count, axis=0).astype(np.uint8)
    for i, frame in enumerate(frames):
        down, across = 1 + i // 2, 1 + (i + 1) // 2
        frame[shape[0] // 2 - down : shape[0] // 2 + down, shape[1] // 2 - across : shape[1] // 2 + across] = 10
    return frames


# --- what equations share ---------------------------------------------------------------------------------------------


def gain(tau, fps):
    """The share of what is new in a low-pass by backward Euler."""
    return 1000 / (1000 + fps * tau)


def ring(side, corner, centre=0.0):
    return np.array([[corner, side, corner], [side, centre, side], [corner, side, corner]])


def bell(size, sigma):
    line = np.exp(-0.5 * ((np.arange(size) - size // 2) / sigma) ** 2)
    return np.outer(line, line) / line.sum() ** 2


def near(x, weights):
    """Weighted sums over neighbours, 0 outside the field."""
    return correlate(x, weights, mode="constant")


def field(x, size, sigma):
    """A Gaussian field, the border replicated."""
    return correlate(x, bell(size, sigma), mode="nearest")


def neighbour(x, down, right):
    """The value of the cell so far off, 0 outside the field."""
    rows, columns = x.shape[-2:]
    wide = np.pad(x, [(0, 0)] * (x.ndim - 2) + [(5, 5)] * 2)
    return wide[..., 5 + down : 5 + down + rows, 5 + right : 5 + right + columns]


def in_blocks(x, weights):
    """Weighted sums over neighbours of the same block of 3x3 cells."""
    rows, columns = x.shape
    blocks = x.reshape(rows // 3, 3, columns // 3, 3).swapaxes(1, 2)
    return near(blocks, weights[None, None]).swapaxes(1, 2).reshape(rows, columns)


def block_sums(x):
    rows, columns = x.shape
    return np.kron(x.reshape(rows // 3, 3, columns // 3, 3).sum(axis=(1, 3)), np.ones((3, 3)))


def changes_of(frames):
    return np.diff(frames.astype(float), axis=0, prepend=frames[:1])


def high_passed(frames, q):
    h, found = np.zeros(frames.shape[1:]), []
    for change in changes_of(frames):
        h = (1 - gain(q.tau_hp, q.fps)) * (h + change)
        found.append(h)
    return np.array(found)


def delayed(signals, q, first=0.0):
    state, found = first, []
    for signal in signals:
        state = state + gain(q.tau_lp, q.fps) * (signal - state)
        found.append(state)
    return np.array(found)


def correlated(d, c, s=1):
    """Mean opponent output along x and along y of a detector that multiplies what is delayed with what is not."""
    x = (d[:, :, :-s] * c[:, :, s:] - c[:, :, :-s] * d[:, :, s:]).sum(axis=(1, 2))
    y = (d[:, :-s] * c[:, s:] - c[:, :-s] * d[:, s:]).sum(axis=(1, 2))
    return {"hs": x / c[0].size, "vs": y / c[0].size}


def grouping(s, t_g, c_w=4.0, delta_c=0.01, ce=None):
    """What is left of S in groups (Yue and Rind 2006)."""
    ce = near(s, np.full((3, 3), 1 / 9)) if ce is None else ce
    g = s * ce / (delta_c + ce.max() / c_w)
    return np.where(g >= t_g, g, 0.0)


def adapted(potentials, q):
    """Spike-frequency adaptation of a series of potentials, and its spikes."""
    before, state, found, hold = 0.5, 0.5, [], 1 - gain(q.tau_sfa, q.fps)
    for k in potentials:
        rise, before = k - before, k
        state = max(0.5, hold * (state + rise if rise <= q.t_sfa else k))
        found.append(state)
    s = np.array(found)
    return {"looming": s, "looming_spikes": np.floor(np.exp(q.k_sp * (s - q.t_sp)))}


# --- the equations ----------------------------------------------------------------------------------------------------


def plain_emd(frames, q):
    hp, mean, h = gain(q.tau_hp, q.fps), frames[0].astype(float), []
    for frame in frames.astype(float):
        mean = mean + hp * (frame - mean)
        h.append((frame - mean if q.tau_hp else frame) / 255)
    h = np.array(h)
    outputs = correlated(delayed(h, q, first=h[0]), h, q.spacing)
    if q.log:
        outputs = {k: np.sign(v) * np.log1p(abs(v) * 255**2) / np.log1p(255**2) for k, v in outputs.items()}
    return outputs


def plain_emd_normalised(frames, q):
    h = high_passed(frames, q)
    c = np.tanh(h / (q.kappa + uniform_filter(abs(h), (1, q.pool, q.pool), mode="nearest")))
    return {channel: q.gain * v for channel, v in correlated(delayed(c, q), c).items()}


def plain_three_arm(frames, q):
    """Four quadrants are pairs of polarities; a cell prefers the way from its first arm to its last."""
    h = high_passed(frames, q) / 255
    x = {1: np.maximum(h, 0), -1: np.maximum(-h, 0)}
    lp = {sign: delayed(signal, q) for sign, signal in x.items()}
    pairs = [(1, 1), (-1, -1)] if q.quadrants == 2 else itertools.product((1, -1), repeat=2)

    def cells(a, b, c):
        return sum(
            i * j * (lp[i][a] * x[j][b] / (q.baseline + lp[j][c]) - x[i][a] * lp[j][b] / (q.baseline + x[j][c]))
            for i, j in pairs
        ).sum(axis=(1, 2))

    pairs, every = list(pairs), slice(None)
    line = slice(None, -2), slice(1, -1), slice(2, None)
    across, along = [(every, every, part) for part in line], [(every, part) for part in line]
    return {channel: q.gain * (cells(*arms) - cells(*arms[::-1])) / h[0].size
            for channel, arms in (("hs", across), ("vs", along))}  # fmt: skip


def plain_t4t5(frames, q):
    shape, delays = frames.shape[1:], [gain(tau, q.fps) for tau in (80.0, 70.0, 60.0, 50.0, 40.0)]
    signals, held, cells, found = np.zeros((2, *shape)), np.zeros((5, 2, *shape)), np.zeros((4, 2, *shape)), []
    for p in changes_of(frames):
        centre, surround = field(p, 3, 10.0), field(p, 5, 20.0)
        s = abs(centre - 1.2 * surround)
        fresh = [s * ((sign * centre > 1e-3) & (sign * surround > 1e-3)) for sign in (1, -1)]
        signals = np.stack(fresh) + 0.1 * signals
        c = np.stack([np.tanh(x / (0.2 + field(x, 5, 20.0))) for x in signals])
        c[c < 0.75] = 0.0
        drive = np.zeros_like(cells)
        for j, share in enumerate(delays, start=1):
            d = held[j - 1] = held[j - 1] + share * (c - held[j - 1])
            for way, (down, right) in enumerate(WAYS.values()):
                far_d, far_c = neighbour(d, j * down, j * right), neighbour(c, j * down, j * right)
                drive[way] += np.maximum(d * far_d * (far_c - q.emd_bias * c), 0.0)
        cells += gain(30.0, q.fps) * (drive - cells)
        right, left, down, up = (cells[:, 0] ** 0.9 + cells[:, 1] ** q.exp_off).sum(axis=(1, 2))
        found.append([expit(x / (0.01 * p.size)) - 0.5 for x in (right - left, down - up)])
    return dict(zip(("hs", "vs"), np.array(found).T, strict=True))


def plain_lgmd1(frames, q):
    """It spikes above its threshold, but not while the whole field moves: the veto is the last frame's change."""
    p = changes_of(frames)
    before = np.stack([p[0], *p[:-1]])
    s = np.maximum(abs(p) - [0.6 * abs(near(last, ring(0.25, 0.125))) for last in before], 0)
    k = np.array([expit(grouping(each, 30.0).sum() / each.size) for each in s])
    return {"looming": k, "looming_spikes": (k >= q.t_sp) & (abs(before).mean(axis=(1, 2)) < q.t_ffi)}


def plain_lgmd2(frames, q):
    """With the literature's weights and delays."""
    pathways = [(1, (2.0, 0.5, 0.25), (15, 30, 45), q.least_on), (-1, (1.0, 0.25, 0.125), (60, 120, 180), 0.5)]
    signals, held, pm, k = np.zeros((2, *frames[0].shape)), np.zeros((2, 3, *frames[0].shape)), 0.0, []
    for p in changes_of(frames):
        pm += gain(90, 30) * (abs(p).mean() - pm)
        s = []
        for i, (sign, weights, taus, least) in enumerate(pathways):
            signals[i] = np.maximum(sign * p, 0) + 0.1 * signals[i]
            for j, tau in enumerate(taus):
                held[i, j] += gain(tau, 30) * (signals[i] - held[i, j])
            centre, side, corner = weights
            inhibition = centre * held[i, 0] + near(held[i, 1], ring(side, 0)) + near(held[i, 2], ring(0, corner))
            s.append(np.maximum(signals[i] - max(least, pm / q.t_pm) * inhibition, 0))
        k.append(expit(grouping(s[0] + s[1] + s[0] * s[1], 30.0).sum() / p.size))
    return adapted(k, q)


def plain_si_lgmd1(frames, q):
    """In the firmware's whole numbers, or in float64."""
    whole = np.floor if q.integer else np.asarray
    alpha_e, alpha_p = gain(q.tau_e, q.fps), gain(q.tau_p, q.fps)
    e, inhibition, mean_before, found = np.zeros(frames[0].shape), np.zeros(frames[0].shape), 0.0, []
    for change in changes_of(frames):
        p = whole(np.minimum(abs(change) / 2, 127))
        e = whole(alpha_e * p + (1 - alpha_e) * e + 1e-9)
        inhibition = whole(alpha_p * p + (1 - alpha_p) * inhibition + 1e-9)
        lateral = near(whole(e / 4), ring(1, 0)) + near(whole(e / 8), ring(0, 1))
        s = whole(np.maximum(p - q.beta_1 * lateral, 0) + 1e-9)
        sides, corners = in_blocks(whole(inhibition / 4), ring(1, 0)), in_blocks(whole(inhibition / 8), ring(0, 1))
        itself = inhibition + sides + corners
        itself = np.minimum(itself, 255) if q.integer else itself
        strong = int(q.beta_2) if q.integer else q.beta_2
        s = (s - q.beta_3 * itself * np.where(block_sums(p) > q.t_az, strong, 1))[1:-1, 1:-1]
        total = s[s >= q.t_s].sum()
        silenced, mean_before = mean_before > q.t_ffi, p.mean()
        found.append(expit(0.0 if silenced else total / (q.k_spi * p.size)))
    return {"looming": np.array(found)}


def plain_si_lgmd2(frames, q):
    """The adapted potential: in the firmware's whole numbers, or in float64."""

    def floor(values):
        return np.floor(values + 1e-9) if q.integer else values

    def kept(values):
        return floor(np.clip(values, 0.0, 255.0 if q.integer else None))

    def mixed(tau, now, before):
        return gain(tau, q.fps) * now + (1 - gain(tau, q.fps)) * before

    def pathway(x, last, weigh, w, tau, tau_si, least, factor):
        """What lateral inhibition leaves of X, and the self-inhibition."""
        itself, sides, corners = (mixed(times * tau, x, last) for times in (1, 2, 3))
        lateral = kept(w * itself + near(w / 4 * sides, ring(1, 0)) + near(w / 8 * corners, ring(0, 1)))
        z = kept(mixed(tau_si, x, last))
        inhibition = floor(2 * w * z) + in_blocks(floor(w / 2 * z), ring(1, 0))
        inhibition += in_blocks(floor(w / 4 * z), ring(0, 1))
        return np.maximum(x - weigh * lateral, 0), inhibition * np.where(block_sums(x) > least, floor(factor), 1)

    last, mean_before, k = np.zeros((2, *frames.shape[1:])), 0.0, []
    for change in changes_of(frames):
        p = np.clip(change / 2, -127, 127)
        x = kept(np.stack([p, -p]))
        pm, mean_before = mixed(q.tau_pm, x.sum() / p.size, mean_before), x.sum() / p.size
        on = pathway(x[0], last[0], max(q.least_on, pm / q.t_pm), q.w_on, q.tau_on, q.tau_si_on, q.r_1, q.beta_1)
        off = pathway(x[1], last[1], max(q.least_off, pm / q.t_pm), q.w_off, q.tau_off, q.tau_si_off, q.r_2, q.beta_2)
        last = x
        s = kept(kept(q.o_on * on[0] + q.o_off * off[0]) - q.o_on * q.beta_3 * on[1] - q.o_off * q.beta_4 * off[1])
        ce = kept(near(s, np.ones((3, 3))) / 9)
        left = kept(grouping(s, 0.0, q.c_w, q.delta_c, ce))
        k.append(expit(left[left >= q.t_g].sum() / (q.k_spi * p.size)))
    return adapted(k, q)


def plain_pon_lgmd(frames, q):
    found, last = [], np.zeros((2, *frames.shape[1:]))
    for p in changes_of(frames):
        x = np.stack([np.maximum(p, 0), np.maximum(-p, 0)])
        m = np.stack([np.tanh(each / (correlate(each, bell(q.gauss_size, q.gauss_div), mode="mirror") + q.alpha_1))
                      for each in x])  # fmt: skip
        contrast, lateral = (
            np.stack([correlate(each, weights, mode="mirror") for each in signals])
            for signals, weights in ((m, ring(-0.125, -0.125, 1.0)), (last, ring(q.w_side, q.w_corner)))
        )
        s, last = np.maximum(m - q.beta * lateral - q.alpha_c * abs(contrast), 0.0), m
        joined = s[0] + s[1] + q.theta_3 * s[0] * s[1]
        ce = correlate(joined, np.full((3, 3), 1 / 9), mode="mirror")
        found.append(expit(grouping(joined, q.t_de / q.c_de, q.c_w, q.delta_c, ce).sum() / (q.k_sig * p.size)))
    return {"looming": np.array(found)}


def plain_lplc2(frames, q):
    """The fourth root of the product of what moves outward in the quadrants."""
    rows, columns = shape = frames.shape[1:]
    down, across = ((np.arange(size) + 0.5 - size / 2) for size in shape)
    bias = np.exp(-0.5 * (across / (q.spread * columns)) ** 2 - 0.5 * (down[:, None] / (q.spread * rows)) ** 2)

    def gelu(z):
        return z / 2 * (1 + np.tanh(math.sqrt(2 / math.pi) * (z + 0.044715 * z**3)))

    def half(off, far):
        """How much of a row or column is in the half at its far end; one in the middle counts half to both."""
        return np.where(off == 0, 0.5, (off > 0) == far)

    x, d, k_before = np.zeros((3, 2, *shape))
    t, products, found = np.zeros((2, 4, *shape)), [], []
    for p in changes_of(frames):
        p_e, p_i = field(p, 3, q.sigma_e), field(p, 5, q.sigma_i)
        motion = np.zeros((4, *shape))
        for side, (sign, exponent) in enumerate(((1, q.exp_on), (-1, q.exp_off))):
            x[side] = q.residue * x[side] + abs(p_e - p_i) * ((sign * p_e > 1e-3) & (sign * p_i > 1e-3))
            c = np.tanh(x[side] / (q.c_base + field(x[side], 11, q.sigma_c)))
            d[side] += gain(q.tau_lp, q.fps) * (c - d[side])
            k = abs(correlate(c, ring(-1 / 8, -1 / 8, 1.0), mode="nearest"))
            change, k_before[side] = q.coe_contrast * (k - k_before[side]), k
            for way, offset in enumerate(WAYS.values()):
                drive = bias * c * neighbour(c, *offset) * (d[side] - neighbour(d[side], *offset))
                t[side, way] += gain(q.tau_t, q.fps) * (drive - t[side, way])
            motion += np.maximum(t[side] - change, 0) ** exponent
        product = 1.0
        for low, right in itertools.product((False, True), repeat=2):
            along_x = (motion[0] - motion[1]) * (1 if right else -1)
            along_y = (motion[2] - motion[3]) * (1 if low else -1)
            product *= max(half(down, low) @ (gelu(along_x) + gelu(along_y)) @ half(across, right), 0.0)
        products.append(product)
        output = (sum(products[-q.length :]) / q.length) ** 0.25
        found.append(expit(output / (q.k_sig * rows * columns / 4)))
    return {"looming": np.array(found)}


# --- and the fast forms -----------------------------------------------------------------------------------------------

SENSITIVE = {"t_g": 1.0, "t_pm": 4.0, "least_on": 0.3, "beta_3": 0.2, "beta_4": 0.2, "k_spi": 0.1}
"""Much is kept in so small a field, the mean change weighs inhibition up, and self-inhibition leaves something."""
BRIGHT = {"least_on": 0.2, "t_pm": 255.0}
"""By default inhibition leaves nothing of what brightens, and its weights would not matter."""


NOISE = np.random.default_rng(7).integers(100, 130, (20, 24, 31), np.uint8)
NOISE[8:, :6] //= 2  # along the border
VETO = {"t_sp": 0.501, "t_ffi": 9.0}
"""The whole field's change is 10 grey levels in the first frames, less in the others."""
APPROACH = np.stack([frame.luma for frame in stimulus("looming", rows=36, columns=40, rest_s=0.0)])
CASES = {
    "emd": ("EMD", plain_emd, drifting(), {}, 1e-5),
    "emd, raw": ("EMD", plain_emd, drifting(), {"tau_hp": 0.0, "log": False}, 2e-7),
    "emd, wide": ("EMD", plain_emd, drifting(), {"spacing": 3, "tau_lp": 20.0, "fps": 60.0, "log": False}, 2e-7),
    "emd-normalised": ("EMDNormalised", plain_emd_normalised, drifting(), {}, 1e-4),
    "emd-normalised, small": ("EMDNormalised", plain_emd_normalised, drifting(),
                                  {"pool": 3, "kappa": 2.0, "fps": 60.0, "gain": 1.0}, 1e-5),
    "three-arm": ("ThreeArm", plain_three_arm, drifting(), {"quadrants": 2}, 1e-5),
    "three-arm-4q": ("ThreeArm", plain_three_arm, drifting(), {"quadrants": 4}, 1e-5),
    "t4t5": ("T4T5", plain_t4t5, drifting((14, 17), 8, (80, 200)), {"emd_bias": 1.5}),
    "t4t5, even": ("T4T5", plain_t4t5, drifting((14, 17), 8, (80, 200)), {"emd_bias": 1.0, "exp_off": 0.5}),
    "lgmd1": ("LGMD1", plain_lgmd1, NOISE, VETO, 2e-4),
    "lgmd1, in Python": ("LGMD1", plain_lgmd1, NOISE, VETO, 2e-4),
    "lgmd1, approach": ("LGMD1", plain_lgmd1, APPROACH, {}, 2e-4),
    "lgmd2": ("LGMD2", plain_lgmd2, NOISE, {}, 2e-4),
    "lgmd2, approach": ("LGMD2", plain_lgmd2, APPROACH, {}, 2e-4),
    "lgmd2, bright": ("LGMD2", plain_lgmd2, 255 - APPROACH, BRIGHT, 2e-4),
    "si-lgmd1": ("SILGMD1", plain_si_lgmd1, flickering(), {}),
    "si-lgmd1, bytes": ("SILGMD1", plain_si_lgmd1, flickering(seed=2), {"integer": True}),
    "si-lgmd1, free": ("SILGMD1", plain_si_lgmd1, flickering(), {"beta_3": 0.0, "t_ffi": 255.0, "fps": 60.0}),
    "si-lgmd2": ("SILGMD2", plain_si_lgmd2, flickering(), {}),
    "si-lgmd2, more": ("SILGMD2", plain_si_lgmd2, flickering(seed=2), SENSITIVE),
    "si-lgmd2, real": ("SILGMD2", plain_si_lgmd2, flickering(), {"integer": False, **SENSITIVE}),
    "pon-lgmd": ("PONLGMD", plain_pon_lgmd, flickering(seed=3), {"t_de": 0.2}),  # or nothing is kept
    "lplc2": ("LPLC2", plain_lplc2, growing((16, 19)), {"length": 5, "k_sig": 0.01}),
    "lplc2, odd": ("LPLC2", plain_lplc2, growing((15, 16)), {"length": 5, "k_sig": 0.01}),
}  # fmt: skip


@pytest.mark.parametrize("name", CASES)
def test_a_model_is_its_equations(name):
    model, plain, frames, changes, *bound = CASES[name]
    q, form = getattr(dsnn, f"{model}Params")(**changes), {"form": "reference"} if "Python" in name else {}
    series, atol = getattr(dsnn, model)(frames.shape[1:], q, **form).run(frames), bound[0] if bound else 1e-6
    for column, expected in plain(frames, q).items():
        rest = 0.5 if column == "looming" else 0.0
        np.testing.assert_allclose(getattr(series, column), expected, rtol=0, atol=atol, err_msg=column)
        assert column == "looming_spikes" or np.abs(expected - rest).max() > 20 * atol, "there is something to compare"
