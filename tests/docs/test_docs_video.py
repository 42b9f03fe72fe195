"""Everything that docs/video.md shows runs as it is pasted; `tests.helpers.chapters` says how."""

import pytest

from tests.helpers.chapters import chapter

__all__ = ["chapter"]


def test_the_chapter_runs_as_pasted(chapter):
    pytest.importorskip("imageio_ffmpeg")
    chapter("video.md")
