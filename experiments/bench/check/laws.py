"""How a law is tried. It is a function of a model, a stimulus or an arena: its docstring says what it asks."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeVar

from pydantic import ValidationError

from experiments.bench.run.errors import explain
from experiments.bench.run.user_code import of_users, traced

T = TypeVar("T")


class LawBroken(ValueError):
    """A law is broken; the message says how, and how to mend it."""


def try_laws(laws: Sequence[Callable[[T], None]], subject: T) -> dict[Callable[[T], None], str]:
    """Try laws on a subject.

    Returns
    -------
    dict
        Law -> how it is broken, empty where it is kept: the message of a ``ValueError`` of ours, as `LawBroken` is one,
        or the traceback of what a user's own code raises, which breaks the law too.
    """
    troubles = {}
    for law in laws:
        try:
            law(subject)
            troubles[law] = ""
        except Exception as error:
            if isinstance(error, ValueError) and not of_users(error):
                troubles[law] = explain(error) if isinstance(error, ValidationError) else str(error)
            else:
                troubles[law] = traced(error)
    return troubles
