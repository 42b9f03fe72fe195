"""A user's own Python files as modules, each named by its path and by the contents of all that it is made of.

A file is made of itself and of the modules beside it that it imports. Two folders may therefore each have a
``helper.py``, an edited file is another module, and equal contents are executed once in a process. Python's own import
does the rest: it locks a module while it is executed, and finds again by name what dataclasses and pickles ask for.

What a file imports from elsewhere, by ``sys.path``, is Python's own module of that name. Such a name means one file in
a process, with the contents that it was first seen with: `check_elsewhere` refuses anything else.
"""

from __future__ import annotations

import ast
import builtins
import contextlib
import functools
import hashlib
import importlib
import importlib.util
import json
import re
import site
import sys
import sysconfig
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import EXTENSION_SUFFIXES, ModuleSpec, PathFinder
from pathlib import Path
from types import ModuleType
from typing import Any

from experiments.bench.engine.errors import UsageError

USER_MODULE = "colias_user_"
"""Prefix of the names of modules made from users' files."""

PACKAGES = ("colias_sim", "dsnn", "scenes", "experiments")
"""Packages of this project."""

INSTALLED = ("site-packages", "dist-packages")


@dataclass(frozen=True, slots=True)
class Unit:
    """A file, or a whole package, as it was read: what an import by one name of one folder gives.

    Attributes
    ----------
    path
        The file, or the package's folder.
    files
        Contents, by path, of the file, or of every Python file of the package.
    beside
        Name -> path of what it imports from the folder that it is in.
    elsewhere
        Dotted names of what it imports otherwise, and of what it gives ``import_module``, which is Python's own.
    """

    path: Path
    files: Mapping[Path, bytes]
    beside: Mapping[str, Path]
    elsewhere: frozenset[str]


@dataclass(frozen=True, slots=True)
class _Named:
    """A unit that can be imported, and the names of those beside it."""

    unit: Unit
    names: Mapping[Path, str]
    """Path of a unit that this one may import -> its module's full name."""
    resolved: dict[str, str] = field(default_factory=dict)
    """Name of an import -> the module's full name; empty where it is none of those beside the file."""

    def full_name(self, name: str) -> str:
        """Find the full name of the module that ``import name`` means; empty where Python's own import finds it."""
        if name not in self.resolved:
            known = {other.partition(".")[0] for other in self.unit.elsewhere}
            # A file that has come beside this one since it was read is not on the record.
            path = None if name in known else beside(self.unit.path.parent, name)
            if path is not None and path not in self.names:  # an import that no statement tells of
                self.resolved[name] = named(units(path))[path]
            else:
                self.resolved[name] = self.names[path] if path is not None else ""
        return self.resolved[name]


_known: dict[str, _Named] = {}
"""First part of a module's name -> what it names."""


def beside(folder: Path, name: str) -> Path | None:
    """Find what ``import name`` means in a file of a folder, where that is a file or a package of the same folder.

    Python's standard library and this project's packages come first, then the folder, then whatever ``sys.path`` has:
    so it is for a script, whose folder comes first there.

    Parameters
    ----------
    folder
        The folder, an absolute path.
    name
        A name without dots.

    Returns
    -------
    Path or None
        The file, or the package's folder; ``None`` where it is neither.
    """
    if name in PACKAGES or name in sys.stdlib_module_names or not name.isidentifier():
        return None
    package = folder / name
    if (package / "__init__.py").is_file():
        return package
    for ending in (*EXTENSION_SUFFIXES, ".py"):
        if (file := folder / f"{name}{ending}").is_file():
            return file
    if not package.is_dir():
        return None
    spec = PathFinder.find_spec(name)  # a folder without __init__.py comes after any module, wherever that is
    return package if spec is None or spec.origin is None else None


def units(path: Path) -> dict[Path, Unit]:
    """Read a file, and all that it imports from its own folder, and so on.

    Parameters
    ----------
    path
        An absolute, resolved path.

    Returns
    -------
    dict of Path to Unit
        By path, the file's own first.

    Raises
    ------
    OSError
        One cannot be read.
    """
    read: dict[Path, Unit] = {}
    waiting = [path]
    while waiting:
        place = waiting.pop()
        if place not in read:
            read[place] = _read(place)
            waiting += read[place].beside.values()
    return read


