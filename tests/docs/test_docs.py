"""README.md and docs/: whole, in step with the code. What docs/how-to/ shows runs in test_docs_*.py of its own."""

import re

import pytest

from experiments.cli import main
from tests.helpers.chapters import PAGES, blocks, called, chapter, headings

__all__ = ["chapter"]


@pytest.mark.parametrize("name", [called(page) for page in PAGES if page.parent.name != "how-to"])
def test_a_page_runs_as_pasted(name, chapter):
    chapter(name)


def test_every_command_is_shown():
    documented = {words[1] for page in PAGES for block in blocks(page) if block.language == "sh"
                  for words in block.commands() if words[0] == "colias"}  # fmt: skip
    commands = main.parser().commands
    assert documented >= {name for name, command in commands.items() if not command.hidden}


@pytest.mark.parametrize("page", PAGES, ids=called)
def test_links_lead_somewhere(page):
    for target in re.findall(r"\]\(([^)]+)\)", page.read_text()):
        if target.startswith("https:") or "generated/" in target:  # tests/site follows those
            continue
        path, _, anchor = target.partition("#")
        there = page.parent / path if path else page
        assert there.exists(), target
        assert not anchor or anchor in headings(there.read_text()), target
