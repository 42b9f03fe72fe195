"""A third of docs/questions/ runs as it is pasted."""

import pytest

from tests.helpers.chapters import chapter
from tests.helpers.questions import part, skip_without_extras

__all__ = ["chapter"]


@pytest.mark.parametrize("name", part(0))
def test_an_answer_runs_as_pasted(name, chapter):
    skip_without_extras(name)
    chapter(name)
