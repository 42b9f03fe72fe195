"""Videos, cameras, pictures and stimuli before models: what the run's folder has is what was shown."""

import resource
import signal
from pathlib import Path

import av
import cv2
import numpy as np
import polars as pl
import pytest

from dsnn import DSNN, DSNNParams
from dsnn.stimuli import stimulus
from experiments import UsageError, watch
from experiments.base import interrupts
from experiments.cli import main
from experiments.judge.motion import motions, near_miss
from experiments.kinds.footage import Recorder
from experiments.paper.claims.footage import stronger
from experiments.settings.pictures import folder_pictures
from experiments.show import video
from experiments.show.play import Showing
from experiments.show.video import VideoSource, usual_size
from tests.dsnn.test_video import ARROW, CASES, written
from tests.helpers.footage import FPS, film as filmed, street
from tests.helpers.recordings import columns

CLIP = street(movers="opposite")
FRAMES = len(CLIP)


@pytest.fixture(scope="module")
def film(tmp_path_factory) -> Path:
    """Two people, one each way."""
    return filmed(tmp_path_factory.mktemp("film") / "street.avi", CLIP)


@pytest.fixture(scope="module")
def seen(film):
    return watch(film, judge=True, out=film.parent / "seen", quiet=True)


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def decoded(path: Path) -> np.ndarray:
    """Luma of every frame (T, R, C) as Motion JPEG stores it: the plane Y, which nothing converts."""
    with av.open(str(path)) as box:
        return np.stack([frame.to_ndarray()[: frame.height] for frame in box.decode(video=0)])


ANSWERS = {  # by the README of these files: channel, peak of the potential, spikes, pictures, frames per second
    "right.mp4": ("hs", 0.40, 79, 90, 30),
    "mirrored.mp4": ("vs", 0.61, 128, 90, 30),
    "interlaced.mpg": ("hs", 0.21, 32, 45, 25),
    "sdr.mp4": ("hs", 0.30, 55, 90, 30),
    "eight-bits.mkv": ("hs", 0.58, 80, 60, 30),
    "lapse_4.mp4": ("hs", 0.30, 55, 90, 4),
    "lapse_5.mp4": ("hs", 0.30, 55, 90, 5),
}


@pytest.mark.parametrize("name", ANSWERS)
def test_models_answer_what_is_shown(name):
    channel, peak, spikes, count, rate = ANSWERS[name]
    run = watch(CASES / name, quiet=True, recordings=False)
    (motion,) = run.summary.to_dicts()
    assert motion["direction"] == {"hs": "rightward", "vs": "downward"}[channel]
    assert motion["peak"] == pytest.approx(peak, abs=0.01) and motion["spikes"] == spikes
    np.testing.assert_allclose(run.frames["time_s"], np.arange(count) / rate, atol=5.1e-4)
    assert run.trials["fps"].to_list() == [rate]


def test_intervals_of_motion_match_who_walked_where(seen):
    assert set(seen.summary["direction"]) == {"rightward", "leftward"}
    for way in ("rightward", "leftward"):
        times = [index / FPS for index, frame in enumerate(CLIP) if frame.truth.motion == way]
        for row in seen.summary.filter(pl.col("direction") == way).to_dicts():
            assert times[0] <= row["start_s"] < row["end_s"] <= times[-1] + 0.1


def test_the_frames_are_those_of_the_network_and_the_recording_has_all_of_them(seen, film):
    expected = DSNN((180, 320), DSNNParams.offline()).run(decoded(film))
    np.testing.assert_array_equal(seen.frames["hs"], expected.hs)
    np.testing.assert_array_equal(seen.frames["vs_spikes"], expected.vs_spikes)
    images = columns(seen.recordings[0], static=False)["/world/observer/camera/image"]
    assert images["frame"] == list(range(FRAMES))
    image = cv2.imdecode(np.frombuffer(bytes(images["blob"][100][0]), np.uint8), cv2.IMREAD_GRAYSCALE)
    assert cv2.absdiff(image, decoded(film)[100]).mean() < 3


def test_flow_and_grades_stand_in_the_tables_and_claims(seen):
    flow, hs = seen.frames["flow"].to_numpy()[1:], seen.frames["hs"].to_numpy()[1:]
    passing = np.abs(hs) > 0.16
    assert passing.any() and (np.sign(flow[passing]) == np.sign(hs[passing])).mean() > 0.9
    (row,) = seen.trials.to_dicts()
    assert row["flow_r_low"] < row["flow_r"] < row["flow_r_high"] and row["right_sign"] > 0.9
    assert seen.claims["id"].to_list() == ["C12", "C12s"]


