"""A stimulus as pictures and a table: what is written is what was painted, and what is true of it."""

import cv2
import numpy as np
import polars as pl
import pytest

from dsnn.stimuli import Jitter, stimulus
from experiments.cli.main import command


def test_a_stimulus_is_written_as_it_is_painted_with_its_truth(tmp_path):
    options = {"speed": 240, "columns": 120, "rows": 46, "background_speed": 3.5}
    settings = [part for name, value in options.items() for part in ("--set", f"cluttered.{name}={value}")]
    out = tmp_path / "clip"
    assert command(["video", "cluttered", "--out", str(out), "--seed", "4", "--jitter", "0.25", *settings]) == 0
    clip = list(Jitter(stimulus("cluttered", seed=4, **options), 0.25, seed=4))
    table = pl.read_csv(out / "truth.csv")
    assert table.height == len(clip) == len(list(out.glob("*.png")))
    for row, frame in zip(table.iter_rows(named=True), clip, strict=True):
        picture = cv2.imread(str(out / f"{row['frame']:06d}.png"), cv2.IMREAD_UNCHANGED)
        np.testing.assert_array_equal(picture, frame.luma)
        assert row["motion"] == frame.truth.motion and row["time_s"] == pytest.approx(row["frame"] / 30)
        assert row["background_x_px_s"] == pytest.approx(frame.truth.background_velocity[0])
        if frame.truth.box is None:
            assert row["left_px"] is row["velocity_x_px_s"] is None
        else:
            assert row["left_px"] == pytest.approx(frame.truth.box.left)
            assert row["velocity_x_px_s"] == pytest.approx(frame.truth.velocity[0])
