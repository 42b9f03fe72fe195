"""The paper's own figure and equation numbers, in place of the labels of its LaTeX source."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping
from functools import cache
from importlib.resources import files

KINDS: Mapping[str, str] = {"figures": "Fig.", "equations": "Eq."}


@cache
def numbers() -> Mapping[str, str]:
    """Label -> what the paper calls it, such as ``Fig. 12``; ``paper.toml`` says how the numbers are derived."""
    table = tomllib.loads(files("experiments.bench.judging").joinpath("paper.toml").read_text(encoding="utf-8"))
    return {
        label: f"{short} {number}" for kind, short in KINDS.items() for number, label in enumerate(table[kind], start=1)
    }


@cache
def _labels() -> re.Pattern[str]:
    longest = sorted(numbers(), key=len, reverse=True)
    return re.compile(rf"(?<![\w-])(?:{'|'.join(map(re.escape, longest))})(?![\w-])")


def cited(text: str) -> str:
    """Return a text with each label of the paper's source replaced by its number.

    Parameters
    ----------
    text
        Words about the paper, such as the source of a claim. Text without labels comes back as it is.

    Examples
    --------
    >>> cited("simu-clean-dth and its text; simu-sys-grayscale (c)")
    'Fig. 6 and its text; Fig. 12 (c)'
    """
    return _labels().sub(lambda found: numbers()[found[0]], text)
