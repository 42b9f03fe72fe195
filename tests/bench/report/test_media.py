"""The same figure for a paper, a talk and a page: equal but for its size."""

import re

import pytest
from matplotlib.figure import Figure
from PIL import Image

from experiments.bench.report import style

RENDERED = True


@pytest.mark.parametrize("medium", style.SHEETS)
def test_a_figure_is_as_wide_as_its_medium_in_both_files(tmp_path, medium):
    token = style.medium.set(medium)
    path = style.save(Figure(figsize=(style.WIDTH, 2.0)), tmp_path / "figure")
    style.medium.reset(token)
    inches, dpi = style.SHEETS[medium]
    width, height = (float(side) / 72.0 for side in re.findall(r'(?:width|height)="([\d.]+)pt"',
                     path.with_suffix(".svg").read_text())[:2])  # fmt: skip
    with Image.open(path) as image:
        pixels = image.size
    assert width == pytest.approx(inches, abs=0.01) and pixels[0] == pytest.approx(inches * dpi, abs=1.5)
    assert height / width == pytest.approx(pixels[1] / pixels[0], rel=0.01)
