"""The API pages as built: every public name has its anchor, with what it takes, gives and raises, and with links."""

from __future__ import annotations

from html.parser import HTMLParser
from pathlib import Path

import pytest

from colias_sim.envs import ENVS
from tests.helpers.surface import FUNCTIONS, PUBLIC
from tests.site import SITE

pytestmark = pytest.mark.site


class Described(HTMLParser):
    """What a page documents: the anchors of names, the sections that each has, and the targets of links."""

    def __init__(self, path: Path) -> None:
        super().__init__()
        self.sections: dict[str, set[str]] = {}
        self.links: set[str] = set()
        self._name, self._in_title = "", False
        self.feed(path.read_text(encoding="utf-8"))

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = {name: value or "" for name, value in attrs}
        kinds = given.get("class", "").split()
        if tag == "dt" and "sig" in kinds and "id" in given:
            self._name = given["id"]
            self.sections[self._name] = set()
        self._in_title = tag == "dt" and any(kind.startswith("field-") for kind in kinds)
        if tag == "a" and "href" in given:
            self.links.add(given["href"])

    def handle_data(self, data: str) -> None:
        if self._in_title and self._name:
            self.sections[self._name].add(data.strip())
            self._in_title = False


@pytest.fixture(scope="module")
def pages() -> dict[str, Described]:
    """The pages by their paths in docs/generated/, without ending."""
    folder = SITE / "generated"
    paths = [*folder.glob("api/*.html"), *folder.glob("envs/*.html")]
    assert len(paths) > 100, f"{SITE}: make docs builds it"
    return {path.relative_to(folder).with_suffix("").as_posix(): Described(path) for path in paths}


def test_every_public_name_has_an_anchor(pages):
    anchors = {name for document in pages.values() for name in document.sections}
    envs = {entry.entry_point.replace(":", ".") for entry in ENVS.values()}
    assert {*PUBLIC, *FUNCTIONS, *envs} <= anchors
