"""What the documentation's generated pages are made of, without Sphinx: equations, commands, units."""

from __future__ import annotations

import dataclasses
import re
from typing import get_args, get_type_hints

import pytest
import typer

from dsnn import CHANNELS, MODELS
from dsnn.stimuli import STIMULI
from tools.pages import commands, docstring_text, parameter_tables
from tools.pages.models import EQUATIONS, assumed

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


ASSUMED_CONSTANTS = {
    "emd": {"tau_hp", "tau_lp", "spacing"}, "lplc2": {"c_base", "spread", "k_sig"}, "pon-lgmd": {"t_sp", "n_sp"},
    "t4t5": {"k_sig"}, "emd-normalised": {"kappa", "gain"}, "three-arm-4q": {"gain"},
}  # fmt: skip


@pytest.mark.parametrize("name", MODELS)
def test_the_page_of_every_model_lists_what_is_assumed(name):
    """Its constants that no source gives, and the choices that its class lists."""
    listed = [re.match(r"`(\w+) = ", item) for item in assumed(MODELS[name])]
    assert {item[1] for item in listed if item} >= ASSUMED_CONSTANTS.get(name, set())
    assert None in listed, "its class lists choices"


def test_every_command_has_a_page_with_all_its_options(tmp_path):
    commands.write(tmp_path)
    group = commands.shown(typer.main.get_command(commands.app))
    assert {path.stem for path in tmp_path.iterdir()} == {*group, "index"}
    for name, command in group.items():
        text = (tmp_path / f"{name}.md").read_text()
        below = commands.shown(command)
        options = {option for each in (command, *below.values()) for param in each.params if not param.hidden
                   for option in param.opts if option.startswith("--")}  # fmt: skip
        assert not [option for option in options if option not in text], name
        assert all(f"colias {name} {subcommand} " in text for subcommand in below)


ENDINGS = {"tau": "ms", "_px": "px", "_deg": "degrees", "_hz": "Hz", "duration_s": "s", "rest_s": "s"}
"""How a parameter's name begins or ends -> its unit."""


@pytest.mark.parametrize(
    "values", [*(entry.robot for entry in MODELS.values()), *(entry.params for entry in STIMULI.values())],
    ids=lambda values: type(values).__name__,
)  # fmt: skip
def test_units_are_those_that_names_promise(values):
    for row in parameter_tables.rows(values):
        for mark, unit in ENDINGS.items():
            if row.key.startswith(mark) or row.key.endswith(mark):
                assert row.unit == unit, row
        assert not (row.unit and row.value in ("true", "false")), row


def test_a_table_of_parameters_tells_every_one_and_where_presets_differ():
    entry = MODELS["dsnn"]
    lines = parameter_tables.parameters(entry.robot, {"off-line": entry.offline}).splitlines()
    rows = [line.split(" | ") for line in lines if line.startswith("| `")]
    assert [row[0].strip("| `") for row in rows] == [field.name for field in dataclasses.fields(entry.robot)]
    assert {row[0].strip("| `") for row in rows if "off-line" in row[1]} == {"k_sp", "t_sp"}
    assert parameter_tables.changes(entry.robot, entry.offline) == ["k_sp=1", "t_sp=0.2"]


def test_docstrings_lose_their_sections_and_keep_code():
    def documented() -> None:
        """Takes ``a | b`` and `c`, 2 * d.

        - one
          goes on
        - two

        Parameters
        ----------
        none
            There are none.
        """

    assert docstring_text.paragraphs(documented) == ["Takes `a \\| b` and `c`, 2 \\* d.", "- one goes on\n- two"]
