"""``colias export``: the tables of every kind of run for other programs, and frames as pictures."""

from __future__ import annotations

import csv
import importlib.util
import json

import cv2
import numpy as np
import polars as pl
import pytest
from scipy import io

import colias_sim
import experiments
from experiments.bench.cli import main
from experiments.bench.run import record
from experiments.bench.run.errors import UsageError
from experiments.bench.store.convert import array, fields, read_file, write
from experiments.bench.store.pictures import pictures
from tests.helpers.h264 import decoded


def described(folder, kind="trials"):
    """A folder as a run leaves it, its tables and recordings aside."""
    folder.mkdir(parents=True)
    made_by = {"colias-sim": colias_sim.__version__}
    noted = {"kind": kind, "experiment": "x", "seed": 0, "trials": 1, "versions": made_by}
    (folder / "run.json").write_text(json.dumps(noted))


def colias(*arguments) -> int:
    return main.command([str(argument) for argument in arguments])


SMALL = (("rows", 40), ("columns", 60), ("width", 9), ("height", 20), ("speed", 240.0))
SHOWN = experiments.OfflineExperiment("small", "small", (experiments.Clip("right", "plain", SMALL),), ("dsnn",))


@pytest.fixture(scope="module")
def clips(tmp_path_factory):
    """A run of one small clip, a parameter of it changed."""
    folder = tmp_path_factory.mktemp("clips") / "small"
    return experiments.run(SHOWN, settings={"dsnn.n_con": 4}, repeats=3, quiet=True, workers=0, out=folder)


@pytest.mark.parametrize("kind", ["csv", "npz", "mat"])
def test_the_tables_come_out_whole(clips, tmp_path, kind):
    assert colias("export", clips.folder, "--to", kind, "--out", tmp_path / "out", "--quiet") == 0
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == [f"frames.{kind}", f"trials.{kind}"]
    rows = clips.trials.to_dicts()
    place = tmp_path / "out" / f"trials.{kind}"
    if kind == "csv":
        with place.open() as file:
            read = list(csv.DictReader(file))
        assert list(read[0]) == clips.trials.columns
        assert [float(row["peak_hs"]) for row in read] == [row["peak_hs"] for row in rows]
        assert [row["dsnn.n_con"] for row in read] == ["4"] * len(rows)
    elif kind == "npz":
        with np.load(place, allow_pickle=False) as read:
            assert list(read) == clips.trials.columns
            np.testing.assert_array_equal(read["peak_hs"], clips.trials["peak_hs"])
            assert read["model"].tolist() == clips.trials["model"].to_list()
            known = [value if value is not None else np.nan for value in clips.trials["hs_rightward"].to_list()]
            np.testing.assert_array_equal(read["hs_rightward"], known)
    else:
        read = io.loadmat(place, simplify_cells=True)["trials"]
        np.testing.assert_array_equal(read["peak_hs"], clips.trials["peak_hs"])
        assert list(read["model"]) == clips.trials["model"].to_list()
        assert set(read["dsnn_n_con"]) == {4}


def test_parts_of_a_run_and_single_tables(tmp_path):
    """A leaderboard's parts are folders of their own; a table of footage is a file."""
    table = pl.DataFrame({"frame": [0, 1], "time_s": [0.0, 0.1], "hs": [None, 0.5]})
    for part in ("robot", "clips"):
        described(tmp_path / "run" / part)
        for name in ("trials", "frames"):
            table.with_columns(trial=0).write_parquet(tmp_path / "run" / part / f"{name}.parquet")
    names = ["clips/trials", "clips/frames", "robot/trials", "robot/frames"]
    assert list(experiments.load(tmp_path / "run").tables()) == names
    assert colias("export", tmp_path / "run", "--to", "npz", "--out", tmp_path / "out", "--quiet") == 0
    with np.load(tmp_path / "out" / "robot" / "trials.npz", allow_pickle=False) as read:
        np.testing.assert_array_equal(read["hs"], [np.nan, 0.5])
    table.write_csv(tmp_path / "seen.csv")
    assert experiments.load(tmp_path / "seen.csv").tables()["seen"].equals(table)
    (tmp_path / "bad.parquet").write_bytes(b"PAR1")
    with pytest.raises(UsageError, match=r"bad\.parquet: cannot be read"):
        read_file(tmp_path / "bad.parquet")
    with pytest.raises(UsageError, match=r"no run\.json there"):
        colias("export", tmp_path / "out", "--to", "csv", "--out", tmp_path / "none")


