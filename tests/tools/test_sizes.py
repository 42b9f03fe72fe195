"""`tools.sizes`: what counts as a line of code."""

import contextlib
import sys
from pathlib import PurePosixPath

import pytest

from tools import sizes
from tools.sizes import code_lines

SOURCE = (
    '"""A module\nof two lines."""\n\nimport math  # why\n\n\nX = (\n    1,\n)\n"""What X is."""\n\n\n'
    'def root(value):\n    """Take it."""\n    text = """two\n    lines"""\n    return math.sqrt(value), text\n'
)


def test_docstrings_comments_and_blank_lines_are_no_code():
    assert code_lines(SOURCE) == 1 + 3 + 4  # the import, the constant, the function with a text of two lines
    assert code_lines(SOURCE + '# a comment\n\n"""A text that stands alone."""\n') == code_lines(SOURCE)


def test_the_product_is_all_but_tests_and_data_and_above_a_ceiling_the_check_fails(monkeypatch):
    files = {"dsnn/a.py": "A = 1\n", "tools/b.py": "B = 1\nC = 2\n", "tests/c.py": "D = 1\n", "scenes/d.xml": "<a/>\n"}
    monkeypatch.setattr(sizes, "sources", lambda: ((PurePosixPath(path), text) for path, text in files.items()))
    monkeypatch.setattr(sys, "argv", ["sizes", "--check"])
    lines = {name: counts["lines"] for name, counts in sizes.sizes().items() if counts}
    assert lines == {"dsnn": 1, "tools, benchmarks": 2, "tests": 1, "data": 1, "product": 3}
    for ceiling, expected in (
        (3, contextlib.nullcontext()),
        (2, pytest.raises(SystemExit, match="product must have at")),
    ):
        monkeypatch.setitem(sizes.BUDGET, "product", {**sizes.BUDGET["product"], "ceiling": ceiling})
        with expected:
            sizes.main()
