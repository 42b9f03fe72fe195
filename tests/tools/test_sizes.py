"""`tools.sizes`: what counts as a line of code."""

from __future__ import annotations

import pytest

from tools.sizes import code_lines, names

SOURCE = '''"""A module
of two lines."""

import math  # why


X = (
    1,
)
"""What X is."""


def root(value):
    """Take it."""
    text = """two
    lines"""
    return math.sqrt(value), text
'''


def test_docstrings_comments_and_blank_lines_are_no_code():
    assert code_lines(SOURCE) == 1 + 3 + 4  # the import, the constant, the function with a text of two lines


@pytest.mark.parametrize("more", ["\n\n", "# a comment\n", '"""A text that stands alone."""\n'])
def test_what_computes_nothing_adds_nothing(more):
    assert code_lines(SOURCE + more) == code_lines(SOURCE)


def test_records_public_names_and_options_are_counted():
    source = """
@dataclasses.dataclass(frozen=True)
class Point:
    x: int

class Row(TypedDict):
    x: int

_HIDDEN = typer.Option(0)
SHOWN = 1

def draw(): ...
"""
    assert names(source) == {"record types": 2, "public names": 4, "options": 1}
