"""Footage of all kinds through ``colias watch`` as a user runs it, and what it leaves behind."""

import os
import signal
import subprocess
import sys
import threading
import time
from functools import partial
from pathlib import Path

import av
import cv2
import numpy as np
import polars as pl
import pytest
import rerun as rr

from dsnn import DSNN, DSNNParams
from experiments.bench.cli.entry import run as main
from experiments.bench.footage import claims as footage_claims
from experiments.bench.footage import flow as footage_flow
from experiments.bench.footage.rows import SCHEMA
from experiments.bench.footage.video import Footage, ahead, usual_size
from experiments.bench.footage.watch import Tracker
from experiments.bench.run.errors import UsageError
from experiments.bench.run.settings import watchers
from experiments.bench.stats.claim import find_claim
from tests.conftest import Colias
from tests.helpers.footage import FPS, SHAPE, Walker, street, write

C12 = find_claim(footage_claims.CLAIM, footage_claims.FootageClaim)

WALKERS = (Walker(3.6, enters=4), Walker(-3.6, enters=110))
FRAMES = 220


@pytest.fixture(scope="module")
def films(tmp_path_factory) -> Path:
    """A folder with a clip of two people, one each way, and the same mirrored."""
    folder = tmp_path_factory.mktemp("films")
    frames = list(street(WALKERS, FRAMES))
    write(folder / "street.avi", frames)
    write(folder / "mirrored.avi", (frame[:, ::-1] for frame in frames))
    return folder


@pytest.fixture(scope="module")
def watched(films) -> tuple[Path, str]:
    """One run over the clip with everything it can leave, and what it printed."""
    leaves = ("--record", "street.rrd", "--table", "street.parquet")
    done = Colias(films)("watch", "street.avi", "--no-view", "--judge", *leaves)
    assert (done.returncode, done.stderr) == (0, "")
    return films, done.stdout


def decoded(path: Path) -> np.ndarray:
    """Luma of every frame (T, R, C) as Motion JPEG stores it: the plane Y, which nothing converts."""
    with av.open(str(path)) as film:
        return np.stack([frame.to_ndarray()[: frame.height] for frame in film.decode(video=0)])


def intervals(printed: str) -> list[tuple[str, float, float]]:
    """The table of motion, (way, from, to) a row."""
    rows = [line.split() for line in printed.splitlines() if "ward " in line and line.startswith("dsnn")]
    return [(row[1], float(row[2]), float(row[3])) for row in rows]


def test_intervals_of_motion_match_who_walked_where(watched):
    motion_intervals = intervals(watched[1])
    assert {way for way, _, _ in motion_intervals} == {"rightward", "leftward"}
    for walker in WALKERS:
        way = "rightward" if walker.speed > 0 else "leftward"
        begins, ends = walker.seen_s()
        slack = 2 * walker.half / abs(walker.speed) / FPS  # swinging limbs come first and leave last
        mine = [(start, end) for name, start, end in motion_intervals if name == way]
        assert min(start for start, _ in mine) >= begins - slack
        assert max(end for _, end in mine) <= ends + slack
        assert max(end for _, end in mine) - min(start for start, _ in mine) >= 0.7 * (ends - begins)


def test_the_summary_tells_rates_and_sizes(watched):
    assert "street.avi: 320x180, 30 frames/s; 220 frames, 7.3 s, seen at 320x180" in watched[1]
    (totals,) = [line.split() for line in watched[1].splitlines() if line.startswith("dsnn  ") and "ward" not in line]
    assert totals[1:3] == ["30", "0.16"]
    ways = [way for way, _, _ in intervals(watched[1])]
    assert totals[3:7] == [f"{ways.count(way)}" for way in ("rightward", "leftward", "downward", "upward")]
    assert "own time" in watched[1] and "frames/s)" in watched[1]


def test_claim_12_is_judged_against_the_flow(watched):
    assert "C12 holds" in watched[1]
    assert "correlation of HS with the flow" in watched[1]
    assert "in the paper's stronger words " in watched[1] and "of these seconds" in watched[1]
    assert "direction told: HS follows the flow by r = " in watched[1] and "threshold passed: in " in watched[1]


