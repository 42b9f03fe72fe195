"""A third of docs/questions/ runs as it is pasted; `tests.chapters` says how, `tests.questions` which."""

import pytest

from tests.chapters import chapter
from tests.questions import part, skip_without_extras

__all__ = ["chapter"]


@pytest.mark.parametrize("name", part(0))
def test_an_answer_runs_as_pasted(name, chapter):
    skip_without_extras(name)
    chapter(name)
