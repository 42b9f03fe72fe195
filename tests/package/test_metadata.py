"""What the project says of itself, in several files, is the same in each."""

import re
import tomllib
from pathlib import Path

from packaging.version import Version

ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]


def test_the_latest_release_and_its_day_are_one():
    citation = (ROOT / "CITATION.cff").read_text()
    cited = re.search(r"^version: (\S+)$", citation, re.MULTILINE)
    day = re.search(r"^date-released: (\S+)$", citation, re.MULTILINE)
    latest = re.search(r"^## \[(\d\S*)\] - (\S+)$", (ROOT / "CHANGELOG.md").read_text(), re.MULTILINE)
    assert cited and day and latest
    assert (cited[1], day[1]) == (latest[1], latest[2])
    assert Version(PROJECT["version"]) >= Version(latest[1])
