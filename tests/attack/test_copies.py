"""Copies and pickles of everything public, in threads and processes: equal, or refused in one line, and harmless."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from tests.attack.judging import expect_none
from tests.attack.processes import python

pytestmark = pytest.mark.attack

COPIES = Path(__file__).with_name("through_copies.py")


@pytest.mark.parametrize("group", ["models", "worlds", "values"])
def test_copies_are_equal_or_refused_and_the_original_stays_as_it_was(group, folder):
    ended = python(folder, [str(COPIES), group], timeout_s=300)
    assert ended.status == 0 and ended.left == () and ended.crashes() == [], (ended.status, ended.err[-2000:])
    expect_none(json.loads((folder / "troubles.json").read_text()))
