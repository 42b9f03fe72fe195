"""Which files a user's own file is made of: itself, and the modules of theirs that it imports.

The rule: every ``import`` statement in the file counts, wherever it stands, also inside a function, and so do the
imports of the modules that it names. A module is the user's own unless it belongs to Python, to an installed
package, or to this project. What a file opens as data, or imports by a name that it computes, is not followed.
"""

from __future__ import annotations

import ast
import functools
import hashlib
import importlib.util
import site
import sys
import sysconfig
from collections.abc import Iterator
from importlib.machinery import PathFinder
from pathlib import Path

PACKAGES = ("colias_sim", "dsnn", "scenes", "experiments")
"""Those of this project."""
INSTALLED = ("site-packages", "dist-packages")


def sha256(path: Path) -> str:
    """Of what the file holds now, as 64 hex digits."""
    return hashlib.sha256(path.read_bytes()).hexdigest()


def closure(path: Path) -> dict[str, str]:
    """SHA-256, by absolute path, of the file at ``path`` and of every module of the user's own that it imports.

    Raises ``OSError`` where one cannot be read.
    """
    found: dict[str, str] = {}
    waiting = [(path.resolve(), "")]
    while waiting:
        file, name = waiting.pop()
        if str(file) in found:
            continue
        data = file.read_bytes()
        found[str(file)] = hashlib.sha256(data).hexdigest()
        if file.suffix == ".py":
            package = name if file.name == "__init__.py" else name.rpartition(".")[0]
            waiting += [(own, each) for each in _imports(data, package) if (own := _own(each)) is not None]
    return dict(sorted(found.items()))


def _imports(data: bytes, package: str) -> Iterator[str]:
    """Dotted names that a module's source imports, a package before what is in it; ``package`` is that it is in."""
    try:
        statements = list(ast.walk(ast.parse(data)))
    except (SyntaxError, ValueError, RecursionError):  # whoever runs it is told
        return
    for statement in statements:
        if isinstance(statement, ast.Import):
            for alias in statement.names:
                yield from _prefixes(alias.name)
        elif isinstance(statement, ast.ImportFrom):
            above = package.split(".")[: len(package.split(".")) - statement.level + 1] if statement.level else []
            base = ".".join([*filter(None, above), *([statement.module] if statement.module else [])])
            yield from _prefixes(base)
            yield from (f"{base}.{alias.name}".lstrip(".") for alias in statement.names if alias.name != "*")


def _prefixes(name: str) -> Iterator[str]:
    parts = name.split(".")
    yield from (".".join(parts[: count + 1]) for count in range(len(parts)) if name)


def _own(name: str) -> Path | None:
    """The file of the module called ``name``, if it is the user's own; found without importing it."""
    top = name.partition(".")[0]
    if top in PACKAGES or top in sys.stdlib_module_names:
        return None
    loaded = sys.modules.get(name)
    file = getattr(loaded, "__file__", None) if loaded is not None else _found(name)
    return Path(file).resolve() if isinstance(file, str) and _is_own(Path(file).resolve()) else None


def _found(name: str) -> str | None:
    """Where an import would find a module that is not loaded yet."""
    path: list[str] | None = None
    spec = None
    parts = name.split(".")
    for count in range(len(parts)):
        try:
            spec = PathFinder.find_spec(".".join(parts[: count + 1]), path)
        except (ImportError, ValueError):
            return None
        if spec is None:
            return None
        path = list(spec.submodule_search_locations or ())
    return spec.origin if spec is not None and spec.has_location else None


def _is_own(file: Path) -> bool:
    return (
        file.is_file()
        and not set(INSTALLED) & set(file.parts)
        and not any(file.is_relative_to(place) for place in _foreign())
    )


@functools.cache
def _foreign() -> tuple[Path, ...]:
    """Folders whose modules are not a user's own: Python's, those of installed packages, this project's."""
    paths = sysconfig.get_paths()
    places = [paths[name] for name in ("stdlib", "platstdlib", "purelib", "platlib")]
    places += [*site.getsitepackages(), site.getusersitepackages()]
    return (*(Path(place).resolve() for place in places), *package_folders().values())


@functools.cache
def package_folders() -> dict[str, Path]:
    """Where this project's packages are, by name."""
    folders = {}
    for name in PACKAGES:
        spec = importlib.util.find_spec(name)
        if spec is not None and spec.submodule_search_locations:
            folders[name] = Path(next(iter(spec.submodule_search_locations))).resolve()
    return folders
