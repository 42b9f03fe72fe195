"""The looming models by their equations: plain implementations beside the fast ones, and what their papers publish."""

import math

import numpy as np
import pytest

from dsnn import (
    LPLC2,
    LPLC2GF,
    MLPLC2,
    PONLGMD,
    SILGMD1,
    SILGMD2,
    T4T5,
    LPLC2GFParams,
    LPLC2Params,
    PONLGMDParams,
    SILGMD1Params,
    SILGMD2Params,
    T4T5Params,
)
from dsnn.stimuli import stimulus

SIDES, CORNERS = ((0, 1), (1, 0), (0, -1), (-1, 0)), ((1, 1), (1, -1), (-1, 1), (-1, -1))


def clip(seed, frames=14, shape=(12, 15)):
    """Noise, then a part of it that changes much: cells that move and cells that hardly do."""
    rng = np.random.default_rng(seed)
    pixels = rng.integers(100, 104, (frames, *shape))
    pixels[3:, 2:9, 3:12] += rng.integers(0, 80, (frames - 3, 7, 9))
    return pixels.astype(np.uint8)


def at(image, row, column):
    """A cell, 0 outside the field."""
    inside = 0 <= row < len(image) and 0 <= column < len(image[0])
    return image[row][column] if inside else 0.0


def plain_si_lgmd1(frames, q):
    """SI-LGMD1 cell by cell: in the firmware's whole numbers, or in float64."""
    rows, columns = frames.shape[1:]
    whole = math.floor if q.integer else float
    alpha_e, alpha_p = (1000 / q.fps / (1000 / q.fps + tau) for tau in (q.tau_e, q.tau_p))
    e, inhibition = ([[0.0] * columns for _ in range(rows)] for _ in range(2))
    before, mean_before, potentials = frames[0].astype(float), 0.0, []
    cells = [(r, c) for r in range(rows) for c in range(columns)]
    for frame in frames.astype(float):
        p = [[whole(min(abs(frame[r][c] - before[r][c]) / 2, 127)) for c in range(columns)] for r in range(rows)]
        for r, c in cells:
            e[r][c] = whole(alpha_e * p[r][c] + (1 - alpha_e) * e[r][c] + 1e-9)
            inhibition[r][c] = whole(alpha_p * p[r][c] + (1 - alpha_p) * inhibition[r][c] + 1e-9)
        total = 0.0
        for r, c in cells:
            if not (0 < r < rows - 1 and 0 < c < columns - 1):
                continue
            lateral = sum(whole(at(e, r + i, c + j) / 4) for i, j in SIDES)
            lateral += sum(whole(at(e, r + i, c + j) / 8) for i, j in CORNERS)
            s = whole(max(p[r][c] - q.beta_1 * lateral, 0) + 1e-9)
            block = [(3 * (r // 3) + i, 3 * (c // 3) + j) for i in range(3) for j in range(3)]
            itself = inhibition[r][c]
            for places, share in ((SIDES, 4), (CORNERS, 8)):
                near = [(r + i, c + j) for i, j in places if (r + i, c + j) in block]
                itself += sum(whole(inhibition[i][j] / share) for i, j in near)
            if q.integer:
                itself = min(itself, 255)
            if sum(p[i][j] for i, j in block) > q.t_az:
                itself *= int(q.beta_2) if q.integer else q.beta_2
            s -= q.beta_3 * itself
            total += s if s >= q.t_s else 0.0
        silenced, mean_before = mean_before > q.t_ffi, sum(map(sum, p)) / (rows * columns)
        potentials.append(1 / (1 + math.exp(0.0 if silenced else -total / (q.k_spi * rows * columns))))
        before = frame
    return np.array(potentials)


@pytest.mark.parametrize("changes", [{}, {"integer": True}, {"beta_3": 0.0, "t_ffi": 255.0, "fps": 60.0}])
@pytest.mark.parametrize("seed", [1, 2])
def test_si_lgmd1_is_its_equations(changes, seed):
    q, frames = SILGMD1Params(**changes), clip(seed)
    potentials = SILGMD1(frames.shape[1:], q).run(frames).looming
    np.testing.assert_allclose(potentials, plain_si_lgmd1(frames, q), rtol=0, atol=1e-6)
    assert potentials.max() > 0.55


def plain_si_lgmd2(frames, q):
    """The adapted potential of SI-LGMD2: in the firmware's whole numbers, or in float64."""
    shape, dt = frames.shape[1:], 1000 / q.fps
    square = (*SIDES, *CORNERS, (0, 0))

    def floor(values):
        return np.floor(values + 1e-9) if q.integer else values

    def kept(values):
        return floor(np.clip(values, 0.0, 255.0 if q.integer else None))

    def mixed(tau, now, before):
        return dt / (dt + tau) * now + tau / (dt + tau) * before

    def near(image, places):
        """The sum over neighbours, 0 outside the field."""
        return np.array([[sum(at(image, r + i, c + j) for i, j in places) for c in range(shape[1])]
                         for r in range(shape[0])], float)  # fmt: skip

    def pathway(x, last, weigh, w, tau, tau_si, least, factor):
        """What lateral inhibition leaves of X, and the self-inhibition."""
        itself, sides, corners = (mixed(times * tau, x, last) for times in (1, 2, 3))
        lateral = kept(w * itself + near(w / 4 * sides, SIDES) + near(w / 8 * corners, CORNERS))
        z, inhibition = kept(mixed(tau_si, x, last)), np.zeros(shape)
        terms = {0: floor(2 * w * z), 1: floor(w / 2 * z), 2: floor(w / 4 * z)}
        for r, c in np.ndindex(shape):
            block = [(3 * (r // 3) + i, 3 * (c // 3) + j) for i in range(3) for j in range(3)]
            total = sum(at(terms[(r - i) ** 2 + (c - j) ** 2], i, j)
                        for i, j in block if max(abs(r - i), abs(c - j)) < 2)  # fmt: skip
            inhibition[r, c] = total * (floor(factor) if sum(at(x, i, j) for i, j in block) > least else 1)
        return np.maximum(x - weigh * lateral, 0), inhibition

    last, mean_before, k_before, adapted, potentials = np.zeros((2, *shape)), 0.0, 0.5, 0.5, []
    before = frames[0].astype(float)
    for frame in frames.astype(float):
        p, before = np.clip((frame - before) / 2, -127, 127), frame
        x = kept(np.stack([p, -p]))
        pm, mean_before = mixed(q.tau_pm, x.sum() / p.size, mean_before), x.sum() / p.size
        on = pathway(x[0], last[0], max(q.least_on, pm / q.t_pm), q.w_on, q.tau_on, q.tau_si_on, q.r_1, q.beta_1)
        off = pathway(x[1], last[1], max(q.least_off, pm / q.t_pm), q.w_off, q.tau_off, q.tau_si_off, q.r_2, q.beta_2)
        last = x
        s = kept(kept(q.o_on * on[0] + q.o_off * off[0]) - q.o_on * q.beta_3 * on[1] - q.o_off * q.beta_4 * off[1])
        ce = kept(near(s, square) / 9)
        grouped = kept(s * ce / (q.delta_c + ce.max() / q.c_w))
        grouped[grouped < q.t_g] = 0.0
        k = 1 / (1 + math.exp(-grouped.sum() / (q.k_spi * p.size)))
        rise, k_before = k - k_before, k
        adapted = max(0.5, q.tau_sfa / (q.tau_sfa + dt) * (adapted + rise if rise <= q.t_sfa else k))
        potentials.append(adapted)
    return np.array(potentials)


SENSITIVE = {"t_g": 1.0, "t_pm": 4.0, "least_on": 0.3, "beta_3": 0.2, "beta_4": 0.2, "k_spi": 0.1}
"""Much is kept in so small a field, the mean change weighs inhibition up, and self-inhibition leaves something."""


@pytest.mark.parametrize("changes", [{}, SENSITIVE, {"integer": False, **SENSITIVE}], ids=["bytes", "more", "real"])
@pytest.mark.parametrize("seed", [1, 2])
def test_si_lgmd2_is_its_equations(changes, seed):
    q, frames = SILGMD2Params(**changes), clip(seed, frames=8)
    answers = SILGMD2(frames.shape[1:], q).run(frames)
    expected = plain_si_lgmd2(frames, q)
    np.testing.assert_allclose(answers.looming, expected, rtol=0, atol=1e-6)
    np.testing.assert_array_equal(answers.looming_spikes, np.floor(np.exp(q.k_sp * (expected - q.t_sp))))
    assert answers.looming.max() > 0.55


def field(image, size, sigma):
    """A Gaussian field of ``size`` px, the border replicated."""
    bell = np.exp(-0.5 * ((np.arange(size) - size // 2) / sigma) ** 2)
    bell /= bell.sum()
    padded, (rows, columns) = np.pad(image, size // 2, mode="edge"), image.shape
    return sum(bell[i] * bell[j] * padded[i : i + rows, j : j + columns] for i in range(size) for j in range(size))


def plain_lplc2(frames, q):
    """LPLC2's potential in float64, cell by cell where cells are paired and quadrants are summed."""
    (rows, columns), dt = frames.shape[1:], 1000 / q.fps
    cells = list(np.ndindex(rows, columns))
    ways = {"right": (0, 1), "left": (0, -1), "down": (1, 0), "up": (-1, 0)}

    def gelu(z):
        return z / 2 * (1 + math.tanh(math.sqrt(2 / math.pi) * (z + 0.044715 * z**3)))

    def share(place, size, far):
        """How much of a row or column is in the half at its far end; one in the middle counts half to both."""
        off = place + 0.5 - size / 2
        return 0.5 if off == 0 else float((off > 0) == far)

    bias = np.array([
        math.exp(-0.5 * ((c + 0.5 - columns / 2) / (q.spread * columns)) ** 2
                 - 0.5 * ((r + 0.5 - rows / 2) / (q.spread * rows)) ** 2)
        for r, c in cells
    ]).reshape(rows, columns)  # fmt: skip
    x, d, k_before = np.zeros((3, 2, rows, columns))
    t = np.zeros((2, 4, rows, columns))
    before, products, potentials = frames[0].astype(float), [], []
    for frame in frames.astype(float):
        p, before = frame - before, frame
        p_e, p_i = field(p, 3, q.sigma_e), field(p, 5, q.sigma_i)
        motion = dict.fromkeys(ways, 0.0)
        for side, (sign, exponent) in enumerate(((1, q.exp_on), (-1, q.exp_off))):
            x[side] = q.residue * x[side] + abs(p_e - p_i) * ((sign * p_e > 1e-3) & (sign * p_i > 1e-3))
            c = np.tanh(x[side] / (q.c_base + field(x[side], 11, q.sigma_c)))
            d[side] += dt / (dt + q.tau_lp) * (c - d[side])
            padded = np.pad(c, 1, mode="edge")
            neighbours = [padded[1 + i : 1 + i + rows, 1 + j : 1 + j + columns] for i, j in (*SIDES, *CORNERS)]
            k = abs(c - sum(neighbours) / 8)
            change, k_before[side] = q.coe_contrast * (k - k_before[side]), k
            for way, (down, right) in enumerate(ways.values()):
                for r, column in cells:
                    there, drive = (r + down, column + right), 0.0
                    if 0 <= there[0] < rows and 0 <= there[1] < columns:
                        drive = bias[r, column] * c[r, column] * c[there] * (d[side][r, column] - d[side][there])
                    t[side, way, r, column] += dt / (dt + q.tau_t) * (drive - t[side, way, r, column])
            for way, name in enumerate(ways):
                motion[name] = motion[name] + np.maximum(t[side, way] - change, 0) ** exponent
        product = 1.0
        for low, right in ((False, False), (False, True), (True, False), (True, True)):
            along_x, along_y = (motion["right"] - motion["left"]) * (1 if right else -1), motion["down"] - motion["up"]
            along_y = along_y if low else -along_y
            quadrant = sum(
                share(r, rows, low) * share(c, columns, right) * (gelu(along_x[r, c]) + gelu(along_y[r, c]))
                for r, c in cells
            )
            product *= max(quadrant, 0.0)
        products.append(product)
        output = (sum(products[-q.length :]) / q.length) ** 0.25
        potentials.append(1 / (1 + math.exp(-output / (q.k_sig * rows * columns / 4))))
    return np.array(potentials)


@pytest.mark.parametrize("shape", [(16, 19), (15, 16)])
def test_lplc2_is_its_equations(shape):
    """A dark square that grows before a picture, for more frames than the output is averaged over."""
    q = LPLC2Params(length=5, k_sig=0.01)
    frames = np.repeat(np.random.default_rng(6).integers(150, 250, (1, *shape)), 9, axis=0).astype(np.uint8)
    for i, frame in enumerate(frames):
        half = 1 + i // 2, 1 + (i + 1) // 2
        frame[shape[0] // 2 - half[0] : shape[0] // 2 + half[0], shape[1] // 2 - half[1] : shape[1] // 2 + half[1]] = 10
    potentials = LPLC2(shape, q).run(frames).looming
    np.testing.assert_allclose(potentials, plain_lplc2(frames, q), rtol=0, atol=1e-6)
    assert potentials[: q.length - 1].max() > 0.55 and potentials[q.length :].max() > 0.55


def mirrored(place, size):
    """The cell that stands for one outside a field of ``size``: the border mirrored about its outermost cells."""
    place = abs(place)
    return 2 * (size - 1) - place if place >= size else place


def around(image, row, column, radius, weight):
    """A weighted sum over the square of ``radius`` about a cell."""
    rows, columns = image.shape
    reach = range(-radius, radius + 1)
    return sum(
        weight(i, j) * image[mirrored(row + i, rows), mirrored(column + j, columns)] for i in reach for j in reach
    )


def plain_pon_lgmd(frames, q):
    """P-ON/OFF LGMD cell by cell in float64."""
    shape, radius = frames.shape[1:], q.gauss_size // 2
    bell = np.exp(-0.5 * (np.arange(-radius, radius + 1) / q.gauss_div) ** 2)
    bell /= bell.sum()
    inhibiting = {0: 0.0, 1: q.w_side, 2: q.w_corner}
    motion_before, before, potentials = np.zeros((2, *shape)), frames[0].astype(float), []
    cells = list(np.ndindex(*shape))
    for frame in frames.astype(float):
        p, s = frame - before, np.zeros((2, *shape))
        for side, x in enumerate((np.maximum(p, 0), np.maximum(-p, 0))):
            m = np.zeros(shape)
            for r, c in cells:
                near = around(x, r, c, radius, lambda i, j: bell[i + radius] * bell[j + radius])
                m[r, c] = math.tanh(x[r, c] / (near + q.alpha_1))
            for r, c in cells:
                contrast = abs(m[r, c] - around(m, r, c, 1, lambda i, j: 0.125 * bool(i or j)))
                lateral = around(motion_before[side], r, c, 1, lambda i, j: inhibiting[abs(i) + abs(j)])
                s[side, r, c] = max(m[r, c] - q.beta * lateral - q.alpha_c * contrast, 0.0)
            motion_before[side] = m
        joined = s[0] + s[1] + q.theta_3 * s[0] * s[1]
        ce = np.array([around(joined, r, c, 1, lambda i, j: 1 / 9) for r, c in cells]).reshape(shape)
        grouped = joined * ce / (q.delta_c + ce.max() / q.c_w)
        grouped[q.c_de * grouped < q.t_de] = 0.0
        potentials.append(1 / (1 + math.exp(-grouped.sum() / (q.k_sig * grouped.size))))
        before = frame
    return np.array(potentials)


@pytest.mark.parametrize("seed", [3, 4])
def test_pon_lgmd_is_its_equations(seed):
    frames = clip(seed, frames=7)
    q = PONLGMDParams(t_de=0.2)  # so that many groups are kept in so small a field
    potentials = PONLGMD(frames.shape[1:], q).run(frames).looming
    np.testing.assert_allclose(potentials, plain_pon_lgmd(frames, q), rtol=0, atol=1e-6)
    assert potentials.max() > 0.55


def plain_t4t5(frames, q):
    """HS and VS of the T4 and T5 cells in float64, cell by cell where cells are paired."""
    shape, dt = frames.shape[1:], 1000 / q.fps
    delays = [dt / (dt + tau) for tau in (80.0, 70.0, 60.0, 50.0, 40.0)]

    signals, delayed, cells = np.zeros((2, *shape)), np.zeros((5, 2, *shape)), np.zeros((4, 2, *shape))
    before, potentials = frames[0].astype(float), []
    for frame in frames.astype(float):
        p, before = frame - before, frame
        centre, surround = field(p, 3, 10.0), field(p, 5, 20.0)
        s = abs(centre - 1.2 * surround)
        fresh = np.stack([s * ((centre > 1e-3) & (surround > 1e-3)), s * ((centre < -1e-3) & (surround < -1e-3))])
        signals = fresh + 0.1 * signals
        c = np.stack([np.tanh(x / (0.2 + field(x, 5, 20.0))) for x in signals])
        c[c < 0.75] = 0.0
        drive = np.zeros_like(cells)
        for j, gain in enumerate(delays, start=1):
            d = delayed[j - 1] = delayed[j - 1] + gain * (c - delayed[j - 1])
            for way, (down, right) in enumerate(((0, j), (0, -j), (j, 0), (-j, 0))):
                for side, row, column in np.ndindex(c.shape):
                    there = row + down, column + right
                    if 0 <= there[0] < shape[0] and 0 <= there[1] < shape[1]:
                        here, far = (side, row, column), (side, *there)
                        drive[(way, *here)] += max(d[here] * d[far] * (c[far] - q.emd_bias * c[here]), 0.0)
        cells += dt / (dt + 30.0) * (drive - cells)
        motion = cells[:, 0] ** 0.9 + cells[:, 1] ** 0.5
        right, left, downward, up = motion.sum(axis=(1, 2))
        scale = 0.01 * shape[0] * shape[1]
        potentials.append([1 / (1 + math.exp(-x / scale)) - 0.5 for x in (right - left, downward - up)])
    return np.array(potentials)


@pytest.mark.parametrize("bias", [1.0, 1.5])
def test_t4t5_is_its_equations(bias):
    q = T4T5Params(emd_bias=bias, exp_off=0.5)
    texture = np.random.default_rng(5).integers(80, 200, (14, 17))
    texture[4:10, 5:12] = 20
    frames = np.stack([np.roll(texture, (i // 2, i), axis=(0, 1)) for i in range(8)]).astype(np.uint8)
    answers = T4T5(frames.shape[1:], q).run(frames)
    np.testing.assert_allclose(np.column_stack([answers.hs, answers.vs]), plain_t4t5(frames, q), rtol=0, atol=1e-6)
    assert np.abs(answers.hs).max() > 0.05


def published_square(l_over_v_s, frames=100):
    """The looming of Zhao and others: 100 wide, drawn 240 px from the eye on 800x600, each fourth pixel."""
    nearest = min(round(50 * 240 / 300), round(50 * 240 / 400))
    speed = 50 / l_over_v_s
    for index in range(1, frames + 1):
        side = 100 * 240 / (nearest + speed - round(index * speed / 100))
        screen = np.full((600, 800), 255, np.uint8)
        top, left = (max(round(half - side / 2), 1) - 1 for half in (300, 400))
        screen[top : round(300 + side / 2), left : round(400 + side / 2)] = 0
        yield np.ascontiguousarray(screen[::4, ::4])


def test_active_cells_are_those_that_the_giant_fibre_s_authors_count():
    """676 and 2116 in the last two frames at l / v = 5 ms, squares of 26 and 46; a corner less than pixels a side."""
    model = LPLC2GF((150, 200), LPLC2GFParams())
    counts = [model.active_cells(frame) for frame in published_square(0.005)]
    assert [math.isqrt(n) for n in counts[-2:]] == [26 - 1, 46 - 1]
    assert counts[-2:] == [25**2, 45**2] and counts[0] == 0


def test_a_larger_receptive_field_fires_at_a_larger_square():
    """The paper's finding: the size of the receptive field sets the size at which the giant fibre fires."""
    sizes = []
    for side in (40, 80):
        model = LPLC2GF((150, 200), LPLC2GFParams(side=side))
        clip = stimulus("looming", rows=150, columns=200, fps=100, focal_px=60.0, l_over_v_s=0.05, end_deg=90.0)
        spikes = model.run(frame.luma for frame in clip).looming_spikes
        sizes.append(clip[int(spikes.nonzero()[0][0])].truth.box.width)
    assert sizes == sorted(set(sizes))


def test_the_membrane_is_a_leaky_integrator():
    """At a steady current below threshold it settles at rest plus R I, by its time constant."""
    model = LPLC2GF((8, 8), LPLC2GFParams())
    for _ in range(30):
        assert model._integrate(0.5) == 0
    assert model._v == pytest.approx(-60 + 5 * (1 - math.exp(-1)), abs=1e-9)
    assert model._integrate(1e4) > 0


@pytest.mark.parametrize("model", [LPLC2, MLPLC2])
def test_an_lplc2_needs_motion_outward_in_all_four_quadrants(model):
    """A dark square whose lower left corner stays where it is: no motion outward in the lower left."""
    whole, part = np.full((2, 30, 72, 99), 200, np.uint8)
    for i in range(30):
        whole[i, 36 - i : 36 + i, 49 - i : 50 + i] = 40
        part[i, 30 - i : 30, 56 : 57 + i] = 40
    looming, corner = (model((72, 99)).run(clip).looming.max() - 0.5 for clip in (whole, part))
    assert looming > 0.1 and corner < looming / 10
