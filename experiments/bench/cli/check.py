"""The command ``colias check``. It imports what is heavy when it runs."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from experiments.bench.cli.options import EXIT_FAILED
from scenes import ARENAS, arena_name


def check(
    model: Annotated[
        str,
        typer.Argument(metavar="MODEL", help="A name or a file; a model under other settings as dsnn:w_i=1,n_con=6."),
    ],
) -> int:
    """Try on a model, a stimulus or an arena what is taken for granted of any, and say what it breaks.

    Legal answers, reset, determinism, no hold on the caller's frame, silence in a still scene, mirror images, and
    refusal of frames of another shape; then what a frame costs. It takes the model's parameters for off-line tests.
    Of a stimulus, of a file its STIMULUS: bytes, order, seeds, shape, and that the truth agrees with what is painted.
    Of an arena, an .xml file or one that declares ARENA: that it can be read, stands in the room, leaves room for the
    robots, that the camera sees them, and the same pixels each time; and that the EXPERIMENT of that file fits into it.
    Exit status: 1 if a law is broken.
    """
    from dsnn.stimuli import STIMULI
    from experiments.bench.conformance import laws, stimulus_laws, table
    from experiments.bench.conformance.notes import notes
    from experiments.bench.leaderboard import time_models
    from experiments.bench.run.models import ask
    from experiments.bench.run.settings import watchers
    from experiments.bench.run.user_code import declares, is_file
    from experiments.bench.sources import clips as stimuli

    source = ask(model).source
    if source in ARENAS or source.endswith(".xml"):
        return _check_arena(source)
    if source in STIMULI or (is_file(source) and declares(Path(source), "STIMULUS")):
        entry = stimuli.find_stimulus(source)
        findings = stimulus_laws.check(entry)
        table.show(entry.name, findings, None)
        return EXIT_FAILED if any(finding.trouble for finding in findings) else 0
    if is_file(source) and declares(Path(source), "ARENA"):
        return _check_arena(source)
    (chosen,), _ = watchers((model,), ())
    findings = laws.check(chosen)
    taken = time_models([chosen], laws.SHAPE).get(chosen.label)
    table.show(chosen.label, findings, min(taken) if taken else None, notes(chosen))
    return EXIT_FAILED if any(finding.trouble for finding in findings) else 0


def _check_arena(source: str) -> int:
    """Try the laws on an arena, and its own trials where its file declares some."""
    from colias_sim.config import known_arena
    from experiments.bench import registry
    from experiments.bench.conformance import arena_laws, table
    from experiments.bench.conformance.laws import Finding
    from experiments.bench.run.errors import UsageError
    from experiments.bench.run.user_code import declares
    from experiments.bench.trials import plan

    try:
        findings = arena_laws.check(known_arena(source))
    except ValueError as error:
        raise UsageError(str(error)) from error
    if source.endswith(".py") and declares(Path(source), "EXPERIMENT") and not findings[-1].trouble:
        trouble = ""
        try:
            declared = registry.load(source)
            plan(declared, declared.models, [f"scene.arena={source}"], None, 0)
        except UsageError as error:
            trouble = str(error)
        findings.append(Finding("trials", "the trials of its file's EXPERIMENT fit into it, and are seen", trouble))
    table.show(arena_name(source), findings, None)
    return EXIT_FAILED if any(finding.trouble for finding in findings) else 0
