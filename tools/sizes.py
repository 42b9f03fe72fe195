"""Sizes of the project: code lines by budget, files, record types, public names and command-line options.

``python -m tools.sizes`` prints those of the working tree, and ``--check`` fails where a budget of ``pyproject.toml``
(``[tool.colias.budget]``) is exceeded.
"""

import argparse
import ast
import io
import subprocess
import tokenize
import tomllib
from collections import Counter
from collections.abc import Iterator
from pathlib import Path, PurePosixPath

ROOT = Path(__file__).parents[1]
BUDGET = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["colias"]["budget"]
DATA = {".c", ".h", ".ld", ".js", ".mjs", ".ts", ".css", ".html", ".j2", ".rst", ".yml", ".yaml", ".toml", ".xml"}
SILENT = {tokenize.COMMENT, tokenize.NL, tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT, tokenize.ENDMARKER}
RECORDS = {"dataclass", "TypedDict", "NamedTuple", "BaseModel"}


def code_lines(source: str) -> int:
    """Count the lines of a Python source that hold code: no docstrings, attributes' docstrings, comments or blanks."""
    texts: set[int] = set()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and isinstance(node.value.value, str):
            texts.update(range(node.lineno, (node.end_lineno or node.lineno) + 1))
    lines: set[int] = set()
    for token in tokenize.generate_tokens(io.StringIO(source).readline):
        if token.type not in SILENT:
            lines.update(range(token.start[0], token.end[0] + 1))
    return len(lines - texts)


def names(source: str) -> Counter[str]:
    """Count a module's record types, public names (classes, functions and constants) and command-line options."""
    tree = ast.parse(source)
    calls = [ast.unparse(node.func) for node in ast.walk(tree) if isinstance(node, ast.Call)]
    classes = [node for node in ast.walk(tree) if isinstance(node, ast.ClassDef)]
    marks = [[*node.bases, *node.decorator_list] for node in classes]
    records = [any(RECORDS & set(ast.unparse(mark).replace("(", ".").split(".")) for mark in found) for found in marks]
    public = [node.name for node in tree.body if isinstance(node, ast.ClassDef | ast.FunctionDef)]
    for node in tree.body:
        if isinstance(node, ast.Assign | ast.AnnAssign):
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
            public += [target.id for target in targets if isinstance(target, ast.Name)]
    return Counter(
        {
            "record types": sum(records),
            "public names": sum(not name.startswith("_") for name in public),
            "options": sum(call.split(".")[-1] in ("Option", "Argument", "add_argument") for call in calls),
        }
    )


def sources() -> Iterator[tuple[PurePosixPath, str]]:
    """Yield path and text of each tracked file that counts, as the working tree has it."""
    output = subprocess.run(["git", "ls-files"], cwd=ROOT, check=True, capture_output=True, text=True).stdout
    for path in map(PurePosixPath, output.splitlines()):
        if path.suffix in {".py", *DATA} and (ROOT / path).is_file():
            yield path, (ROOT / path).read_text(encoding="utf-8")


def sizes() -> dict[str, Counter[str]]:
    """Count files, lines and names of each budget."""
    counts = {name: Counter[str]() for name in BUDGET}
    for path, text in sources():
        if path.suffix in DATA:
            counts["data"].update({"files": 1, "lines": len(text.splitlines())})
            continue
        for name in (name for name, budget in BUDGET.items() if path.parts[0] in budget["folders"]):
            counts[name].update({"files": 1, "lines": code_lines(text)} | names(text))
    return counts


def main() -> None:
    """Print the table; with ``--check``, exit with 1 where a budget is exceeded."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--check", action="store_true", help="fail where a budget is exceeded")
    asked = parser.parse_args()
    now = sizes()
    heads = ("lines", "files", "record types", "public names", "options")
    print(f"{'':22}" + "".join(f"{head:>16}" for head in heads) + f"{'ceiling':>10}")
    for name, counts in now.items():
        cells = [f"{counts[head]:,}" for head in heads]
        print(f"{name:22}" + "".join(f"{cell:>16}" for cell in cells) + f"{BUDGET[name]['ceiling']:>10,}")
    over = [
        f"{name} must have at most {budget['ceiling']} lines"
        for name, budget in BUDGET.items() if now[name]["lines"] > budget["ceiling"]
    ]  # fmt: skip
    if over and asked.check:
        raise SystemExit("\n".join(over))


if __name__ == "__main__":
    main()
