"""Run a user's own Python file, which they asked for by name, and take what it declares."""

from __future__ import annotations

import ast
import contextlib
import contextvars
import difflib
import functools
import hashlib
import importlib.util
import os
import site
import sys
import sysconfig
import traceback
from collections.abc import Callable, Iterator, Mapping, Sequence
from importlib.machinery import PathFinder
from pathlib import Path
from types import MappingProxyType, ModuleType
from typing import TypeVar

from pydantic import ValidationError

from experiments.bench.core import interrupts
from experiments.bench.core.errors import UsageError, explain, explained, printable

USER_MODULE = "colias_user_"
"""What the names of modules made from users' files begin with."""

Result = TypeVar("Result")

_loaded: dict[str, Mapping[str, str]] = {}


def is_file(name: str) -> bool:
    """Whether ``name`` means a file rather than something registered."""
    return name.endswith(".py") or "/" in name


def is_own(source: str) -> bool:
    """Say whether ``source`` means a file of the user's own, a trained policy too, rather than something registered."""
    return is_file(source) or source.endswith(".npz")


def declared(path: Path, name: str) -> object:
    """What the file at ``path`` declares as ``name``.

    Modules beside the file can be imported, and what it defines can be found again by name, as dataclasses and
    pickles need. Raises `UsageError` on a file that cannot be read, has an error, or declares no such name.
    """
    if not path.is_file():
        raise UsageError(f"{path}: no such file")
    module = _module(path.resolve(), path)
    if not hasattr(module, name):
        raise UsageError(f"{path}: declares no {name}")
    return getattr(module, name)


def as_loaded(path: str) -> Mapping[str, str]:
    """SHA-256, by path, of a file that `declared` ran in this process, and of the modules of the user's own that it
    imports, as they were then; empty if it ran none at ``path``."""
    return _loaded.get(path, MappingProxyType({}))


def _module(path: Path, shown: Path) -> ModuleType:
    alias = USER_MODULE + path.stem
    known = sys.modules.get(alias)
    if known is not None and known.__file__ == str(path):
        return known
    spec = importlib.util.spec_from_file_location(alias, path)
    if spec is None or spec.loader is None:
        raise UsageError(f"{shown}: the file's name should end in .py")
    module = importlib.util.module_from_spec(spec)
    sys.modules[alias] = module
    if str(path.parent) not in sys.path:
        sys.path.append(str(path.parent))
    try:
        # Not by the loader, which may take what Python compiled of the file as it was up to a second ago.
        data = path.read_bytes()
        code = compile(data, str(path), "exec", dont_inherit=True)
        apart(lambda: exec(code, module.__dict__))
        _loaded[str(path)] = {**closure(path), str(path): hashlib.sha256(data).hexdigest()}
    except SyntaxError as error:
        del sys.modules[alias]
        raise UsageError(f"{shown}, line {error.lineno}: {error.msg}") from None
    except BaseException as error:  # SystemExit too: sys.exit in the file is no end of ours
        del sys.modules[alias]
        interrupts.pass_on(error)
        frames = traceback.extract_tb(error.__traceback__)
        lines = [frame.lineno for frame in frames if Path(frame.filename).resolve() == path]
        where = f", line {lines[-1]}" if lines else ""
        said = printable(explain(error)) if isinstance(error, ValidationError) else explained(error)
        raise UsageError(f"{shown}{where}: {said}") from None
    return module


def apart(call: Callable[[], Result]) -> Result:
    """Call a user's code, and put back what it changes of this process that others' files and numbers depend on.

    That are the current folder, what ``sys.stdout`` and its like are, NumPy's way with floating-point errors, and
    OpenCV's number of threads and fast paths.
    """
    folder, streams, cv2 = _folder(), (sys.stdin, sys.stdout, sys.stderr), sys.modules.get("cv2")
    switches = (cv2.getNumThreads(), cv2.useOptimized()) if cv2 else None
    try:
        return contextvars.copy_context().run(call)  # NumPy keeps what np.seterr says in the context
    finally:
        sys.stdin, sys.stdout, sys.stderr = streams
        if folder is not None and _folder() != folder:
            with contextlib.suppress(OSError):  # it is gone
                os.chdir(folder)
        if cv2 and switches and (cv2.getNumThreads(), cv2.useOptimized()) != switches:
            cv2.setNumThreads(switches[0])
            cv2.setUseOptimized(switches[1])


def _folder() -> str | None:
    try:
        return os.getcwd()  # noqa: PTH109  (at every frame: a path takes longer)
    except OSError:
        return None


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
    return Path(file).resolve() if isinstance(file, str) and is_users(Path(file).resolve()) else None


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


def place_of(error: BaseException) -> str:
    """The file and line of a user's own code where an exception was raised; empty where it was not in any."""
    called = (frame for frame in traceback.extract_tb(error.__traceback__) if is_users(Path(frame.filename)))
    last = next(iter(reversed(list(called))), None)
    return f"{Path(last.filename).name}, line {last.lineno}: " if last else ""


def blamed(error: Exception, rows: Sequence[Mapping[str, object]]) -> str:
    """Where a user's own judge raised an exception, and what; of a column that there is not, the nearest."""
    said = f"{place_of(error)}{explained(error)}"
    if isinstance(error, KeyError) and error.args and isinstance(error.args[0], str) and rows:
        (near,) = difflib.get_close_matches(error.args[0], [str(name) for name in rows[0]], n=1, cutoff=0.0)
        said += f" (nearest column: {near})"
    return said


def is_users(file: Path) -> bool:
    """Say whether the file at a resolved path is the user's own: of no installed package, and not of this project."""
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
