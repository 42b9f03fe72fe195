"""Laws of the square on a collision course: its size by l / v, its place by the angle, and the truth beside it."""

import math

import numpy as np
import pytest

from dsnn.stimuli import stimulus


def moving(clip):
    return [frame for frame in clip if frame.truth.time_to_contact_s is not None]


@pytest.mark.parametrize("l_over_v", [0.08, 0.32])
def test_the_angle_is_that_of_l_over_v(l_over_v):
    """theta = 2 atan((l / v) / t), from the angle asked for to the other, whatever the frame rate."""
    for fps in (30, 100):
        frames = moving(stimulus("looming", l_over_v_s=l_over_v, fps=fps, start_deg=10.0, focal_px=60.0))
        angles = [2 * math.degrees(math.atan(frame.truth.box.width / 2 / 60.0)) for frame in frames]
        times = [frame.truth.time_to_contact_s for frame in frames]
        np.testing.assert_allclose(angles, [2 * math.degrees(math.atan(l_over_v / t)) for t in times])
        assert angles[0] == pytest.approx(10.0) and 40.0 < angles[-1] < 60.0
        np.testing.assert_allclose(np.diff(times), -1 / fps)


@pytest.mark.parametrize(("azimuth", "elevation", "grey"), [(0.0, 0.0, 40.0), (20.0, 0.0, 200.0), (-20.0, 10.0, 40.0)])
def test_it_is_painted_where_the_angle_says(azimuth, elevation, grey):
    ground = 240.0 - grey
    clip = stimulus("looming", azimuth_deg=azimuth, elevation_deg=elevation, grey=grey, background_grey=ground)
    frame = clip[len(clip) // 2]
    weights = np.abs(frame.luma - ground)
    rows, columns = np.indices(clip.shape) + 0.5
    place = (weights * columns).sum() / weights.sum(), (weights * rows).sum() / weights.sum()
    x, y = (70.7 * math.tan(math.radians(angle)) for angle in (azimuth, elevation))
    assert place == pytest.approx((99 / 2 + x, 72 / 2 + y), abs=0.05)
    assert weights.sum() / abs(grey - ground) == pytest.approx(frame.truth.box.width**2, rel=0.01)


def test_receding_is_looming_backward():
    there, back = (list(stimulus("looming", motion=motion, miss=2.0)) for motion in ("looming", "receding"))
    for one, other in zip(there, back[::-1], strict=True):
        np.testing.assert_array_equal(one.luma, other.luma)
    assert {frame.truth.motion for frame in back} == {"still", "receding"}
    assert moving(back)[0].truth.time_to_contact_s < 0 < moving(there)[0].truth.time_to_contact_s


@pytest.mark.parametrize("way", ["rightward", "leftward", "downward", "upward"])
def test_what_crosses_has_the_size_and_the_speed_of_the_near_end(way):
    """At the distance d where it subtends end_deg, v = d / contact: in the picture focal / contact."""
    clip = stimulus("looming", motion=way, end_deg=40.0, l_over_v_s=0.16, fps=200)
    frames = [frame.truth for frame in clip if frame.truth.motion == way]
    near = 0.16 / math.tan(math.radians(20))
    assert {round(truth.box.width, 9) for truth in frames} == {round(2 * 70.7 * math.tan(math.radians(20)), 9)}
    assert max(abs(part) for part in frames[0].velocity) == pytest.approx(70.7 / near)
    x, y = ([getattr(truth.box, side) for truth in frames] for side in ("left", "top"))
    np.testing.assert_allclose(np.diff(x) * 200, frames[0].velocity[0], atol=1e-6)
    np.testing.assert_allclose(np.diff(y) * 200, frames[0].velocity[1], atol=1e-6)
    assert all((clip[index].luma == 200).all() for index in (0, len(clip) - 1)), "from outside to outside"
    assert np.isnan(clip.contact_s()).all()


def test_a_disc_covers_pi_over_4_of_its_square():
    for elevation, azimuth in ((0.0, 0.0), (10.3, -14.7)):
        clip = stimulus("looming", outline="disc", elevation_deg=elevation, azimuth_deg=azimuth)
        for index in (len(clip) // 2, 3 * len(clip) // 4):
            frame = clip[index]
            covered = (200.0 - frame.luma) / 160.0
            assert covered.sum() == pytest.approx(math.pi / 4 * frame.truth.box.width**2, rel=0.02)
            box = frame.truth.box
            outside = np.ones(clip.shape, bool)
            outside[int(box.top) : int(box.top + box.height) + 1, int(box.left) : int(box.left + box.width) + 1] = False
            assert not covered[outside].any()
    even = stimulus("looming", outline="disc")[20].luma
    np.testing.assert_array_equal(even, even[::-1])
    np.testing.assert_array_equal(even, even[:, ::-1])


def test_what_misses_the_eye_drifts_outward_at_the_velocity_of_the_truth():
    clip = stimulus("looming", miss=1.5, fps=200)
    frames = moving(clip)
    centres = [frame.truth.box.left + frame.truth.box.width / 2 for frame in frames]
    between = [frame.truth.velocity[0] for frame in frames]
    np.testing.assert_allclose(np.diff(centres) * 200, np.add(between[1:], between[:-1]) / 2, rtol=2e-3)
    assert between[-1] > between[0] > 0
