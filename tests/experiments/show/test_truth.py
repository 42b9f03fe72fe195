"""What truly moved, in recordings and films of trials."""

import dataclasses

import numpy as np
import pytest

from experiments.draw.video import FLOW, Canvas, Reel
from experiments.show.record import ARROWS, DEPTH_UNITS
from tests.experiments.show.test_trial import spec
from tests.helpers.played import Played
from tests.helpers.recordings import columns

CAMERA = "world/observer/camera"


@pytest.fixture(scope="module")
def told(tmp_path_factory):
    played = Played(dataclasses.replace(spec(speed=20.0), truth=True))
    path = tmp_path_factory.mktemp("truth") / "trial.rrd"
    path.write_bytes(played.recording)
    return played, path


def test_a_recording_has_flow_depth_and_surfaces_below_the_camera(told):
    played, path = told
    truths = [sample.pixels for sample in played.showings[0].samples]
    entities = columns(path)
    depth = np.array(entities[f"/{CAMERA}/truth/depth"]["buffer"], np.uint8).reshape(len(truths), -1).view("<u2")
    surface = np.array(entities[f"/{CAMERA}/truth/surface"]["buffer"], np.uint8).reshape(len(truths), -1).view("<u2")
    assert entities[f"/{CAMERA}/truth/depth"]["meter"][0] == [DEPTH_UNITS]
    ((names,),) = entities[f"/{CAMERA}/truth/surface"]["context"]
    called = {one["class_id"]: one["class_description"]["info"]["label"] for one in names}
    arrows = entities[f"/{CAMERA}/truth/flow"]
    heads = 0
    for truth, far, geoms, tails, ways in zip(
        truths, depth, surface, arrows["origins"], arrows["vectors"], strict=True
    ):
        met = truth.geom.ravel() >= 0
        np.testing.assert_allclose(far[met] / DEPTH_UNITS, truth.depth_m.ravel()[met], atol=1e-4)
        assert [called[number] for number in geoms[met][::97]] == [
            truth.geoms[g] for g in truth.geom.ravel()[met][::97]
        ]
        for tail, way in zip(tails or [], ways or [], strict=True):
            column, row = np.floor(np.add(tail, way)).astype(int)
            assert truth.flow[row, column] == pytest.approx(way, abs=1e-5)
            heads += 1
    assert heads > 5 * ARROWS


def test_a_film_has_a_panel_of_the_flow_and_one_without_truth_has_none(told, tmp_path):
    played, path = told
    reel = Reel(path)
    assert len(reel.flow) == played.frames and FLOW in Canvas(reel, (640, 360)).panels[0]
    moved = np.concatenate([ends[:, 1] - ends[:, 0] for ends in list(reel.flow.values())[8:-8]])
    assert (moved[:, 0] > 2).all() and np.abs(moved[:, 1]).max() < 2, "a crossing to the right"
    plain = tmp_path / "plain.rrd"
    plain.write_bytes(Played(spec(speed=20.0)).recording)
    assert not Reel(plain).flow and FLOW not in Canvas(Reel(plain), (640, 360)).panels[0]
