"""Docstrings of the public names: each names exactly its parameters, and says what it returns."""

import ast
import dataclasses
import doctest
import importlib
import inspect
import types
from typing import Any

import pytest
from numpydoc.docscrape import NumpyDocString

from tests.helpers.chapters import PAGES, blocks
from tests.helpers.surface import CLASSES, EXPORTED, FUNCTIONS, PUBLIC, documented, is_constant
from tools.pages import api


def is_property(name: str) -> bool:
    owner, _, last = name.rpartition(".")
    if owner not in CLASSES:
        return False
    value = inspect.getattr_static(CLASSES[owner], last)
    return not isinstance(value, types.FunctionType | classmethod | staticmethod)


def expected(function: Any) -> list[str]:
    return [name for name in inspect.signature(function).parameters if name not in ("self", "cls")]


@pytest.mark.parametrize("name", FUNCTIONS)
def test_a_function_documents_what_it_takes_and_gives(name):
    function = FUNCTIONS[name]
    assert documented(function, "Parameters") == expected(function)
    page = NumpyDocString(inspect.getdoc(function) or "")
    gives = inspect.signature(function).return_annotation not in ("None", None, inspect.Signature.empty)
    assert bool(page["Returns"] or page["Yields"]) == (gives and not is_property(name))


@pytest.mark.parametrize("name", CLASSES)
def test_a_class_documents_how_it_is_made(name):
    cls = CLASSES[name]
    if dataclasses.is_dataclass(cls):
        made_of = {field.name for field in dataclasses.fields(cls) if field.init}
        assert set(documented(cls, "Parameters", "Attributes")) == made_of
    elif not getattr(cls, "_is_protocol", False) and isinstance(cls.__init__, types.FunctionType):
        assert documented(cls, "Parameters") == expected(cls.__init__)


def test_constants_are_described():
    for name, thing in PUBLIC.items():
        assert not is_constant(thing) or api.constant(name), name


def test_the_pages_list_every_name_once():
    assert len(api.listed()) == len(PUBLIC)
    for name, thing in EXPORTED.items():
        twice = not is_constant(thing) and any(thing is other for other in PUBLIC.values())  # by another package
        assert name in PUBLIC or twice, name
    things = [id(thing) for thing in PUBLIC.values() if not is_constant(thing)]
    assert len(things) == len(set(things))


def test_what_chapters_import_is_public():
    for where in PAGES:
        for block in (block for block in blocks(where) if block.language == "python"):
            for node in ast.walk(ast.parse(block.text)):
                if isinstance(node, ast.ImportFrom) and str(node.module).partition(".")[0] in api.PACKAGES:
                    module = importlib.import_module(str(node.module))
                    for alias in node.names:
                        public = any(getattr(module, alias.name) is thing for thing in PUBLIC.values())
                        assert public, (block.where, alias.name)


# --- examples --------------------------------------------------------------------------------------------------------

NOT_RUN = {
    "experiments.run": "takes half a minute: tests/experiments/kinds/test_api.py",
    "experiments.load": "needs a run",
    "experiments.Run": "needs a run",
    "experiments.runs": "needs a folder of runs",
    "experiments.compare": "takes minutes",
    "experiments.watch": "needs a film",
    "experiments.score": "takes a minute",
    "experiments.sweep": "takes a while: tests/experiments/kinds/test_sweep.py",
    "experiments.fit": "takes minutes: tests/experiments/kinds/test_fit.py",
}
"""Name -> why its example is not run."""
EXAMPLES = [name for name, thing in PUBLIC.items() if ">>>" in (inspect.getdoc(thing) or "")]


@pytest.mark.parametrize("name", sorted(set(EXAMPLES) - set(NOT_RUN)))
def test_an_example_runs_as_shown(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    if name == "colias_sim.swarm_env":
        pytest.importorskip("pettingzoo")
    test = doctest.DocTestParser().get_doctest(inspect.getdoc(PUBLIC[name]) or "", {}, name, None, None)
    output: list[str] = []
    assert test.examples
    doctest.DocTestRunner(verbose=False).run(test, out=output.append)
    assert not output, "".join(output)
