"""What a recording has, read back from disk; and the functions that Rerun keeps to itself, which this sees move."""

import math
import re
import subprocess
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from colias_sim import CameraConfig, SceneConfig
from colias_sim.obstacles import Obstacle
from dsnn import MODELS, Response, ResponseSeries
from experiments.base.palette import BRIGHTER, CHANNELS, DARKER, STILL, rgb
from experiments.declare.conditions import Condition
from experiments.declare.experiment import Angular
from experiments.draw.video import model_part
from experiments.draw.viewer import program
from experiments.show import record
from experiments.show.recording import map_colours
from scenes import WALL_HEIGHT_CM
from tests.experiments.show.test_trial import trial_of
from tests.helpers.played import Played
from tests.helpers.recordings import columns

COUNT = 5
COUNTS = np.array([0, 2, 0, -1, 0])
BOTH = (("hs", 0.16), ("vs", 0.16))
SERIES = ResponseSeries.from_responses([Response(0.1, -0.2, int(n), int(-n), None, 0.6, 1, 0.5) for n in COUNTS])
CONTENT = record.Content(
    tuple(
        record.RecordedModel(label, ("hs", "vs", "looming", "azimuth"), (*BOTH, ("looming", 0.7)))
        for label in (*MODELS, "a/b@c")
    ),
    eyes=("",),
)


def written(path: Path, content: record.Content = CONTENT) -> Path:
    images = np.arange(COUNT * 12, dtype=np.uint8).reshape(COUNT, 3, 4)
    frames = record.Frames(
        np.arange(COUNT) / 30, np.arange(COUNT), {model.label: SERIES for model in content.models}, {"": images}
    )
    path.write_bytes(record.write(content, frames, "looks"))
    return path


def colour(looks: dict[str, list[Any]]) -> tuple[int, ...]:
    """Rerun has colours as one number, the red first."""
    packed = looks["colors"][0][0]
    return tuple(packed >> shift & 255 for shift in (24, 16, 8))


def test_what_is_written_is_read_back(tmp_path):
    held = columns(written(tmp_path / "a.rrd"), static=False)
    for model in CONTENT.models:
        root = f"/{record.model_entity(model.label)}"
        for channel, value in (("hs", 0.1), ("vs", -0.2), ("looming", 0.6), ("azimuth", 0.5)):
            np.testing.assert_array_equal(np.ravel(held[f"{root}/{channel}"]["scalars"]), [value] * COUNT)
        for channel, counts in (("hs", COUNTS), ("vs", -COUNTS), ("looming", [1] * COUNT)):
            np.testing.assert_array_equal(np.ravel(held[f"{root}/spikes/{channel}"]["scalars"]), counts)
        assert held[f"{root}/threshold"]["scalars"] == [[-0.16, 0.16, 0.7]] * 2
        assert model_part(f"{root}/spikes/hs".strip("/")) == (model.label, "spikes/hs")
    assert all({"time", "frame"} <= set(entity) for entity in held.values())
    assert not [entity for entity in held if any(part.isdigit() for part in re.split("[/_]", entity))], "no value"


def test_strokes_stand_beyond_the_potentials_at_the_frames_that_spike_on_the_side_of_their_sign(tmp_path):
    held = columns(written(tmp_path / "a.rrd"), static=False)
    for channel, counts in (("hs", COUNTS), ("vs", -COUNTS), ("looming", np.ones(COUNT))):
        entity = held[f"/{record.model_entity('dsnn')}/strokes/{channel}"]
        ends, spiking = np.reshape(entity["scalars"], (-1, 3)), np.flatnonzero(counts)
        assert entity["frame"] == np.repeat(spiking, 3).tolist()
        assert (np.sign(ends[:, :2]) == np.sign(counts[spiking])[:, None]).all() and np.isnan(ends[:, 2]).all()
        assert (np.abs(ends[:, 0]) > 1.0).all() and (np.abs(ends[:, 0]) < np.abs(ends[:, 1])).all()
        assert (np.argsort(np.abs(ends[:, 1] - ends[:, 0]), kind="stable") ==
                np.argsort(np.abs(counts[spiking]), kind="stable")).all(), "more spikes, a longer stroke"  # fmt: skip


def test_a_channel_has_its_hue_in_every_model(tmp_path):
    held = columns(written(tmp_path / "a.rrd"), static=True)
    for model in CONTENT.models:
        root = f"/{record.model_entity(model.label)}"
        for channel, hue in CHANNELS.items():
            assert colour(held[f"{root}/{channel}"]) == colour(held[f"{root}/spikes/{channel}"]) == rgb(hue)


