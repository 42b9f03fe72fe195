"""Docstrings completed, as numpydoc parsed them: with the fields of dataclasses, and with shared sections.

The meaning of a dataclass's fields may stand below each field, and methods of one kind in several classes are
documented once. Here these come together, so that no source says anything twice.
"""

from __future__ import annotations

import ast
import dataclasses
import functools
import importlib
import inspect
import itertools
import re
import sys
import typing
from pathlib import Path
from typing import Any

from numpydoc.docscrape import NumpyDocString, Parameter

LISTS = ("Parameters", "Attributes")
"""Sections whose entries are parameters or fields."""
SHARED = re.compile(r"Parameters, returns and errors are those of `([\w.]+)`\.")
"""Sentence of a method that is documented elsewhere."""


def names_in(entries: list[Parameter]) -> list[str]:
    """Return the names that the entries of a section document, without stars."""
    return [name.strip().lstrip("*") for entry in entries for name in entry.name.split(",")]


@functools.cache
def below(module: str) -> dict[str, str]:
    """Return what stands below the assignments of a module: ``NAME``, or ``Class.name`` -> its docstring."""
    path = inspect.getsourcefile(importlib.import_module(module))
    assert path is not None
    tree = ast.parse(Path(path).read_text(encoding="utf-8"))
    bodies = [("", tree.body), *((f"{n.name}.", n.body) for n in tree.body if isinstance(n, ast.ClassDef))]
    by_name: dict[str, str] = {}
    for prefix, body in bodies:
        for node, after in itertools.pairwise(body):
            target = node.target if isinstance(node, ast.AnnAssign) else None
            target = node.targets[0] if isinstance(node, ast.Assign) else target
            text = after.value if isinstance(after, ast.Expr) else None
            if isinstance(target, ast.Name) and isinstance(text, ast.Constant) and isinstance(text.value, str):
                by_name[f"{prefix}{target.id}"] = inspect.cleandoc(text.value)
    return by_name


def constant(name: str, value: object) -> str:
    """Return the docstring of a public constant, wherever the package defines it; empty if it has none."""
    if name.endswith(".__version__"):
        return "The version of colias-sim that is installed."
    root, last = name.partition(".")[0], name.rpartition(".")[2]
    for module in sorted(m for m in sys.modules if m == root or m.startswith(f"{root}.")):
        if getattr(sys.modules[module], "__dict__", {}).get(last) is value and last in below(module):
            return below(module)[last]
    return ""


def fields(cls: type[Any]) -> dict[str, str]:
    """Return the fields of a dataclass that its constructor takes -> what stands below each, or nothing."""
    meanings: dict[str, str] = {}
    for base in reversed(cls.__mro__):
        if base.__module__ != "builtins":
            prefix = f"{base.__name__}."
            meanings |= {
                k.removeprefix(prefix): text for k, text in below(base.__module__).items() if k.startswith(prefix)
            }
    return {field.name: meanings.get(field.name, "") for field in dataclasses.fields(cls) if field.init}


def completed(thing: Any, text: str, find: typing.Callable[[str], Any]) -> NumpyDocString:
    """Return a docstring with what is said of the thing elsewhere.

    Parameters
    ----------
    thing
        A function, method or class.
    text
        Its docstring, without indentation.
    find
        Finds a public object by its name in full.

    Returns
    -------
    numpydoc.docscrape.NumpyDocString
        It has the sections of the method that it shares them with, and the fields of a dataclass.
    """
    page = NumpyDocString(SHARED.sub("", text))
    if shared := SHARED.search(text):
        source = NumpyDocString(inspect.getdoc(find(shared[1])) or "")
        for title in ("Parameters", "Returns", "Raises"):
            page[title] = source[title] or page[title]
    if inspect.isclass(thing) and dataclasses.is_dataclass(thing) and not any(page[title] for title in LISTS):
        page["Parameters"] = [Parameter(name, "", meaning.splitlines()) for name, meaning in fields(thing).items()]
    return page