def test_columns_have_one_type_and_no_pickles(tmp_path):
    table = pl.DataFrame(
        {"n": [1, None], "word": ["a", None], "yes": [True, False], "none": [None, None], "1.x": [1, 2]}
    )
    kinds = {name: array(table[name]).dtype.kind for name in table.columns}
    assert kinds == {"n": "f", "word": "U", "yes": "b", "none": "f", "1.x": "i"}
    assert fields(["dsnn.n_con", "dsnn-n_con", "1.x", "_y"]) == ["dsnn_n_con", "dsnn_n_con_2", "c_1_x", "c__y"]
    for kind in ("csv", "npz", "mat"):
        (file,) = write({"odd": table}, tmp_path, kind)
        assert file.stat().st_size


def recorded(images) -> bytes:
    count = len(images[""])
    frames = record.Frames(np.arange(count) / 30, np.arange(count), images=images)
    return record.write(record.Content(eyes=tuple(images)), frames, "x")


@pytest.fixture
def filmed(tmp_path):
    """A run with two recordings, one of them of a part, of three and of five frames."""
    described(tmp_path / "run", "leaderboard")
    described(tmp_path / "run" / "part")
    for place, frames in (("recordings/trial-0003", 3), ("part/recordings/trial-0000", 5)):
        images = np.full((frames, 12, 16), 40 * frames, np.uint8)
        path = tmp_path / "run" / f"{place}.rrd"
        path.parent.mkdir(parents=True)
        path.write_bytes(recorded({"": images}))
    return tmp_path / "run"


@pytest.mark.skipif(importlib.util.find_spec("imageio_ffmpeg") is None, reason="needs the extra [video]")
def test_a_video_of_every_recording_or_of_one(filmed, tmp_path):
    def exported(*more):
        assert colias("export", filmed, "--to", "mp4", "--out", tmp_path / "out", "--force", "--quiet", *more) == 0
        videos = sorted((tmp_path / "out").rglob("*.*"))
        return {str(path.relative_to(tmp_path / "out")): len(decoded(path)) for path in videos}

    assert exported() == {"part/trial-0000.mp4": 5, "trial-0003.mp4": 3}
    assert exported("--trial", "3") == {"trial-0003.mp4": 3}
    with pytest.raises(UsageError, match=r"--trial 7: .* no recording of it \(recorded: 3"):
        exported("--trial", "7")


def test_one_trial_s_frames(filmed, tmp_path):
    assert colias("export", filmed, "--frames", tmp_path / "out", "--trial", "3", "--quiet") == 0
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["trial-0003"]


def test_frames_are_the_pictures_of_the_recordings(tmp_path):
    """A folder a recording, one more below it for each eye; frames are numbered from 0, and exact where they were."""
    frames = np.random.default_rng(0).integers(0, 256, (3, 12, 16), np.uint8)
    described(tmp_path / "run")
    (tmp_path / "run" / "recordings").mkdir()
    for name, images in (
        ("trial-0000", {"": frames, "ov7670": frames[::-1]}),
        ("trial-0001", {"": record.jpegs(frames, 95)}),
    ):
        (tmp_path / "run" / "recordings" / f"{name}.rrd").write_bytes(recorded(images))
    assert colias("export", tmp_path / "run", "--frames", tmp_path / "out", "--quiet") == 0
    paths = sorted(str(path.relative_to(tmp_path / "out")) for path in (tmp_path / "out").rglob("*.png"))
    folders = ("trial-0000/camera", "trial-0000/camera_ov7670", "trial-0001")
    assert paths == [f"{folder}/{number:06d}.png" for folder in folders for number in range(3)]
    read = [cv2.imread(str(tmp_path / "out" / path), cv2.IMREAD_UNCHANGED) for path in paths]
    np.testing.assert_array_equal(read[:3], frames)
    np.testing.assert_array_equal(read[3:6], frames[::-1])
    single = tmp_path / "run" / "recordings" / "trial-0001.rrd"
    assert colias("export", single, "--frames", tmp_path / "one", "--quiet") == 0
    assert len(list((tmp_path / "one" / "trial-0001").iterdir())) == 3
    single.write_bytes(b"no recording")
    with pytest.raises(UsageError, match="no recording"):
        pictures(single)
