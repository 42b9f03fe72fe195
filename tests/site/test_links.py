"""The documentation as `make docs` has built it: every link leads somewhere, and nothing comes from a network."""

from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

import pytest

from colias_sim.envs import ENVS
from tests.helpers.surface import FUNCTIONS, PUBLIC
from tests.site import SITE

pytestmark = pytest.mark.site
LOADS = {"script": "src", "img": "src", "link": "href", "iframe": "src", "source": "src", "video": "src"}


class Page(HTMLParser):
    """What a page links to, what it loads, and its anchors."""

    def __init__(self, path: Path) -> None:
        super().__init__()
        self.links: list[str] = []
        self.loads: list[str] = []
        self.anchors: set[str] = set()
        self.feed(path.read_text(encoding="utf-8"))

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = {name: value or "" for name, value in attrs}
        self.anchors |= {given[name] for name in ("id", "name") if name in given}
        if tag == "a" and "href" in given:
            self.links.append(given["href"])
        if tag in LOADS and LOADS[tag] in given:
            self.loads.append(given[LOADS[tag]])


@pytest.fixture(scope="module")
def pages() -> dict[Path, Page]:
    parsed = {path: Page(path) for path in sorted(SITE.rglob("*.html")) if "_static" not in path.parts}
    assert len(parsed) > 20, f"{SITE}: make docs builds it"
    return parsed


def local(page: Path, target: str) -> tuple[Path, str]:
    parts = urlsplit(target)
    return (page.parent / unquote(parts.path)).resolve() if parts.path else page, unquote(parts.fragment)


def test_links_within_the_site_lead_somewhere(pages):
    broken = []
    for path, page in pages.items():
        for target in (*page.links, *page.loads):
            if urlsplit(target).scheme:
                continue
            there, anchor = local(path, target)
            known = pages.get(there)
            place = anchor and "=" not in anchor  # the playground's states are no places on its page
            if not there.exists() or (place and known and anchor not in known.anchors):
                broken.append(f"{path.relative_to(SITE)}: {target}")
    assert not broken


def test_nothing_is_loaded_from_a_network(pages):
    loaded = {target for page in pages.values() for target in page.loads if urlsplit(target).scheme not in ("", "data")}
    assert not loaded


def test_every_public_name_has_an_anchor(pages):
    anchors = {anchor for path, page in pages.items() if "generated" in path.parts for anchor in page.anchors}
    envs = {f"{env.__module__}.{env.__name__}" for env in ENVS.values()}
    assert {*PUBLIC, *FUNCTIONS, *envs} <= anchors
