"""The same figure for a paper, a talk and a page: equal but for its size."""

import re

import pytest
from matplotlib.figure import Figure
from PIL import Image

from experiments.bench.figures.media import SHEETS, Medium, choose
from experiments.bench.figures.plotting import TYPE, WIDTH, save

RENDERED = True


@pytest.fixture(autouse=True)
def web_again():
    yield
    choose(Medium.WEB)


def size_of(path):
    with Image.open(path) as image:
        return image.size


def written(folder, medium, inches=WIDTH):
    choose(medium)
    figure = Figure(figsize=(inches, 2.0))
    figure.subplots().set_xlabel("speed (cm/s)", fontsize=TYPE)
    save(figure, folder, medium.value)
    text = (folder / f"{medium.value}.svg").read_text(encoding="utf-8")
    sides = re.search(r'width="([\d.]+)pt" height="([\d.]+)pt" viewBox="0 0 ([\d.]+) ([\d.]+)"', text)
    return [float(side) / 72.0 for side in sides.groups()], size_of(folder / f"{medium.value}.png")


@pytest.mark.parametrize("medium", Medium)
def test_a_figure_is_as_wide_as_its_medium_in_both_files(tmp_path, medium):
    (width, height, drawn_width, _), pixels = written(tmp_path, medium)
    sheet = SHEETS[medium]
    assert width == pytest.approx(sheet.inches, abs=0.01)
    assert pixels[0] == pytest.approx(sheet.inches * sheet.dpi, abs=1.5)
    assert height / width == pytest.approx(pixels[1] / pixels[0], rel=0.01)
    assert TYPE * width / drawn_width >= 8.0 - 1e-6, "no type is smaller than 8 points"
