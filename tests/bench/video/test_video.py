"""Videos, GIFs and strips: they show what was recorded, when it was, and no file is left that is not whole."""

from __future__ import annotations

import dataclasses
import re
from pathlib import Path

import cv2
import numpy as np
import pytest
from PIL import Image

from colias_sim import CameraConfig, RobotConfig, SceneConfig
from dsnn import Response
from experiments.bench.cli import main
from experiments.bench.closed_loop.episode import play_entry
from experiments.bench.closed_loop.find import load_behaviour
from experiments.bench.closed_loop.recording import record as record_episode
from experiments.bench.footage.recording import LiveLog
from experiments.bench.footage.video import Picture
from experiments.bench.run import settings
from experiments.bench.run.models import choose, shown_models
from experiments.bench.sources.conditions import Condition
from experiments.bench.sources.experiment import Settings
from experiments.bench.sources.robot import RobotTrial, forget_simulations
from experiments.bench.video import make
from experiments.bench.video import pictures as reading
from experiments.bench.video.drawing import Drawer
from experiments.bench.video.layout import LONGEST_WHOLE_S, WINDOW_S, Layout, Panel, ground, lay_out
from experiments.bench.video.make import Film, frames
from experiments.bench.video.outside import outside
from experiments.bench.video.pictures import pictures
from experiments.bench.video.reading import Reel, read
from experiments.bench.video.still import still_of
from tests.helpers.h264 import decoded, report
from tests.helpers.played import Played

SIZE = 480, 270
LANE = "dsnn"


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    return tmp_path_factory.mktemp("video")


@pytest.fixture(scope="module")
def trial(folder) -> tuple[Played, Path]:
    trial_settings = Settings((choose("dsnn"),), RobotConfig(), CameraConfig(), SceneConfig(), 1.0, 1.0)
    condition = Condition("translation", "rightward", 15.0, 8.0)
    result = Played(RobotTrial("speed", 7, 0, 7, condition, trial_settings), maps=True)
    forget_simulations()
    path = folder / "recordings" / "trial-0007.rrd"
    path.parent.mkdir()
    path.write_bytes(result.recording)
    return result, path


@pytest.fixture(scope="module")
def footage(folder) -> Path:
    """A minute of footage in which a bar stands where the time says."""
    path = folder / "footage.rrd"
    chosen, _ = settings.watchers(shown_models(["dsnn"], None, False), (), fps=2.0)
    log = LiveLog.to_file(path, chosen, (64, 48))
    for i in range(120):
        luma = np.full((48, 64), 30, np.uint8)
        luma[:, i % 64] = 250
        log.add(
            Picture(luma=luma, time_s=i / 2, frame=i, decode_s=0.0, resize_s=0.0),
            [Response(hs=0.5 * np.sin(i / 5), hs_spikes=int(i % 10 == 0))],
        )
    log.close()
    return path


def film(reel: Reel) -> tuple[Drawer, Layout, np.ndarray]:
    """What draws its frames, where everything is, and what does not move."""
    layout = lay_out(reel, make.aspects(reel), *SIZE)
    base = still_of(reel, layout, "caption").picture()
    return Drawer(reel, layout, base), layout, base


def drawn(frame: np.ndarray, base: np.ndarray, panel: Panel) -> np.ndarray:
    """The columns of a panel that are not as they were."""
    rows = slice(int(panel.top) + 2, int(panel.top + panel.height) - 2)
    return np.flatnonzero((frame[rows] != base[rows]).any(-1).any(0))


# What a recording has.


