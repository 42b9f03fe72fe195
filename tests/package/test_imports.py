"""The direction of imports, read from the source: every package has a floor, and imports those below it alone."""

import ast
import importlib
import re
import subprocess
import sys
from collections.abc import Iterator, Mapping
from functools import cache
from pathlib import Path

import pytest

from experiments.kinds import tables

ROOT = Path(__file__).parents[2]
PACKAGES = ("scenes", "colias_sim", "dsnn", "experiments")

FLOORS = (
    "scenes", "dsnn.files", "dsnn.video", "dsnn.pictures", "dsnn.field_docs", "dsnn.snapshot", "colias_sim", "dsnn",
    "experiments.base", "experiments.declare", "experiments.settings", "experiments.store", "experiments.show",
    "experiments.judge", "experiments.draw", "experiments.robot", "experiments.kinds", "experiments.live",
    "experiments.cli", "experiments", "experiments.paper",
)  # fmt: skip
"""Packages and leaves, the lowest first. A module imports those of its own floor and of floors below it.

On the floor ``experiments`` stand the scripts, ``wiring`` and the face.
"""
BESIDE = ("dsnn", "colias_sim")
"""Two floors that do not know each other, but for the leaves of ``dsnn`` below both."""
NAMED = ("KINDS", "EXPERIMENTS", "BEHAVIOURS", "CLAIMS", "STUDIES", "PLANS")
"""The tables of strings that name modules of ours."""
WIRING = "experiments.wiring"
"""What `colias_sim` names by a string, for models and arenas that users write."""


def files() -> list[Path]:
    return sorted(path for package in PACKAGES for path in (ROOT / package).rglob("*.py"))


def name_of(path: Path) -> str:
    return ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__")


@cache
def modules() -> Mapping[str, Path]:
    return {name_of(path): path for path in files()}


def statements(whole: ast.AST) -> Iterator[ast.Import | ast.ImportFrom]:
    """Every import, those of functions and of type checking too, but not those of a declaration's ``__main__`` tail."""
    for node in ast.iter_child_nodes(whole):
        if isinstance(node, ast.If) and "__main__" in ast.unparse(node.test):
            continue
        if isinstance(node, ast.Import | ast.ImportFrom):
            yield node
        else:
            yield from statements(node)


@cache
def tree(module: str) -> ast.Module:
    return ast.parse(modules()[module].read_text(encoding="utf-8"))


def names(node: ast.Import | ast.ImportFrom) -> Iterator[str]:
    """The modules that a statement imports; of a name in one of them, that one."""
    for alias in node.names:
        whole = alias.name if isinstance(node, ast.Import) else f"{node.module}.{alias.name}"
        yield whole if isinstance(node, ast.Import) or whole in modules() else str(node.module)


@cache
def imported(module: str) -> frozenset[str]:
    """The modules of ours that a module imports."""
    found = list(statements(tree(module)))
    assert not any(node.level for node in found if isinstance(node, ast.ImportFrom)), f"{module}: relative imports"
    return frozenset(name for node in found for name in names(node) if name in modules()) - {module}


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


def floor(module: str) -> str:
    """The floor of a module: that of the narrowest name in `FLOORS`."""
    return max((name for name in FLOORS if f"{module}.".startswith(f"{name}.")), key=len)


@pytest.mark.parametrize("module", sorted(modules()))
def test_a_module_imports_floors_below_its_own(module):
    """No machinery imports the face: it stands above it. A declaration's ``__main__`` tail is not read."""
    ours = floor(module)
    for other in imported(module):
        theirs = floor(other)
        assert FLOORS.index(theirs) <= FLOORS.index(ours), f"{module} imports {other}"
        assert {ours, theirs} != set(BESIDE), f"{module} imports {other}"


def test_every_package_has_a_floor():
    """No package of ours is on the floor ``experiments`` by being forgotten."""
    there = {path.parent.name for path in (ROOT / "experiments").glob("*/__init__.py")}
    assert {f"experiments.{name}" for name in there} == {name for name in FLOORS if name.startswith("experiments.")}


def test_contributing_draws_the_imports_as_they_are():
    text = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    drawn = re.findall(r"^(\w+)/ .* imports ([\w, ]+)$", text, re.MULTILINE)
    ours = {package: {other.split(".")[0] for module in modules() if module.split(".")[0] == package
                      for other in imported(module)} - {package} for package in PACKAGES}  # fmt: skip
    assert {package: {*others.split(", ")} - {"nothing"} for package, others in drawn} == ours


