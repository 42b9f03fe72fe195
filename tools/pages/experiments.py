"""Pages: the experiments that ship, in a table."""

from __future__ import annotations

from pathlib import Path

from experiments.kinds import registry
from experiments.kinds.tables import NAMES, OFFLINE
from tools.pages import markdown


def write(folder: Path) -> None:
    """Write the page into ``folder``."""
    rows = []
    for name in (*NAMES, *OFFLINE):
        experiment = registry.find(name)
        claims = [claim if isinstance(claim, str) else claim.id for claim in experiment.claims]
        shown = "clips" if name in OFFLINE else "robot"
        models = ", ".join(f"`{model}`" for model in experiment.models)
        rows.append((f"`{name}`", experiment.summary, shown, str(experiment.repeats), models, ", ".join(claims)))
    markdown.write(
        folder / "index.md",
        "# Experiments\n",
        "What [`colias run NAME`](../commands/index.md#colias-run) runs, with the robot or with clips.\n"
        "[Run and change experiments](../../how-to/run-experiments.md) changes and compares them,"
        " and [Write experiments](../../how-to/experiments-claims-and-arenas.md) declares another.\n"
        "`colias list parameters NAME` lists what `--set` changes, and"
        " [Results](../../results/index.md) has the claims.\n",
        markdown.table(("Experiment", "What it shows", "With", "Repeats", "Models", "Claims"), rows),
    )
