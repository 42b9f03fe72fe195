"""`tools.sizes`: what counts as a line of code."""

from __future__ import annotations

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
    assert code_lines(SOURCE + '# a comment\n\n"""A text that stands alone."""\n') == code_lines(SOURCE)


def test_records_public_names_and_options_are_counted():
    source = "@dataclass\nclass Point: ...\nclass Row(TypedDict): ...\n_HIDDEN = typer.Option(0)\n"
    source += "SHOWN = 1\ndef draw(): ..."
    assert names(source) == {"record types": 2, "public names": 4, "options": 1}
