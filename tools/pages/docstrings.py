"""Docstrings completed, as numpydoc parsed them: with the fields of dataclasses, with types.

The types of parameters are in signatures, the meaning of a dataclass's fields may stand below each field, and methods
of one kind in several classes are documented once. Here these come together, so that no source says anything twice.
"""

from __future__ import annotations

import ast
import collections.abc
import dataclasses
import functools
import importlib
import inspect
import itertools
import re
import sys
import typing
from pathlib import Path
from types import FunctionType, NoneType, UnionType
from typing import Any

import numpy as np
from numpydoc.docscrape import NumpyDocString, Parameter

LISTS = ("Parameters", "Attributes")
"""Sections whose entries are parameters or fields."""
LONGEST = 40
"""Characters of a default beside the name of its parameter; the signature has longer ones."""
SHARED = re.compile(r"Parameters, returns and errors are those of `([\w.]+)`\.")
"""Sentence of a method that is documented elsewhere."""


def names_in(entries: list[Parameter]) -> list[str]:
    """Return the names that the entries of a section document, without stars."""
    return [name for entry in entries for name in _names(entry)]


def _names(entry: Parameter) -> list[str]:
    """Return the names of an entry, as ``x, y``."""
    return [name.strip().lstrip("*") for name in entry.name.split(",")]


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
        It has the sections of the method that it shares them with, the fields of a dataclass, and types.
    """
    page = NumpyDocString(SHARED.sub("", text))
    if shared := SHARED.search(text):
        source = NumpyDocString(inspect.getdoc(find(shared[1])) or "")
        for title in ("Parameters", "Returns", "Raises"):
            page[title] = source[title] or page[title]
    if inspect.isclass(thing) and dataclasses.is_dataclass(thing) and not any(page[title] for title in LISTS):
        page["Parameters"] = [Parameter(name, "", meaning.splitlines()) for name, meaning in fields(thing).items()]
    types = parameter_types(thing)
    for title in LISTS:
        page[title] = [_typed(entry, types) for entry in page[title]]
    return page


def _typed(entry: Parameter, types: dict[str, str]) -> Parameter:
    """Return an entry, as ``x, y``, with the type and default that all its names have."""
    kinds = {types.get(name, "") for name in _names(entry)}
    return entry._replace(type=entry.type or kinds.pop()) if len(kinds) == 1 else entry


def parameter_types(thing: Any) -> dict[str, str]:
    """Return parameter -> its type and default in words; without those whose type says nothing."""
    try:
        signature = inspect.signature(thing)
    except (TypeError, ValueError):
        return {}
    hints = _hints(thing)
    types: dict[str, str] = {}
    for name, parameter in signature.parameters.items():
        words = type_words(hints.get(name, Any))
        default = parameter.default
        short = isinstance(default, bool | int | float | str | tuple | None) and len(repr(default)) <= LONGEST
        if default is not parameter.empty and short:
            words = f"{words}, default {default!r}" if words else f"default {default!r}"
        if words and parameter.kind not in (parameter.VAR_POSITIONAL, parameter.VAR_KEYWORD):
            types[name] = words
    return types


def _hints(thing: Any) -> dict[str, Any]:
    """Read the annotations of a function, or of what a class is made of, with names that only type checkers import."""
    source = thing
    if inspect.isclass(thing) and not dataclasses.is_dataclass(thing):
        source = thing.__init__ if isinstance(thing.__init__, FunctionType) else thing
    module = sys.modules.get(getattr(source, "__module__", ""))
    space = _checked_imports(module.__name__) if module else {}
    try:
        return typing.get_type_hints(source, localns=space)
    except (NameError, TypeError):
        return {}


@functools.cache
def _checked_imports(module: str) -> dict[str, Any]:
    """Return what a module imports under ``if TYPE_CHECKING:``."""
    path = inspect.getsourcefile(sys.modules[module])
    space: dict[str, Any] = {}
    tree = ast.parse(Path(path).read_text(encoding="utf-8")) if path else ast.Module([], [])
    for node in tree.body:
        if isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING":
            imports = (
                node_inside
                for node_inside in node.body
                if isinstance(node_inside, ast.ImportFrom) and node_inside.module
            )
            for node_inside in imports:
                there = importlib.import_module(str(node_inside.module))
                space |= {alias.asname or alias.name: getattr(there, alias.name) for alias in node_inside.names}
    return space


_MANY = {
    collections.abc.Sequence: "sequence", collections.abc.Iterable: "iterable", collections.abc.Iterator: "iterator",
    list: "list", set: "set", frozenset: "frozenset", collections.abc.Collection: "collection",
}  # fmt: skip


def type_words(hint: Any) -> str:
    """Return a type as numpydoc writes it: ``ndarray of uint8``, ``sequence of str``; empty for any object."""
    origin, parts = typing.get_origin(hint), typing.get_args(hint)
    if hint is Any or hint is Ellipsis or hint is inspect.Parameter.empty:
        return ""
    if isinstance(hint, typing.TypeVar):
        return type_words(hint.__bound__) if hint.__bound__ else ""
    if isinstance(hint, typing.ForwardRef):
        return str(hint.__forward_arg__)
    if origin is typing.Literal:
        return "{" + ", ".join(map(repr, parts)) + "}"
    if origin in (typing.Union, UnionType):
        return " or ".join(dict.fromkeys(filter(None, map(type_words, parts))))
    if origin is typing.Annotated:
        return type_words(parts[0])
    if origin is np.ndarray:
        kinds = typing.get_args(parts[1]) if len(parts) > 1 else ()
        kind = getattr(kinds[0], "__name__", "") if kinds and inspect.isclass(kinds[0]) else ""
        known = {"": "", "Any": "", "generic": "", "floating": " of float"}
        return f"ndarray{known.get(kind, f' of {kind}')}"
    if origin is collections.abc.Callable:
        return "callable"
    if origin in (collections.abc.Mapping, dict):
        key, value = (type_words(part) for part in parts)
        return f"{'dict' if origin is dict else 'mapping'} of {key} to {value or 'any'}"
    if origin in _MANY:
        inside = type_words(parts[0])
        return f"{_MANY[origin]} of {inside}" if inside else _MANY[origin]
    if origin is tuple:
        if len(parts) == 2 and parts[1] is Ellipsis:
            return f"tuple of {type_words(parts[0]) or 'any'}"
        return f"tuple[{', '.join(type_words(part) or 'Any' for part in parts)}]"
    if origin is not None:
        return type_words(origin)
    return "None" if hint is NoneType else _name(hint)


def _name(cls: Any) -> str:
    """Return the name of a class; of one that is not ours with the shortest path by which it can be imported."""
    name, module = getattr(cls, "__qualname__", str(cls)), getattr(cls, "__module__", "builtins")
    path = module.split(".")
    if path[0] in ("builtins", "os", "pathlib", "collections", "colias_sim", "dsnn", "experiments", "scenes"):
        return str(name)
    for length in range(1, len(path)):
        place = ".".join(path[:length])
        if getattr(sys.modules.get(place), name, None) is cls:
            return f"{place}.{name}"
    return f"{module}.{name}"