def test_a_trial_is_read_back_as_it_was(trial):
    result, path = trial
    reel = read(path)
    (answer,) = result.answers
    traces = {(trace.place, trace.name): trace.values for trace in reel.traces}
    np.testing.assert_array_equal(traces["potential", "HS"], answer.series.hs)
    np.testing.assert_array_equal(traces["spikes", "HS"], answer.series.hs_spikes)
    dotted = {(trace.place, trace.name): trace.dotted for trace in reel.traces}
    assert dotted == {("potential", "HS"): False, ("potential", "VS"): True, ("spikes", "HS"): False,
                      ("spikes", "VS"): False}, "every channel has its name, and its look in the recording"  # fmt: skip
    threshold = answer.thresholds["hs"]
    assert reel.levels == (-threshold, threshold)
    np.testing.assert_allclose(reel.time_s, result.columns.sim_time_s, atol=1e-8)
    assert [track.name for track in reel.tracks] == ["observer", "stimulus"]
    columns = result.columns
    expected = np.column_stack([columns.stimulus_x_cm, columns.stimulus_y_cm, np.radians(columns.stimulus_heading_deg)])
    np.testing.assert_allclose(reel.tracks[1].poses, expected, atol=1e-5)
    assert reel.view_deg == pytest.approx(result.trial.settings.camera.hfov_deg, abs=1e-3)
    seen = [picture for _, picture in pictures(path, "world/observer/camera/image")]
    np.testing.assert_array_equal(np.stack(seen)[..., 0], result.media.pictures[""])


def test_the_counter_has_the_spikes_of_hs_as_tables_do(trial):
    result, path = trial
    reel = read(path)
    traces = [dataclasses.replace(trace, values=np.ones_like(trace.values))
              if (trace.place, trace.channel) == ("spikes", "vs") else trace for trace in reel.traces]  # fmt: skip
    drawer, *_ = film(dataclasses.replace(reel, traces=traces))
    count = int(np.abs(result.answers[0].series.hs_spikes).sum())
    assert drawer.spikes_so_far(float(reel.time_s[-1])) == f"{count} HS spike{'s' * (count != 1)}"
    assert drawer.spikes_so_far(-1.0) == "0 HS spikes"


def test_an_episode_is_read_back_as_it_was(folder):
    episode = play_entry(load_behaviour("fixation"), "colias_sim/Fixation-v0", {}, 0, steps=8, images=True)
    path = folder / "episode.rrd"
    path.write_bytes(record_episode(episode))
    reel = read(path)
    assert len(reel.time_s) == 8 and len(list(pictures(path, "world/observer/camera/image"))) == 8
    for track in reel.tracks:
        poses = episode.paths[track.name]
        np.testing.assert_allclose(track.poses[:, :2], poses[:, :2], atol=1e-4)
        turned = np.angle(np.exp(1j * (track.poses[:, 2] - np.radians(poses[:, 2]))))
        np.testing.assert_allclose(turned, 0.0, atol=1e-4)
    (azimuth,) = (trace for trace in reel.traces if trace.place == "azimuth")
    np.testing.assert_array_equal(azimuth.values, episode.series.azimuth)


# What a frame shows.


