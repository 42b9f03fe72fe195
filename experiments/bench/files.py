"""Run a user's own Python file, which they asked for by name, and take what it declares."""

from __future__ import annotations

import hashlib
import importlib.util
import re
import sys
import traceback
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType, ModuleType

from pydantic import ValidationError

from experiments.bench.own_files import closure

USER_MODULE = "colias_user_"
"""What the names of modules made from users' files begin with."""

_loaded: dict[str, Mapping[str, str]] = {}


class UsageError(Exception):
    """A wrong use, told in one line: what was given, what is legal, where it came from."""


LONGEST_NAME = 60


def check_name(what: str, name: object) -> None:
    """Raise ``ValueError`` for a name, of a ``what``, that tables, figures and file names cannot show."""
    if not isinstance(name, str) or not re.fullmatch(r"[A-Za-z0-9][A-Za-z0-9_.-]*", name) or len(name) > LONGEST_NAME:
        text = repr(name) if len(repr(name)) <= LONGEST_NAME else f"{repr(name)[:LONGEST_NAME]}..."
        raise ValueError(f"{what} {text}: legal in a name are up to {LONGEST_NAME} letters, digits, ., - and _")


def is_file(name: str) -> bool:
    """Whether ``name`` means a file rather than something registered."""
    return name.endswith(".py") or "/" in name


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
        exec(compile(data, str(path), "exec", dont_inherit=True), module.__dict__)
        _loaded[str(path)] = {**closure(path), str(path): hashlib.sha256(data).hexdigest()}
    except SyntaxError as error:
        del sys.modules[alias]
        raise UsageError(f"{shown}, line {error.lineno}: {error.msg}") from None
    except (Exception, SystemExit) as error:
        del sys.modules[alias]
        frames = traceback.extract_tb(error.__traceback__)
        lines = [frame.lineno for frame in frames if Path(frame.filename).resolve() == path]
        where = f", line {lines[-1]}" if lines else ""
        said = explain(error) if isinstance(error, ValidationError) else f"{type(error).__name__}: {error}"
        raise UsageError(f"{shown}{where}: {' '.join(said.split())}") from None
    return module


def explain(error: ValidationError) -> str:
    """The first problem of a failed validation in one line: object, attribute, value, bound."""
    problem = error.errors()[0]
    where = ".".join([error.title, *(str(part) for part in problem["loc"])])
    return f"{where}={problem['input']!r}: {problem['msg'][0].lower()}{problem['msg'][1:]}"


LONGEST_TROUBLE = 500
"""Characters of what is told of one failure."""


def explained(error: BaseException, said: str | None = None) -> str:
    """What an exception says, or ``said`` instead, in one line that begins with the exception's kind.

    The line has at most `LONGEST_TROUBLE` characters, and none that would steer a terminal.
    """
    kind, text = type(error).__name__, message(error) if said is None else said
    return printable(f"{kind}: {text}" if text else kind)


def message(error: BaseException) -> str:
    """The message of an exception; empty where it has none, or making it fails."""
    try:
        return str(error)
    except Exception:
        return ""


def printable(text: str, limit: int = LONGEST_TROUBLE) -> str:
    """``text`` in one line of at most ``limit`` characters, all of them printable."""
    line = " ".join(text[: 2 * limit].split())
    line = "".join(c if c.isprintable() else ascii(c)[1:-1] for c in line)
    return line if len(line) <= limit else f"{line[: limit - 3]}..."