def test_the_command_does_what_python_does_with_other_models_sizes_and_rates(film):
    arguments = ("--model", "dsn2017", "--set", "dsnn.t_sp=0.1", "--fps", "25", "--size", "160x120", "-q", "--no-view")
    assert main.command(["watch", str(film), *arguments, "--out", "a"]) == 0
    settings = {"dsnn.t_sp": 0.1}
    run = watch(film, models="dsn2017", settings=settings, fps=25, size=(160, 120), out="b", quiet=True)
    assert run.frames.equals(pl.read_parquet("a/frames.parquet")) and run.frames.height == 2 * FRAMES
    assert any("33%" in note for note in run.description["notes"])
    assert run.trials.select("width", "height").row(0) == (160, 120)
    small = [cv2.resize(frame, (160, 120), interpolation=cv2.INTER_AREA) for frame in decoded(film)]
    expected = DSNN((120, 160), DSNNParams.offline(t_sp=0.1, fps=25)).run(small)
    np.testing.assert_array_equal(run.frames.filter(pl.col("model") == "dsnn")["hs"], expected.hs)
    assert main.command(["run", "--again", "a", "--out", "c", "-q"]) == 0
    with pytest.raises(UsageError, match="holds a run"):
        watch(film, out="a", quiet=True)


def test_a_stimulus_is_shown_as_it_is_painted():
    settings = {"plain.motion": "leftward", "plain.rows": 60, "plain.columns": 80}
    run = watch("plain", settings=settings, seed=3, quiet=True)
    clip = stimulus("plain", seed=3, motion="leftward", rows=60, columns=80)
    expected = DSNN((60, 80), DSNNParams.offline()).run(frame.luma for frame in clip)
    np.testing.assert_array_equal(run.frames["hs"], expected.hs)
    assert "/world/observer/camera/stimulus" in columns(run.recordings[0]), "its outline"


def folder_of(images, names, folder="pictures") -> str:
    Path(folder).mkdir()
    for name, image in zip(names, images, strict=True):
        cv2.imwrite(f"{folder}/{name}.png", image)
    return folder


NUMBERS = {  # names in their order: the frame that each is
    "a_9 a_10 a_12": (0, 1, 3),
    "a-1 a-2 a-10": (0, 1, 9),
    "a_-10 a_-5 a_0 a_5 a_15": (0, 1, 2, 3, 5),
    "-2 -1 1": (0, 1, 3),
    "33ms 66ms 100ms 133ms 200ms": (0, 1, 2, 3, 5),
    "2026-01-02_7 2026-01-02_8 2026-01-03_1": (0, 1, 2),
    "left right": (0, 1),
    "1 2 1000000002": (0, 1, 1000000001),
}


@pytest.mark.parametrize("names", NUMBERS)
def test_lost_numbers_are_lost_time_and_a_note(names):
    names, frames = names.split(), NUMBERS[names]
    source = VideoSource(folder_of([np.full((36, 64), 10 * i, np.uint8) for i in range(len(names))], names))
    samples = list(source)
    assert [sample.image[0, 0] for sample in samples] == [10 * i for i in range(len(names))]
    np.testing.assert_allclose([sample.time_s for sample in samples], np.array(frames) / 30)
    assert [note.split()[0] for note in source.notes(np.zeros(1))] == [
        str(lost) for lost in [frames[-1] + 1 - len(frames)] if lost
    ]


def test_what_is_no_picture_is_left_out_and_a_damaged_one_is_lost_time():
    folder = Path(folder_of([ARROW] * 4, ["1", "2", "3", "4"]))
    (folder / "0").mkdir()
    (folder / "notes.txt").write_text("by hand")
    (folder / "2.png").write_bytes((folder / "2.png").read_bytes()[:60])
    source = VideoSource(str(folder))
    np.testing.assert_allclose([sample.time_s for sample in source], np.array([0, 2, 3]) / 30)
    assert [note.split()[0] for note in source.notes(np.zeros(1))] == ["2", "1"]
    user_pictures = folder_pictures(folder_of([ARROW], ["1"], "own"))
    (Path("own") / "more").mkdir()
    (Path("own") / "notes.txt").write_text("by hand")
    assert folder_pictures("own") == user_pictures


