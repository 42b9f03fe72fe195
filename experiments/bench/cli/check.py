"""The command ``colias check``. It imports what is heavy when it runs."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from experiments.bench.cli.options import EXIT_FAILED


def register(app: typer.Typer) -> None:
    """Put the command into ``app``."""
    app.command(short_help="Try the laws that every model, or stimulus, keeps on one, such as yours.")(check)


def check(
    model: Annotated[
        str,
        typer.Argument(metavar="MODEL", help="A name or a .py file; under other settings as dsnn:w_i=1,n_con=6."),
    ],
) -> int:
    """Try on a model, or a stimulus, what is taken for granted of any, and say what it breaks and how to mend it.

    Legal answers, reset, determinism, no hold on the caller's frame, silence in a still scene, mirror images, and
    refusal of frames of another shape; then what a frame costs. It takes the model's parameters for off-line tests.
    Of a file that declares a STIMULUS: bytes, order, seeds, shape, and that the truth agrees with what is painted.
    Exit status: 1 if a law is broken.
    """
    from experiments.bench.clips import stimuli
    from experiments.bench.conformance import laws, stimulus_laws, table
    from experiments.bench.conformance.notes import notes
    from experiments.bench.engine.models import ask
    from experiments.bench.engine.settings import watchers
    from experiments.bench.engine.user_code import declares, is_file
    from experiments.bench.leaderboard.timing import time_models

    source = ask(model).source
    if is_file(source) and declares(Path(source), "STIMULUS"):
        entry = stimuli.find(source)
        findings = stimulus_laws.check(entry)
        table.show(entry.name, findings, None)
        return EXIT_FAILED if any(finding.trouble for finding in findings) else 0
    (chosen,), _ = watchers((model,), ())
    findings = laws.check(chosen)
    taken = time_models([chosen], laws.SHAPE).get(chosen.label)
    table.show(chosen.label, findings, min(taken) if taken else None, notes(chosen))
    return EXIT_FAILED if any(finding.trouble for finding in findings) else 0
