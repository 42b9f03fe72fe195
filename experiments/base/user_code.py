"""Run a user's own Python file and return what it declares."""

import builtins
import functools
import hashlib
import importlib.metadata
import importlib.util
import sys
import sysconfig
import threading
import traceback
from collections.abc import Mapping, Sequence
from importlib.machinery import PathFinder, SourceFileLoader
from pathlib import Path
from types import CodeType, ModuleType
from typing import Any, TypeVar
from urllib.parse import unquote

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
_HIDDEN_BY_NONE = sys.stdlib_module_names.union(PACKAGES)
_digests: dict[str, dict[str, str]] = {}
"""Name of a user's file as a module -> the SHA-256, by path, of it and of its folder's modules that it imported."""
Names = Mapping[str, object] | None
Kind = TypeVar("Kind")
_loading = threading.RLock()


def is_file(name: str) -> bool:
    """Return whether ``name`` means a file rather than something registered; MJCF is an arena's."""
    return name.endswith((".py", ".xml")) or "/" in name


def is_own(source: str) -> bool:
    """Return whether ``source`` means a user's own file, or a trained policy, rather than something registered."""
    return is_file(source) or source.endswith(".npz")


def declared(path: Path, name: str, *kinds: type[Kind]) -> Kind:
    """Return what the file at ``path`` declares as ``name``, an object of one of the ``kinds``.

    A file is executed once in a process, and again when it, or a module of its folder that it imports, has changed.
    It imports the modules of its folder, as a script does, but for those that have the name of one of Python's.

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
    value: Kind = getattr(module, name)
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
    return _digests.get(_name(path)) or {str(path): sha256(path)}


def _name(path: Path) -> str:
    """Return the name of a user's file as a module, from which any process finds it."""
    return USER_MODULE + str(path).replace("%", "%25").replace(".", "%2E")


def _module(path: Path) -> ModuleType:
    if path.suffix != ".py" or not path.is_file():
        raise UsageError(f"{path}: no such file, or its name does not end in .py")
    name = _name(path.resolve())
    with _loading:
        files = _digests.get(name, {})
        if any(not Path(file).is_file() or sha256(Path(file)) != digest for file, digest in files.items()):
            for old in [other for other in list(sys.modules) if other.partition(".")[0] == name]:
                del sys.modules[old]
            _digests[name] = {}
            importlib.invalidate_caches()
        try:
            return importlib.import_module(name)
        except SystemExit as error:
            status = error.code
    raise UsageError(f"{path}: sys.exit({status!r}) ends its import: put that under if __name__ == '__main__'")


class _UserFile(SourceFileLoader):
    """A user's file, which is a package, or a module of its folder, which is in that package.

    So it replaces no module of the caller's, two folders may have modules of one name, and none hides one of Python's.
    """

    @classmethod
    def find_spec(cls, name: str, path: Sequence[str] | None = None, target: ModuleType | None = None) -> Any:
        """Find a user's file by its name, or a module of its folder by the ``path`` of that; see `sys.meta_path`."""
        own, file = name.startswith(USER_MODULE), unquote(name.removeprefix(USER_MODULE))
        spec = PathFinder.find_spec(name, path, target) if own and path is not None else None
        if own and path is None:
            folder = str(Path(file).parent)
            spec = importlib.util.spec_from_file_location(name, file, submodule_search_locations=[folder])
            if folder not in sys.path:
                sys.path.append(folder)  # for what asks by name, such as a pickle; the last, so that it hides nothing
        if spec is not None and spec.has_location and spec.origin:
            _digests.setdefault(name.partition(".")[0], {})[spec.origin] = sha256(Path(spec.origin))
            spec.loader = cls(name, spec.origin) if isinstance(spec.loader, SourceFileLoader) else spec.loader
        return spec

    def exec_module(self, module: ModuleType) -> None:
        """Execute the file, whose ``import`` looks in its folder."""
        found = functools.partial(_imported, self.name.partition(".")[0])
        vars(module)["__builtins__"] = {**vars(builtins), "__import__": found}
        super().exec_module(module)

    def get_code(self, fullname: str) -> CodeType:
        """Compile the file: by time and size, as bytecode is told, an edit within a second is none."""
        return self.source_to_code(self.get_data(self.path), self.path)


sys.meta_path.insert(0, _UserFile)


def _imported(
    package: str, name: str, of: Names = None, local: Names = None, fromlist: Sequence[str] = (), level: int = 0
) -> ModuleType:
    """Import for the files of a folder: its modules are found first, but none that hides one of Python's or of ours."""
    first = name.partition(".")[0]
    if not level and first not in _HIDDEN_BY_NONE:
        own = importlib.util.find_spec(f"{package}.{first}")
        if own and (own.has_location or not getattr(importlib.util.find_spec(first), "has_location", False)):
            module = __import__(f"{package}.{name}", of, local, fromlist)
            return module if fromlist else sys.modules[f"{package}.{first}"]
    return __import__(name, of, local, fromlist, level)


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