def test_the_table_is_what_the_network_says_of_the_frames(watched):
    folder, _ = watched
    table = pl.read_parquet(folder / "street.parquet")
    series = DSNN(SHAPE, DSNNParams.offline()).run(decoded(folder / "street.avi"))
    assert table.schema == SCHEMA
    assert table["frame"].to_list() == list(range(FRAMES))
    np.testing.assert_allclose(table["time_s"], np.arange(FRAMES) / FPS, atol=1e-6)
    for name in ("hs", "vs", "hs_spikes", "vs_spikes"):
        np.testing.assert_array_equal(table[name], getattr(series, name))


def test_the_recording_holds_every_frame(watched):
    folder, _ = watched
    table = pl.read_parquet(folder / "street.parquet")
    hs = temporal(folder / "street.rrd", "/models/dsnn/hs")
    values = [value for batch in hs for row in batch[column(batch, "Scalars")].to_pylist() for value in row]
    np.testing.assert_array_equal(values, table["hs"])
    seconds = np.concatenate([batch["time"].cast("int64").to_numpy() for batch in hs]) / 1e9
    np.testing.assert_allclose(seconds, table["time_s"], atol=1e-8)
    pictures = temporal(folder / "street.rrd", "/world/observer/camera/image")
    jpegs = [row[0] for batch in pictures for row in batch[column(batch, "blob")].to_pylist()]
    assert len(jpegs) == FRAMES
    picture = cv2.imdecode(np.frombuffer(bytes(jpegs[100]), np.uint8), cv2.IMREAD_GRAYSCALE)
    assert cv2.absdiff(picture, decoded(folder / "street.avi")[100]).mean() < 3
    arrows = temporal(folder / "street.rrd", "/world/observer/camera/motion/dsnn")
    vectors = [row for batch in arrows for row in batch[column(batch, "vectors")].to_pylist()]
    np.testing.assert_allclose(
        [row[0][0] for row in vectors], 90 * np.clip(np.asarray(table["hs"]) / 0.5, -1, 1), rtol=1e-5
    )
    assert (folder / "street.rrd").stat().st_size < 200_000 + 13_000 * FRAMES


def temporal(recording: Path, path: str) -> list:
    """The chunks of one entity, in the order of their frames."""
    store = rr.chunk.RrdReader(recording).stream().filter(content=path, is_static=False)
    return sorted((chunk.to_record_batch() for chunk in store.to_chunks()), key=lambda batch: batch["frame"][0].as_py())


def column(batch, word: str) -> str:
    return next(name for name in batch.schema.names if word in name)


def test_a_mirrored_film_flips_the_signs(watched, colias):
    folder, _ = watched
    assert colias("watch", str(folder / "mirrored.avi"), "--no-view", "--table", "m.csv").returncode == 0
    mirrored = pl.read_csv(colias.folder / "m.csv")
    plain, other = np.asarray(pl.read_parquet(folder / "street.parquet")["hs"]), np.asarray(mirrored["hs"])
    strong = np.abs(plain) > 0.05
    assert strong.sum() > 100
    assert (np.sign(other[strong]) == -np.sign(plain[strong])).all()


def test_models_parameters_size_and_rate(films, colias):
    arguments = ("--model", "dsnn", "--model", "dsn2017", "--set", "dsnn.t_sp=0.1", "--fps", "25", "--size", "160x120")
    done = colias("watch", str(films / "street.avi"), "--no-view", "--table", "t.csv", *arguments)
    assert done.returncode == 0
    assert "note: 160x120 is not the aspect of 320x180: the network sees it distorted by 33%" in done.stderr
    rows = [line.split()[:3] for line in done.stdout.splitlines() if " 25 " in line]
    assert rows == [["dsnn", "25", "0.1"], ["dsn2017", "25", "0.16"]]
    table = pl.read_csv(colias.folder / "t.csv")
    assert table["model"].to_list() == ["dsnn", "dsn2017"] * FRAMES
    small = [cv2.resize(frame, (160, 120), interpolation=cv2.INTER_AREA) for frame in decoded(films / "street.avi")]
    expected = DSNN((120, 160), DSNNParams.offline(t_sp=0.1, fps=25)).run(small)
    np.testing.assert_array_equal(np.asarray(table["hs"])[::2], expected.hs)


