"""Laws of an event camera: how many events an edge gives, when, of which polarity, and what noise adds."""

import math
from dataclasses import replace

import numpy as np
import pytest

from colias_sim import CameraConfig, EventConfig, Pose, Simulation
from colias_sim.events import EVENT, EventPixels, event_counts, joined, log_light

IDEAL = EventConfig.preset("ideal")
STEP_S = 1 / 540
SPEED = 53.0
"""Px a second: 6 cm/s at 8 cm."""


def edge(time_s, behind, ahead, columns=12):
    """The light of a row over which an edge goes right."""
    share = np.clip(SPEED * time_s - np.arange(columns), 0.0, 1.0)
    return (ahead + share * (behind - ahead))[None].astype(np.float32)


def shown(lights, config=IDEAL, seed=0):
    """The events of a sequence of lights."""
    eye = EventPixels(lights[0].shape, config)
    eye.restart(lights[0], 0.0, np.random.default_rng(seed))
    for number, light in enumerate(lights[1:], 1):
        eye.see(light, number * STEP_S)
    return eye.take()


def pixel(*greys):
    return [np.full((1, 1), grey, np.float32) for grey in greys]


@pytest.mark.parametrize(("behind", "ahead"), [(200.0, 21.0), (21.0, 200.0), (230.0, 50.0), (60.0, 100.0)])
def test_an_edge_gives_as_many_events_as_its_contrast_has_thresholds_each_in_its_time(behind, ahead):
    events = shown([edge(number * STEP_S, behind, ahead) for number in range(160)])
    contrast = math.log(behind / ahead)
    count = int(abs(contrast) / 0.2)
    assert len(events) == 12 * count and (events["polarity"] == np.sign(contrast)).all()
    levels = ahead * np.exp(0.2 * np.sign(contrast) * np.arange(1, count + 1))
    for column in range(12):
        expected = (column + (levels - ahead) / (behind - ahead)) / SPEED
        assert events["t"][events["x"] == column] == pytest.approx(expected, abs=0.001)


def test_there_and_back_again_is_as_many_events_of_the_other_polarity_each_by_its_threshold():
    assert shown(pixel(40, 200, 40, 200, 40))["polarity"].tolist() == ([1] * 8 + [-1] * 8) * 2
    own = shown(pixel(50, 100, 50), replace(IDEAL, pos_thres=0.1, neg_thres=0.4))["polarity"]
    assert own.tolist() == [1] * 6 + [-1]


def test_below_twenty_greys_light_counts_by_a_line_that_a_threshold_exceeds():
    """A grey is 0.15 there: no single grey of an 8-bit picture is an event, as 1 to 2 greys would be in the log."""
    greys = np.arange(0.0, 256.0)
    assert np.diff(log_light(greys)).max() == pytest.approx(math.log(20.0) / 20.0)
    assert log_light(greys)[20] == math.log(20.0)
    assert shown(pixel(5, 6, 5, 4)).size == 0


def test_a_still_scene_without_noise_is_silent_and_leak_is_on_events_at_its_rate():
    still = [np.full((20, 20), 90.0, np.float32)] * 541
    assert shown(still).size == 0
    events = shown(still, EventConfig(leak_rate_hz=4.0))
    assert (events["polarity"] == 1).all() and len(events) == 1600


def test_shot_noise_has_its_rate_in_the_dark_and_a_quarter_at_white():
    for grey, rate in ((0.0, 1.0 - 0.75 * 20 / 275), (255.0, 0.25)):
        events = shown([np.full((20, 20), grey)] * 541, replace(IDEAL, shot_noise_rate_hz=20.0))
        expected = 20.0 * rate * 400
        assert len(events) == pytest.approx(expected, abs=5 * math.sqrt(expected))
        assert (events["polarity"] == 1).mean() == pytest.approx(0.5, abs=0.05)


def test_spread_is_that_of_the_thresholds_and_draws_come_from_the_generator_alone():
    rise = [100.0 * np.exp(np.full((60, 60), level)) for level in np.arange(0.0, 0.31, 0.005)]
    one, again, other = (shown(rise, replace(IDEAL, sigma_thres=0.03), seed) for seed in (3, 3, 4))
    _, first = np.unique(one["x"] + 60 * one["y"], return_index=True)
    levels = 0.005 / STEP_S * one["t"][first]
    assert levels.mean() == pytest.approx(0.2, abs=0.002) and levels.std() == pytest.approx(0.03, rel=0.1)
    assert np.array_equal(one, again) and not np.array_equal(one, other)


def test_no_pixel_has_two_events_within_its_refractory_period():
    times = shown(pixel(20, *[250] * 61), replace(IDEAL, refractory_period_s=0.004))["t"]
    assert len(times) == 12 and np.diff(times).min() >= 0.004 - 1e-12


