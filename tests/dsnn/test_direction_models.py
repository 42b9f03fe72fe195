"""What single detectors of direction are known for, as their papers publish it."""

import numpy as np
import pytest

from dsnn import (
    MODELS,
    EMDNormalised,
    EMDNormalisedParams,
    Flow,
    FlowParams,
    FrameError,
    Hybrid,
    HybridParams,
    ThreeArm,
    ThreeArmParams,
)
from dsnn.stimuli import stimulus
from tests.dsnn.clips import SHAPE, approach, oblique, texture


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
