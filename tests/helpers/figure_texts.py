"""The texts of a figure as they are drawn."""

from __future__ import annotations

import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.text import Text
from matplotlib.transforms import Bbox


def drawn_texts(figure: Figure) -> list[tuple[str, Bbox]]:
    """Draw a figure; return its texts, each with its place. An axis keeps labels that it does not draw."""
    texts: list[Text] = []
    draw = Text.draw
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Text, "draw", lambda self, *args, **more: (texts.append(self), draw(self, *args, **more)))
        canvas = FigureCanvasAgg(figure)
        canvas.draw()
    visible = {id(text): text for text in texts if text.get_text().strip() and text.get_visible()}.values()
    return [(text.get_text(), text.get_window_extent(canvas.get_renderer())) for text in visible]
