"""Recordings as Rerun's viewer opens them, without a window: every view is there and painted, without a warning."""

from pathlib import Path
from urllib.request import urlopen

import cv2
import gymnasium as gym
import numpy as np
import pytest

import experiments
from experiments.base.palette import BRIGHTER, CHANNELS, DARKER, rgb
from experiments.cli import main
from experiments.draw import viewer
from experiments.settings.models import choose
from tests.experiments.show.test_trial import spec
from tests.helpers.played import Played
from tests.helpers.processes import CLI, members, start, wait_until

DRIVERS = [*Path("/usr/share/vulkan/icd.d").glob("*lvp*"), *Path("/usr/local/share/vulkan/icd.d").glob("*lvp*")]
CAMERA = "/world/observer/camera"
ROOT = Path(__file__).parents[3]
NEAR = 40
"""Difference of a pixel's red, green and blue from a colour, their sum, up to which it counts as of that colour."""


Recorded = tuple[Path, dict[str, set[str]], set[str]]
"""A recording, the parts of each model that have a view, and the other views."""


def trial(folder: Path) -> Recorded:
    models = {"dsnn": {"", *(f"/maps/{name}" for name in ("p", "la", "f_on", "f_off"))}, "emd": {""},
              "lplc2": {""}}  # fmt: skip
    path = folder / "trial.rrd"
    path.write_bytes(Played(spec(models=tuple(map(choose, models))), maps=True).recording)
    return path, models, {"/world", "/about", CAMERA}


def watched(folder: Path) -> Recorded:
    run = experiments.watch("plain", out=folder / "run", quiet=True)
    return run.recordings[0], {"dsnn": {""}}, {CAMERA}


def episode(folder: Path) -> Recorded:
    pursuit = gym.make("colias_sim/Pursuit-v0", observation="neural", model="hybrid", max_episode_steps=20)
    env = experiments.RecordRerun(pursuit, folder / "episode.rrd")
    env.reset(seed=0)
    for step in range(20):
        env.step(np.array([0.4, 0.3 + 0.02 * step], np.float32))
    env.close()
    others = {"/world", "/about", CAMERA, "/world/observer/wheels", "/reward"}
    return folder / "episode.rrd", {"hybrid": {"/hs", "/vs", "/looming", "/azimuth"}}, others


def decoded(content: bytes) -> np.ndarray:
    return cv2.imdecode(np.frombuffer(content, np.uint8), cv2.IMREAD_COLOR_RGB).astype(int)


@pytest.mark.skipif(not DRIVERS, reason="no Vulkan: on Debian run 'apt-get install mesa-vulkan-drivers'")
@pytest.mark.parametrize("kind", [trial, watched, episode])
def test_the_first_screen_has_every_view_and_traces_in_their_hues(kind, tmp_path, monkeypatch):
    monkeypatch.delenv("DISPLAY", raising=False)
    shown, paint = set(), viewer._painted

    def painted(client, deadline):
        picture = paint(client, deadline)
        views = {f"/{view.origin.lstrip('/')}": view for view in client.get_state().views}
        assert not [view.reports for view in views.values() if view.reports], "the viewer warns of nothing"
        shown.update(views)
        for origin in {"/world", CAMERA} & views.keys():
            assert decoded(client.take_screenshot(views[origin].view_id)).std() > 10, f"{origin} is blank"
        return picture

    monkeypatch.setattr(viewer, "_painted", painted)
    path, models, others = kind(tmp_path)
    assert main.command(["view", str(path), "--screenshot", str(tmp_path / "screen.png")]) == 0
    assert shown == others | {f"/models/{model}{part}" for model, parts in models.items() for part in parts}
    screen = decoded((tmp_path / "screen.png").read_bytes())
    least = {rgb(CHANNELS["hs"]): screen.shape[1] / 3}  # a trace crosses its lane
    changed = dict.fromkeys(map(rgb, (BRIGHTER, DARKER)), 20) if kind is trial else {}
    for colour, count in {**least, **changed}.items():
        assert (np.abs(screen - colour).sum(axis=2) <= NEAR).sum() > count, colour


def test_a_page_of_the_viewer_ends_with_the_command(tmp_path):
    run = experiments.watch("plain", out=tmp_path / "run", quiet=True)
    with start(tmp_path, *CLI, "view", str(run.recordings[0]), "--web", PYTHONPATH=str(ROOT)) as viewing:
        try:
            address = viewing.stdout.readline().split()[0]
            assert b"<canvas" in urlopen(address, timeout=60).read()
        finally:
            viewing.terminate()
        assert (viewing.communicate(), viewing.returncode) == (("", ""), 143)
        assert wait_until(lambda: not members(viewing.pid), 20), "Rerun runs on"


def test_a_scene_is_drawn_into_a_file_without_a_screen(tmp_path, monkeypatch):
    monkeypatch.delenv("DISPLAY", raising=False)
    assert main.command(["view", "bright", "--screenshot", str(tmp_path / "scene.png")]) == 0
    scene = decoded((tmp_path / "scene.png").read_bytes())
    assert (scene.max(axis=2) < 40).sum() > 300, "the stimulus is black"
