"""A user model's file as a case of the attack: its text, and what the project promises of it.

A case is a file's text. Unless it says otherwise it answers as `TWIN` does, and does its mischief besides, so that what
is left of it can be held against the honest twin's numbers.
"""

from __future__ import annotations

import textwrap
from dataclasses import dataclass
from pathlib import Path

WORKS = "works"
"""Its numbers are in the tables, and are its twin's."""
LOST = "loses its own part"
"""Its rows are missing, it is named with the reason, the others' rows are as they would be without it; status 1."""
REFUSED = "is refused"
"""One line, status 2, before anything runs."""
KILLS = "kills its process"
"""In workers the trial is lost, after its attempts, and the rest goes on; in the command itself all may end."""


@dataclass(frozen=True, slots=True)
class Case:
    """A model file ``name``.py that declares a model called ``label``; ``may`` are the outcomes that are right."""

    name: str
    text: str
    may: frozenset[str]
    label: str
    twin: str | None
    """Whose numbers its rows have where it works; ``None``: there is none."""
    close: float
    """By how much they may differ."""
    ignore: str
    """Columns with this in their name say what it is not asked for, and may hold anything that is a number."""
    leaves: str
    """A program of its own that may outlive the run: the bench cannot know of it."""

    def write(self, folder: Path) -> str:
        """Write the file; its name, to give to ``--model``."""
        (folder / f"{self.name}.py").write_bytes(self.text.encode("utf-8", "surrogateescape"))
        return f"{self.name}.py"


BASE = """
import ctypes, dataclasses, os, signal, subprocess, sys, threading, time
from dataclasses import dataclass, replace
from types import SimpleNamespace

import numpy as np

from dsnn import LayerMaps, ModelEntry, Response

LAST = int(os.environ.get("ATTACK_LAST", "-1"))  # the number of the last frame that the command shows
@TOP@

@dataclass(frozen=True)
class Parameters:
    t_sp: float = 0.02


def count(potential):
    return int(np.sign(potential)) * int(abs(potential) > 0.02)


class Model:
    def __init__(self, shape, parameters):
        self.shape, self.parameters = shape, parameters
        self.n, self.last = 0, None
@BUILD@

    def reset(self):
        self.n, self.last = 0, None
@RESET@

    def honest(self, frame):
        now = np.array(frame, np.float64)
        change = np.zeros(now.shape) if self.last is None else now - self.last
        self.last = now
        rows, columns = (size // 2 for size in now.shape)
        right, low = float(change[:, columns:].sum()), float(change[rows:].sum())
        return right / (1000.0 + abs(right)), low / (1000.0 + abs(low))

    def step(self, frame, *, channels="grey", maps=False):
        n, (hs, vs) = self.n, self.honest(frame)
        self.n += 1
        answer = Response(hs, vs, count(hs), count(vs))
@STEP@
        return answer


MODEL = ModelEntry(@NAME@, "a model of the attack", @MAKE@, Parameters()@ENTRY@)
"""


def model_text(name: str, *, top: str = "", build: str = "", reset: str = "", step: str = "", entry: str = "",
               make: str = "Model", label: object = None) -> str:  # fmt: skip
    """The text of a model file: `TWIN` with changes."""
    parts = {"TOP": top, "BUILD": _inner(build), "RESET": _inner(reset), "STEP": _inner(step), "MAKE": make}
    text = BASE
    for slot, given in {**parts, "NAME": repr(name if label is None else label), "ENTRY": entry}.items():
        text = text.replace(f"@{slot}@", given)
    return text


def _inner(code: str) -> str:
    return textwrap.indent(textwrap.dedent(code).strip("\n"), " " * 8)


def case(name: str, *may: str, twin: str | None = "twin", close: float = 0.0, ignore: str = "-",
         leaves: str = "", text: str | None = None,
         label: str | None = None, **changes: str) -> Case:  # fmt: skip
    """A case; ``changes`` are those of `made`, unless ``text`` is the whole file."""
    whole = model_text(name, label=label, **changes) if text is None else text  # type: ignore[arg-type]
    return Case(name, whole, frozenset(may), name if label is None else label, twin, close, ignore, leaves)