def test_the_film_s_own_rate_is_taken_when_asked(colias):
    write(colias.folder / "slow.avi", street((), 8), fps=12.5)
    done = colias("watch", "slow.avi", "--no-view", "--fps", "real")
    assert done.returncode == 0
    assert "12.5 frames/s" in done.stdout and " 12.5  0.16 " in done.stdout


def test_a_film_cut_short_keeps_what_there_is(films, colias):
    whole = (films / "street.avi").read_bytes()
    (colias.folder / "cut.avi").write_bytes(whole[: len(whole) // 2])
    done = colias("watch", "cut.avi", "--no-view", "--table", "cut.parquet", "--record", "cut.rrd")
    assert done.returncode == 1
    count = pl.read_parquet(colias.folder / "cut.parquet").height
    assert 60 < count < 200
    note = f"note: ended early: {count} of the {FRAMES} frames its header announces were decoded\n"
    assert done.stderr == note
    assert f"; {count} frames, " in done.stdout
    assert sum(batch.num_rows for batch in temporal(colias.folder / "cut.rrd", "/world/observer/camera/image")) == count


def spoilt(films: Path, folder: Path) -> None:
    """Files that are no film."""
    (folder / "text.mp4").write_text("a film by name alone\n" * 200)
    (folder / "empty.avi").touch()
    whole = (films / "street.avi").read_bytes()
    (folder / "header.avi").write_bytes(whole[:4096])
    noise = np.random.default_rng(0).integers(0, 256, len(whole), np.uint8).tobytes()
    (folder / "noise.avi").write_bytes(whole[:16] + noise)
    (folder / "folder.mp4").mkdir()


NO_FILM = {
    "absent.mp4": "no such file",
    "text.mp4": "not a video",
    "empty.avi": "the file is empty",
    "noise.avi": "noise.avi: no",
    "header.avi": "header.avi: no",
    "folder.mp4": "a folder",
    "63": "camera 63: cannot be opened",
}


@pytest.mark.parametrize("source", NO_FILM)
def test_what_cannot_be_decoded_is_told_in_one_line(films, colias, source):
    spoilt(films, colias.folder)
    there = sorted(colias.folder.iterdir())
    done = colias("watch", source, "--no-view", "--table", "out.csv", "--record", "out.rrd")
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1), done.stderr
    assert NO_FILM[source] in done.stderr
    assert sorted(colias.folder.iterdir()) == there


WRONG = {
    "size": (("--size", "320"), "WIDTHxHEIGHT"),
    "tiny": (("--size", "4x4"), "from 8 to 4096"),
    "rate": (("--fps", "fast"), "legal is 'real', or a number"),
    "no rate": (("--fps", "0"), "above 0"),
    "model": (("--model", "dsn"), "nearest: dsnn"),
    "only": (("--only",), "name them by --model"),
    "key": (("--set", "dsnn.n_kon=3"), "nearest: dsnn.n_con"),
    "overwrite": (("--table", "there.csv"), "is there already"),
    "ending": (("--table", "out.txt"), ".csv or .parquet"),
    "recording": (("--record", "out.mp4"), "end in .rrd"),
    "nowhere": (("--record", "no/out.rrd"), "no such folder"),
}


@pytest.mark.parametrize("case", WRONG)
def test_wrong_uses_end_in_one_line(films, tmp_path, monkeypatch, capfd, case):
    arguments, says = WRONG[case]
    (tmp_path / "there.csv").write_text("mine\n")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "argv", ["colias", "watch", str(films / "street.avi"), "--no-view", *arguments])
    with pytest.raises(SystemExit) as ended:
        main()
    printed, errors = capfd.readouterr()
    assert (ended.value.code, printed, errors.count("\n")) == (2, "", 1), errors
    assert says in errors
    assert [path.name for path in tmp_path.iterdir()] == ["there.csv"]
    assert (tmp_path / "there.csv").read_text() == "mine\n"


def test_a_viewer_needs_a_screen(films, colias):
    done = colias("watch", str(films / "street.avi"))
    assert (done.returncode, done.stderr.count("\n")) == (2, 1)
    assert "--no-view" in done.stderr