def test_a_frame_has_the_picture_the_robots_and_the_traces_of_its_time(trial):
    result, path = trial
    reel = read(path)
    drawer, layout, base = film(reel)
    (eye,), plan, panel = layout.eyes, layout.plan, layout.lanes[LANE]
    for k in (2, result.frames // 2, result.frames - 1):
        time_s = float(reel.time_s[k])
        (frame,) = frames(reel, drawer, np.array([time_s]))
        eye_picture = frame[int(eye.top) : int(eye.top + eye.height), int(eye.left) : int(eye.left + eye.width)]
        expected = cv2.resize(result.media.pictures[""][k], eye_picture.shape[1::-1], interpolation=cv2.INTER_NEAREST)
        np.testing.assert_array_equal(eye_picture[..., 0], expected)
        x, y, heading = reel.tracks[1].poses[k]
        behind = plan.pixels(np.array([x - 1.2 * np.cos(heading)]), np.array([y - 1.2 * np.sin(heading)]))[0]
        np.testing.assert_array_equal(frame[round(behind[1]), round(behind[0])], reel.tracks[1].colour)
        now, columns = panel.pixels(np.array([time_s]), np.array([0.0]))[0, 0], drawn(frame, base, panel)
        assert columns.max() <= now + 3, "a trace goes beyond now"
        assert len(columns) >= 0.9 * (now - panel.left), "a trace goes up to now"


def test_what_changed_is_warm_where_it_became_brighter_and_cool_where_darker():
    """A bar that moves to the right by a column: brighter where it left, darker where it came to."""
    dark = np.full((2, 4, 6, 3), 200, np.uint8)
    dark[0, :, 2:4], dark[1, :, 3:5] = 20, 20
    (_, first), (_, second) = reading.changes(iter([(0.0, dark[0]), (0.1, dark[1])]))
    assert (first == reading.STILL).all(), "before the second picture nothing has changed"
    np.testing.assert_array_equal(second[0], [reading.STILL] * 2 + [reading.ON, reading.STILL, reading.OFF,
                                                                   reading.STILL])  # fmt: skip


def test_the_arrow_points_where_the_potentials_do(trial):
    """A stimulus that moves to the right: more of the arrow's head is at its right end."""
    reel = read(trial[1])
    drawer, layout, base = film(reel)
    (hs,) = (trace for trace in reel.traces if (trace.place, trace.channel) == ("potential", "hs"))
    peak = int(hs.values.argmax())
    panel, canvas = layout.change, base.copy()
    drawer.change(canvas, panel, np.zeros((72, 99, 3), np.uint8), float(reel.time_s[peak]))
    part = canvas[int(panel.top) : int(panel.top + panel.height), int(panel.left) : int(panel.left + panel.width), 0]
    tall = (part > 128).sum(0)
    columns = np.flatnonzero(tall)
    head = columns[0] + int(tall[columns[0] : columns[-1] + 1].argmax())
    assert hs.values[peak] > 0 and head > (columns[0] + columns[-1]) / 2


def test_seen_from_outside_a_robot_that_passes_to_the_right_goes_right(trial):
    """Left and right are those of the camera; the dark hull is what differs from its absence."""
    reel = read(trial[1])
    view = outside(reel, 120)
    assert view is not None
    pictures_of = [view.at(float(reel.time_s[k])).astype(int) for k in (0, len(reel.time_s) // 2, -1)]
    middles = [np.flatnonzero(_dark(picture).any(0)).mean() for picture in pictures_of]
    assert middles[0] < middles[1] < middles[2]
    elsewhere = dataclasses.replace(reel, properties={**reel.properties, "arena": "/tmp/own.xml"})
    assert outside(elsewhere, 120) is None, "a recording opens no file that it names"


def _dark(picture: np.ndarray) -> np.ndarray:
    """Where the black hull is: dark and without colour."""
    return (picture.max(-1) < 45) & (np.ptp(picture, axis=-1) < 6)


def test_a_plan_shows_the_obstacles_that_the_camera_sees(trial):
    reel = read(trial[1])
    square = 2.0 * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    ahead, behind = square + np.array([40.0, 3.0]), square - np.array([40.0, 0.0])
    near = ground(reel)
    (low, high), _ = ground(dataclasses.replace(reel, obstacles=(ahead,)))
    assert low < ahead[:, 0].min() and high > ahead[:, 0].max()
    assert ground(dataclasses.replace(reel, obstacles=(behind,))) == near, "what stands behind the camera moves nothing"


def test_a_long_recording_s_axis_moves_on(footage):
    reel = read(footage)
    drawer, layout, base = film(reel)
    assert np.ptp(reel.time_s) > LONGEST_WHOLE_S and layout.moving
    assert layout.lanes[LANE].x == (-WINDOW_S, 0.0)
    early, late = frames(reel, drawer, np.array([5.0, 55.0]))
    panel = layout.lanes[LANE]
    first = [int(drawn(frame, base, panel)[0]) for frame in (early, late)]
    assert first[0] == pytest.approx(panel.left + panel.width * (1 - 5.0 / WINDOW_S), abs=3)
    assert first[1] == pytest.approx(panel.left, abs=0.5 / WINDOW_S * panel.width + 3)


def test_the_picture_shown_is_the_last_one_that_was_taken(footage):
    """At every time: the bar's column says which picture it is."""
    latest = make.latest_at(pictures(footage, "world/observer/camera/image"), [0.0, 0.49, 0.5, 7.2, 31.0])
    columns = [int(picture[24, :, 0].argmax()) for picture in latest]
    assert columns == [0, 0, 1, 14, 62]


def test_pictures_are_read_as_they_are_needed(footage, monkeypatch):
    """Memory does not grow with length: no picture is decoded before the frame that it is for."""
    reel, decoded = read(footage), 0

    def counted(*given):
        nonlocal decoded
        decoded += 1
        return imdecode(*given)

    imdecode = reading.cv2.imdecode
    drawer, *_ = film(reel)
    monkeypatch.setattr(reading.cv2, "imdecode", counted)
    for number, _ in enumerate(frames(reel, drawer, reel.time_s[:40]), 1):
        assert decoded <= number + 1


# Files.


def test_an_mp4_is_h264_with_every_frame(trial, folder):
    pytest.importorskip("imageio_ffmpeg")
    result, path = trial
    reel, out = read(path), folder / "all.mp4"
    assert make.make(reel, Film(out, *SIZE)) == result.frames
    assert re.search(r"Video: h264 .*yuv420p.* 480x270.* 30 fps", report(out))
    film_frames = decoded(out)
    assert len(film_frames) == result.frames
    drawer = make.drawer_of(reel, Film(out, *SIZE))
    for k in (0, result.frames // 2, result.frames - 1):
        (expected,) = frames(reel, drawer, reel.time_s[[k]])
        apart = np.abs(film_frames[k][30:].astype(int) - expected[30:]).mean()  # the caption above differs
        assert apart < 3.0, f"frame {k}"
    assert sorted(file.name for file in folder.glob("*all*")) == ["all.mp4"]


@pytest.mark.parametrize(("speed", "rate", "times"), [(1.0, 15.0, 0.5), (0.5, None, 1.0), (0.5, 30.0, 2.0)])
def test_speed_and_rate_decide_how_many_frames_there_are(trial, speed, rate, times):
    result, path = trial
    reel = read(path)
    wanted = Film(Path("x.mp4"), *SIZE, rate=rate, speed=speed)
    film_times = wanted.times(reel)
    assert len(film_times) == pytest.approx(times * result.frames, abs=2)
    length_s = len(film_times) / wanted.frames_per_second(reel)
    assert length_s == pytest.approx(np.ptp(reel.time_s) / speed, abs=0.2)
    assert reel.time_s[0] == film_times[0] and film_times[-1] <= reel.time_s[-1] + 1e-6


def test_a_gif_has_its_frames_and_colours(trial, folder):
    pytest.importorskip("imageio_ffmpeg")
    reel, out = read(trial[1]), folder / "own.gif"
    count = make.make(reel, Film(out, 321, 181))
    with Image.open(out) as gif:
        assert gif.size == (321, 181) and gif.n_frames <= count
        length_ms = 0
        for k in range(gif.n_frames):
            gif.seek(k)
            length_ms += gif.info["duration"]
        assert length_ms == pytest.approx(80 * count, abs=90)
        colours = np.asarray(gif.convert("RGB")).reshape(-1, 3).astype(int)
    for track in reel.tracks:
        assert np.abs(colours - track.colour).max(1).min() < 2, f"no pixel has the colour of {track.name}"


def test_a_webp_has_its_frames_for_ever(trial, folder):
    pytest.importorskip("imageio_ffmpeg")
    reel, out = read(trial[1]), folder / "own.webp"
    count = make.make(reel, Film(out, 320, 180, rate=10.0))
    with Image.open(out) as webp:
        assert webp.size == (320, 180) and webp.n_frames <= count and webp.info["loop"] == 0
        seconds = 0.0
        for k in range(webp.n_frames):
            webp.seek(k)
            webp.load()
            seconds += webp.info["duration"] / 1000
    assert seconds == pytest.approx(count / 10, abs=0.15)


def test_a_strip_shows_its_moments(trial, folder):
    result, path = trial
    out = folder / "strip.png"
    assert main.command(["video", str(path), "--out", str(out), "--frames", "4", "--quiet"]) == 0
    picture = np.asarray(Image.open(out).convert("L")).astype(int)
    assert picture.shape[1] == 1800
    width = (1800 - 2 * 20 - 3 * 10) / 4
    for k, index in enumerate(np.rint(np.linspace(0, result.frames - 1, 4)).astype(int)):
        high = round(width / 99 * 72)
        left, top = round(20 + k * (width + 10)), round(96 + high + 44)  # below the view from outside and a title
        eye_picture = cv2.resize(picture[top : top + high, left : left + round(width)].astype(np.uint8), (99, 72))
        apart = [np.abs(eye_picture.astype(int) - frame).mean() for frame in result.media.pictures[""]]
        assert abs(int(np.argmin(apart)) - index) <= 1


# Refusals.
