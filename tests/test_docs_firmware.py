"""Everything that docs/from-bench-to-robot.md shows runs as it is pasted; `tests.chapters` says how."""

from tests.chapters import chapter
from tests.test_firmware import needs_tools

__all__ = ["chapter"]


@needs_tools
def test_the_chapter_runs_as_pasted(chapter):
    chapter("from-bench-to-robot.md")
