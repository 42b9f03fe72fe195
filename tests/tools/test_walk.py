"""The walk that docs/architecture.md prints is the one that a run takes."""

from __future__ import annotations

import re

import pytest

from tools.walk import ROOT, VALUES, table, walked


@pytest.fixture(scope="module")
def ways():
    return walked()


def test_the_walk_in_the_documentation_is_the_one_that_is_run(ways):
    assert list(ways) == list(VALUES), "every value is made, in this order"
    page = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    printed = re.search(r"<!-- walk -->\n(.*?)\n<!-- end of walk -->", page, re.DOTALL)
    assert printed is not None and printed[1] == table(ways), "python -m tools.walk prints it anew"


def test_no_value_is_made_where_an_earlier_one_was_made_and_left(ways):
    """Data flow one way: once another file has made a value, the earlier one makes no more."""
    makers = [way[0].file for way in ways.values()]
    assert all(makers.index(file) == place or makers[place - 1] == file for place, file in enumerate(makers))


def test_no_file_is_entered_again_once_a_row_has_left_it(ways):
    """The rows of the walk in which a file stands follow each other."""
    rows = [{place.file for place in way} for way in ways.values()]
    for file in set().union(*rows):
        places = [row for row, files in enumerate(rows) if file in files]
        assert places == list(range(places[0], places[-1] + 1)), file
