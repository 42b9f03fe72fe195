"""Everything that docs/how-to/real-robot.md shows runs as it is pasted; `tests.helpers.chapters` says how."""

from tests.helpers.chapters import chapter
from tests.helpers.firmware import needs_tools

__all__ = ["chapter"]


@needs_tools
def test_the_chapter_runs_as_pasted(chapter):
    chapter("how-to/real-robot.md")
