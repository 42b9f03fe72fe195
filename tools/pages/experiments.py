"""Pages: a page for each experiment that ships."""

from __future__ import annotations

import importlib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from dsnn import MODELS
from experiments import NAMES, OFFLINE
from experiments.bench import registry
from experiments.bench.sources.clips import Clip, OfflineExperiment
from experiments.bench.sources.experiment import Experiment
from experiments.bench.stats.claim import Claim, Words, words
from tools.pages import docstring_text, markdown
from tools.pages.markdown import code, prose, sentence, table
from tools.pages.parameter_tables import parameters, written

MOST_ROWS = 30
"""Largest number of rows of a table of clips."""


def write(folder: Path) -> None:
    """Write the pages into ``folder``."""
    for name in (*NAMES, *OFFLINE):
        _write_page(folder, registry.find(name))
    markdown.write(
        folder / "index.md",
        "# Experiments\n",
        "What [`colias run NAME`](../commands/run.md) runs.\n"
        "[Robot trials](../../robot-trials.md) says how to run, change and compare them,"
        " and [Your own experiment](../../your-own-experiment.md) how to declare another.\n",
        "## With the robot\n",
        _list(NAMES),
        "## With clips\n",
        _list(OFFLINE),
        markdown.toctree((*NAMES, *OFFLINE)),
    )


def _list(names: Sequence[str]) -> str:
    rows = ((f"[{code(name)}]({name}.md)", prose(sentence(registry.find(name).summary))) for name in names)
    return table(("Experiment", "What it shows"), rows)


def _write_page(folder: Path, experiment: Experiment | OfflineExperiment) -> None:
    name = experiment.name
    module = importlib.import_module(f"experiments.{name.replace('-', '_')}")
    parts = _clips(experiment) if isinstance(experiment, OfflineExperiment) else _trials(experiment)
    markdown.write(
        folder / f"{name}.md",
        f"# {name}\n",
        *(f"{text}\n" for text in docstring_text.paragraphs(module)),
        f"```text\ncolias run {name}\n```",
        _facts(experiment),
        *parts,
        _claims(experiment.claims),
    )


def _facts(experiment: Experiment | OfflineExperiment) -> str:
    if isinstance(experiment, OfflineExperiment):
        what, unit, amount = "Clips", "clip", len(experiment.clips)
    else:
        what, unit, amount = "Conditions", "condition", len(experiment.conditions())
    repeats = f"{experiment.repeats} of each {unit}"
    if experiment.repeats > 1:
        repeats += f", {amount * experiment.repeats} in all"
    rows = [
        (what, str(amount)),
        ("Repeats", repeats),
        ("Models", ", ".join(map(_model, experiment.models))),
    ]
    return table(("Experiment", code(experiment.name)), rows)


def _model(label: str) -> str:
    name = label.partition(":")[0]
    return f"[{code(label)}](../models/{name}.md)" if name in MODELS else code(label)


def _trials(experiment: Experiment) -> list[str]:
    rows = [
        (str(number), prose(condition.label())) for number, condition in enumerate(experiment.conditions(), start=1)
    ]
    return [
        "## Conditions\n",
        table(("", "Condition"), rows),
        "## Parameters\n",
        f"`--set experiment.NAME=VALUE` sets one; [`colias parameters {experiment.name}`](../commands/parameters.md)"
        " lists these and those of robot, camera, scene and models.\n",
        parameters(experiment.design),
    ]


def _clips(experiment: OfflineExperiment) -> list[str]:
    clips = experiment.clips
    rows = [(prose(clip.name), _stimulus(clip), ", ".join(map(_change, clip.changes))) for clip in clips[:MOST_ROWS]]
    more = f"and {len(clips) - MOST_ROWS} more.\n" if len(clips) > MOST_ROWS else ""
    return [
        "## Clips\n",
        table(("Clip", "Stimulus", "Set otherwise than its defaults"), rows),
        more,
    ]


def _stimulus(clip: Clip) -> str:
    trembles = f", trembling by {clip.jitter_px:g} px" if clip.jitter_px else ""
    return f"[{code(clip.entry.name)}](../stimuli/{clip.entry.name}.md){trembles}"


def _change(change: tuple[str, Any]) -> str:
    return code(f"{change[0]}={written(change[1])}")


def _says(claim: Words) -> str:
    return f"{claim.says} (the equations imply it: {claim.implied})" if claim.implied else claim.says


def _claims(claims: Sequence[str | Claim]) -> str:
    if not claims:
        return ""
    rows = [
        (code(claim), prose(_says(words(claim)))) if isinstance(claim, str) else (code(claim.id), prose(_says(claim)))
        for claim in claims
    ]
    text = "[What the numbers mean](../../what-the-numbers-mean.md) explains the verdicts."
    return "\n".join(["## Claims\n", table(("Claim", "It says"), rows), f"{text}\n"])