def test_cutoff_is_a_first_order_low_pass_whose_corner_goes_with_the_light():
    times = shown(pixel(100, *[200] * 200), replace(IDEAL, pos_thres=0.01, cutoff_hz=10.0))["t"]
    tau_s = 275.0 / 220.0 / (2 * math.pi * 10.0)
    reached = 0.01 * np.arange(1, len(times) + 1) / math.log(2.0)
    assert times == pytest.approx(-tau_s * np.log(1.0 - reached), abs=STEP_S / 2)


def test_counts_have_on_before_off_and_saturate():
    events = np.array([(0.1, 2, 1, 1)] * 300 + [(0.2, 0, 0, -1)], EVENT)
    counts = event_counts(events, (2, 3))
    assert counts.dtype == np.uint8 and counts[0, 1, 2] == 255 and counts[1, 0, 0] == 1 and counts.sum() == 256


# --- in the arena ---

CAMERA = CameraConfig(read_noise=0.0, shot_noise=0.0)
FOCAL_PX, LENS_M = CAMERA.focal_px, CAMERA.forward_cm / 100
AWAY_M, HALF_M = 0.0795, 0.03
"""Distance of a card's face from the lens, and half its width."""


def crossing(events, frames=20, camera=CAMERA, speed=0.06):
    """A card of 23 greys crosses before the lens: its events, the frames, and the column of its front edge by time."""
    look = {"shell_grey": 0.1, "shell_shape": "card", "shell_width_cm": 200 * HALF_M, "shell_turn_deg": 90.0}
    rng, seen, taken, front = np.random.default_rng(0), [], [], []
    with Simulation(camera=camera, scene={"arena": "plain", "light_sd": 0.0, **look}, events=events) as sim:
        start = Pose(LENS_M + AWAY_M + 0.0005, 0.03, -math.pi / 2)
        sim.reset({"observer": Pose(0.0, 0.0, 0.0), "stimulus": start}, rng)
        robot = sim.robots["stimulus"]
        for _ in range(frames):
            frame, pose = sim.step(rng, lambda dt: robot.ease((speed, speed), dt)), robot.pose
            front.append((frame.time, 49.5 + FOCAL_PX * (HALF_M - pose.y) / (pose.x - 0.0005 - LENS_M)))
            seen.append(frame.luma)
            taken += [sim.event_camera.take()] if events else []
    return joined(taken), np.stack(seen), np.array(front)


def test_a_card_that_crosses_gives_the_events_of_the_closed_form():
    """Of its front edge, right of the middle: within 5 % in number and 1 ms in time; polarity exact."""
    events, frames, front = crossing(IDEAL)
    time_s, at = front[3:].T
    assert np.diff(at) / np.diff(time_s) == pytest.approx(SPEED, rel=0.02)
    dark, found, expected = float(frames[-1, 36, 50]), 0, 0
    assert 20.0 < dark < 25.0 and at[-1] - at[0] > 25.0
    for column in range(math.ceil(at[0]), math.floor(at[-1])):
        light = float(frames[0, 36, column])
        levels = light * np.exp(-0.2 * np.arange(1, int(math.log(light / dark) / 0.2) + 1))
        crossed = np.interp(column + (levels - light) / (dark - light), at, time_s)
        here = events[(events["x"] == column) & (events["y"] == 36) & (events["t"] > time_s[0])]
        assert (here["polarity"] == -1).all() and here["t"][: len(levels)] == pytest.approx(crossed, abs=0.001)
        found, expected = found + len(here), expected + len(levels)
    assert found == pytest.approx(expected, rel=0.05)


def test_frames_are_those_without_an_event_camera():
    few = EventConfig(samples_per_step=2, supersample_columns=4, shot_noise_rate_hz=5.0)
    (events, frames, front), (_, without, before) = (
        crossing(eye, 5, CameraConfig.preset("ov7670")) for eye in (few, None)
    )
    assert (frames == without).all() and (front == before).all() and events.size


def test_a_wall_that_turns_moves_evenly_between_two_commands():
    """Each of the nine steps of a command has its share of the events."""
    with Simulation(scene={"arena": "drum"}, events=replace(IDEAL, supersample_columns=8)) as sim:
        sim.reset({"stimulus": Pose(0.3, 0.3, 0.0)}, np.random.default_rng(0))
        for _ in range(3):
            sim.advance(lambda dt: sim.turn_wall(sim.wall_turn + 2.0 * dt))
        steps = np.bincount((sim.event_camera.take()["t"] / STEP_S).astype(int), minlength=54)[18:54]
    assert steps.min() > 0.5 * steps.mean() > 0.0
