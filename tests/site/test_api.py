"""The API pages as built: every public name has its page and its anchor, with what it takes, gives and raises."""

from __future__ import annotations

import inspect
from html.parser import HTMLParser

import pytest
from numpydoc.docscrape import NumpyDocString
from sphinx.util.inventory import InventoryFile

from colias_sim.envs import ENVS
from tests.site.test_links import SITE
from tests.test_docstrings import CLASSES, FUNCTIONS, page
from tools.pages import docstrings, surface

pytestmark = pytest.mark.site
PUBLIC = surface.public()


class Text(HTMLParser):
    """The text of a page by the anchor of what it documents, and the targets of its links."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.sections: set[tuple[str, str]] = set()
        self.links: set[str] = set()
        self._name, self._in_field = "", False
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = {name: value or "" for name, value in attrs}
        if tag == "dt" and "sig" in given.get("class", "").split():
            self._name = given.get("id", self._name)
        self._in_field = tag == "dt" and given.get("class", "").startswith("field-")
        if tag == "a":
            self.links.add(given.get("href", ""))

    def handle_data(self, data: str) -> None:
        if self._in_field and data.strip():
            self.sections.add((self._name, data.strip().rstrip(":")))
            self._in_field = False


@pytest.fixture(scope="module")
def inventory() -> dict[str, str]:
    """Every documented object of Python -> its page and anchor."""
    found = InventoryFile.load((SITE / "objects.inv").open("rb"), "", lambda base, path: path)
    return {
        name: item.uri
        for kind, items in found.data.items()
        if kind.startswith("py:")
        for name, item in items.items()
    }


def test_every_public_name_has_an_anchor(inventory):
    classes = {f"{module}.{cls}" for module, _, cls in (entry.entry_point.partition(":") for entry in ENVS.values())}
    for name in {*PUBLIC, *FUNCTIONS, *classes}:
        path, _, anchor = inventory[name].replace("$", name).partition("#")
        assert f'id="{anchor}"' in (SITE / path).read_text(encoding="utf-8"), name


def test_pages_show_parameters_returns_and_raises(inventory):
    pages = {path.name: Text(path.read_text(encoding="utf-8")) for path in (SITE / "generated" / "api").glob("*.html")}
    shown = {each for text in pages.values() for each in text.sections}
    for name, thing in {**FUNCTIONS, **CLASSES}.items():
        for title in {"Parameters", "Attributes", "Returns", "Raises"} & set(page(thing)):
            assert (name, title) in shown, (name, title)


def test_types_are_links(inventory):
    run = Text((SITE / inventory["experiments.run"].partition("#")[0]).read_text(encoding="utf-8"))
    for name in ("experiments.Experiment", "experiments.Run", "experiments.UsageError"):
        assert f"{name}.html#{name}" in run.links


@pytest.mark.parametrize("name", [*FUNCTIONS, *CLASSES])
def test_numpydoc_reads_a_docstring_as_the_tests_do(name):
    """tests/test_docstrings.py has a parser of its own, as numpydoc is installed for these pages alone."""
    thing = {**FUNCTIONS, **CLASSES}[name]
    text = "\n".join(docstrings.joined(page(thing)))
    read, own = NumpyDocString(text), page(thing)
    for title in ("Parameters", "Attributes", "Returns", "Raises"):
        assert bool(read[title]) == (title in own)
    names = [part.strip().lstrip("*") for each in read["Parameters"] for part in each.name.split(",")]
    assert names == docstrings.names_in(own.get("Parameters", []))
    assert inspect.getdoc(thing)