def test_a_viewer_that_does_not_open_is_told_in_one_line(films, tmp_path):
    command = [
        sys.executable,
        "-m",
        "experiments.bench.cli",
        "watch",
        str(films / "street.avi"),
        "--table",
        "t.csv",
    ]
    environment = {k: v for k, v in os.environ.items() if k != "WAYLAND_DISPLAY"} | {"DISPLAY": ":7654321"}
    done = subprocess.run(
        command, cwd=tmp_path, env=environment, capture_output=True, text=True, timeout=60, check=False
    )
    assert done.stderr.count("\n") == 1, done.stderr
    if done.returncode == 0:  # on a busy machine the viewer gives up only when frames are on their way to it
        assert "note: the viewer was closed, or could not open" in done.stderr
        assert pl.read_csv(tmp_path / "t.csv").height == FRAMES
    else:
        assert done.returncode == 2 and "viewer did not open" in done.stderr
        assert not list(tmp_path.iterdir())


def test_an_interrupt_leaves_whole_files_of_what_was_seen(films, tmp_path):
    command = [sys.executable, "-m", "experiments.bench.cli", "watch", str(films / "street.avi"), "--no-view"]
    command += ["--size", "960x540", "--record", "out.rrd", "--table", "out.parquet"]  # slow enough to interrupt
    heed = partial(signal.signal, signal.SIGINT, signal.SIG_DFL)
    recording, deadline = tmp_path / "out.rrd.part", time.monotonic() + 60
    with subprocess.Popen(
        command, cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, preexec_fn=heed
    ) as process:
        try:
            while not (recording.exists() and recording.stat().st_size > 400_000):
                assert process.poll() is None and time.monotonic() < deadline
                time.sleep(0.02)
            process.send_signal(signal.SIGINT)
            printed, errors = process.communicate(timeout=20)
        finally:
            process.kill()
    assert (process.returncode, errors) == (130, "")
    table = pl.read_parquet(tmp_path / "out.parquet")
    count = table.height
    assert 0 < count < FRAMES
    assert table["frame"].to_list() == list(range(count))
    assert f"; {count} frames, " in printed
    assert sum(batch.num_rows for batch in temporal(tmp_path / "out.rrd", "/models/dsnn/hs")) == count
    assert not list(tmp_path.glob("*.part"))


class FakeCapture:
    """A capture with frames of its own, each (image, ms), in place of OpenCV's."""

    def __init__(self, frames, rate=30.0):
        self.frames, self.rate, self.at = list(frames), rate, 0.0

    def isOpened(self):
        return True

    def read(self):
        if not self.frames:
            return False, None
        image, self.at = self.frames.pop(0)
        return True, image

    def get(self, what):
        return {cv2.CAP_PROP_POS_MSEC: self.at, cv2.CAP_PROP_FPS: self.rate}.get(what, 0.0)

    def release(self):
        self.frames = []


@pytest.fixture
def capture(monkeypatch, tmp_path):
    """Opens a film, or a camera, of the given frames."""

    def opened(frames, source=None, **more) -> Footage:
        (tmp_path / "film.mkv").write_bytes(b"something")
        monkeypatch.setattr(cv2, "VideoCapture", lambda *_: FakeCapture(frames, **more))
        return Footage(source or str(tmp_path / "film.mkv"))

    return opened


def grey(width=64, height=36) -> np.ndarray:
    return np.full((height, width, 3), 90, np.uint8)


def test_a_camera_that_falls_silent_is_an_early_end(capture):
    camera = capture(((grey(), 0.0) for _ in range(5)), source="0")
    assert camera.live and camera.announced is None
    assert len(list(ahead(camera.pictures((64, 36)), threading.Event()))) == 5
    assert camera.ended_early() == "camera 0 gave no more frames after 5"


def test_a_camera_that_hangs_can_be_left():
    stop, release = threading.Event(), threading.Event()

    def hang():
        yield 1
        stop.set()
        release.wait(120)
        left.append(release.is_set())
        yield 2

    left = []
    assert list(ahead(hang(), stop)) in ([], [1])
    assert not left, "it still hangs when it is left"
    release.set()


def test_what_decoding_raises_on_its_thread_is_raised_here():
    def broken():
        yield 1
        raise UsageError("broken")

    with pytest.raises(UsageError, match="broken"):
        list(ahead(broken(), threading.Event()))


@pytest.mark.parametrize(
    ("own", "seen"), [((640, 360), (320, 180)), ((1080, 1920), (180, 320)), ((99, 72), (99, 72)), ((5000, 3), (320, 2))]
)
def test_the_usual_size_keeps_the_aspect_and_never_enlarges(own, seen):
    assert usual_size(own) == seen


