"""Videos and strips: they show what was recorded, when it was, and no file is left that is not whole."""

import copy
from unittest.mock import Mock

import av
import cv2
import numpy as np
import polars as pl
import pytest
from matplotlib.patches import Circle

from experiments.base.errors import UsageError
from experiments.base.files import part
from experiments.base.palette import BRIGHTER, CHANNELS, DARKER, STILL, rgb
from experiments.cli import main
from experiments.draw import video
from experiments.draw.video import Canvas, Reel, changes, film_times, make, moments, strip
from experiments.kinds.episodes import load_behaviour
from experiments.show.episodes import play, record as record_episode
from experiments.store.recordings import pictures_of, recording
from tests.experiments.show.test_record import CONTENT, written
from tests.experiments.show.test_trial import spec
from tests.helpers.played import Played

SIZE = 640, 360
SEEN = "world/observer/camera/image"


@pytest.fixture(scope="module")
def trial(tmp_path_factory):
    """A finished trial, and its recording."""
    result = Played(spec(), maps=True)
    path = tmp_path_factory.mktemp("video") / "trial-0007.rrd"
    path.write_bytes(result.recording)
    return result, Reel(path)


def test_a_trial_is_read_back_as_it_was(trial):
    result, reel = trial
    series, columns = result.answers[0].series, result.columns
    for channel in ("hs", "vs"):
        np.testing.assert_array_equal(reel.values["dsnn"][channel][1], getattr(series, channel))
    assert reel.levels == {"dsnn": pytest.approx([-0.2, 0.2])}
    np.testing.assert_allclose(reel.time_s, columns.time_s, atol=1e-8)
    poses = np.vstack([columns.stimulus_x_cm, columns.stimulus_y_cm, np.radians(columns.stimulus_heading_deg)])
    np.testing.assert_allclose(reel.tracks["stimulus"][1:], poses, atol=1e-5)
    np.testing.assert_array_equal([picture for _, picture in pictures_of(reel.path, SEEN)], result.media.images[""])


def test_an_episode_is_read_back_as_it_was(tmp_path):
    episode = play(load_behaviour("fixation"), "colias_sim/Fixation-v0", {}, 0, 8, images=True)
    (tmp_path / "episode.rrd").write_bytes(record_episode(episode))
    reel = Reel(tmp_path / "episode.rrd")
    assert len(reel.time_s) == 8
    off = [[cv2.absdiff(seen, image).mean() for image in episode.images] for _, seen in pictures_of(reel.path, SEEN)]
    assert np.argmin(off, axis=1).tolist() == [*range(8)], "the nearest picture to one that went through JPEG"
    for name, places in episode.poses.items():
        x, y, heading = np.transpose(places)
        np.testing.assert_allclose(reel.tracks[name][1:3], [x, y], atol=1e-4)
        np.testing.assert_allclose(np.exp(1j * reel.tracks[name][3]), np.exp(1j * np.radians(heading)), atol=1e-4)


