"""The commands for what is your own: ``colias new`` and ``colias check``. Heavy imports happen when they run."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from experiments.bench.cli import options
from experiments.bench.new import KINDS, write
from scenes import ARENAS, arena_name

MOST_US = 1000.0
"""Largest cost of a model for a frame of 99x72, us, without a word: the robot's camera gives 30 frames a second."""


def new(
    kind: Annotated[str, typer.Argument(metavar="KIND", help=f"What the file has: {', '.join(KINDS)}.")],
    name: Annotated[
        str, typer.Argument(metavar="NAME", help="Its name: letters, digits, - and _. The file is NAME.py, - as _.")
    ],
) -> int:
    """Write a file to begin with into the current folder. It runs as it is; three comments say what to do next.

    Nothing is overwritten.
    """
    from experiments.bench.report.terminal import show_line

    path = write(kind, name, Path())
    summary, command = KINDS[kind]
    show_line(f"{path}: {summary}; its first lines say what to do next. Try it as it is:", 4)
    show_line(f"colias {command} {path}", 4)
    return 0


def check(
    model: Annotated[
        str,
        typer.Argument(metavar="MODEL", help="A name or a file; a model under other settings as dsnn:w_i=1,n_con=6."),
    ],
) -> int:
    """Try on a model, a stimulus or an arena what is taken for granted of any, and say what it breaks.

    Of a model, under its parameters for off-line tests: legal answers, reset, determinism, no hold on the caller's
    frame, silence in a still scene, mirror images, refusal of frames of another shape, and declared channels and
    thresholds; then what a frame costs.
    Of a stimulus, of a file its STIMULUS: bytes, order, seeds, shape, and that the truth agrees with what is painted.
    Of an arena, an .xml file or one that declares ARENA: that it can be read, stands in the room, leaves room for the
    robots, that the camera sees them, and the same pixels each time.
    Exit status: 1 if a law is broken.
    """
    from experiments.bench.check.laws import try_laws
    from experiments.bench.report.terminal import count, out_console, show_line

    label, laws, subject = _subject(model)
    troubles = try_laws(laws, subject)
    for law, trouble in troubles.items():
        *_, last = trouble.split("\n")  # of a traceback what was raised
        verdict = f"broken: {last}" if trouble else f"kept: {str(law.__doc__).splitlines()[0]}"
        show_line(f"{law.__name__:<13}{verdict}", 13)
    for traceback in {text.splitlines()[-1]: text for text in troubles.values() if "\n" in text}.values():
        out_console.print(traceback, soft_wrap=True, markup=False, highlight=False)
    if hasattr(subject, "network"):
        _show_cost(subject)
    broken = sum(map(bool, troubles.values()))
    summary = f"breaks {count(broken, 'law')} of {len(laws)}" if broken else f"keeps all {len(laws)} laws"
    out_console.print(f"{label} {summary}", markup=False)
    return options.EXIT_FAILED if broken else 0


def _subject(text: str) -> tuple[str, tuple[Any, ...], Any]:
    """Return what a name or a file means: its label, the laws of its kind, and what they are tried on."""
    from dsnn.stimuli import STIMULI
    from experiments.bench.check import arenas, models, stimuli
    from experiments.bench.run.models import ask
    from experiments.bench.run.settings import watchers
    from experiments.bench.run.user_code import declares, is_file
    from experiments.bench.sources.clips import find_stimulus

    source, _ = ask(text)

    def declared(name: str) -> bool:
        return is_file(source) and not source.endswith(".xml") and declares(Path(source), name)

    if source in ARENAS or source.endswith(".xml") or declared("ARENA"):
        return arena_name(source), arenas.LAWS, source if source in ARENAS else str(Path(source).resolve())
    if source in STIMULI or declared("STIMULUS"):
        entry = find_stimulus(source)
        return entry.name, stimuli.LAWS, entry
    (chosen,), _ = watchers((text,), ())
    return chosen.label, models.LAWS, chosen


def _show_cost(model: Any) -> None:
    """Print what a frame costs: of several rounds that of the fastest, as what else runs on the machine only adds."""
    from experiments.bench.check.models import SHAPE
    from experiments.bench.leaderboard import time_models
    from experiments.bench.report.terminal import out_console

    if taken := time_models([model], SHAPE).get(model.label):
        more = "; more than 1 ms: say why in its docstring" if min(taken) > MOST_US else ""
        line = f"{'cost':<13}{min(taken):.0f} us a frame at 99x72, in its fastest round{more}"
        out_console.print(line, markup=False)
