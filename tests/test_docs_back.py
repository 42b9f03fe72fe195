"""Everything that docs/back-from-the-robot.md shows runs as it is pasted; `tests.chapters` says how."""

from tests.chapters import chapter

__all__ = ["chapter"]


def test_the_chapter_runs_as_pasted(chapter):
    chapter("back-from-the-robot.md")
