"""Pages: the experiments that ship, in a table."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from experiments import NAMES, OFFLINE
from experiments.bench import registry
from experiments.bench.sources.clips import OfflineExperiment
from tools.pages import markdown
from tools.pages.markdown import code, prose, sentence, table


def write(folder: Path) -> None:
    """Write the page into ``folder``."""
    markdown.write(
        folder / "index.md",
        "# Experiments\n",
        "What [`colias run NAME`](../commands/run.md) runs.\n"
        "[Run and change experiments](../../how-to/run-experiments.md) changes and compares them,"
        " and [Write experiments](../../how-to/experiments-claims-and-arenas.md) declares another.\n"
        "`colias list parameters NAME` lists what `--set` changes, and [Results](../../results.md) has the claims.\n",
        "## With the robot\n",
        _table(NAMES),
        "## With clips\n",
        _table(OFFLINE),
    )


def _table(names: Sequence[str]) -> str:
    rows = []
    for name in names:
        experiment = registry.find(name)
        shown = experiment.clips if isinstance(experiment, OfflineExperiment) else experiment.conditions()
        claims = [claim if isinstance(claim, str) else claim.id for claim in experiment.claims]
        rows.append((code(name), prose(sentence(experiment.summary)), f"{experiment.repeats} of {len(shown)}",
                     ", ".join(map(code, experiment.models)), ", ".join(claims)))  # fmt: skip
    return table(("Experiment", "What it shows", "Repeats of each condition or clip", "Models", "Claims"), rows)
