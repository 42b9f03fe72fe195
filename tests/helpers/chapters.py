"""Run what README.md and the pages of docs/ show, each in an empty folder and in order.

A fenced block is a ``python`` snippet, ``sh`` commands, or an ``xml`` file; others are not run.

- A snippet runs in its chapter's namespace, so it may use names of earlier ones. One with ``title=NAME`` is a file: it
  is written, and commands and snippets below it may use it.
- ``colias ...`` and ``python FILE ...`` run in this process, ``make -C FOLDER`` in one of its own. Of ``make TARGET``
  and of the extras of ``pip install '.[EXTRA]'`` it is checked that there are such.
- A comment before the block changes that. ``<!-- test: add ARGUMENTS -->`` appends the arguments to each of its
  ``colias`` and ``python`` commands, to make them short. ``<!-- test: skip REASON -->`` runs none of it: only the
  commands' options are checked, by their parser.

Jobs run in this process, whatever the number of workers: starting workers takes longer than these jobs. Episodes end
after 30 steps.
"""

import re
import runpy
import shlex
import subprocess
import sys
import tomllib
import types
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest

from experiments.cli import main
from experiments.show.robot import forget_simulations
from experiments.store import workers
from tests.helpers.envs import end_after

ROOT = Path(__file__).parents[2]
README = ROOT / "README.md"
DOCS = ROOT / "docs"
LEFT_OUT = ("generated", "reference", "tutorials", "gallery")
"""Folders whose pages Sphinx makes or executes."""
PAGES = (
    README,
    ROOT / "CONTRIBUTING.md",
    *sorted(page for page in DOCS.rglob("*.md") if page.relative_to(DOCS).parts[0] not in LEFT_OUT),
)


def called(page: Path) -> str:
    """The name of a page here: its path in docs/."""
    return page.name if page.parent == ROOT else page.relative_to(DOCS).as_posix()


_FENCE = re.compile(
    r"(?:^<!-- test: (?P<verb>add|skip) (?P<rest>[^\n]*?) -->\n)?"
    r"^```(?P<language>\w+)(?: title=(?P<title>[\w.]+))?\n(?P<text>.*?)^```$",
    re.DOTALL | re.MULTILINE,
)


@dataclass(frozen=True)
class Block:
    """A fenced block of a page, and the comment before it."""

    page: Path
    line: int
    language: str
    title: str
    text: str
    added: tuple[str, ...]
    skipped: str

    @property
    def where(self) -> str:
        return f"{self.page.relative_to(ROOT)}, line {self.line}"

    def commands(self) -> Iterator[list[str]]:
        """Each command line of it as words; comments are left out."""
        for line in self.text.replace("\\\n", " ").splitlines():
            words = shlex.split(line, comments=True)
            if words:
                yield words


def blocks(page: Path) -> list[Block]:
    text = page.read_text(encoding="utf-8")
    parsed = []
    for match in _FENCE.finditer(text):
        rest = match["rest"] or ""
        added = tuple(shlex.split(rest)) if match["verb"] == "add" else ()
        line = text.count("\n", 0, match.start("text")) + 1
        skipped = rest if match["verb"] == "skip" else ""
        parsed.append(Block(page, line, match["language"], match["title"] or "", match["text"], added, skipped))
    return parsed


def written(page: Path) -> set[str]:
    """The files that a page shows with ``title=NAME``, and those that its commands ``colias new KIND NAME`` write."""
    titles = {block.title for block in blocks(page) if block.title}
    begun = {f"{words[3].replace('-', '_')}.py" for block in blocks(page) if block.language == "sh"
             for words in block.commands() if words[:2] == ["colias", "new"]}  # fmt: skip
    return titles | begun


def titled(name: str) -> str:
    """The file that a page shows with ``title=NAME``."""
    (text,) = [block.text for page in PAGES for block in blocks(page) if block.title == name]
    return text


@pytest.fixture
def chapter(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[[str], None]]:
    """Runs the page that is `called` by a name, in an empty folder."""
    monkeypatch.chdir(tmp_path)
    # As a Python that is started in the folder has it: before what other tests' files left there.
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.setenv("COLUMNS", "100")
    monkeypatch.setattr(workers, "worker_count", lambda given: 0)
    end_after(30, monkeypatch)
    for name in {Path(file).stem for page in PAGES for file in written(page)}:
        monkeypatch.delitem(sys.modules, name, raising=False)  # another test's file of this name
    module = types.ModuleType("pasted")
    monkeypatch.setitem(sys.modules, module.__name__, module)

    def run(name: str) -> None:
        (page,) = [path for path in PAGES if called(path) == name]
        for block in blocks(page):
            try:
                _run(block, module)
            except BaseException as error:
                error.add_note(f"in {block.where}")
                raise

    yield run
    forget_simulations()


def _run(block: Block, module: types.ModuleType) -> None:
    if block.language == "xml":
        Path(block.title).write_text(block.text, encoding="utf-8")
    elif block.language == "python":
        code = compile(block.text, block.where, "exec")
        if block.title:
            Path(block.title).write_text(block.text, encoding="utf-8")
        elif not block.skipped:
            exec(code, module.__dict__)
    elif block.language == "sh":
        for words in block.commands():
            _command(words, block)


def _command(words: list[str], block: Block) -> None:
    program, *arguments = words
    if program == "colias" and block.skipped:
        check_options(arguments)
    elif program == "colias":
        status = main.command([*arguments, *block.added])
        assert status == 0, f"{shlex.join(words)}: exit status {status}"
    elif program == "python":
        if not block.skipped:
            _python(*arguments, *block.added)
    elif program == "make" and arguments[0] == "-C":
        if not block.skipped:
            done = subprocess.run(words, capture_output=True, text=True, timeout=300, check=False)
            assert done.returncode == 0, done.stderr
    elif program == "make":
        assert re.search(rf"^{arguments[0]}:", (ROOT / "Makefile").read_text(), re.MULTILINE), words
    elif program == "pip":
        extras = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["optional-dependencies"]
        assert arguments[0] == "install" and set(re.findall(r"\[(\w+)\]", arguments[1])) <= set(extras), words
    else:
        raise AssertionError(f"{shlex.join(words)}: no test knows how to run this")


def check_options(arguments: list[str]) -> None:
    """Raise what the command line's parser raises for ``arguments``, but do nothing."""
    group = main.parser()
    name, command, rest = group.resolve_command(group.make_context("colias", list(arguments)), list(arguments))
    command.make_context(name, rest)


def _python(file: str, *arguments: str) -> None:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sys, "argv", [file, *arguments])
        runpy.run_path(file, run_name="__main__")


def headings(text: str) -> set[str]:
    """The anchors of a page's headings, as GitHub makes them."""
    titles = re.findall(r"^#+ (.*)$", re.sub(r"```.*?```", "", text, flags=re.DOTALL), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-") for title in titles}
