"""The commands for stimuli, through real processes: what they write is what was painted, and what they refuse."""

import csv
import subprocess
import sys

import cv2
import numpy as np
import pytest

from dsnn import DSNN, DSNNParams
from dsnn.stimuli import STIMULI, Jittered, stimulus
from experiments.bench.run.models import choose
from experiments.bench.run.play import Showing
from experiments.bench.sources import clip_file as export
from experiments.bench.sources.clips import Clip
from tests.helpers.chapters import FOOTAGE, blocks


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
    clip = Jittered(stimulus("cluttered", seed=4, speed=240, columns=120), 0.25, seed=4)
    np.testing.assert_array_equal(decoded(colias.folder / "sub" / "a.avi"), [frame.luma for frame in clip])
    before = (colias.folder / "sub" / "a.avi").read_bytes()
    (colias.folder / "sub" / "a.csv").unlink()
    again = colias("video", "plain", "--out", "sub/a.avi")
    assert (again.returncode, again.stderr) == (
        2, "error: sub/a.avi is there already: choose another name, or remove it\n"
    )  # fmt: skip
    assert (colias.folder / "sub" / "a.avi").read_bytes() == before


def test_list_and_parameters_name_the_stimuli(colias):
    listed = colias("list").stdout
    assert all(name in listed for name in STIMULI)
    output = colias("list", "parameters", "grating").stdout
    assert "grating.period_px=20.0" in output
    assert not list(colias.folder.iterdir())


def test_models_respond_to_what_the_stimulus_paints():
    source = Clip("small", "plain", {"rows": 60, "columns": 80, "width": 20, "height": 30}).open(0)
    showing = Showing(source, [choose("dsnn", "offline"), choose("dsn2017", "offline")])
    motions = [sample.truth["motion"] for sample in showing]
    for (_, series), params in zip(
        showing.series(), (DSNNParams.offline(), DSNNParams.offline(fdsr=False)), strict=True
    ):  # fmt: skip
        expected = DSNN(source.shape, params).run(frame.luma for frame in source.stimulus)
        np.testing.assert_array_equal(series.hs, expected.hs)
        np.testing.assert_array_equal(series.vs_spikes, expected.vs_spikes)
    assert motions == [frame.truth.motion for frame in source.stimulus]


def test_the_example_of_the_documentation_runs(tmp_path):
    (example,) = [block.text for block in blocks(FOOTAGE) if 'stimulus("cluttered"' in block.text]
    done = subprocess.run([sys.executable, "-c", example], cwd=tmp_path, capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    lines = done.stdout.splitlines()
    assert len(lines) > 50
    assert any("rightward" in line for line in lines)
