"""The commands for stimuli, through real processes: what they write is what was painted, and what they refuse."""

import csv

import cv2
import numpy as np
import pytest

from dsnn.stimuli import STIMULI, Jitter, stimulus
from experiments.bench.sources import clip_file as export


def decoded(path):
    """Every frame of a video, (T, R, C); its three channels must be one and the same grey."""
    video = cv2.VideoCapture(str(path), cv2.CAP_FFMPEG)
    frames = []
    while (read := video.read())[0]:
        np.testing.assert_array_equal(read[1], read[1][:, :, :1].repeat(3, axis=2))
        frames.append(read[1][:, :, 0])
    return np.stack(frames)


def table(path):
    with path.open() as file:
        return list(csv.DictReader(file))


@pytest.mark.parametrize("name", STIMULI)
def test_a_clip_on_disk_is_the_stimulus_byte_for_byte(name, tmp_path):
    clip = stimulus(name, seed=2, rows=46, columns=70, fps=15)
    told = []
    written = export.write(clip, tmp_path / "clip.avi", lambda: told.append(1))
    np.testing.assert_array_equal(decoded(tmp_path / "clip.avi"), [frame.luma for frame in clip])
    assert cv2.VideoCapture(str(tmp_path / "clip.avi")).get(cv2.CAP_PROP_FPS) == 15
    assert len(table(written)) == len(clip) == len(told)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["clip.avi", "clip.csv"]


def test_the_table_is_the_truth(tmp_path):
    clip = stimulus("cluttered", rows=48, columns=80, width=10, height=12, background_speed=3.5)
    for row, (index, frame) in zip(
        table(export.write(clip, tmp_path / "a.avi", lambda: None)), enumerate(clip), strict=True
    ):
        assert (int(row["frame"]), row["motion"]) == (index, frame.truth.motion)
        assert float(row["time_s"]) == pytest.approx(index / 30, abs=1e-6)
        assert float(row["background_x_px_s"]) == 3.5
        if frame.truth.box is None:
            assert row["left_px"] == row["velocity_x_px_s"] == ""
        else:
            assert float(row["left_px"]) == pytest.approx(frame.truth.box.left, abs=1e-6)
            assert float(row["velocity_x_px_s"]) == frame.truth.velocity.x


def test_stimulus_writes_what_python_paints(colias):
    done = colias("video", "cluttered", "--out", "sub/a.avi", "--set", "cluttered.speed=240", "--seed", "4",
                  "--set", "cluttered.columns=120", "--jitter", "0.25")  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""
    clip = Jitter(stimulus("cluttered", seed=4, speed=240, columns=120), 0.25, seed=4)
    np.testing.assert_array_equal(decoded(colias.folder / "sub" / "a.avi"), [frame.luma for frame in clip])
    before = (colias.folder / "sub" / "a.avi").read_bytes()
    (colias.folder / "sub" / "a.csv").unlink()
    again = colias("video", "plain", "--out", "sub/a.avi")
    assert (again.returncode, again.stderr) == (
        2, "error: sub/a.avi is there already: choose another name, or remove it\n"
    )  # fmt: skip
    assert (colias.folder / "sub" / "a.avi").read_bytes() == before
