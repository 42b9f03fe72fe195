"""Everything that docs/footage.md shows runs as it is pasted; `tests.helpers.chapters` says how."""

from pathlib import Path

from tests.helpers.chapters import chapter
from tests.helpers.footage import film, street

__all__ = ["chapter"]


def test_the_chapter_runs_as_pasted(chapter):
    film(Path("street.mp4"), street(150.0), codec="mp4v")
    chapter("footage.md")
