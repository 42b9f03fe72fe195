"""The pictures of a recording are those that were seen, as arrays and as files."""

import cv2
import numpy as np

from experiments.cli import main
from experiments.show import record
from experiments.store.recordings import pictures

FRAMES = np.random.default_rng(0).integers(0, 256, (3, 12, 16), np.uint8)


def recorded(path, images):
    count = len(images[""])
    frames = record.Frames(np.arange(count) / 30, np.arange(count), images=images)
    path.write_bytes(record.write(record.Content(eyes=tuple(images)), frames, "x"))
    return path


def test_a_folder_has_the_frames_of_each_eye_exactly(tmp_path):
    recording = recorded(tmp_path / "trial-0000.rrd", {"": FRAMES, "ov7670": FRAMES[::-1]})
    assert main.command(["video", str(recording), "--out", str(tmp_path / "out"), "--quiet"]) == 0
    for camera, images in (("camera", FRAMES), ("camera_ov7670", FRAMES[::-1])):
        paths = [tmp_path / "out" / camera / f"{number:06d}.png" for number in range(3)]
        read = [cv2.imread(str(path), cv2.IMREAD_UNCHANGED) for path in paths]
        np.testing.assert_array_equal(read, images)


def test_frames_that_went_through_jpeg_are_read_too(tmp_path):
    recording = recorded(tmp_path / "clip.rrd", {"": record.jpegs(np.full((3, 12, 16), 90, np.uint8), 95)})
    assert np.abs(pictures(recording)["camera"].astype(int) - 90).max() <= 2
