"""docs/questions/: each page is short, begins with its question, names who asked, and has a snippet that runs."""

from __future__ import annotations

import importlib
import re
import sys
from pathlib import Path

import pytest

from dsnn.stimuli import stimulus
from tests.helpers.chapters import DOCS, README, blocks, called, titled
from tests.helpers.questions import ANSWERS, INDEX, PARTS, part

LEAST, MOST = 25, 30
LONGEST = 40
"""Lines of a page, the files that it shows to be pasted left out."""
THREAD = re.compile(r"\[([\w./-]+)#(\d+)\]\((https://[^)]+)\)")
"""A link to a thread: its repository with or without the owner, its number, its address."""


def test_there_are_enough():
    assert LEAST <= len(ANSWERS) <= MOST


def test_the_index_names_each_once():
    targets = re.findall(r"^- \[([^]]+)\]\(([\w-]+\.md)\)$", INDEX.read_text(), re.MULTILINE)
    assert sorted(name for _, name in targets) == [page.name for page in ANSWERS]
    for title, name in targets:
        assert (INDEX.parent / name).read_text().startswith(f"# {title}\n"), name


def test_the_readme_and_the_index_of_the_documentation_lead_there():
    assert "(docs/questions/index.md)" in README.read_text()
    assert "(questions/index.md)" in (DOCS / "index.md").read_text()


def test_every_answer_is_run_by_one_file_of_tests():
    dealt = [name for number in range(PARTS) for name in part(number)]
    assert sorted(dealt) == sorted(map(called, ANSWERS))
    for number in range(PARTS):
        path = Path(__file__).with_name(f"test_docs_questions_{'abc'[number]}.py")
        assert f"part({number})" in path.read_text()


@pytest.mark.parametrize("page", ANSWERS, ids=called)
def test_a_page_begins_with_its_question_and_is_short(page):
    lines = page.read_text().splitlines()
    assert re.fullmatch(r"# How do I [^?]+\?", lines[0])
    assert not lines[1] and not lines[2].startswith(("#", "```", "<!--", "-", "|", "Asked")), "the answer comes first"
    pasted = sum(len(block.text.splitlines()) for block in blocks(page) if block.title)
    assert 10 <= len(lines) - pasted <= LONGEST
    assert lines[-1].startswith("More: ")


@pytest.mark.parametrize("page", ANSWERS, ids=called)
def test_a_page_has_a_snippet_that_runs(page):
    run = [block for block in blocks(page) if not block.skipped and block.language in ("python", "sh")]
    assert any(not block.title and not block.text.startswith("pip ") for block in run)


@pytest.mark.parametrize("page", ANSWERS, ids=called)
def test_a_page_names_the_threads_in_which_it_was_asked(page):
    """And its links lead to no other host. Nothing here asks the network."""
    text = page.read_text()
    (asked,) = re.findall(r"^Asked in .*$", text, re.MULTILINE)
    threads = THREAD.findall(asked)
    assert threads and len(re.findall(r"https?://", text)) == len(threads)
    for repository, number, address in threads:
        match = re.fullmatch(r"https://github\.com/([\w.-]+/[\w.-]+)/(?:issues|pull)/(\d+)", address)
        assert match and match[1].endswith(repository) and match[2] == number, address


def test_the_network_in_pytorch_answers_in_its_wrapper(tmp_path, monkeypatch):
    torch = pytest.importorskip("torch")
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    torch.manual_seed(0)
    network = torch.nn.ModuleList([torch.nn.GRUCell(24 * 33, 16), torch.nn.Linear(16, 2)])
    torch.save(network.state_dict(), "weights.pt")
    for name in ("learned", "in_torch"):
        Path(f"{name}.py").write_text(titled(f"{name}.py"), encoding="utf-8")
        monkeypatch.delitem(sys.modules, name, raising=False)
    learned, in_torch = (importlib.import_module(name) for name in ("learned", "in_torch"))
    learned.network = in_torch.network
    clip = stimulus("plain", rows=72, columns=99, width=16, height=30)
    model = learned.MODEL.build(clip.shape, learned.MODEL.robot)
    first, again = [], []
    for answers in (first, again):
        model.reset()
        answers += [model.step(frame.luma) for frame in clip]
    assert first == again and len({answer.hs for answer in first}) > 1
