"""Docstrings of the public names: each names exactly its parameters, and says what it returns."""

from __future__ import annotations

import ast
import dataclasses
import doctest
import importlib
import inspect
import re
import types
from typing import Any

import pytest
from numpydoc.docscrape import NumpyDocString

from tests.helpers.chapters import PAGES, ROOT, blocks
from tests.helpers.surface import CLASSES, EXPORTED, FUNCTIONS, PUBLIC, page
from tools.pages import docstrings, surface

API = ROOT / "docs" / "reference" / "api"


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
    documented = page(function)
    assert docstrings.names_in(documented["Parameters"]) == expected(function)
    gives = inspect.signature(function).return_annotation not in ("None", None, inspect.Signature.empty)
    assert bool(documented["Returns"] or documented["Yields"]) == (gives and not is_property(name))


@pytest.mark.parametrize("name", CLASSES)
def test_a_class_documents_how_it_is_made(name):
    cls = CLASSES[name]
    documented = page(cls)
    listed = [name for title in docstrings.LISTS for name in docstrings.names_in(documented[title])]
    if dataclasses.is_dataclass(cls):
        assert set(listed) == set(docstrings.fields(cls))
        written = NumpyDocString(inspect.getdoc(cls) or "")
        own = {field.name for field in dataclasses.fields(cls)} & set(vars(cls).get("__annotations__", ()))
        assert own <= {name for title in docstrings.LISTS for name in docstrings.names_in(written[title])}, "for help()"
    elif getattr(cls, "_is_protocol", False):
        return
    elif isinstance(cls.__init__, types.FunctionType):
        assert docstrings.names_in(documented["Parameters"]) == expected(cls.__init__)


def test_constants_are_described():
    for name, thing in PUBLIC.items():
        if surface.is_constant(thing):
            assert docstrings.constant(name, thing), name


def test_the_pages_list_every_name_once():
    text = "\n".join(path.read_text(encoding="utf-8") for path in sorted(API.glob("*.md")))
    listed = re.findall(r"^   ([\w.]+)$", text, re.MULTILINE)
    assert sorted(listed) == sorted(PUBLIC)


def test_what_chapters_import_is_public():
    exported = list(EXPORTED.values())
    for where in PAGES:
        for block in (block for block in blocks(where) if block.language == "python"):
            for node in ast.walk(ast.parse(block.text)):
                if isinstance(node, ast.ImportFrom) and str(node.module).partition(".")[0] in surface.OURS:
                    module = importlib.import_module(str(node.module))
                    for alias in node.names:
                        assert any(getattr(module, alias.name) is entry for entry in exported), (
                            block.where,
                            alias.name,
                        )


# --- examples --------------------------------------------------------------------------------------------------------

NOT_RUN = {
    "experiments.run": "takes half a minute: tests/bench/test_api.py",
    "experiments.load": "needs a run",
    "experiments.Run": "needs a run",
    "experiments.runs": "needs a folder of runs",
    "experiments.compare": "takes minutes",
    "experiments.watch": "needs a film",
    "experiments.score": "takes a minute",
    "experiments.sweep": "takes a while: tests/bench/test_sweep.py",
    "experiments.fit": "takes minutes: tests/bench/test_fit.py",
}
"""Name -> why its example is not run."""
EXAMPLES = [name for name, thing in PUBLIC.items() if ">>>" in (inspect.getdoc(thing) or "")]


@pytest.mark.parametrize("name", sorted(set(EXAMPLES) - set(NOT_RUN)))
def test_an_example_runs_as_shown(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    test = doctest.DocTestParser().get_doctest(inspect.getdoc(PUBLIC[name]) or "", {}, name, None, None)
    output: list[str] = []
    assert test.examples
    doctest.DocTestRunner(verbose=False).run(test, out=output.append)
    assert not output, "".join(output)
