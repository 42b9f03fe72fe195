"""Everything that docs/your-own-arena.md shows runs as it is pasted; `tests.helpers.chapters` says how."""

from tests.helpers.chapters import chapter

__all__ = ["chapter"]


def test_the_chapter_runs_as_pasted(chapter):
    chapter("your-own-arena.md")
