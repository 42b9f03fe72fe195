"""``make bench`` and the tools' pictures to their ends, at their smallest: what they print is numbers."""

import math
import runpy

import pytest
from PIL import Image
from rich.console import Console

from benchmarks import envs, eye, loop, network, swarm
from colias_sim import CameraConfig
from tools import eye as pictures

RENDERED = True


@pytest.fixture
def smallest(monkeypatch):
    """A round, and as few frames as the network's answers need."""
    for module in (eye, loop, network, swarm):
        monkeypatch.setattr(module, "FRAMES", 3)
    for module in (envs, eye, loop, network, swarm):
        monkeypatch.setattr(module, "interleaved", lambda work, rounds=1, once=module.interleaved: once(work, 1))
    monkeypatch.setattr(swarm, "COUNTS", (1,))
    monkeypatch.setattr(eye, "SPEEDS", (1.0,))
    monkeypatch.setattr(eye, "variants", lambda: {"default": CameraConfig(), "* ov7670": eye.EYE})
    for name, least in {"COUNT": 1, "STEPS": 1, "OBSERVED": ("pixels",)}.items():
        monkeypatch.setattr(envs, name, least)


def test_every_ratio_is_measured(smallest, monkeypatch):
    printed = []
    monkeypatch.setattr(Console, "print", lambda self, table: printed.append(table))
    runpy.run_module("benchmarks", run_name="__main__")
    assert len(printed) == 7 and all(table.row_count for table in printed)
    for table in printed:
        for column in table.columns[1:]:
            for cell in column.cells:
                assert not cell or all(math.isfinite(float(word.strip("(%),"))) for word in cell.split()), cell


def test_the_pictures_of_eye_and_layers_are_drawn(tmp_path, monkeypatch):
    monkeypatch.setattr(pictures, "PICTURES", {"default": CameraConfig(), pictures.FIFTH: CameraConfig()})
    pictures.main(tmp_path)
    with Image.open(tmp_path / "eye.png") as picture:
        assert picture.size[0] == pytest.approx(160 * pictures.WIDTH, abs=2)
    assert (tmp_path / "layers.png").stat().st_size > 10_000
