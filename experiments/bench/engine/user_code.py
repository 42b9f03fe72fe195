"""Run a user's own Python file, which they asked for by name, and take what it declares."""

from __future__ import annotations

import contextlib
import contextvars
import hashlib
import importlib
import os
import sys
import traceback
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType, ModuleType
from typing import TypeVar

from pydantic import ValidationError

from dsnn.hints import closest
from experiments.bench.engine import interrupts, user_modules
from experiments.bench.engine.errors import UsageError, explain, explained, printable
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
        The file cannot be read, has an error, declares no such name, or imports a module of the user's own that is
        not what its name stands for in this process.
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
    try:
        module = apart(lambda: importlib.import_module(name))
    except BaseException as error:  # SystemExit too: sys.exit in the file is no end of ours
        interrupts.pass_on(error)
        raise UsageError(f"{path_shown}{_where(error, path)}") from None
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


def _where(error: BaseException, path: Path) -> str:
    """Return the line of the file at ``path`` where an exception came up while it was executed, and what it says."""
    if isinstance(error, SyntaxError) and error.filename == str(path):
        return f", line {error.lineno}: {error.msg}"
    lines = [frame.lineno for frame in traceback.extract_tb(error.__traceback__) if frame.filename == str(path)]
    where = f", line {lines[-1]}" if lines else ""
    if isinstance(error, SyntaxError) and error.filename:
        return f"{where}: {Path(error.filename).name}, line {error.lineno}: {error.msg}"
    text = explain(error) if isinstance(error, ValidationError) else explained(error)
    return f"{where}: {printable(user_modules.plain_names(text))}"


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


def place_of(error: BaseException) -> str:
    """Return the file and line of a user's own code where an exception was raised; empty where it was not in any."""
    called = (frame for frame in traceback.extract_tb(error.__traceback__) if is_users(Path(frame.filename)))
    last = next(iter(reversed(list(called))), None)
    return f"{Path(last.filename).name}, line {last.lineno}: " if last else ""


def blamed(error: BaseException, rows: Sequence[Mapping[str, object]]) -> str:
    """Return where a user's own judge raised an exception, and what; of a column that there is not, the nearest."""
    message = f"{place_of(error)}{explained(error)}"
    if isinstance(error, KeyError) and error.args and isinstance(error.args[0], str) and rows:
        near = closest(error.args[0], map(str, rows[0]))
        message += f" (nearest column: {near})" if near else ""
    return message