def _read(path: Path) -> Unit:
    package = path.is_dir()
    inside = sorted(file for file in path.rglob("*.py") if not file.name.startswith(".")) if package else [path]
    files = {file: file.read_bytes() for file in inside}
    names = {name for file, data in files.items() if file.suffix == ".py" for name in imported(data)}
    near, elsewhere = {}, set()
    for name in names:
        top = name.partition(".")[0]
        if package and top == path.name:
            continue
        place = beside(path.parent, top)
        if place is None:
            elsewhere.add(name)
        elif place != path:
            near[top] = place
    elsewhere.update(*(called(data, "import_module") for file, data in files.items() if file.suffix == ".py"))
    return Unit(path, files, near, frozenset(elsewhere))


@functools.lru_cache(maxsize=512)
def imported(data: bytes) -> frozenset[str]:
    """List the dotted names that a module's source imports by statements, each package and what is taken from it.

    A call ``__import__("name")`` is such a statement too. Relative imports are left out: they stay in the module's own
    package.
    """
    names = set(called(data, "__import__"))
    for statement in ast.walk(_parsed(data)):  # whoever runs what cannot be parsed is told
        if isinstance(statement, ast.Import):
            names.update(alias.name for alias in statement.names)
        elif isinstance(statement, ast.ImportFrom) and not statement.level and statement.module:
            names.add(statement.module)
            names.update(f"{statement.module}.{alias.name}" for alias in statement.names if alias.name != "*")
    return frozenset(prefix for name in names for prefix in _prefixes(name))


@functools.lru_cache(maxsize=512)
def called(data: bytes, function: str) -> frozenset[str]:
    """List the dotted names that a module's source gives, as texts, to a function that imports; relative ones not."""
    names: set[str] = set()
    for call in ast.walk(_parsed(data)):
        if isinstance(call, ast.Call) and call.args and isinstance(call.args[0], ast.Constant):
            name, by = call.args[0].value, call.func
            if function in (getattr(by, "id", ""), getattr(by, "attr", "")) and isinstance(name, str):
                names.add(name)
    return frozenset(prefix for name in names if not name.startswith(".") for prefix in _prefixes(name))


def _prefixes(name: str) -> Iterator[str]:
    parts = name.split(".")
    yield from (".".join(parts[: count + 1]) for count in range(len(parts)))


def named(read: Mapping[Path, Unit]) -> dict[Path, str]:
    """Give each unit its module's full name, by which it can be imported from now on.

    Parameters
    ----------
    read
        From `units`.

    Returns
    -------
    dict of Path to str
        By path. A name is that of the path and of the contents of all that the unit is made of.
    """
    names = {path: f"{USER_MODULE}{_key(path, read)}.{_stem(path)}" for path in read}
    for path, name in names.items():
        _known.setdefault(name.partition(".")[0], _Named(read[path], names))
    return names


def _key(path: Path, read: Mapping[Path, Unit]) -> str:
    """16 hex digits of the path of a unit and the contents of those that it reaches."""
    reached = {path}
    waiting = [path]
    while waiting:
        new = set(read[waiting.pop()].beside.values()) - reached
        reached |= new
        waiting += new
    made_of = [str(path), *(f"{file} {sha}" for file, sha in digests(read[module] for module in reached).items())]
    return hashlib.sha256(json.dumps(made_of).encode()).hexdigest()[:16]


def digests(read: Iterable[Unit]) -> dict[str, str]:
    """Return the SHA-256, by path, of every file of some units, in order of the paths."""
    files = {str(file): data for unit in read for file, data in unit.files.items()}
    return {file: hashlib.sha256(files[file]).hexdigest() for file in sorted(files)}


def _stem(path: Path) -> str:
    """Return the last part of a module's name: an extension's code asks for its own."""
    return re.sub(r"\W", "_", path.name.partition(".")[0] if path.suffix != ".py" else path.stem)


class _Finder(MetaPathFinder):
    """Finds modules by the names that `named` gave."""

    def find_spec(self, name: str, path: Sequence[str] | None, target: ModuleType | None = None) -> ModuleSpec | None:
        first, _, rest = name.partition(".")
        if not first.startswith(USER_MODULE) or first not in _known:
            return None
        if not rest:
            return ModuleSpec(name, None, is_package=True)  # an empty package: it only holds the name
        known = _known[first]
        stem, *inside = rest.split(".")
        place: Path | None = known.unit.path if stem == _stem(known.unit.path) else None
        for part in inside:
            place = _within(place, part) if place is not None else None
        return _spec(name, place, known) if place is not None else None


def _within(package: Path, name: str) -> Path | None:
    """Return the module or package of a name inside a package's folder."""
    places = [package / name, *(package / f"{name}{ending}" for ending in (*EXTENSION_SUFFIXES, ".py"))]
    if (places[0] / "__init__.py").is_file():
        return places[0]
    return next((place for place in [*places[1:], places[0]] if place.exists()), None)


