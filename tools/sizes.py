"""Lines of code of the project, without docstrings, comments and blank lines: what it takes to read it.

``python -m tools.sizes`` counts the working tree; ``python -m tools.sizes REVISION`` counts that revision of git beside
it. Sizes are reported, and bound nothing.
"""

from __future__ import annotations

import argparse
import ast
import io
import subprocess
import tokenize
from collections import Counter
from collections.abc import Iterator, Mapping
from pathlib import Path, PurePosixPath

ROOT = Path(__file__).parents[1]
ROOMS = ("dsnn", "colias_sim", "scenes", "experiments", "tools", "benchmarks", "tests")
DATA = (".toml", ".j2", ".css", ".js", ".html")
"""Endings of data and templates. Their lines are counted apart, so that logic moved there is not lost from sight."""
SILENT = (tokenize.COMMENT, tokenize.NL, tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT, tokenize.ENCODING)


def code_lines(source: str) -> int:
    """Count the lines of a Python source that hold code.

    Parameters
    ----------
    source
        The text of a module.

    Returns
    -------
    int
        Lines with a token that is neither a comment nor part of a docstring. A string that stands alone, as after a
        constant, is a docstring too.

    Examples
    --------
    >>> code_lines('X = 1  # one\\n"What X is."\\n')
    1
    """
    texts: set[int] = set()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and isinstance(node.value.value, str):
            texts.update(range(node.lineno, (node.end_lineno or node.lineno) + 1))
    lines: set[int] = set()
    for token in tokenize.generate_tokens(io.StringIO(source).readline):
        if token.type not in (*SILENT, tokenize.ENDMARKER):
            lines.update(range(token.start[0], token.end[0] + 1))
    return len(lines - texts)


def sources(revision: str = "") -> Iterator[tuple[PurePosixPath, str]]:
    """Yield the path and the text of every counted file of the working tree, or of a revision of git."""
    listing = ["git", "ls-tree", "-r", "--name-only", revision] if revision else ["git", "ls-files"]
    names = subprocess.run(listing, cwd=ROOT, check=True, capture_output=True, text=True).stdout.splitlines()
    for name in names:
        path = PurePosixPath(name)
        if path.parts[0] not in ROOMS or path.suffix not in (".py", *DATA):
            continue
        if revision:
            command = ["git", "show", f"{revision}:{name}"]
            yield path, subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True).stdout
        elif (ROOT / path).is_file():
            yield path, (ROOT / path).read_text(encoding="utf-8")


def room(path: PurePosixPath) -> str:
    """Return the folder that a file is counted under: a package, a folder of ``experiments``, a wing of the bench."""
    if path.parts[0] != "experiments" or len(path.parts) == 2:
        return path.parts[0]
    return "/".join(path.parts[: 3 if path.parts[1] == "bench" and len(path.parts) > 3 else 2])


def sizes(revision: str = "") -> tuple[Mapping[str, int], Mapping[str, int]]:
    """Count lines of code, and of data and templates, by folder."""
    code: Counter[str] = Counter()
    data: Counter[str] = Counter()
    for path, text in sources(revision):
        lines = code_lines(text) if path.suffix == ".py" else sum(bool(line.strip()) for line in text.splitlines())
        for name in {room(path), path.parts[0]}:
            (code if path.suffix == ".py" else data)[name] += lines
    return code, data


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description="Lines of code, without docstrings, comments and blank lines.")
    parser.add_argument("revision", nargs="?", default="", help="a revision of git to stand beside the working tree")
    revision = parser.parse_args().revision
    code, data = sizes()
    before, data_before = sizes(revision) if revision else ({}, {})
    heads = [*([revision[:12]] if revision else []), "now", *(["change"] if revision else []), "data"]
    print(f"{'':34}" + "".join(f"{head:>14}" for head in heads))
    for name in sorted({*code, *before, *data}):
        now, data_now = code.get(name, 0), data.get(name, 0)
        cells = [f"{now:,}"]
        if revision:
            old = before.get(name, 0)
            cells = [f"{old:,}", *cells, f"{now / old - 1:+.0%}" if old else "new"]
        changed = f"{data_before.get(name, 0):,} to {data_now:,}" if revision else f"{data_now:,}"
        print(f"{name:34}" + "".join(f"{cell:>14}" for cell in (*cells, changed)))


if __name__ == "__main__":
    main()
