"""The tutorials: notebooks in text form, which the documentation's build executes. Here without Sphinx, and quickly."""

import ast
import re
import shlex
from pathlib import Path

import pytest

import experiments
from tests.helpers.chapters import ROOT, check_options

FOLDER = ROOT / "docs" / "tutorials"
INDEX = FOLDER / "index.md"
TUTORIALS = sorted(path for path in FOLDER.glob("*.md") if path != INDEX)
POLICY = ROOT / "experiments" / "policies" / "optomotor-policy.npz"
PUBLIC = {"experiments", "dsnn", "colias_sim"}
LIBRARIES = {"numpy", "matplotlib", "gymnasium", "cv2", "IPython"}
STANDARD = {"csv", "dataclasses", "importlib", "json"}


def cells(page: Path) -> list[str]:
    return re.findall(r"^```\{code-cell\} ipython3\n(.*?)^```$", page.read_text(), re.DOTALL | re.MULTILINE)


def shells(page: Path) -> list[str]:
    return re.findall(r"^```sh\n(.*?)^```$", page.read_text(), re.DOTALL | re.MULTILINE)


def split(cell: str) -> tuple[str, str]:
    """A cell's Python, and its shell commands, in which ``{options}`` is the cell's text of this name."""
    lines = [line for line in cell.splitlines() if not line.startswith("%%writefile ")]
    commands = "\n".join(line[1:] for line in lines if line.startswith("!"))
    for name, text in re.findall(r'^(\w+) = "(.*)"$', cell, re.MULTILINE):
        commands = commands.replace(f"{{{name}}}", text)
    return "\n".join(line for line in lines if not line.startswith("!")), commands


def written(page: Path) -> set[str]:
    """The modules that the page itself writes."""
    return {Path(name).stem for name in re.findall(r"^%%writefile (\S+\.py)$", page.read_text(), re.MULTILINE)}


@pytest.mark.parametrize("page", TUTORIALS, ids=lambda page: page.stem)
def test_cells_are_python_from_public_packages(page):
    assert page.read_text().count("```{code-cell}") == len(cells(page)) > 0
    for cell in cells(page):
        for node in ast.walk(ast.parse(split(cell)[0])):
            names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            names += [str(node.module)] if isinstance(node, ast.ImportFrom) else []
            assert {name.partition(".")[0] for name in names} <= PUBLIC | LIBRARIES | STANDARD | written(page)


def test_commands_have_options_that_there_are():
    texts = [text for page in TUTORIALS for text in [*(split(cell)[1] for cell in cells(page)), *shells(page)]]
    lines = [line for text in texts for line in text.replace("\\\n", " ").splitlines()]
    assert len(lines) > len(TUTORIALS)
    for line in lines:
        program, *arguments = shlex.split(line.partition("|")[0], comments=True)
        assert program == "colias", line
        check_options(arguments)


def test_the_policy_that_ships_beats_standing_still_and_chance():
    gain, total = {}, {}
    for name in (str(POLICY), "still", "random"):
        scores = experiments.score(name, env="Optomotor", episodes=1, seed=100, quiet=True)
        gain[name], total[name] = scores["optomotor gain"].value, scores["return"].value
    assert gain["still"] == 0.0
    assert gain[str(POLICY)] > 0.5  # over half of the drum's turning is followed
    assert total[str(POLICY)] > max(total["still"], total["random"])