def _spec(name: str, place: Path, known: _Named) -> ModuleSpec | None:
    folders = [str(place)] if place.is_dir() else None
    file = place / "__init__.py" if folders else place
    if folders and not file.is_file():
        spec = ModuleSpec(name, None, is_package=True)
        spec.submodule_search_locations = folders
        return spec
    loader = _Loader(file, known) if file.suffix == ".py" else None
    return importlib.util.spec_from_file_location(name, file, loader=loader, submodule_search_locations=folders)


class _Loader(Loader):
    """Executes a module's source as it was read, with an ``import`` that looks beside the file first."""

    def __init__(self, file: Path, known: _Named) -> None:
        self._file, self._known = file, known

    def create_module(self, spec: ModuleSpec) -> None:
        """Leave it to Python."""

    def exec_module(self, module: ModuleType) -> None:
        data = self._known.unit.files.get(self._file)
        code = compile(data if data is not None else self._file.read_bytes(), self._file, "exec", dont_inherit=True)
        # The statement `import` calls what the module's builtins name. So two folders' helpers have equal names.
        module.__dict__["__builtins__"] = {**vars(builtins), "__import__": _importer(self._known)}
        exec(code, module.__dict__)


def _importer(known: _Named) -> Callable[..., Any]:
    def load(name: str, globals: Any = None, locals: Any = None, fromlist: Any = (), level: int = 0) -> Any:
        package = str((globals or {}).get("__package__") or "")
        if level and package.startswith(USER_MODULE) and "." not in package:
            raise ImportError("attempted relative import with no known parent package")
        top, _, rest = name.partition(".")
        full = "" if level else known.full_name(top)
        if not full:
            return builtins.__import__(name, globals, locals, fromlist, level)
        whole = f"{full}.{rest}" if rest else full
        if fromlist:
            return builtins.__import__(whole, None, None, fromlist, 0)
        importlib.import_module(whole)
        return sys.modules[full]  # `import a.b` binds a

    return load


sys.meta_path.insert(0, _Finder())  # before that which looks into packages' folders


def plain_names(text: str) -> str:
    """Return a text with modules called as their user calls them."""
    return re.sub(rf"{USER_MODULE}[0-9a-f]{{16}}\.", "", text)


_first_seen: dict[str, tuple[ModuleSpec | None, str]] = {}
"""Path of a module of the user's own that Python imported -> its spec, which a reload renews, and its SHA-256 then.

There is no spec of a module that was only looked for yet: an import is about to execute it.
"""


class _Witness(MetaPathFinder):
    """Finds nothing: it notes what a module's file holds when Python is about to execute it."""

    def find_spec(self, name: str, path: Sequence[str] | None, target: ModuleType | None = None) -> None:
        top = name.partition(".")[0]
        if top in PACKAGES or top in sys.stdlib_module_names or top.startswith(USER_MODULE):
            return
        with contextlib.suppress(Exception):  # the import itself tells what is wrong
            spec = PathFinder.find_spec(name, path)
            if spec is not None and spec.origin is not None and spec.has_location:
                _witness(spec.origin, None)


def _witness(file: str, spec: ModuleSpec | None) -> None:
    if not set(INSTALLED) & set(Path(file).parts):
        place = Path(file).resolve()
        _first_seen[str(place)] = (spec, hashlib.sha256(place.read_bytes()).hexdigest())


def _witness_loaded() -> None:
    """Note the modules that were imported before this one: among them is the user's own that made us be imported."""
    for name, module in sys.modules.copy().items():
        file, top = getattr(module, "__file__", None), name.partition(".")[0]
        if isinstance(file, str) and top not in PACKAGES and top not in sys.stdlib_module_names:
            with contextlib.suppress(OSError):
                _witness(file, module.__spec__)


_witness_loaded()
sys.meta_path.insert(0, _Witness())


def elsewhere(names: Iterable[str]) -> dict[str, str]:
    """Hash the modules of the user's own that Python's own import finds, and those that they import.

    Parameters
    ----------
    names
        Dotted names.

    Returns
    -------
    dict of str to str
        SHA-256 by absolute path.

    Raises
    ------
    UsageError
        A module was edited after this process imported it.
    OSError
        A file cannot be read.
    """
    hashes: dict[str, str] = {}
    waiting = sorted(names)
    while waiting:
        name = waiting.pop()
        file = _own(name)
        if file is None or str(file) in hashes:
            continue
        data = file.read_bytes()
        hashes[str(file)] = hashlib.sha256(data).hexdigest()
        if file.suffix == ".py":
            waiting += sorted(_absolute(data, name, file))
    check_unedited(hashes)
    return hashes


