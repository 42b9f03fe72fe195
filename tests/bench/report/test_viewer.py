"""Recordings looked at in Rerun's viewer itself, without a window: its panels are there, without a warning, and not
blank; the first screen shows the traces in the models' colours. And finding a viewer that listens.
"""

from __future__ import annotations

from pathlib import Path

import cv2
import gymnasium as gym
import numpy as np
import pytest
import rerun as rr

import experiments
from experiments.bench.cli import main
from experiments.bench.report.palette import colours
from experiments.bench.run.models import choose
from experiments.bench.run.record import OFF, ON, rgb
from tests.bench.robot.test_trial import spec
from tests.helpers.played import Played
from tests.helpers.rerun_viewer import needs_vulkan, viewing

HALF_S = 1.0
"""The stimulus of the trial is before the camera."""
NEAR = 40
"""Difference of a pixel's red, green and blue from a colour, their sum, up to which it counts as of that colour."""


def coloured(colour, least: float):
    """Whether more than ``least`` pixels of a picture, or such a share of its width, have about a colour."""

    def has(picture) -> bool:
        pixels = (np.abs(picture.astype(int) - colour).sum(axis=2) <= NEAR).sum()
        return bool(pixels > (least if least > 1 else least * picture.shape[1]))

    return has


def varied(least: float):
    """Whether a picture is not blank: its standard deviation is above the least."""
    return lambda picture: bool(picture.std() > least)


def trial(path: Path, *models: str) -> Path:
    path.write_bytes(Played(spec(models=tuple(map(choose, models))), maps=True).recording)
    return path


def views_in(path: Path) -> set[str]:
    """Origins of the views of a file's layout."""
    reader = rr.chunk.RrdReader(path)
    (layout,) = reader.blueprints()
    batches = [chunk.to_record_batch() for chunk in reader.stream(store=layout).to_chunks()]
    named = [batch for batch in batches if "ViewBlueprint:space_origin" in batch.schema.names]
    return {origin for batch in named for (origin,) in batch["ViewBlueprint:space_origin"].to_pylist()}


CAMERA = "/world/observer/camera"
MAPS = {f"/models/dsnn/maps/{name}" for name in ("p", "la", "f_on", "f_off")}


def wanted(models) -> set[str]:
    """Origins of a trial's views: spikes of the models that have a threshold."""
    spiking = [model for model in models if choose(model).threshold is not None]
    lanes = {*(f"/models/{model}" for model in models), *(f"/models/{model}/spikes" for model in spiking)}
    return {"/world", CAMERA, *MAPS, *lanes}


@pytest.mark.parametrize("models", [("dsnn",), ("dsnn", "emd", "lplc2")])
def test_the_layout_of_a_trial_has_a_lane_for_each_model(models, tmp_path):
    there = views_in(trial(tmp_path / "trial.rrd", *models))
    origins = {origin if origin.startswith("/") else f"/{origin}" for origin in there}
    assert origins == wanted(models)


@needs_vulkan
def test_the_first_screen_of_a_trial(tmp_path):
    models = ("dsnn", "emd")
    with viewing(trial(tmp_path / "trial.rrd", *models)) as screen:
        state = screen.state()
        screen.stop_at(HALF_S)
        views = {view.origin: view for view in state.views}
        assert set(views) == wanted(models)
        for model, colour in colours(models).items():
            trace = coloured(rgb(colour), 0.5)
            assert screen.shows(tmp_path / f"{model}.png", trace, views[f"/models/{model}"]), "it crosses its lane"
            assert screen.shows(tmp_path / "whole.png", trace), "and is on the first screen"
        for origin in ("/world", CAMERA):
            assert screen.shows(tmp_path / "view.png", varied(20), views[origin]), origin
        for colour in (ON, OFF):
            assert screen.shows(tmp_path / "map.png", coloured(colour, 20), views["/models/dsnn/maps/p"])
        assert not [view.reports for view in screen.state().views if view.reports], "the viewer warns of nothing"


@needs_vulkan
def test_what_was_watched_in_the_viewer(tmp_path):
    run = experiments.watch("plain", out=tmp_path / "run", quiet=True)
    with viewing(run.recordings[0]) as screen:
        views = {view.origin: view for view in screen.state().views}
        assert set(views) == {CAMERA, "/models/dsnn", "/models/dsnn/spikes"}
        blue = rgb(colours(["dsnn"])["dsnn"])
        assert screen.shows(tmp_path / "lane.png", coloured(blue, 20), views["/models/dsnn"])
        assert screen.shows(tmp_path / "seen.png", varied(20), views[CAMERA])


@needs_vulkan
def test_an_episode_in_the_viewer(tmp_path):
    pursuit = gym.make("colias_sim/Pursuit-v0", observation="neural", model="hybrid", max_episode_steps=20)
    env = experiments.RecordRerun(pursuit, tmp_path / "episode.rrd")
    env.reset(seed=0)
    for step in range(20):
        env.step(np.array([0.4, 0.3 + 0.02 * step], np.float32))
    env.close()
    plots = {"/world/observer/wheels", "/reward", *(f"/models/hybrid{part}" for part in ("", "/spikes", "/azimuth"))}
    with viewing(tmp_path / "episode.rrd") as screen:
        state = screen.state()
        assert {f"/{view.origin.lstrip('/')}" for view in state.views} == {"/world", CAMERA, *plots}
        assert screen.shows(tmp_path / "whole.png", varied(10)), "the window is not blank"


@needs_vulkan
def test_a_screenshot_has_the_traces_and_what_is_seen(tmp_path, monkeypatch):
    """It waits for the images: the camera's, half of them dark, and the layer maps."""
    monkeypatch.delenv("DISPLAY", raising=False)
    path, place = trial(tmp_path / "trial.rrd", "dsnn"), tmp_path / "trial.png"
    assert main.command(["view", str(path), "--screenshot", str(place)]) == 0
    picture = cv2.cvtColor(cv2.imread(str(place)), cv2.COLOR_BGR2RGB)
    for colour in (rgb(colours(["dsnn"])["dsnn"]), ON, OFF):
        assert coloured(colour, 200)(picture), colour
    with pytest.raises(experiments.UsageError):
        main.command(["view", str(path), "--screenshot", str(tmp_path / "trial.jpg")])