def test_a_robot_and_an_obstacle_have_their_sizes_in_cm(tmp_path):
    shell = SceneConfig(shell_width_cm=6.0, shell_height_cm=4.5)
    block = record.outlines([Obstacle("block", np.array([[0.1, 0.0], [0.2, 0.0], [0.2, 0.1]]), 0.04)])
    content = record.Content(CONTENT.models[:1], scene=shell, robots=(("stimulus", "colias_black"),), obstacles=block)
    held = columns(written(tmp_path / "a.rrd", content), static=True)
    robot, edges = held["/world/stimulus"], np.array(held["/world/arena/obstacles"]["strips"][0])
    np.testing.assert_allclose([robot["radii"], robot["lengths"]], [[[3.0]], [[4.5]]], rtol=1e-6)
    x, y, z = np.transpose(held["/world/arena/wall"]["vertex_positions"][0])
    np.testing.assert_allclose(np.hypot(x, y), 45.0, rtol=1e-6)
    assert {*z} == {0.0, WALL_HEIGHT_CM}
    np.testing.assert_allclose(edges.max(axis=(0, 1)), [20.0, 10.0, 4.0], rtol=1e-6)


@pytest.mark.parametrize(
    "condition",
    [Angular("approach").at("approach", 0.0), Condition("translation", "rightward", 10.0, 8.0)],
    ids=["approach", "crossing"],
)
def test_poses_and_pinhole_put_the_hull_where_the_image_is_dark(condition, tmp_path):
    """On the horizon, in every frame in which all of it is in view; its rims have 2 cm, and are 3 cm high."""
    result = Played(trial_of(condition, camera=CameraConfig.ideal()))
    (tmp_path / "trial.rrd").write_bytes(result.recording)
    held, around, shown = columns(tmp_path / "trial.rrd"), np.linspace(0.0, 2.0 * math.pi, 181), 0
    lens, turn, place = (np.array(held["/world/observer/camera"][name][0][0])
                         for name in ("image_from_camera", "mat3x3", "translation"))  # fmt: skip
    lens, turn = lens.reshape(3, 3).T, turn.reshape(3, 3).T  # Rerun has matrices by their columns
    assert lens[[0, 1], [0, 1]] == pytest.approx([49.5 / math.tan(math.radians(35.0))] * 2, abs=0.01)
    rims = [(2.0 * math.cos(angle), 2.0 * math.sin(angle), z) for angle in around for z in (0.0, 3.0)]
    observer, hull = held["/world/observer"], held["/world/stimulus"]["translation"]
    poses = zip(observer["translation"], observer["quaternion"], hull, result.media.images[""], strict=True)
    for (eye,), ((*_, z, w),), (middle,), image in poses:
        c, s = math.cos(2.0 * math.atan2(z, w)), math.sin(2.0 * math.atan2(z, w))
        ahead = (np.array(rims) + middle - eye) @ np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
        x, _, depth = ((ahead - place) @ turn @ lens.T).T
        left, right = (x / depth).min(), (x / depth).max()
        if 1.0 < left < right < 98.0:
            dark = np.flatnonzero((image[34:39] < 125).all(axis=0))
            assert (dark[0], dark[-1] + 1) == pytest.approx((left, right), abs=1.5)
            assert np.median(image[34:39, dark[1:-1]]) == pytest.approx(255 * 0.02, abs=1.5)
            shown += 1
    assert shown >= 15


@pytest.mark.parametrize(("layer", "grey", "tint"), [
    ("p", 138, BRIGHTER), ("p", 118, DARKER), ("la", 168, BRIGHTER), ("la", 88, DARKER), ("f_on", 128, BRIGHTER),
    ("f_off", 128, DARKER),
])  # fmt: skip
def test_a_layer_has_the_colours_of_brighter_and_darker_pixels(layer, grey, tint):
    """The full colour is that of 40 grey levels, or of an F of 1."""
    still = 0 if layer.startswith("f") else 128
    assert [map_colours(layer)[value] for value in (still, grey)] == [rgb(STILL), rgb(tint)]


def test_a_recording_is_made_without_room_for_temporary_files(monkeypatch):
    monkeypatch.setattr(tempfile, "tempdir", "/dev/full")
    record.layout_chunks.cache_clear()
    assert record.write(CONTENT, record.Frames(np.zeros(0), np.zeros(0, np.int64)), "looks")


def test_a_recording_that_was_cut_is_not_whole(tmp_path):
    path = written(tmp_path / "a.rrd")
    assert record.is_whole(path)
    for size in (path.stat().st_size - 1, 1000, 5, 0):
        path.write_bytes(path.read_bytes()[:size])
        assert not record.is_whole(path)


def test_a_saved_layout_is_opened_with(tmp_path):
    command = [*program(), "rrd", "print", str(written(tmp_path / "a.rrd"))]
    printed = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    orders = re.findall(r"BlueprintActivationCommand.*(make_active.*)", printed)
    assert orders == ["make_active: true, make_default: true)"]
