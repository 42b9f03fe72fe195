"""The files of `experiments.claims`: the ids of the claims that ship, without importing one.

A file ``c15_peak_speed.py`` holds claim C15. The paper's claims have the letter C, those about behaviours of our own
the letter B.
"""

from __future__ import annotations

import importlib
import pkgutil
import re
from collections.abc import Iterator, Mapping
from functools import cache
from types import ModuleType

from experiments.bench.run.errors import UsageError

PACKAGE = "experiments.claims"
PAPER, BEHAVIOURS = "C", "B"
"""The letters of the ids: claims of the paper, and of our own about behaviours."""
_NAME = re.compile(r"([a-z])0*(\d+)_\w+")
_BESIDE = ("readings", "of_models")
"""What stands beside the claims: their readings of the paper, and the claims of other models' papers."""


def claim_ids(letter: str = "") -> tuple[str, ...]:
    """Return the ids of the claims that ship, by letter and number, those of the paper first.

    Parameters
    ----------
    letter
        `PAPER` or `BEHAVIOURS`, of these alone.
    """
    return tuple(claim for claim in _modules() if claim.startswith(letter))


def claim_module(claim: str) -> ModuleType:
    """Return the module of one of `claim_ids`."""
    return importlib.import_module(f"{PACKAGE}.{_modules()[claim]}")


def _modules() -> Mapping[str, str]:
    """Id -> the name of its module, in the folders that the package has now."""
    return _numbered(tuple(importlib.import_module(PACKAGE).__path__))


@cache
def _numbered(folders: tuple[str, ...]) -> Mapping[str, str]:
    return {f"{letter}{number}": module for _, number, letter, module in sorted(_parts(folders))}


def _parts(folders: tuple[str, ...]) -> Iterator[tuple[bool, int, str, str]]:
    for module in pkgutil.iter_modules(folders):
        parts = _NAME.fullmatch(module.name)
        if parts:
            letter = parts[1].upper()
            yield letter != PAPER, int(parts[2]), letter, module.name
        elif module.name not in _BESIDE:
            raise UsageError(
                f"experiments/claims/{module.name}.py: its name begins with no claim's id, as c15_peak_speed.py does"
            )
