"""The public names, and their docstrings as parsed."""

from __future__ import annotations

import inspect
import types
from collections.abc import Callable, Iterator
from typing import Any

from numpydoc.docscrape import NumpyDocString

from tools.pages import docstrings, surface

EXPORTED, PUBLIC = surface.exported(), surface.public()


def is_ours(cls: type) -> bool:
    return cls.__module__.partition(".")[0] in surface.OURS


def find(name: str) -> Any:
    owner, _, last = name.rpartition(".")
    return PUBLIC[name] if name in PUBLIC else getattr(PUBLIC[owner], last)


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


def page(thing: Any) -> NumpyDocString:
    return docstrings.completed(thing, inspect.getdoc(thing) or "", find)
