"""What autodoc cannot know about the public names: where a constant is described, and which words are links."""

from __future__ import annotations

import dataclasses
import functools
import inspect
import re
import sys
from pathlib import Path
from typing import Any

from numpydoc.xref import DEFAULT_LINKS
from sphinx.application import Sphinx
from sphinx.ext.autosummary import import_by_name
from sphinx.pycode import ModuleAnalyzer

API = Path(__file__).parents[2] / "docs" / "reference" / "api"
"""Pages whose lists have every public name."""
PACKAGES = ("experiments", "colias_sim", "dsnn", "scenes")


def listed() -> list[str]:
    """Return the public names in full, in the order of the pages."""
    text = "\n".join(path.read_text(encoding="utf-8") for path in sorted(API.glob("*.md")))
    return re.findall(r"^   (\w+(?:\.\w+)+)$", text, re.MULTILINE)


@functools.cache
def public() -> dict[str, Any]:
    """Return the public names -> their objects."""
    return {name: import_by_name(name)[1] for name in listed()}


def links() -> dict[str, str]:
    """Return the words in types that are links -> what they link to: public classes, by either name.

    Names of Python's own types that numpydoc would look up elsewhere stay words; so do names of two classes.
    """
    classes = [name for name, thing in public().items() if inspect.isclass(thing)]
    short = {name.rpartition(".")[2]: name for name in reversed(classes)}
    twice = [name for name in classes if public()[name] is not public()[short[name.rpartition(".")[2]]]]
    short |= {word: word for word in (name.rpartition(".")[2] for name in twice)}
    return {word: word for word in DEFAULT_LINKS} | short | {name: name for name in classes}


def filenames() -> dict[str, str]:
    """Return the names of pages that would differ from another's in case alone, which some systems cannot tell."""
    lower = [name.lower() for name in public()]
    return {name: f"{name}-function" for name in public() if name.islower() and lower.count(name) > 1}


def fields() -> dict[str, str]:
    """Return each public dataclass -> its fields, with commas: the docstring has them, so members leave them out."""
    classes = {name: thing for name, thing in public().items() if dataclasses.is_dataclass(thing)}
    return {name: ", ".join(field.name for field in dataclasses.fields(thing)) for name, thing in classes.items()}


def constant(name: str) -> list[str]:
    """Return what stands below a public constant, wherever it is defined; empty if nothing does."""
    last = name.rpartition(".")[2]
    ours = [module for module in sorted(sys.modules) if module.partition(".")[0] in PACKAGES]
    for module in (module for module in ours if vars(sys.modules[module]).get(last) is public()[name]):
        if lines := ModuleAnalyzer.for_module(module).find_attr_docs().get(("", last)):
            return lines
    return []


def _on_docstring(app: Sphinx, what: str, name: str, thing: Any, options: Any, lines: list[str]) -> None:
    if what == "data":
        lines[:] = constant(name)


def _on_signature(
    app: Sphinx, what: str, name: str, thing: Any, options: Any, signature: str | None, returns: str | None
) -> tuple[str | None, str | None]:
    """Keep Python's signature, where numpydoc would look for one in the docstring; nobody makes a protocol."""
    return ("", None) if getattr(thing, "_is_protocol", False) else (signature, returns)


def setup(app: Sphinx) -> dict[str, bool]:
    """Connect to autodoc, before numpydoc."""
    app.connect("autodoc-process-docstring", _on_docstring, priority=400)
    app.connect("autodoc-process-signature", _on_signature, priority=400)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
