"""Every figure of the bench, from fixed rows, with a model of a user's own beside one of the bench's."""

from __future__ import annotations

import matplotlib as mpl
import pytest

from experiments.bench.report.style import PAGE, WIDTH
from tests.helpers.figure_list import FIGURES, OF_ONE_MODEL, shown
from tests.helpers.figure_rows import MODELS_SHOWN as MODELS
from tests.helpers.figure_texts import drawn_texts

RENDERED = True

mpl.use("agg")
FRAMES_OF_FILMS = ("video",)
"""Not figures of a page: `colias video` says how many pixels they have."""


@pytest.mark.parametrize("name", FIGURES)
def test_a_figure_fits_a_page_and_shows_every_model(name):
    figure = FIGURES[name](MODELS)
    if name not in FRAMES_OF_FILMS:
        width, height = figure.get_size_inches()
        assert width <= WIDTH and height <= PAGE + 1e-9
    if name in OF_ONE_MODEL:
        return
    titles = {part.get_suptitle() for part in (figure, *figure.subfigs)}
    texts = [text for text, _ in drawn_texts(figure) if text not in titles]
    words = "\n".join(form for text in texts for form in (text, text.replace("\n", " "), text.replace("\n", "")))
    assert not [model for model in shown(name, MODELS) if model not in words]
