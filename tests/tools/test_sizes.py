"""`tools.sizes`: what counts as a line of code."""

from __future__ import annotations

import sys

import pytest

from tools import sizes
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


def test_the_project_is_below_its_ceilings_and_above_one_the_check_fails(monkeypatch, capsys):
    monkeypatch.setattr(sys, "argv", ["sizes", "--check"])
    sizes.main()
    product = next(line.split() for line in capsys.readouterr().out.splitlines() if line.startswith("product"))
    monkeypatch.setitem(sizes.BUDGET, "product", {**sizes.BUDGET["product"], "ceiling": 1})
    with pytest.raises(SystemExit, match="product must have at most 1 line"):
        sizes.main()
    parts = [name for name, budget in sizes.BUDGET.items() if budget["folders"] and name not in ("tests", "product")]
    counted = sizes.sizes()
    assert sum(counted[name]["lines"] for name in parts) == int(product[1].replace(",", ""))
