"""The tutorials: notebooks in text form, which the documentation's build executes. Here without Sphinx, and quickly."""

from __future__ import annotations

import ast
import json
import re
import shlex
from pathlib import Path

import numpy as np
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
FEWEST_CELLS, MOST_CELLS = 4, 12
WIDEST = 76
"""Columns of code that a page shows at 1280 px without scrolling sideways."""
MOST_BYTES = 100_000

every_page = pytest.mark.parametrize("page", TUTORIALS, ids=lambda page: page.stem)


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


@every_page
def test_cells_are_python_from_public_packages(page):
    assert FEWEST_CELLS <= len(cells(page)) <= MOST_CELLS
    assert page.read_text().count("```{code-cell}") == len(cells(page))
    for cell in cells(page):
        assert max(map(len, cell.splitlines())) <= WIDEST, cell
        for node in ast.walk(ast.parse(split(cell)[0])):
            names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            names += [str(node.module)] if isinstance(node, ast.ImportFrom) else []
            assert {name.partition(".")[0] for name in names} <= PUBLIC | LIBRARIES | STANDARD | written(page)
            assert not any("bench" in name for name in names)


def test_commands_have_options_that_there_are():
    texts = [text for page in TUTORIALS for text in [*(split(cell)[1] for cell in cells(page)), *shells(page)]]
    lines = [line for text in texts for line in text.replace("\\\n", " ").splitlines()]
    assert len(lines) > len(TUTORIALS)
    for line in lines:
        program, *arguments = shlex.split(line.partition("|")[0], comments=True)
        assert program == "colias", line
        check_options(arguments)


def about() -> dict[str, object]:
    with np.load(POLICY, allow_pickle=False) as file:
        facts = json.loads(str(file["about"]))
    assert isinstance(facts, dict)
    return facts


@pytest.mark.parametrize("page", [FOLDER / "training.md", POLICY.parent / "README.md"], ids=lambda page: page.stem)
def test_pages_say_how_the_policy_that_ships_was_made(page):
    facts, text = about(), page.read_text()
    env = str(facts["env"]).partition("/")[2].partition("-")[0]
    command = f"colias train --env {env} --seed {facts['seed']} --steps {facts['steps']} --envs {facts['envs']}"
    assert f"```sh\n{command}\n```" in text
    assert facts["options"] == {}
    versions = facts["versions"]
    assert isinstance(versions, dict)
    torch = str(versions["torch"]).partition("+")[0]
    assert f"PyTorch {torch}" in text and f"stable-baselines3 {versions['stable-baselines3']}" in text


def test_the_policy_that_ships_is_small_and_beats_standing_still_and_chance():
    assert POLICY.stat().st_size <= MOST_BYTES
    gain, total = {}, {}
    for name in (str(POLICY), "still", "random"):
        scores = experiments.score(name, env="Optomotor", episodes=1, seed=100, quiet=True)
        gain[name], total[name] = scores["optomotor gain"].value, scores["return"].value
    assert gain["still"] == 0.0
    assert gain[str(POLICY)] > 0.5  # over half of the drum's turning is followed
    assert total[str(POLICY)] > max(total["still"], total["random"])
