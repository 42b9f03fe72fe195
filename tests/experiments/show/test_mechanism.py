"""Parts of a crossing: its time in view, near the axis, and in windows of one length."""

import math
from types import SimpleNamespace

import numpy as np
import polars as pl
import pytest

from colias_sim.config import CameraConfig
from experiments.declare.conditions import Condition
from experiments.settings.models import choose
from experiments.show.trial_rows import responses, windows

CAMERA = CameraConfig()
HALF_VIEW = math.tan(math.radians(CAMERA.hfov_deg / 2))


def crossing(speed, distance=8.0, reach_cm=14.0):
    """A stimulus on its line, from ``reach_cm`` on the left to as far on the right: condition, frames."""
    condition = Condition("translation", "rightward", speed, distance)
    time_s = np.arange(1, 2 * reach_cm / speed * CAMERA.fps) / CAMERA.fps
    frames = pl.DataFrame({"time_s": time_s}).with_columns(
        stimulus_x_cm=pl.lit(CAMERA.forward_cm + distance), stimulus_y_cm=pl.Series(reach_cm - speed * time_s),
        observer_x_cm=pl.lit(0.0), observer_y_cm=pl.lit(0.0), observer_heading_deg=pl.lit(0.0),
    )  # fmt: skip
    return condition, frames.with_columns(
        stimulus_bearing_deg=-pl.arctan2(pl.col("stimulus_y_cm"), pl.lit(distance)).degrees()
    )


def parts_of(speed, distance=8.0):
    condition, frames = crossing(speed, distance)
    return SimpleNamespace(**windows(condition, CAMERA, frames))


def seconds(mask):
    return mask.sum() / CAMERA.fps


@pytest.mark.parametrize("speed", [2.0, 6.0, 10.0, 30.0])
@pytest.mark.parametrize("distance", [5.0, 8.0, 15.0])
def test_time_in_view_and_near_the_axis_are_geometry(speed, distance):
    parts = parts_of(speed, distance)
    assert seconds(parts.in_view) == pytest.approx(2 * distance * HALF_VIEW / speed, abs=1.5 / CAMERA.fps)
    assert seconds(parts.near_axis) == pytest.approx(7.0 / speed, abs=1.5 / CAMERA.fps)


def test_one_window_is_as_long_at_every_speed():
    slow, usual, fast = (parts_of(speed) for speed in (2.0, 6.0, 10.0))
    edges = 2 * (8.0 * HALF_VIEW + 2.0 / math.cos(math.radians(CAMERA.hfov_deg / 2))) / 10.0
    centres = 2 * 8.0 * HALF_VIEW / 10.0
    for parts in (slow, usual, fast):
        assert seconds(parts.window) == pytest.approx(edges, abs=1.5 / CAMERA.fps)
        assert seconds(parts.inner_window) == pytest.approx(centres, abs=1.5 / CAMERA.fps)
        assert not (parts.inner_window & ~parts.window).any()
    assert abs(int(fast.inner_window.sum()) - int(fast.in_view.sum())) <= 1, "at the fastest it is the crossing itself"
    assert (slow.inner_window & ~slow.near_axis).sum() == 0, "at 2 cm/s it is 1.1 cm to either side"


def test_a_model_that_does_not_spike_has_no_count_which_0_would_be():
    condition, frames = crossing(10.0)
    masks = windows(condition, CAMERA, frames)
    count = frames.height
    hs, spikes = np.linspace(-0.5, 0.5, count), np.arange(count, dtype=np.int64) - count // 2
    zero, none = np.zeros(count), np.zeros(count, np.int64)
    frames = frames.with_columns(hs=hs, vs=zero, hs_spikes=spikes, vs_spikes=none, looming=zero)
    silent = SimpleNamespace(**responses(choose("emd"), frames, masks, CAMERA.fps))
    assert (silent.spikes_in_view, silent.rate_in_view_hz, silent.spikes_in_window) == (None, None, None)
    assert silent.mean_hs_near_axis == pytest.approx(hs[masks["near_axis"]].mean())
