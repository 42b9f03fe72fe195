"""Run a user's own Python file, which they asked for by name, and take what it declares."""

from __future__ import annotations

import contextlib
import contextvars
import hashlib
import importlib
import os
import sys
import traceback
from collections.abc import Callable, Mapping
from pathlib import Path
from types import MappingProxyType, ModuleType, TracebackType
from typing import TypeVar

from experiments.bench.engine import user_modules
from experiments.bench.engine.errors import UsageError, explained
from experiments.bench.engine.user_modules import is_users

Result = TypeVar("Result")

_COMMANDS: Mapping[str, str] = MappingProxyType(
    {
        "EXPERIMENT": "colias run FILE",
        "STUDY": "colias study FILE",
        "MODEL": "--model FILE",
        "STIMULUS": "colias play FILE",
        "BEHAVIOUR": "colias behave FILE",
        "ARENA": "--set scene.arena=FILE",
    }
)
"""What a file can declare -> where it is given."""
_loaded: dict[str, Mapping[str, str]] = {}


class NotDeclared(UsageError):
    """A file runs and declares something else."""


def is_file(name: str) -> bool:
    """Tell whether ``name`` means a file rather than something registered; MJCF is an arena's."""
    return name.endswith((".py", ".xml")) or "/" in name


def is_own(source: str) -> bool:
    """Say whether ``source`` means a file of the user's own, a trained policy too, rather than something registered."""
    return is_file(source) or source.endswith(".npz")


def declared(path: Path, name: str) -> object:
    """Take what the file at ``path``, as it is now, declares as ``name``.

    A file is executed once for each of its contents: see `user_modules`. Modules beside the file can be imported, and
    what it defines can be found again by name, as dataclasses and pickles need.

    Raises
    ------
    UsageError
        The file cannot be read, declares no such name, or imports a module of the user's own that is not what its name
        stands for in this process.
    Exception
        Whatever the file raises.
    """
    if not path.is_file():
        raise UsageError(f"{path}: no such file")
    if path.suffix != ".py":
        raise UsageError(f"{path}: the file's name should end in .py")
    module = _module(path.resolve(), path)
    if not hasattr(module, name):
        there = next((other for other in _COMMANDS if hasattr(module, other)), None)
        raise NotDeclared(
            f"{path}: declares no {name}{f', but {there}, which is for {_COMMANDS[there]}' if there else ''}"
        )
    return getattr(module, name)


def declares(path: Path, name: str) -> bool:
    """Tell whether the file at ``path`` declares ``name``; `UsageError` as `declared` where it cannot be run."""
    try:
        declared(path, name)
    except NotDeclared:
        return False
    return True


def as_loaded(path: str) -> Mapping[str, str]:
    """SHA-256, by path, of a file that `declared` ran in this process, and of the modules of the user's own that it
    imports, as they were then; empty if it ran none at ``path``."""
    return _loaded.get(path, MappingProxyType({}))


def _module(path: Path, path_shown: Path) -> ModuleType:
    try:
        units = user_modules.units(path)
    except OSError as error:
        raise UsageError(f"{path_shown}: cannot be read ({error.strerror})") from None
    name = user_modules.named(units)[path]
    others = frozenset(other for unit in units.values() for other in unit.elsewhere)
    first = name not in sys.modules
    module = apart(lambda: importlib.import_module(name))
    try:
        if first:
            user_modules.check_elsewhere(others, path_shown)
        near = user_modules.digests(units.values())
        _loaded[str(path)] = {**user_modules.elsewhere(others), **near}
        for file, digest in near.items():  # what was run itself before, and edited since, is what it is here
            if _loaded.get(file, near).get(file) != digest:
                _loaded.pop(file, None)
    except (UsageError, OSError) as error:
        sys.modules.pop(name, None)  # it is executed again at the next request, and refused again
        raise error if isinstance(error, UsageError) else UsageError(f"{path_shown}: {explained(error)}") from None
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


def sha256(path: Path) -> str:
    """Return the digest of what the file holds now, as 64 hex digits."""
    return hashlib.sha256(path.read_bytes()).hexdigest()


def closure(path: Path) -> dict[str, str]:
    """SHA-256, by absolute path, of the file at ``path`` and of every module of the user's own that it imports.

    Raises ``OSError`` where one cannot be read, and `UsageError` where one was edited after this process imported it.
    """
    units = user_modules.units(path.resolve())
    near = user_modules.digests(units.values())
    user_modules.check_unedited(near)
    others = {name for unit in units.values() for name in unit.elsewhere}
    return dict(sorted({**user_modules.elsewhere(others), **near}.items()))


def of_users(error: BaseException) -> BaseException | None:
    """Return what a user's own file raised, where that led to ``error``; ``None`` where no such file did."""
    link: BaseException | None = error
    while link is not None and not isinstance(link, SyntaxError) and _steps(link) is None:
        link = link.__cause__ or link.__context__
    return link


def traced(error: BaseException) -> str:
    """Return the traceback of an exception; of what a user's own file raised, from that file on."""
    own = of_users(error)
    shown, steps = (error, error.__traceback__) if own is None else (own, _steps(own))
    return "".join(traceback.format_exception(type(shown), shown, steps)).rstrip()


def _steps(error: BaseException) -> TracebackType | None:
    """Return the part of a traceback that begins in a user's own file; ``None`` where it passes none."""
    step = error.__traceback__
    while step is not None and not is_users(Path(step.tb_frame.f_code.co_filename)):
        step = step.tb_next
    return step
