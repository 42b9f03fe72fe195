"""The kinds of files that ``colias new`` writes. A new one is a template ``KIND.py.j2`` beside this, and a line below.

A template is filled in with ``name``, as the tables show it, and ``stem``, the file's name without its ending. The file
runs as it is, and three numbered comments at its top have what to do next.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from types import MappingProxyType


@dataclass(frozen=True, slots=True)
class Kind:
    """A kind of file of one's own.

    Parameters
    ----------
    summary
        What the file has, in a few words.
    command
        The command that tries the file first: ``colias COMMAND FILE``.
    shipped
        Returns the names that are taken: those of this kind that ship.
    """

    summary: str
    command: str
    shipped: Callable[[], Iterable[str]]


def _models() -> Iterable[str]:
    from dsnn import MODELS

    return MODELS


def _experiments() -> Iterable[str]:
    from experiments import NAMES, OFFLINE

    return *NAMES, *OFFLINE


def _claims() -> Iterable[str]:
    from experiments.bench.stats.claim import claim_ids

    return claim_ids()


def _stimuli() -> Iterable[str]:
    from dsnn.stimuli import STIMULI

    return STIMULI


def _behaviours() -> Iterable[str]:
    from experiments.behaviours import BEHAVIOURS, GROUPS

    return *BEHAVIOURS, *GROUPS


def _arenas() -> Iterable[str]:
    from scenes import ARENAS

    return ARENAS


KINDS: Mapping[str, Kind] = MappingProxyType(
    {
        "model": Kind("a model of motion vision", "check", _models),
        "experiment": Kind("trials with the robot on a path of your own, and a claim", "run", _experiments),
        "claim": Kind("a claim, and the trials with the robot that it is judged on", "run", _claims),
        "stimulus": Kind("a synthetic stimulus, clips of it, and a claim about them", "check", _stimuli),
        "arena": Kind("a room with obstacles, for trials and envs", "check", _arenas),
        "behaviour": Kind("a reflex that drives the robot in an env", "behave", _behaviours),
    }
)
"""Kind, as the command line has it -> what it is."""
