"""The paper's own figure and equation numbers, in place of the labels of its LaTeX source."""

from __future__ import annotations

import re
from collections.abc import Mapping
from functools import cache

FIGURES = (
    "physiology",
    "motion-models",
    "dsn",
    "colias",
    "simu-clean",
    "simu-clean-dth",
    "simu-clean-dtv",
    "simu-nature-depth",
    "simu-nature-trans",
    "simu-sys-speed",
    "simu-sys-grayscale-mp",
    "simu-sys-grayscale",
    "real-world",
    "robot-exps-setting",
    "robot-general-tests",
    "robot-sys-trans",
    "robot-sys-ar",
)
EQUATIONS = (
    "high-pass",
    "two-gauss",
    "gauss-function",
    "polar-dogs",
    "halfwave",
    "fdsr-lowpass",
    "fdsr-subtraction",
    "medulla-HS-EI",
    "dynamic-lowpass",
    "medulla-VS-EI",
    "lobula-HS-EI",
    "lobula-VS-EI",
    "LPTCs",
    "sigmoid",
    "HS-VS",
    "spiking",
)
"""The labels of the paper's LaTeX source (arXiv 1808.07692), in the order in which its figures and numbered equations
stand there. LaTeX numbers both in that order, from 1: the source has no starred figure, no manual number and no
equation without a number. So the place of a label here is the number that the paper prints.
"""
LABELS: Mapping[str, tuple[str, ...]] = {"Fig.": FIGURES, "Eq.": EQUATIONS}


@cache
def numbers() -> Mapping[str, str]:
    """Return label -> what the paper calls it, such as ``Fig. 12``."""
    return {label: f"{kind} {n}" for kind, labels in LABELS.items() for n, label in enumerate(labels, start=1)}


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
    return _labels().sub(lambda match: numbers()[match[0]], text)
