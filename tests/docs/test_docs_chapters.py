"""Everything that long chapters show runs as it is pasted; `tests.helpers.chapters` says how."""

import pytest

from tests.helpers.chapters import chapter

__all__ = ["chapter"]
RUN_HERE = (
    "back-from-the-robot.md", "behaviours-and-training.md", "robot-trials.md", "your-own-arena.md",
    "your-own-experiment.md", "your-own-model.md",
)  # fmt: skip


@pytest.mark.parametrize("name", RUN_HERE)
def test_a_chapter_runs_as_pasted(name, chapter):
    chapter(name)