def test_contributing_names_the_floors_in_their_order_and_where_things_are_added():
    """Where a recipe adds to a table, the file has it."""
    text = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    rows = text.split("| in `experiments/` |")[1].split("\n\n")[0].splitlines()[2:]
    named = ["experiments." + re.findall(r"`(\w+)/`", row)[0] for row in rows]
    assert named == [name for name in FLOORS if name.startswith("experiments.")]
    for row in text.split("| to add | write | and add it to |")[1].split("\n\n")[0].splitlines()[2:]:
        places = [ROOT / place for place in re.findall(r"`(\w+/[\w/.]*)`", row)]
        assert all(place.exists() for place in places), row
        for table in re.findall(r"`(_?[A-Z]+)`", row):
            files = [file for place in places for file in (place.glob("*.py") if place.is_dir() else [place])]
            assert any(re.search(rf"^{table}\b", file.read_text(), re.MULTILINE) for file in files), (table, row)


def strings(module: str) -> Iterator[str]:
    """Every string of a module that names a module of ours, with its attribute or without; docstrings are none."""
    prose = {id(node.value) for node in ast.walk(tree(module)) if isinstance(node, ast.Expr)}
    for node in ast.walk(tree(module)):
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in prose:
            name = re.fullmatch(r"([a-z_]+(?:\.[a-z_0-9]+)+)(?::[A-Za-z_]+)?", node.value)
            if name and name[1] in modules():
                yield node.value


def test_strings_that_name_modules_stand_in_the_tables():
    for module in modules():
        found = set(strings(module))
        if module == "experiments.kinds.tables":
            listed = {place for table in NAMED for place in getattr(tables, table).values()}
            assert found <= listed
        else:
            assert found <= ({WIRING} if floor(module) == "colias_sim" else set()), module


@pytest.mark.parametrize("table", NAMED)
def test_strings_of_the_tables_resolve(table):
    for place in getattr(tables, table).values():
        module, _, name = place.partition(":")
        assert not name or hasattr(importlib.import_module(module), name), place


def test_a_simulator_loads_leaves_of_dsnn_alone():
    """Nothing of a model is loaded by what simulates."""
    code = (
        "import sys, colias_sim.simulation, colias_sim.envs; print(*(m for m in sys.modules if m.startswith('dsnn.')))"
    )
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()
    assert set(loaded) <= {"dsnn.files", "dsnn.pictures", "dsnn.field_docs", "dsnn.snapshot"}


# What kind of run it is, is asked by kinds alone.

RUNS = ("Experiment", "OfflineExperiment", "Behaviour", "Study", "Fit")
OF_LIBRARIES = {"experiments.show.play": {"kind"}, "experiments.live.page": {"kind"}}
"""Attributes called ``kind`` of libraries: of `inspect.Parameter`, and of a mesh's visual in trimesh."""


def asks(module: str) -> Iterator[str]:
    """Where a module compares, matches or looks up the kind of a run, or asks what a declaration is an instance of."""
    for node in ast.walk(tree(module)):
        if isinstance(node, ast.Compare):
            inside = [node.left, *node.comparators]
        elif isinstance(node, ast.Match):
            inside = [node.subject]
        elif isinstance(node, ast.Subscript):
            inside = [node.slice]
        elif isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "isinstance":
            named = {one.id for one in ast.walk(node.args[1]) if isinstance(one, ast.Name)}
            if named & set(RUNS):
                yield ast.unparse(node)
            continue
        else:
            continue
        for part in inside:
            if isinstance(part, ast.Attribute) and part.attr == "kind" and "kind" not in OF_LIBRARIES.get(module, ()):
                yield ast.unparse(node)
            if isinstance(part, ast.Constant) and part.value == "kind" and isinstance(node, ast.Subscript):
                yield ast.unparse(node)


@pytest.mark.parametrize("module", sorted(name for name in modules() if name.startswith("experiments")))
def test_what_kind_of_run_it_is_is_asked_by_kinds_alone(module):
    if floor(module) not in ("experiments.kinds", "experiments.declare"):
        assert not list(asks(module))
