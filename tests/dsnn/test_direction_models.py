"""The detectors of direction that are not of the DSNN's family, by their equations: plain float64 beside the fast."""

import math

import numpy as np
import pytest

from dsnn import EMDNormalised, EMDNormalisedParams, ThreeArm, ThreeArmParams
from dsnn.stimuli import stimulus


def noise(seed, frames=12, shape=(9, 11)):
    """Noise that shifts obliquely, and changes."""
    rng = np.random.default_rng(seed)
    picture = rng.integers(0, 256, shape)
    return np.stack([np.roll(picture, (i // 3, i), (0, 1)) for i in range(frames)]).astype(np.uint8)


def high_passed(frames, tau, fps):
    """H of each frame, (T, R, C)."""
    h, answers = np.zeros(frames.shape[1:]), []
    for before, frame in zip((frames[0], *frames), frames.astype(float)):  # noqa: B905 (the last one is not needed)
        h = (1 - 1000 / (1000 + fps * tau)) * (h + frame - before)
        answers.append(h)
    return np.array(answers)


def delayed(signals, tau, fps):
    state, answers = np.zeros(signals.shape[1:]), []
    for signal in signals:
        state = state + 1000 / (1000 + fps * tau) * (signal - state)
        answers.append(state)
    return np.array(answers)


def plain_emd_normalised(frames, q):
    """HS and VS cell by cell."""
    rows, columns = frames.shape[1:]
    h, reach = high_passed(frames, q.tau_hp, q.fps), range(-(q.pool // 2), q.pool // 2 + 1)
    c = np.zeros(frames.shape)
    for t, row, column in np.ndindex(*frames.shape):
        around = [
            abs(h[t, min(max(row + i, 0), rows - 1), min(max(column + j, 0), columns - 1)])
            for i in reach
            for j in reach
        ]
        c[t, row, column] = math.tanh(h[t, row, column] / (q.kappa + sum(around) / len(around)))
    d = delayed(c, q.tau_lp, q.fps)
    hs = d[:, :, :-1] * c[:, :, 1:] - c[:, :, :-1] * d[:, :, 1:]
    vs = d[:, :-1] * c[:, 1:] - c[:, :-1] * d[:, 1:]
    return [q.gain * part.sum(axis=(1, 2)) / (rows * columns) for part in (hs, vs)]


@pytest.mark.parametrize("changes", [{}, {"pool": 3, "kappa": 2.0, "fps": 60.0, "gain": 1.0}])
def test_emd_normalised_is_its_equations(changes):
    q, frames = EMDNormalisedParams(**changes), noise(1)
    answers = EMDNormalised(frames.shape[1:], q).run(frames)
    np.testing.assert_allclose([answers.hs, answers.vs], plain_emd_normalised(frames, q), rtol=0, atol=1e-5 * q.gain)
    assert answers.hs.max() > 0.05 * q.gain


def plain_three_arm(frames, q):
    """HS and VS cell by cell, with four quadrants as pairs of polarities."""
    h = high_passed(frames, q.tau_hp, q.fps) / 255
    x = {1: np.maximum(h, 0), -1: np.maximum(-h, 0)}
    lp = {sign: delayed(signal, q.tau_lp, q.fps) for sign, signal in x.items()}
    pairs = [(1, 1), (-1, -1)] if q.quadrants == 2 else [(i, j) for i in (1, -1) for j in (1, -1)]
    (frames_, rows, columns), answers = frames.shape, np.zeros((2, len(frames)))

    def cell(t, a, b, c):
        """R of the cell that prefers the way from a to c."""
        return sum(
            i * j * lp[i][t][a] * x[j][t][b] / (q.baseline + lp[j][t][c])
            - i * j * x[i][t][a] * lp[j][t][b] / (q.baseline + x[j][t][c])
            for i, j in pairs
        )

    for t, row, column in np.ndindex(frames_, rows, columns):
        if 0 < column < columns - 1:
            line = [(row, column + k) for k in (-1, 0, 1)]
            answers[0, t] += cell(t, *line) - cell(t, *line[::-1])
        if 0 < row < rows - 1:
            line = [(row + k, column) for k in (-1, 0, 1)]
            answers[1, t] += cell(t, *line) - cell(t, *line[::-1])
    return q.gain * answers / (rows * columns)


@pytest.mark.parametrize("quadrants", [2, 4])
def test_three_arm_is_its_equations(quadrants):
    q, frames = ThreeArmParams(quadrants=quadrants), noise(2)
    answers = ThreeArm(frames.shape[1:], q).run(frames)
    np.testing.assert_allclose([answers.hs, answers.vs], plain_three_arm(frames, q), rtol=0, atol=1e-5)
    assert answers.hs.max() > 0.5


def test_the_weight_of_contrast_is_that_of_its_square_without_normalisation():
    """The control of the claim that a grating of a quarter of the contrast gives at least half of the potential."""
    faint, full = (
        stimulus("grating", rows=24, columns=36, contrast=contrast, period_px=12.0) for contrast in (0.2, 0.8)
    )
    for kappa, pool, least, most in ((10.0, 11, 0.5, 1.0), (255.0, 1, 0.0, 0.2)):
        q = EMDNormalisedParams(kappa=kappa, pool=pool)
        weak, strong = (EMDNormalised(clip.shape, q).run(f.luma for f in clip).hs.max() for clip in (faint, full))
        assert least <= weak / strong <= most


@pytest.mark.parametrize("quadrants", [2, 4])
def test_reverse_phi_is_seen_backward(quadrants):
    """By four quadrants, which pair either polarity; by two as well, as a high-pass answers a step by both in turn."""
    phi, reverse = (
        stimulus("reverse-phi", rows=36, columns=48, contrast_at_a_step=contrast) for contrast in ("kept", "reversed")
    )
    there, back = (
        ThreeArm(clip.shape, ThreeArmParams(quadrants=quadrants)).run(f.luma for f in clip).hs.mean()
        for clip in (phi, reverse)
    )
    assert back < -0.1 < 0.1 < there
