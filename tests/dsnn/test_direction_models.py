"""What single detectors of direction are known for, as their papers publish it."""

import numpy as np
import pytest

from dsnn import MODELS, Flow, FlowParams, FrameError, Hybrid, HybridParams, ThreeArm, ThreeArmParams
from dsnn.stimuli import stimulus
from tests.dsnn.clips import SHAPE, approach, oblique, texture


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
