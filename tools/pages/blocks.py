"""Code blocks of the chapters as the tests read them, turned into what Sphinx knows.

People read a chapter on GitHub. tests/helpers/chapters.py reads it too, and runs its blocks. A block with
``title=NAME`` is a file, and gets its name as a caption; comments that are for the tests are left out.
"""

from __future__ import annotations

import re

from sphinx.application import Sphinx

_TITLE = re.compile(r"^```(?P<language>\w+) title=(?P<title>[\w.]+)$", re.MULTILINE)
_COMMENT = re.compile(r"^<!-- (?:test: [^\n]*?|measured: [^\n]*?|end of measured) -->\n", re.MULTILINE)


def _on_source_read(app: Sphinx, name: str, source: list[str]) -> None:
    text = _TITLE.sub(r"```{code-block} \g<language>\n:caption: \g<title>\n", source[0])
    source[0] = _COMMENT.sub("", text)


def setup(app: Sphinx) -> dict[str, bool]:
    """Rewrite every page when it is read."""
    app.connect("source-read", _on_source_read)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
