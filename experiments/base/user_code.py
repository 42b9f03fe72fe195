"""Run a user's own Python file and return what it declares."""

from __future__ import annotations

import functools
import hashlib
import importlib.metadata
import importlib.util
import sys
import sysconfig
import threading
import traceback
from collections.abc import Mapping
from pathlib import Path
from types import ModuleType
from typing import Any

from experiments.base.errors import UsageError

_COMMANDS: Mapping[str, str] = {
    "EXPERIMENT": "colias run FILE",
    "STUDY": "colias sweep FILE",
    "MODEL": "--model FILE",
    "STIMULUS": "colias watch FILE",
    "BEHAVIOUR": "colias behave FILE",
    "ARENA": "--set scene.arena=FILE",
}
"""Name that a file can declare -> the command that takes it."""
USER_MODULE = "colias_user_"
"""Prefix of the names of modules made from users' files, so that two files may have one name."""
PACKAGES = ("colias_sim", "dsnn", "scenes", "experiments")
"""Packages of this project."""
_loaded: dict[Path, tuple[ModuleType, Mapping[str, str]]] = {}
"""A user's file -> its module, and the SHA-256, by path, of the file and of its folder's modules that it imported."""
_loading = threading.RLock()


def is_file(name: str) -> bool:
    """Return whether ``name`` means a file rather than something registered; MJCF is an arena's."""
    return name.endswith((".py", ".xml")) or "/" in name


def is_own(source: str) -> bool:
    """Return whether ``source`` means a user's own file, or a trained policy, rather than something registered."""
    return is_file(source) or source.endswith(".npz")


def declared(path: Path, name: str, *kinds: type) -> Any:
    """Return what the file at ``path`` declares as ``name``, an object of one of the ``kinds``.

    A file is executed once in a process, and again when it, or a module of its folder that it imports, has changed.
    Its folder comes first on ``sys.path``, as a script's does.

    Raises
    ------
    UsageError
        There is no such file, or it declares no such name, or something else by it.
    Exception
        Whatever the file raises.
    """
    module = _module(path)
    if not hasattr(module, name):
        others = [f", but {other}, which is for {use}" for other, use in _COMMANDS.items() if hasattr(module, other)]
        raise UsageError(f"{path}: declares no {name}{''.join(others[:1])}")
    value = getattr(module, name)
    if kinds and not isinstance(value, kinds):
        expected = " or ".join(kind.__name__ for kind in kinds)
        raise UsageError(f"{path}: {name} is a {type(value).__name__}, expected {expected}")
    return value


def named_file(declaring: Path, name: str, where: str) -> Path:
    """Return a file that a user's file names, in ``where``, by a path relative to itself; `UsageError` without one."""
    path = declaring.resolve().parent / name
    if not path.is_file():
        raise UsageError(f"{declaring}: {where}: {path}: no such file (a path is relative to the file that has it)")
    return path


def declares(path: Path, name: str) -> bool:
    """Return whether the file at ``path`` declares ``name``; `UsageError` as `declared` where there is no such file."""
    return hasattr(_module(path), name)


def digests(path: Path) -> Mapping[str, str]:
    """Return the SHA-256, by path, of a user's file and of the modules that it imported when it was executed here."""
    path = path.resolve()
    return _loaded[path][1] if path in _loaded else {str(path): sha256(path)}


def _module(path: Path) -> ModuleType:
    if path.suffix != ".py" or not path.is_file():
        raise UsageError(f"{path}: no such file, or its name does not end in .py")
    path = path.resolve()
    with _loading:
        if path not in _loaded or any(
            not Path(file).is_file() or sha256(Path(file)) != digest for file, digest in _loaded[path][1].items()
        ):
            _loaded[path] = _executed(path)
        return _loaded[path][0]


def _executed(path: Path) -> tuple[ModuleType, Mapping[str, str]]:
    """Execute a file; it imports the modules of its folder again."""
    name = f"{USER_MODULE}{hashlib.sha256(str(path).encode()).hexdigest()[:12]}"
    spec = importlib.util.spec_from_file_location(name, path)
    assert spec is not None and spec.loader is not None, "its name ends in .py"
    module = importlib.util.module_from_spec(spec)
    for folder in {path.parent, *(other.parent for other in _loaded)}:  # two folders may have a module of one name
        for other in _modules_in(folder):
            del sys.modules[other]
    bytecode = sys.dont_write_bytecode
    sys.path[:] = [str(path.parent), *(entry for entry in sys.path if entry != str(path.parent))]
    importlib.invalidate_caches()
    sys.dont_write_bytecode = True  # by time and size alone, an edit within a second could be taken for what it was
    sys.modules[name] = module
    try:
        spec.loader.exec_module(module)
    finally:
        sys.dont_write_bytecode = bytecode
    return module, {str(file): sha256(file) for file in sorted({path, *_modules_in(path.parent).values()})}


def _modules_in(folder: Path) -> dict[str, Path]:
    """Return the modules that are loaded from a user's folder and below it -> their files."""
    loaded = list(sys.modules.items())  # another thread may import something meanwhile
    files = {name: getattr(module, "__file__", None) for name, module in loaded}
    places = {
        name: _place(file)
        for name, file in files.items()
        if isinstance(file, str) and not name.startswith(("__main__", USER_MODULE))
    }
    return {name: place for name, place in places.items() if place.is_relative_to(folder) and is_users(place)}


_place = functools.cache(lambda file: Path(file).resolve())
"""Resolve a module's path, once: there are two thousand of them."""


def sha256(path: Path) -> str:
    """Return the digest of what the file holds now, as 64 hex digits."""
    return hashlib.sha256(path.read_bytes()).hexdigest()


def is_users(file: Path) -> bool:
    """Return whether the file at a resolved path is the user's own, not Python's, a package's or this project's."""
    installed = {"site-packages", "dist-packages"} & {*file.parts}
    others = (Path(sysconfig.get_path("stdlib")).resolve(), *package_folders().values())
    return file.is_file() and not installed and not any(map(file.is_relative_to, others))


@functools.cache
def package_folders() -> dict[str, Path]:
    """Return where this project's packages are, by name."""
    folders = {}
    for name in PACKAGES:
        spec = importlib.util.find_spec(name)
        if spec is not None and spec.submodule_search_locations:
            folders[name] = Path(next(iter(spec.submodule_search_locations))).resolve()
    return folders


def of_users(error: BaseException) -> bool:
    """Return whether an exception, or what led to it, went through a user's own file, or is that it cannot be read."""
    link: BaseException | None = error
    while link is not None:
        frames = (frame for frame, _ in traceback.walk_tb(link.__traceback__))
        if isinstance(link, SyntaxError) or any(USER_MODULE in str(f.f_globals.get("__name__")) for f in frames):
            return True
        link = link.__cause__ or link.__context__
    return False


def traced(error: BaseException) -> str:
    """Return the traceback of an exception."""
    return "".join(traceback.format_exception(error)).rstrip()


def run_main() -> None:
    """Run the experiment that the script ``python FILE [OPTIONS]`` declares, as ``colias run FILE`` does."""
    sys.argv[1:1] = ["run", str(sys.modules["__main__"].__file__)]
    # Found as the shell finds it: the commands stand on everything else.
    (command,) = importlib.metadata.entry_points(group="console_scripts", name="colias")
    command.load()()
