"""The public names, and their docstrings as parsed."""

import importlib
import inspect
import types
from collections.abc import Callable, Iterator
from typing import Any

from numpydoc.docscrape import NumpyDocString

from tools.pages import api

PACKAGES = ("experiments", "colias_sim", "colias_sim.envs", "colias_sim.calibrate", "dsnn", "dsnn.stimuli")
"""Packages whose ``__all__`` is public."""
EXPORTED = {f"{module}.{name}": getattr(importlib.import_module(module), name)
            for module in PACKAGES for name in importlib.import_module(module).__all__}  # fmt: skip
PUBLIC = api.public()


def is_ours(cls: type) -> bool:
    return cls.__module__.partition(".")[0] in api.PACKAGES


def is_constant(thing: object) -> bool:
    return not inspect.isclass(thing) and not inspect.isfunction(thing)


def functions() -> Iterator[tuple[str, Callable[..., Any]]]:
    """Public functions, and the public methods and properties of public classes."""
    for name, thing in PUBLIC.items():
        if inspect.isfunction(thing):
            yield name, thing
        for base in filter(is_ours, thing.__mro__) if inspect.isclass(thing) else ():
            for method, value in vars(base).items():
                plain = (
                    getattr(value, "__func__", None) or getattr(value, "fget", None) or getattr(value, "func", value)
                )
                if not method.startswith("_") and isinstance(plain, types.FunctionType):
                    yield f"{name}.{method}", plain


FUNCTIONS = dict(functions())
CLASSES = {name: thing for name, thing in PUBLIC.items() if inspect.isclass(thing)}


def documented(thing: Any, *titles: str) -> list[str]:
    """The names that a docstring's sections document, without stars."""
    page = NumpyDocString(inspect.getdoc(thing) or "")
    return [name.strip().lstrip("*") for title in titles for entry in page[title] for name in entry.name.split(",")]
