"""A trial as a data set: what is written is what is true, and what its page shows reads it."""

import re

import cv2
import numpy as np
import polars as pl
import pytest

from experiments.base.errors import UsageError
from experiments.declare.clip import Clip
from experiments.kinds import data_set
from experiments.settings.models import choose
from experiments.show.clips import TRUE, ClipTrial
from experiments.show.play import play
from experiments.store.asked import Asked

FAST = {"experiment.speeds_cm_s": [20.0]}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    out = tmp_path_factory.mktemp("data") / "crossing"
    data_set.write(Asked(kind="trials", what=("speed",), repeats=1, values=FAST), None, out)
    return out


def test_pictures_of_flow_have_the_flow_of_the_arrays(folder):
    """As KITTI's own development kit decodes them."""
    data = np.load(folder / "camera" / "truth.npz")
    flow, known = data["flow"], 0
    assert flow.shape == (*data["depth_m"].shape, 2) and flow.shape[1:3] == (72, 99)
    assert len(list((folder / "camera").glob("*.png"))) == len(flow) == len(data["time_s"])
    for number in range(0, len(flow), 5):
        coded = cv2.imread(str(folder / "camera" / "flow" / f"{number:06d}.png"), cv2.IMREAD_UNCHANGED)
        valid, down, right = np.moveaxis(coded, -1, 0).astype(float)
        assert np.array_equal(valid == 1, np.isfinite(flow[number, ..., 0]))
        there = np.stack([(right - 2**15) / 64, (down - 2**15) / 64], axis=-1)[valid == 1]
        np.testing.assert_allclose(there, flow[number][valid == 1], atol=1 / 128 + 1e-5)
        known += len(there)
    assert known > 10_000


def test_the_lines_of_its_page_read_it(folder, monkeypatch, capsys):
    monkeypatch.chdir(folder)
    exec(re.search(r"```python\n(.*?)```", (folder / "README.md").read_text(), re.S)[1], {})
    read = [line.split() for line in capsys.readouterr().out.splitlines()]
    table = pl.read_csv(folder / "frames.csv", infer_schema_length=None)
    assert [float(hs) for *_, hs in read] == pytest.approx(table["hs"].to_list())
    both = [(float(row[1]), true) for row, true in zip(read, table["true_flow_x"], strict=True) if row[1] != "None"]
    assert len(both) > 10 and all(one == pytest.approx(other, abs=1e-4) for one, other in both)


def test_only_trials_with_the_robot_know_every_pixel(tmp_path):
    with pytest.raises(UsageError, match="trials with the robot, got one of the kind clips"):
        data_set.write(Asked(kind="clips", what=("clean",)), None, tmp_path / "no")
    with pytest.raises(UsageError, match="--trial"):
        data_set.write(Asked(kind="trials", what=("speed",), repeats=1, values=FAST), 7, tmp_path / "no")


def test_clips_know_how_far_their_object_has_moved():
    """The difference of its outline's left edge; nothing in the first frame."""
    trial = ClipTrial("test", 0, 0, 0, Clip("edge", "cluttered"), (choose("emd"),), truth=True)
    frames = play(trial).frames
    assert frames.columns[-len(TRUE) :] == list(TRUE)
    (source,) = (source for _, source, _ in trial.sources())
    left = [np.nan if frame.truth.box is None else frame.truth.box.left for frame in source.stimulus]
    moved, flow = np.diff(left), frames["true_flow_x"].to_numpy()[1:]
    both = np.isfinite(moved) & np.isfinite(flow)
    np.testing.assert_allclose(flow[both], moved[both], atol=1e-9)
    assert both.sum() > 20 and frames["true_flow_x"][0] is None
