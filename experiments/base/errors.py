"""Errors in one line: a wrong use, a trial that failed."""

import re
from collections.abc import Collection, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

from scenes.hints import nearest


class UsageError(ValueError):
    """A wrong use, in one line: the value given, its bounds, and the option or file that has it.

    Options are named as the command line names them: ``--set`` is the argument ``settings=`` of `experiments.run`.

    Parameters
    ----------
    text
        The line, with values as they were given: line breaks become spaces, and control characters are escaped.
    """

    def __init__(self, text: str) -> None:
        line = re.sub(r"\s*[\r\n\v\f]\s*", " ", text)
        super().__init__("".join(c if c.isprintable() else ascii(c)[1:-1] for c in line))


@contextmanager
def as_usage_error(before: str = "", after: str = "") -> Iterator[None]:
    """Raise a ``ValueError`` of the block as a `UsageError`, its text between two others."""
    try:
        yield
    except ValueError as error:
        raise UsageError(f"{before}{error}{after}") from error


class TrialError(RuntimeError):
    """A trial that could not be completed, and why."""


def check_known(what: str, name: str, known: Collection[str]) -> None:
    """Raise `UsageError` for a ``name``, of a ``what``, that is none of those known; it has the nearest of these."""
    if name not in known:
        raise UsageError(f"{what} '{name}'{nearest(name, known, ' (', ')')} must be one of {', '.join(known)}")


def check_unique(what: str, names: Sequence[str]) -> None:
    """Raise `UsageError` for a name that is there twice: ``what`` are called so."""
    if twice := next((name for name in names if names.count(name) > 1), None):
        raise UsageError(f"{what} are called '{twice}'; rename one of them")


def check_name(what: str, name: object) -> None:
    """Raise ``ValueError`` for a name, of a ``what``, that tables, figures and file names cannot show."""
    if not isinstance(name, str) or not re.fullmatch(r"[A-Za-z0-9][A-Za-z0-9_.-]*", name) or len(name) > 60:
        raise ValueError(f"{what} {short(name)}: a name must be up to 60 letters, digits, ., - and _")


def check_declared(name: Any, repeats: Any, models: Any) -> None:
    """Raise ``ValueError`` for a name, repeats or models that an experiment cannot have."""
    check_name("experiment", name)
    if not isinstance(repeats, int) or repeats < 1:
        raise ValueError(f"experiment {name}: repeats must be a whole number of 1 or more, got {short(repeats)}")
    if isinstance(models, str) or not models:
        raise ValueError(f"experiment {name}: models must be a tuple of one name or more, got {short(models)}")


def short(value: Any) -> str:
    """Return the beginning of a value in one line, enough to find it by."""
    text = " ".join(repr(value).split())
    return text if len(text) <= 80 else f"{text[:77]}..."
