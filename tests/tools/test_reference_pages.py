"""What the documentation's generated pages are made of, without Sphinx: equations, commands, units."""

import dataclasses
import re
from typing import get_args, get_type_hints

import pytest

from dsnn import CHANNELS, MODELS
from dsnn.stimuli import STIMULI
from experiments.settings.settings import described
from tools.pages import commands
from tools.pages.models import EQUATIONS

CODE = re.compile(r"`([^`]+)`")


def fields(name: str) -> set[str]:
    return {field.name for field in dataclasses.fields(MODELS[name].robot)}


def equations(name: str) -> str:
    return (EQUATIONS / f"{name}.md").read_text(encoding="utf-8")


def words(name: str) -> set[str]:
    """The values that a model's parameters may have, where these are words."""
    hints = get_type_hints(type(MODELS[name].robot))
    return {word for hint in hints.values() for word in get_args(hint) if isinstance(word, str)}


def test_every_model_has_its_equations_and_no_other():
    assert {path.stem for path in EQUATIONS.glob("*.md")} == set(MODELS)


@pytest.mark.parametrize("name", MODELS)
def test_what_equations_name_exists(name):
    """Code in them is a parameter, a channel, another model, or a word that a parameter may be set to."""
    named = set(CODE.findall(equations(name)))
    assert named <= fields(name) | set(CHANNELS) | set(MODELS) | words(name)
    for link in re.findall(r"\]\(([^)]+)\)", equations(name)):
        assert link.removesuffix(".md") in MODELS, link


@pytest.mark.parametrize("name", MODELS)
def test_equations_leave_out_no_parameter(name):
    """Those of a variant name what it has of its own, and link to the model that it is made of."""
    text = equations(name)
    others = [link.removesuffix(".md") for link in re.findall(r"\]\(([^)]+)\)", text)]
    assert fields(name) <= set(CODE.findall(" ".join([text, *map(equations, others)])))


def test_the_page_of_commands_has_every_option(tmp_path):
    commands.write(tmp_path)
    text = (tmp_path / "index.md").read_text()
    sections = dict(re.findall(r"^#+ (colias .*)\n\n```text\n([^`]*)```$", text, re.MULTILINE))
    group = commands.parser()
    assert set(sections) == set(commands.shown(group, "colias"))
    for name, section in sections.items():
        command = group
        for word in name.split()[1:]:
            command = command.commands[word]
        assert not [option for param in command.params if not param.hidden
                    for option in param.opts if option.startswith("--") and option not in section]  # fmt: skip


ENDINGS = {"tau": "ms", "_px": "px", "_deg": "degrees", "_hz": "Hz", "duration_s": "s", "rest_s": "s"}
"""How a parameter's name begins or ends -> its unit."""


@pytest.mark.parametrize(
    "values", [*(entry.robot for entry in MODELS.values()), *(entry.params for entry in STIMULI.values())],
    ids=lambda values: type(values).__name__,
)  # fmt: skip
def test_units_are_those_that_names_promise(values):
    for row in described({"section": values}):
        name = row["key"].partition(".")[2]
        for mark, unit in ENDINGS.items():
            if name.startswith(mark) or name.endswith(mark):
                assert row["unit"] == unit, row
        assert not (row["unit"] and row["value"] in ("true", "false")), row
