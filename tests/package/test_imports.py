"""The direction of imports, read from the source: no circle anywhere, and no import against the direction."""

from __future__ import annotations

import ast
from collections.abc import Iterator, Mapping
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PACKAGES = ("scenes", "colias_sim", "dsnn", "experiments")

LAYERS = (
    "run stats report.terminal report.palette report.templates grid",
    "doctor new sources check",
    "study",
    "report measures replicates",
    "result",
    "compare",
    "trials offline",
    "registry behave watch",
    "tune leaderboard sweep robot_side",
    "sweep_plan",
    "fit train reproduce",
    "report.page api",
    "live",
    "cli",
)
"""Wings of ``experiments.bench``, the lowest first. A wing imports those of lower layers, and itself; those of the
lowest import each other."""
LEVELS = {f"experiments.bench.{name}": level for level, names in enumerate(LAYERS) for name in names.split()}

MAY_IMPORT: Mapping[str, frozenset[str]] = {
    "scenes": frozenset({"scenes"}),
    "colias_sim": frozenset({"scenes", "colias_sim", "dsnn"}),
    "dsnn": frozenset({"dsnn"}),
    "experiments": frozenset(PACKAGES),
}
"""Package -> the packages of ours that it may import."""


def files() -> list[Path]:
    return sorted(path for package in PACKAGES for path in (ROOT / package).rglob("*.py"))


def name_of(path: Path) -> str:
    return ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__")


@cache
def modules() -> Mapping[str, Path]:
    return {name_of(path): path for path in files()}


def statements(tree: ast.AST) -> Iterator[ast.Import | ast.ImportFrom]:
    """Every import, those of functions and of type checking too, but not those of a declaration's ``__main__`` tail."""
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, ast.If) and "__main__" in ast.unparse(node.test):
            continue
        if isinstance(node, ast.Import | ast.ImportFrom):
            yield node
        else:
            yield from statements(node)


@cache
def imported(module: str) -> frozenset[str]:
    """The modules of ours that a module imports."""
    imports: set[str] = set()
    for node in statements(ast.parse(modules()[module].read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        else:
            assert node.level == 0, f"{module}: relative imports hide the direction"
            names = [f"{node.module}.{alias.name}" for alias in node.names]
        for name in names:
            known = name if name in modules() else name.rpartition(".")[0]
            if known in modules():
                imports.add(known)
    return frozenset(imports - {module})


def test_no_module_comes_back_to_itself():
    """A circle of imports, at any depth, is named in full."""
    done: set[str] = set()

    def visit(module: str, way: tuple[str, ...]) -> None:
        assert module not in way, " -> ".join((*way[way.index(module) :], module))
        if module not in done:
            for target in sorted(imported(module)):
                visit(target, (*way, module))
            done.add(module)

    for module in modules():
        visit(module, ())


@pytest.mark.parametrize("package", PACKAGES)
def test_packages_import_one_way(package):
    """`colias_sim` knows no model, `dsnn` no simulator, and nothing the experiments."""
    for module in (m for m in modules() if m.split(".")[0] == package):
        for other in imported(module):
            assert other.split(".")[0] in MAY_IMPORT[package], f"{module} imports {other}"


def wing(module: str) -> str | None:
    """The narrowest wing that a module belongs to."""
    return max((name for name in LEVELS if f"{module}.".startswith(f"{name}.")), key=len, default=None)


def test_wings_import_one_way():
    """The foundation <- robot, clips <- tuning, leaderboard <- studies <- training, reproduce <- cli."""
    for module in modules():
        ours = wing(module)
        for other in imported(module):
            theirs = wing(other)
            if ours is None or theirs is None or ours == theirs or LEVELS[ours] == LEVELS[theirs] == 0:
                continue
            assert LEVELS[theirs] < LEVELS[ours], f"{module} imports {other}"
    outside = [m for m in modules() if wing(m) is None]
    for module in outside:
        cli = [other for other in imported(module) if wing(other) == "experiments.bench.cli"]
        assert not cli, f"{module} imports {cli}: only a declaration's tail may"
