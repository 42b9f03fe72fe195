"""The commands for what is your own: ``colias new`` and ``colias check``. Heavy imports happen when they run."""

from pathlib import Path
from typing import Annotated, Any

import typer

from experiments.base.console import count, out_console
from experiments.cli import options
from experiments.cli.new import KINDS, write
from scenes import ARENAS, arena_name


def new(
    kind: Annotated[str, typer.Argument(metavar="KIND", help=f"What the file has: {', '.join(KINDS)}.")],
    name: Annotated[
        str, typer.Argument(metavar="NAME", help="Its name: letters, digits, - and _. The file is NAME.py, - as _.")
    ],
) -> int:
    """Write a file to begin with into the current folder. It runs as it is; three comments say what to do next.

    Nothing is overwritten.
    """
    path = write(kind, name, Path())
    summary, command = KINDS[kind]
    out_console.print(f"{path}: {summary}. Try it as it is:")
    out_console.print(f"colias {command} {path}")
    return 0


def check(
    model: Annotated[
        str,
        typer.Argument(metavar="MODEL", help="A name or a file; a model under other settings as dsnn:w_i=1,n_con=6."),
    ],
) -> int:
    """Try on a model, a stimulus or an arena what is taken for granted of any, and say what it breaks.

    A model, under its parameters for off-line tests: valid responses, reset, determinism, no hold on the caller's
    frame, silence in a still scene, mirror images, refusal of frames of another shape, and declared channels and
    thresholds. Then it is shown one clip and its controls: frozen, absent, mirrored and reversed.
    A stimulus, in a file its STIMULUS: bytes, order, seeds, shape, and that the truth agrees with what is painted.
    An arena, an .xml file or one that declares ARENA: that it can be read, stands in the room, leaves its middle free,
    and lets the camera see a robot.
    Exit status: 1 if a law is broken.
    """
    from experiments.cli.check import MODELS, answers, try_laws, vision

    label, laws, subject = _subject(model)
    troubles = try_laws(laws, subject)
    for law, trouble in troubles.items():
        *_, last = trouble.split("\n")  # of a traceback what was raised
        verdict = f"broken: {last}" if trouble else f"kept: {str(law.__doc__).splitlines()[0]}"
        out_console.print(f"{law.__name__:<13}{verdict}")
    for traceback in {text.splitlines()[-1]: text for text in troubles.values() if "\n" in text}.values():
        out_console.print(traceback)
    broken = sum(map(bool, troubles.values()))
    summary = f"breaks {count(broken, 'law')} of {len(laws)}" if broken else f"keeps all {len(laws)} laws"
    out_console.print(f"{label} {summary}")
    if laws is MODELS and not troubles[answers]:
        out_console.print("is it vision? one clip and its controls (words need trials: colias run general --controls):")
        out_console.print(*vision(subject), sep="\n")
    return options.EXIT_FAILED if broken else 0


def _subject(text: str) -> tuple[str, tuple[Any, ...], Any]:
    """Return what a name or a file means: its label, the laws of its kind, and what they are tried on."""
    from dsnn.stimuli import STIMULI
    from experiments.base.user_code import declares, is_file
    from experiments.cli import check
    from experiments.declare.clip import find_stimulus
    from experiments.settings.models import parse_model
    from experiments.settings.settings import watchers

    source, _ = parse_model(text)
    own = Path(source) if is_file(source) and not source.endswith(".xml") else None
    if source in ARENAS or source.endswith(".xml") or (own and declares(own, "ARENA")):
        return arena_name(source), check.ARENAS, source if source in ARENAS else str(Path(source).resolve())
    if source in STIMULI or (own and declares(own, "STIMULUS")):
        entry = find_stimulus(source)
        return entry.name, check.STIMULI, entry
    (chosen,) = watchers((text,))
    return chosen.label, check.MODELS, chosen