def test_a_frame_has_the_picture_the_robots_and_the_traces_of_its_time(trial):
    result, reel = trial
    canvas = Canvas(reel, SIZE)
    (panels,), (lane,) = canvas.panels, canvas.lanes.values()

    def pixel(axes, x, y):
        across, up = axes.transData.transform((x, y))
        return int(SIZE[1] - up), int(across)

    for k in (2, result.frames // 2, result.frames - 1):
        time_s = float(reel.time_s[k])
        (seen,) = reel.seen([time_s])
        frame = canvas.frame(time_s, seen)
        image = result.media.images[""][k]
        for row, column in ((10, 20), (36, 50), (60, 90)):
            shown = frame[pixel(panels[SEEN], column, row)][0]
            assert abs(int(shown) - int(image[row, column])) <= 1
        assert float(canvas.figure.texts[-1].get_text().split()[0]) == pytest.approx(time_s, abs=0.006)
        circles = [patch for patch in panels["plan"].patches if isinstance(patch, Circle)]
        lines = panels["plan"].lines[-2 * len(circles) :]
        for name, body, trail, nose in zip(reversed(reel.tracks), circles, lines[::2], lines[1::2], strict=True):
            *place, heading = reel.tracks[name][1:, k]
            assert body.get_center() == pytest.approx(place)
            np.testing.assert_array_equal(trail.get_xydata(), reel.tracks[name][1:3, : k + 1].T)
            (ahead,) = np.diff(nose.get_xydata(), axis=0)
            assert ahead / np.hypot(*ahead) == pytest.approx([np.cos(heading), np.sin(heading)])
        if k < result.frames - 1:
            row, _ = pixel(lane, 0.0, 0.0)
            columns = [pixel(lane, time_s + step, 0.0)[1] for step in (-0.02, 0.02)]
            over, to_come = (frame[row - 2 : row + 3, column].min() for column in columns)
            assert over < to_come - 20, "what is to come is faint"


def test_a_lane_has_its_own_model_s_potentials_thresholds_spikes_and_moments(trial):
    reel, rng = copy.copy(trial[1]), np.random.default_rng(0)
    time_s, counts = reel.time_s, np.resize([0, 1, -1, 3], len(reel.time_s))
    reel.values = {model: {name: np.stack([time_s, values]) for name, values in
                           {"hs": rng.normal(size=len(time_s)), "vs": rng.normal(size=len(time_s)),
                            "spikes/hs": sign * counts}.items()} for model, sign in (("a", 1), ("b", -1))}  # fmt: skip
    reel.levels, moments = {"a": [0.3, -0.3], "b": [0.5]}, time_s[[3, 9]].tolist()
    canvas = Canvas(reel, SIZE, moments)
    assert [float(panels[SEEN].get_title("right").split()[0]) for panels in canvas.panels] == np.round(
        moments, 2
    ).tolist()
    for model, lane in canvas.lanes.items():
        assert lane.get_title("left").startswith(f"{model}:")
        series = {line.get_color(): line.get_xydata() for line in lane.lines if len(line.get_xdata()) > 2}
        for name in ("hs", "vs"):
            np.testing.assert_array_equal(series[CHANNELS[name]], reel.values[model][name].T)
        levels = {line.get_ydata()[0] for line in lane.lines if [*line.get_xdata()] == [0, 1]}
        assert levels == {0.0, *reel.levels[model]}
        assert [line.get_xdata()[0] for line in lane.lines if [*line.get_ydata()] == [0, 1]] == moments
        strokes = np.array(lane.collections[0].get_segments())[:4, :, 1]
        assert np.sign(strokes[:, 0]).tolist() == np.sign(reel.values[model]["spikes/hs"][1, :4]).tolist()
        none, one, back, three = np.abs(np.diff(strokes, axis=1))[:, 0]
        assert none == 0 < one == pytest.approx(back) and three > 1.5 * one


def test_what_became_brighter_and_what_became_darker_have_a_colour_each():
    """A bar that moves to the right by a column: brighter where it left, darker where it came to."""
    dark = np.full((2, 4, 6), 200, np.uint8)
    dark[0, :, 2:4], dark[1, :, 3:5] = 20, 20
    (_, first), (_, second) = changes(iter([(0.0, dark[0]), (0.1, dark[1])]))
    still, brighter, darker = map(rgb, (STILL, BRIGHTER, DARKER))
    assert (first == still).all(), "before the second picture nothing has changed"
    np.testing.assert_array_equal(second[0], [still, still, brighter, still, darker, still])


def test_the_picture_shown_is_the_last_one_that_was_taken(trial, monkeypatch):
    taken = [np.full((2, 2), value, np.uint8) for value in range(3)]
    monkeypatch.setattr(video, "pictures_of", lambda path, eye: zip((0.0, 0.5, 1.0), taken, strict=True))
    seen = [one[SEEN] for one in trial[1].seen([-0.1, 0.0, 0.49, 0.5, 7.0])]
    assert seen[0] is None and [int(one[0, 0]) for one in seen[1:]] == [0, 0, 1, 2]


def test_models_are_those_asked_for_otherwise_the_first(tmp_path):
    path = written(tmp_path / "many.rrd")
    assert list(Reel(path).values) == [model.label for model in CONTENT.models][: video.MOST_MODELS]
    assert list(Reel(path, ["a/b@c", "emd"]).values) == ["a/b@c", "emd"]


def test_times_of_a_film(trial):
    _, reel = trial
    times, rate = film_times(reel)
    assert rate == pytest.approx(30.0) and np.array_equal(times, reel.time_s)
    slow, _ = film_times(reel, speed=0.5)
    assert np.allclose(np.diff(slow), 0.5 / 30) and slow[-1] == pytest.approx(reel.time_s[-1], abs=0.02)


@pytest.mark.parametrize("ending", [".mp4", ".webp"])
def test_a_film_has_every_frame_and_no_file_is_left_of_one_that_breaks_off(trial, tmp_path, ending):
    pytest.importorskip("imageio_ffmpeg")
    (_, reel), out = trial, tmp_path / f"trial{ending}"
    count = make(reel, out, SIZE, rate=10.0)
    if ending == ".mp4":
        with av.open(str(out)) as film:
            assert len([*film.decode(video=0)]) == count
    out.unlink()

    with pytest.raises(KeyboardInterrupt):
        make(reel, out, SIZE, rate=10.0, advance=Mock(side_effect=KeyboardInterrupt))
    assert not list(tmp_path.iterdir())


def test_a_strip_has_the_pictures_of_its_moments(trial, tmp_path):
    result, reel = trial
    strip(reel, tmp_path / "strip.png", 3)
    assert cv2.imread(str(tmp_path / "strip.png")).shape[1] == 1800
    times = reel.time_s[[0, result.frames // 2, -1]].tolist()
    canvas = Canvas(reel, (1800, 900), times)
    canvas.strip(times, list(reel.seen(times)))
    for column, k in zip(canvas.panels, (0, result.frames // 2, -1), strict=True):
        np.testing.assert_array_equal(column[SEEN].images[0].get_array(), result.media.images[""][k])


def test_a_strips_moments_divide_the_time_of_responses(trial):
    result, reel = trial
    series = result.answers[0].series
    traces = [series.hs, series.vs, series.hs_spikes, series.vs_spikes]
    over = [k for k in range(result.frames) if any(abs(trace[k]) > np.abs(trace).max() / 20 for trace in traces)]
    first, last = reel.time_s[over[0]], reel.time_s[over[-1]]
    assert 0 < over[0] < over[-1]
    assert moments(reel, 3) == pytest.approx([first + (last - first) * share for share in (0.25, 0.5, 0.75)])
    silent = copy.copy(reel)
    silent.values = {}
    assert moments(silent, 1) == pytest.approx([(reel.time_s[0] + reel.time_s[-1]) / 2])


@pytest.mark.parametrize(("name", "more"), [("a.mp4", ("--speed", "0")), ("a.gif", ()), ("a.mp4", ("--seed", "3"))])
def test_wrong_uses_are_refused(trial, tmp_path, name, more):
    with pytest.raises(UsageError):
        main.command(["video", str(trial[1]), "--out", str(tmp_path / name), *more])
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("ending", [".mp4", ".webp"])
def test_a_film_that_the_disk_has_no_room_for_gets_no_name(trial, tmp_path, ending):
    out = tmp_path / f"film{ending}"
    part(out).symlink_to("/dev/full")
    with pytest.raises(OSError, match=f"film{ending}.*full"):
        make(trial[1], out, SIZE, 5.0)
    assert not out.exists() and not part(out).is_symlink()


def test_the_recording_that_opens_first_is_of_a_trial_in_which_a_model_spikes(tmp_path):
    places = [tmp_path / "recordings" / f"trial-{number:04d}.rrd" for number in range(4)]
    places[0].parent.mkdir()
    for place in places:
        place.touch()
    assert recording(tmp_path, None) == places[0], "of none it is known"
    rows = {"trial": [0, 0, 3, 2, 2], "model": [*"abaab"], "spikes": [0, None, 1, 0, 5]}
    pl.DataFrame(rows).write_parquet(tmp_path / "trials.parquet")
    assert recording(tmp_path, None) == places[2] and recording(tmp_path, 3) == places[3]
