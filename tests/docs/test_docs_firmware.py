"""Everything that docs/from-bench-to-robot.md shows runs as it is pasted; `tests.helpers.chapters` says how."""

from tests.bench.firmware.test_firmware import needs_tools
from tests.helpers.chapters import chapter

__all__ = ["chapter"]


@needs_tools
def test_the_chapter_runs_as_pasted(chapter):
    chapter("from-bench-to-robot.md")
