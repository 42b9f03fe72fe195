"""How functions are written: their length, and what they import."""

import ast
from collections.abc import Iterator
from functools import cache

import pytest

from tests.package.test_imports import modules, names, tree

MOST_LINES = 50
"""Lines of a function without its docstring."""
HEAVY = frozenset({
    "OpenGL", "av", "cffi", "cv2", "distributed", "gymnasium", "imageio_ffmpeg", "importlib.metadata", "jinja2", "loky",
    "matplotlib", "mujoco", "numpy", "numpydoc", "optuna", "polars", "pydantic", "pydantic_core", "rerun", "rich",
    "onnxruntime", "pettingzoo", "scipy", "stable_baselines3", "torch", "trimesh", "typer", "viser",
})  # fmt: skip
"""Libraries that take time to load. A function may import them, and modules of ours that load one."""
BEFORE_ALL = ("experiments", "experiments.cli.entry")
"""Modules that load before anything else does, Ctrl-C included."""
CHOOSES = "colias_sim.gl"
"""What chooses the renderer when it is imported."""

Function = ast.FunctionDef | ast.AsyncFunctionDef


def imports(node: ast.AST, *, lazy: bool, inside: bool = False) -> Iterator[str]:
    """What is imported within functions, or where a module loads."""
    for child in ast.iter_child_nodes(node):
        if isinstance(child, ast.Import | ast.ImportFrom):
            yield from names(child) if inside == lazy else ()
        elif not (isinstance(child, ast.If) and "TYPE_CHECKING" in ast.unparse(child.test)):
            yield from imports(child, lazy=lazy, inside=inside or isinstance(child, Function))


@cache
def heavy(name: str) -> bool:
    """Whether to import this loads one of the libraries, by whatever way."""
    if name not in modules():
        return name in HEAVY or name.partition(".")[0] in HEAVY
    return name == CHOOSES or any(heavy(other) for other in imports(tree(name), lazy=False) if other != name)


@pytest.mark.parametrize("module", sorted({*modules()} - {*BEFORE_ALL}))
def test_a_function_imports_what_is_heavy_alone(module):
    assert [name for name in imports(tree(module), lazy=True) if not heavy(name)] == []


@pytest.mark.parametrize("module", sorted(modules()))
def test_functions_are_short(module):
    for node in ast.walk(tree(module)):
        if isinstance(node, Function):
            lines = node.end_lineno - node.lineno + 1
            if ast.get_docstring(node):
                lines -= node.body[0].end_lineno - node.body[0].lineno + 1
            assert lines <= MOST_LINES, f"{node.name} has {lines} lines"
