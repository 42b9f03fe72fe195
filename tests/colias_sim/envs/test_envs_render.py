"""Pictures of the envs: modes, views, and that every OpenGL context is freed."""

import math

import numpy as np
import pytest

from tests.helpers.envs import bare, every_env


@every_env
def test_rgb_array(name, contexts):
    env = bare(name, observation="state", render_mode="rgb_array", render_width=80, render_height=60)
    env.reset(seed=0)
    first = env.render()
    assert first.shape == (60, 80, 3) and first.dtype == np.uint8 and first.std() > 10
    kept = first.copy()
    for _ in range(8):
        env.step([1.0, -1.0])
    second = env.render()
    assert np.abs(second.astype(int) - first).max() > 30, "the robot has turned"
    np.testing.assert_array_equal(first, kept)
    assert contexts, "which are all gone in the end"
    env.close()


def test_the_observer_s_view_is_what_its_camera_sees(contexts):
    """And the observation is of this moment: the robot turns by 4 px a frame."""
    env = bare(
        "colias_sim/Pursuit-v0", camera="ideal", render_mode="rgb_array", render_view="observer",
        render_width=99, render_height=72,
    )  # fmt: skip
    env.reset(seed=0)
    for _ in range(4):
        seen, *_ = env.step([0.1, -0.1])
    picture, luma = env.render().astype(float) @ (0.299, 0.587, 0.114), seen[..., 0].astype(float)
    env.close()
    alike = np.corrcoef(picture.ravel(), luma.ravel())[0, 1]
    assert alike > 0.98
    for other in (picture[:, ::-1], picture[::-1], np.roll(picture, 3, 0), np.roll(picture, 3, 1)):
        assert np.corrcoef(other.ravel(), luma.ravel())[0, 1] < alike - 0.01


def test_the_views_differ_and_the_top_one_looks_down(contexts):
    pictures = {}
    for view in ("arena", "top", "observer"):
        env = bare(
            "colias_sim/Fixation-v0", observation="state", render_mode="rgb_array", render_view=view,
            render_width=120, render_height=120,
        )  # fmt: skip
        env.reset(seed=0)
        pictures[view] = env.render().astype(int)
        target = env.poses["target"]
        env.close()
    assert len({picture.tobytes() for picture in pictures.values()}) == 3
    # The black robot from above: right in the picture is +x, up is +y.
    dark = pictures["top"].max(-1) < 40
    rows, columns = np.nonzero(dark[20:100, 20:100])
    towards = math.atan2(39.5 - rows.mean(), columns.mean() - 39.5)
    assert math.remainder(towards - math.atan2(target.y, target.x), 2 * math.pi) == pytest.approx(0.0, abs=0.3)