def motions(potentials, fps=30.0, threshold=0.16):
    tracker = Tracker(("rightward", "leftward"), threshold)
    for i, potential in enumerate(potentials):
        tracker.add(i / fps, potential, round(np.sign(potential)) if abs(potential) > threshold else 0)
    return [(m.direction, round(m.start_s * fps), round(m.end_s * fps), m.frames, m.peak) for m in tracker.motions()]


def test_intervals_are_merged_over_short_gaps_and_need_three_frames():
    assert motions([0, 0.2, 0.2, 0]) == []
    assert motions([0, 0.2, 0.3, 0.2, 0]) == [("rightward", 1, 3, 3, 0.3)]
    assert motions([0.16] * 9) == []  # at the threshold is not over it
    over = [-0.2] * 3
    assert motions(over + [0] * 4 + over) == [("leftward", 0, 9, 6, -0.2)]
    assert motions(over + [0] * 6 + over) == [("leftward", 0, 2, 3, -0.2), ("leftward", 9, 11, 3, -0.2)]
    assert motions([0.2] * 3 + over) == [("rightward", 0, 2, 3, 0.2), ("leftward", 3, 5, 3, -0.2)]


def test_models_get_the_off_line_preset():
    plain, earlier = (model.network for model in watchers(["dsnn", "dsn2017"], ())[0])
    assert plain == DSNNParams.offline()
    assert earlier == DSNNParams.offline(fdsr=False)
    (told,), _ = watchers(["dsnn"], ["dsnn.fps=24"], fps=60.0)
    assert told.network.fps == 24, "what is said of one parameter counts"
    (other,), _ = watchers(["dsnn"], (), fps=60.0)
    assert other.network.fps == 60


def columns(sign: float = 1.0, vertical: float = 0.3) -> tuple[np.ndarray, ...]:
    """Flow that turns every second, an HS that follows it by ``sign`` with noise, and a VS."""
    rng, turn = np.random.default_rng(1), np.sign(np.sin(np.pi * np.arange(600) / 30 + 0.01))
    return turn, sign * 0.25 * turn + 0.02 * rng.standard_normal(600), vertical * rng.standard_normal(600)


def test_claim_12_holds_fails_or_is_not_judged():
    flow, hs, vs = columns(vertical=0.03)
    assert C12.judge(flow, hs, vs, 0.16, 30.0).verdict == "holds"
    assert C12.judge(-flow, hs, vs, 0.16, 30.0).verdict == "fails"
    assert C12.judge(flow, hs, 10 * hs, 0.16, 30.0).verdict == "fails"
    wrong = flow * np.where(np.arange(600) % 8 == 0, -1, 1)  # the sign of one frame in eight: still correlated
    outcome = C12.judge(wrong, hs, vs, 0.16, 30.0)
    assert outcome.verdict == "fails" and "same sign over T 0.88" in outcome.measured
    assert C12.judge(flow, hs / 10, vs, 0.16, 30.0).verdict == "not shown"
    assert C12.judge(flow[:59], hs[:59], vs[:59], 0.16, 30.0).verdict == "not shown"


def test_the_interval_of_claim_12_is_that_of_blocks_not_of_frames():
    """Of slow noise, frames tell less than their number: the interval must cover what independent blocks show."""
    rng = np.random.default_rng(2)
    flow, hs = (np.repeat(rng.standard_normal(40), 30) for _ in range(2))
    outcome = C12.judge(flow, hs, np.zeros(1200), 0.16, 30.0)
    low, high = (float(part) for part in outcome.measured.split("[")[1].split("]")[0].split(","))
    assert high - low > 2 / np.sqrt(40)  # 1200 frames taken as independent would give 0.11
    assert low < np.corrcoef(flow, hs)[0, 1] < high


def test_flow_is_rightward_positive():
    frames = [cv2.cvtColor(f, cv2.COLOR_BGR2GRAY) for f in street((Walker(4.0, enters=0),), 30)][-2:]
    assert footage_flow.mean_flow(*frames) > 0.01
    assert footage_flow.mean_flow(*(frame[:, ::-1].copy() for frame in frames)) < -0.01