def test_white_is_known_once_a_folder_of_16_bits():
    deep = ARROW.astype(np.uint16) * 257
    source = VideoSource(folder_of([deep // 20, deep // 5, deep, deep // 20], "1234"))
    np.testing.assert_array_equal([sample.image.max() for sample in source], [11, 44, 220, 11])
    with pytest.raises(UsageError, match="fewer bits"):
        VideoSource(folder_of([ARROW.astype(np.uint16) << 4] * 3, "123", "twelve"))


def test_no_image_is_kept(film, monkeypatch):
    showings = []
    monkeypatch.setattr(Showing, "__init__", lambda self, *args, _init=Showing.__init__, **more: (
        showings.append(self), _init(self, *args, **more))[1])  # fmt: skip
    watch(film, size=(32, 18), quiet=True)
    (showing,) = showings
    assert len(showing.samples) == FRAMES and not any(sample.image.size for sample in showing.samples)


def test_a_film_cut_short_keeps_what_there_is_and_says_so(film, capsys):
    whole = film.read_bytes()
    Path("cut.avi").write_bytes(whole[: len(whole) // 2])
    assert main.command(["watch", "cut.avi", "--no-view", "-q", "--out", "cut"]) == 1
    assert 60 < pl.read_parquet("cut/frames.parquet").height < 200
    assert "ended early" in capsys.readouterr().err
    assert not watch(film, seconds=1.0, quiet=True).description["notes"], "left on purpose"


def test_ctrl_c_ends_a_film_and_keeps_what_was_seen(film, monkeypatch):
    frames, see = [], Recorder.see

    def fiftieth(recorder, showing):
        see(recorder, showing)
        frames.append(1)
        if len(frames) == 50:
            signal.raise_signal(signal.SIGINT)

    monkeypatch.setattr(Recorder, "see", fiftieth)
    before = signal.signal(signal.SIGINT, interrupts.leave)
    try:
        assert main.command(["watch", str(film), "--no-view", "-q", "--out", "out"]) == 128 + signal.SIGINT
    finally:
        signal.signal(signal.SIGINT, before)
    assert pl.read_parquet("out/frames.parquet").height == 50
    assert [path.name for path in Path("out/recordings").iterdir()] == ["trial-0000.rrd"]


@pytest.mark.parametrize(
    ("source", "more", "says"),
    [
        ("absent.mp4", {}, "no such file"),
        ("text.mp4", {}, "not a video"),
        ("empty", {}, "no frame"),
        ("63", {}, "cannot be opened"),
        ("plain", {"size": (4, 4)}, "between 8 and 4096"),
        ("plain", {"fps": 0}, "above 0"),
        ("plain", {"seconds": -1}, "above 0"),
        ("plain", {"settings": {"plain.speeed": 1}}, "plain.speed"),
    ],
)
def test_what_cannot_be_shown_is_refused_and_leaves_nothing(source, more, says):
    Path("text.mp4").write_text("a film by name alone\n" * 200)
    Path("empty").mkdir()
    with pytest.raises(UsageError, match=says):
        watch(source, quiet=True, **more)
    assert sorted(path.name for path in Path.cwd().iterdir()) == ["empty", "text.mp4"]


def test_a_camera_has_the_times_of_the_clock_and_its_silence_is_told(monkeypatch):
    film, opened = written(Path("five.mkv"), [np.full((36, 64), 90, np.uint8)] * 5), cv2.VideoCapture
    monkeypatch.setattr(cv2, "VideoCapture", lambda index: opened(film))
    clock = iter([10.0, 10.04, 10.08, 10.13, 10.2])
    monkeypatch.setattr(video.time, "monotonic", lambda: next(clock))
    source = VideoSource("0")
    samples = list(source)
    np.testing.assert_allclose([sample.time_s for sample in samples], [0.0, 0.04, 0.08, 0.13, 0.2])
    assert all((sample.image == 90).all() and sample.image.shape == (36, 64) for sample in samples)
    assert "no more frames after 5" in source.ended_early(5, 0.2)
    coloured = np.full((4, 4, 3), (200, 100, 50), np.uint8)  # blue, green, red
    assert (video.resized(coloured, (2, 2)) == round(0.114 * 200 + 0.587 * 100 + 0.299 * 50)).all()


def test_uneven_times_are_noted_and_a_film_may_change_its_size():
    stamps = [round(1000 / 30 * i) for i in range(20)]
    uneven = [time + (20 if i > 10 else 0) for i, time in enumerate(stamps)]
    for name, times in (("even", stamps), ("uneven", uneven)):
        run = watch(written(Path(f"{name}.mkv"), [ARROW] * 20, times=times), quiet=True, recordings=False)
        assert bool(run.description["notes"]) == (name == "uneven")
    for name, shape in (("one", (36, 64)), ("two", (40, 80))):
        written(Path(f"{name}.mjpeg"), [np.full(shape, 90, np.uint8)] * 3, "mjpeg", "yuvj420p")
    Path("both.mjpeg").write_bytes(Path("one.mjpeg").read_bytes() + Path("two.mjpeg").read_bytes())
    run = watch("both.mjpeg", size=(32, 18), quiet=True, recordings=False)
    assert run.frames.height == 6
    assert any("3 frames have another size" in note for note in run.description["notes"])


@pytest.mark.parametrize(
    ("own", "seen"), [((640, 360), (320, 180)), ((1080, 1920), (180, 320)), ((99, 72), (99, 72)), ((5000, 3), (320, 2))]
)
def test_the_usual_size_keeps_the_aspect_and_never_enlarges(own, seen):
    assert usual_size(own) == seen


def intervals(potentials, threshold=0.16, channel="hs", rate=30):
    shown = np.asarray(potentials, float)
    table = pl.DataFrame({"model": "m", "time_s": np.arange(len(shown)) / rate, channel: shown,
                          f"{channel}_spikes": np.sign(shown).astype(int) * (np.abs(shown) > threshold)})  # fmt: skip
    found = motions(table, {"m": {"hs": None, "vs": None, "azimuth": 0.1, channel: threshold}})
    assert found["frames"].to_list() == found["spikes"].to_list()
    return [(row["direction"], round(row["start_s"] * rate), round(row["end_s"] * rate), row["frames"], row["peak"])
            for row in found.to_dicts()]  # fmt: skip


def test_intervals_are_merged_over_short_gaps_and_need_three_frames():
    assert intervals([0, 0.2, 0.2, 0]) == []
    assert intervals([0, 0.2, 0.3, 0.2, 0]) == [("rightward", 1, 3, 3, 0.3)]
    assert intervals([0.16] * 9) == []  # at the threshold is not over it
    over = [-0.2] * 3
    assert intervals(over + [0] * 4 + over) == [("leftward", 0, 9, 6, -0.2)]
    assert intervals(over + [0] * 6 + over) == [("leftward", 0, 11, 6, -0.2)]
    assert intervals(over + [0] * 7 + over) == [("leftward", 0, 2, 3, -0.2), ("leftward", 10, 12, 3, -0.2)]
    assert intervals([0.2] * 3 + over) == [("rightward", 0, 2, 3, 0.2), ("leftward", 3, 5, 3, -0.2)]
    for rate in (1, 4, 5, 12):  # three frames, where they last longer than 0.25 s
        assert len(intervals([*over, 0, *over], rate=rate)) == 1
        assert len(intervals(over + [0] * 2 + over, rate=rate)) == 2
    vertical = [("downward", 0, 2, 3, 0.2), ("upward", 3, 5, 3, -0.2)]
    assert intervals([0.2] * 3 + over, channel="vs") == vertical


def test_without_an_interval_it_is_said_how_near_the_model_came():
    frames = pl.DataFrame({"hs": [0.0, -0.08, 0.05], "vs": [0.0, 0.3, 0.0], "looming": [0.0, 0.0, 0.0]})
    text = near_miss(frames, {"hs": 0.16, "vs": 0.16, "looming": None, "azimuth": 0.1})
    assert "T = 0.16" in text and "|HS| reached 0.08" in text and "|VS| reached 0.3 and passed it in 1" in text
    assert not near_miss(frames, {"hs": None})


def test_the_paper_s_stronger_words_hold_at_any_rate():
    """A second of a film of 2 frames/s has 2 frames, all of which can pass."""
    hs, rate = np.full(20, 0.3), 2.0
    assert [stronger(hs, hs, vs, 0.16, rate).verdict for vs in (0 * hs, hs)] == ["holds", "fails"]


def test_a_recording_without_room_is_a_failure_of_its_own_and_gets_no_name(tmp_path):
    _, most = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (60_000, most))  # more than a table has, and less than a recording
    try:
        run = watch("plain", out=tmp_path / "out", quiet=True)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (most, most))
    assert run.frames.height == run.trials["frames"].sum() > 0
    assert run.failures["model"].to_list() == ["(recording)"] and not run.recordings
    assert not list((tmp_path / "out" / "recordings").iterdir())
