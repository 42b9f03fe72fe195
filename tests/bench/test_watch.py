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
from experiments.bench.cli import main
from experiments.bench.run import interrupts
from experiments.bench.run.play import Showing
from experiments.bench.sources import video
from experiments.bench.sources.motion import motions
from experiments.bench.sources.video import VideoSource, usual_size
from experiments.bench.watch import Recorder
from tests.dsnn.test_video import ARROW, CASES, written
from tests.helpers.answering import write_model
from tests.helpers.footage import FPS, street
from tests.helpers.footage import film as filmed
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
}


@pytest.mark.parametrize("name", ANSWERS)
def test_models_answer_what_is_shown(name):
    channel, peak, spikes, count, rate = ANSWERS[name]
    run = watch(CASES / name, quiet=True, recordings=False)
    (motion,) = run.summary.to_dicts()
    assert motion["direction"] == {"hs": "rightward", "vs": "downward"}[channel]
    assert motion["peak"] == pytest.approx(peak, abs=0.01) and motion["spikes"] == spikes
    np.testing.assert_allclose(run.frames["time_s"], np.arange(count) / rate, atol=1e-6)
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


def test_a_folder_of_pictures_is_shown_in_the_order_of_its_numbers():
    Path("pictures").mkdir()
    images = [np.roll(ARROW, 3 * i, axis=1) for i in range(12)]
    for number, image in enumerate(images):
        cv2.imwrite(f"pictures/{number}.png", image)
    run = watch("pictures", quiet=True, recordings=False)
    np.testing.assert_array_equal(run.frames["hs"], DSNN(ARROW.shape, DSNNParams.offline()).run(images).hs)
    Path("pictures/twelve.png").write_bytes((CASES / "twelve-bits.png").read_bytes())
    with pytest.raises(UsageError, match="twelve"):
        watch("pictures", quiet=True, recordings=False)


@pytest.mark.parametrize("alone", [False, True])
def test_a_model_that_raises_loses_its_own_rows(film, alone):
    broken = write_model(Path(), "broken", "Response(hs=0.5) if self.frame < 6 else 1 / 0")
    run = watch(film, models=broken, only=alone, quiet=True, seconds=1.0)
    assert run.trials["model"].to_list() == ([] if alone else ["dsnn"])
    assert run.frames.height == (0 if alone else 31)
    assert "division by zero" in run.failures["reason"][0]


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


@pytest.mark.parametrize(
    ("own", "seen"), [((640, 360), (320, 180)), ((1080, 1920), (180, 320)), ((99, 72), (99, 72)), ((5000, 3), (320, 2))]
)
def test_the_usual_size_keeps_the_aspect_and_never_enlarges(own, seen):
    assert usual_size(own) == seen


def intervals(potentials, threshold=0.16, channel="hs"):
    shown = np.asarray(potentials, float)
    table = pl.DataFrame({"model": "m", "time_s": np.arange(len(shown)) / 30, channel: shown,
                          f"{channel}_spikes": np.sign(shown).astype(int) * (np.abs(shown) > threshold)})  # fmt: skip
    found = motions(table, {"m": {"hs": None, "vs": None, "azimuth": 0.1, channel: threshold}})
    assert found["frames"].to_list() == found["spikes"].to_list()
    return [(row["direction"], round(row["start_s"] * 30), round(row["end_s"] * 30), row["frames"], row["peak"])
            for row in found.to_dicts()]  # fmt: skip


def test_intervals_are_merged_over_short_gaps_and_need_three_frames():
    assert intervals([0, 0.2, 0.2, 0]) == []
    assert intervals([0, 0.2, 0.3, 0.2, 0]) == [("rightward", 1, 3, 3, 0.3)]
    assert intervals([0.16] * 9) == []  # at the threshold is not over it
    over = [-0.2] * 3
    assert intervals(over + [0] * 4 + over) == [("leftward", 0, 9, 6, -0.2)]
    assert intervals(over + [0] * 6 + over) == [("leftward", 0, 2, 3, -0.2), ("leftward", 9, 11, 3, -0.2)]
    assert intervals([0.2] * 3 + over) == [("rightward", 0, 2, 3, 0.2), ("leftward", 3, 5, 3, -0.2)]
    vertical = [("downward", 0, 2, 3, 0.2), ("upward", 3, 5, 3, -0.2)]
    assert intervals([0.2] * 3 + over, channel="vs") == vertical


@pytest.mark.parametrize("rate", [1, 25, 50])
def test_the_rate_of_a_film_is_its_own(rate):
    """Models are told by it that their parameters assume another."""
    source = VideoSource(written(Path(f"{rate}.mkv"), [ARROW] * 5, rate=rate))
    assert source.fps == source.columns()["fps"] == rate


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
