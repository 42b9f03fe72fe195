"""Hooks of Sphinx that document a name: its docstring completed, and links."""

from __future__ import annotations

import dataclasses
import functools
import inspect
from typing import Any

from docutils import nodes
from numpydoc.xref import DEFAULT_LINKS
from sphinx.application import Sphinx
from sphinx.util.nodes import make_refnode

from tools.pages import docstrings, surface

FIRST = 400
"""Priority before that at which numpydoc reads a docstring, which it does at 500."""


@functools.cache
def _public() -> dict[str, object]:
    return surface.public()


def aliases() -> dict[str, str]:
    """Return the words in types that are links -> what they link to: public classes by either name.

    Names of Python's own types that numpydoc would look up elsewhere stay words.
    """
    classes = [name for name, thing in _public().items() if inspect.isclass(thing)]
    by_last_name = {name.rpartition(".")[2]: name for name in reversed(classes)}
    places = {place: name for place, name in surface.places(_public()).items() if name in classes and place != name}
    return {word: word for word in DEFAULT_LINKS} | by_last_name | {name: f"~{name}" for name in classes} | places


def filenames() -> dict[str, str]:
    """Return the names of pages that would differ from another's in case alone, which some systems cannot tell."""
    lower = [name.lower() for name in _public()]
    return {
        name: f"{name}-function"
        for name, thing in _public().items()
        if inspect.isfunction(thing) and lower.count(name.lower()) > 1
    }


def _find(name: str) -> Any:
    """Return a public object, or a method of one, by its name in full."""
    if name in _public():
        return _public()[name]
    owner, _, last = name.rpartition(".")
    return getattr(_public()[owner], last)


def _on_docstring(app: Sphinx, what: str, name: str, thing: Any, options: Any, lines: list[str]) -> None:
    if name in _public() and surface.is_constant(thing):
        lines[:] = docstrings.constant(name, thing).splitlines()
    elif what in ("function", "method", "class", "exception"):
        lines[:] = str(docstrings.completed(thing, "\n".join(lines), _find)).splitlines()


def _on_signature(
    app: Sphinx, what: str, name: str, thing: Any, options: Any, signature: str | None, returns: str | None
) -> tuple[str | None, str | None]:
    """Keep Python's signature, where numpydoc would look for one in the docstring; nobody makes a protocol."""
    return ("", None) if getattr(thing, "_is_protocol", False) else (signature, returns)


def left_out() -> dict[str, str]:
    """Return each public class -> its members that are left out, with commas: fields are among the parameters."""
    made_of = [(name, thing) for name, thing in _public().items() if isinstance(thing, type)]
    fields = {name: ", ".join(docstrings.fields(thing)) for name, thing in made_of if dataclasses.is_dataclass(thing)}
    return fields | {"colias_sim.envs.base.ColiasEnv": "options_type"}


def public_name(target: str) -> str | None:
    """Return the public name that a target of a link means: itself, where it is defined, or its last part if unique."""
    places = surface.places(_public())
    owner, _, last = target.rpartition(".")
    if target in _public() or target in places:
        return places.get(target, target)
    if owner in places:
        return f"{places[owner]}.{last}"
    ends = [name for name in _public() if name.endswith(f".{target}")]
    return ends[0] if len(ends) == 1 else None


def _on_missing(app: Sphinx, env: Any, node: Any, content: nodes.TextElement) -> nodes.reference | None:
    """Link a name by which no page knows an object."""
    name = public_name(node["reftarget"].lstrip("~.")) if node.get("refdomain") == "py" else None
    target = env.domains.python_domain.objects.get(name)
    return make_refnode(app.builder, node["refdoc"], target.docname, target.node_id, content, name) if target else None


def setup(app: Sphinx) -> dict[str, bool]:
    """Connect to autodoc and to the resolution of links."""
    for name, thing in _public().items():
        if inspect.isclass(thing):
            thing.__name__ = name.rpartition(".")[2]  # as it is imported; autodoc calls another name an alias
    app.connect("autodoc-process-docstring", _on_docstring, priority=FIRST)
    app.connect("autodoc-process-signature", _on_signature, priority=FIRST)
    app.connect("missing-reference", _on_missing)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
