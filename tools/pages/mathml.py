"""Equations as MathML, which browsers draw themselves: no network, no script, no LaTeX.

Docutils has the converter; Sphinx has no renderer that uses it.
"""

from __future__ import annotations

from typing import Any

from docutils import nodes
from docutils.utils.math import MathError
from docutils.utils.math.latex2mathml import tex2mathml
from sphinx.application import Sphinx
from sphinx.errors import ExtensionError


def _converted(node: nodes.Element, *, block: bool) -> str:
    text = node.astext()
    try:
        return str(tex2mathml(text, as_block=block))
    except MathError as error:
        raise ExtensionError(f"an equation cannot be drawn as MathML: {text!r} ({error})") from error


def visit_inline(writer: Any, node: nodes.Element) -> None:
    """Write an equation within a line."""
    writer.body.append(_converted(node, block=False))
    raise nodes.SkipNode


def visit_display(writer: Any, node: nodes.Element) -> None:
    """Write an equation on a line of its own."""
    writer.body.append(f'<div class="equation">{_converted(node, block=True)}</div>\n')
    raise nodes.SkipNode


def setup(app: Sphinx) -> dict[str, bool]:
    """Offer the renderer to ``html_math_renderer``."""
    app.add_html_math_renderer("mathml", (visit_inline, None), (visit_display, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}
