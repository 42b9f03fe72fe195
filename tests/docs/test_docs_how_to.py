"""Everything that docs/how-to/ shows runs as it is pasted; `tests.helpers.chapters` says how."""

from pathlib import Path

import pytest

from tests.helpers.chapters import DOCS, called, chapter
from tests.helpers.firmware import needs_tools
from tests.helpers.footage import film, street

__all__ = ["chapter"]
FIRMWARE = "how-to/real-robot.md"
NAMES = [called(page) for page in sorted((DOCS / "how-to").glob("*.md")) if page.stem != "reinforcement-learning"]


@pytest.mark.parametrize("name", [pytest.param(n, marks=needs_tools) if n == FIRMWARE else n for n in NAMES])
def test_a_page_runs_as_pasted(name, chapter):
    if name == "how-to/view-and-video.md":
        pytest.importorskip("imageio_ffmpeg")
    if name == "how-to/many-robots.md":
        pytest.importorskip("pettingzoo")
    film(Path("street.mp4"), street(150.0), codec="mp4v")  # stands for the reader's film
    chapter(name)