def _absolute(data: bytes, name: str, file: Path) -> set[str]:
    """Return what a module outside of `units` imports: relative imports too, by their whole names."""
    package = name if file.name == "__init__.py" else name.rpartition(".")[0]
    names = set(imported(data))
    for statement in ast.walk(_parsed(data)):
        if isinstance(statement, ast.ImportFrom) and statement.level:
            above = package.split(".")[: len(package.split(".")) - statement.level + 1]
            base = ".".join([*filter(None, above), *([statement.module] if statement.module else [])])
            names |= {base, *(f"{base}.{alias.name}" for alias in statement.names)}
    return {prefix for name in names if name for prefix in _prefixes(name)}


def _parsed(data: bytes) -> ast.AST:
    try:
        return ast.parse(data)
    except (SyntaxError, ValueError, RecursionError):
        return ast.Module([], [])


def check_unedited(hashes: Mapping[str, str]) -> None:
    """Refuse a file that was edited after Python imported it: what runs is no longer what the file holds.

    What a file held at its import is known of modules that were imported after this one or that import it, and else
    from the first time on that this function is told of the file. A module that was reloaded is as its file is.

    Parameters
    ----------
    hashes
        SHA-256, by absolute path, of what the files hold now.

    Raises
    ------
    UsageError
        A file was edited.
    """
    endings = tuple(Path(path).name for path in hashes)  # to resolve the path of every module would take long
    for name, module in sys.modules.copy().items():  # another thread may be importing
        loaded = getattr(module, "__file__", None)
        if name.startswith(USER_MODULE) or not isinstance(loaded, str) or not loaded.endswith(endings):
            continue
        file = str(Path(loaded).resolve())
        if file not in hashes:
            continue
        spec, first = _first_seen.setdefault(file, (module.__spec__, hashes[file]))
        if first != hashes[file] and (spec is None or spec is module.__spec__):
            raise UsageError(f"{file}: was edited after this process imported it as {name}; start a new process")
        _first_seen[file] = (module.__spec__, hashes[file])


def check_elsewhere(names: Iterable[str], importer: Path) -> None:
    """Refuse a name that a file has just imported where ``sys.path`` would now give it another file.

    Parameters
    ----------
    names
        Dotted names that the file imports from elsewhere.
    importer
        The file, for the message.

    Raises
    ------
    UsageError
        A module of the user's own is loaded under such a name from another place.
    """
    for name in sorted({name.partition(".")[0] for name in names}):
        module = sys.modules.get(name)
        loaded = getattr(module, "__file__", None)
        if not isinstance(loaded, str) or not is_users(Path(loaded).resolve()):
            continue
        near = beside(importer.resolve().parent, name)  # what `import_module` is given may be beside the file
        spec = PathFinder.find_spec(name) if near is None else None
        meant = near / "__init__.py" if near is not None and near.is_dir() else near
        if spec is not None and spec.origin is not None:
            meant = Path(spec.origin)
        if meant is not None and not _is_at(module, meant.resolve()):
            problem = f"import {name}: this process has loaded {loaded} by that name, and {meant} is meant now"
            remedy = "put it beside the file that imports it" if near is None else "import it by a statement"
            raise UsageError(f"{importer}: {problem}; rename one of them, or {remedy}")


def _is_at(module: ModuleType | None, file: Path) -> bool:
    loaded = getattr(module, "__file__", None)
    return isinstance(loaded, str) and Path(loaded).resolve() == file


def _own(name: str) -> Path | None:
    """Return the file of the module called ``name``, if it is the user's own; found without importing it."""
    top = name.partition(".")[0]
    if top in PACKAGES or top in sys.stdlib_module_names:
        return None
    loaded = sys.modules.get(name)
    file = getattr(loaded, "__file__", None) if loaded is not None else _found(name)
    return Path(file).resolve() if isinstance(file, str) and is_users(Path(file).resolve()) else None


def _found(name: str) -> str | None:
    """Return where an import would find a module that is not loaded yet."""
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
    """Return where this project's packages are, by name."""
    folders = {}
    for name in PACKAGES:
        spec = importlib.util.find_spec(name)
        if spec is not None and spec.submodule_search_locations:
            folders[name] = Path(next(iter(spec.submodule_search_locations))).resolve()
    return folders
