"""Several training seeds on the terminal."""

from __future__ import annotations

from rich.table import Table

from colias_sim.envs import ENVS
from experiments.bench.engine.terminal import count, out_console, show_line, show_places, show_table, stacked
from experiments.bench.stats.scores import written
from experiments.bench.training.scores import TRAINED
from experiments.bench.training.study import Studied

FEW = 10
"""Training seeds below which the interval is said to be too narrow."""


def show(studied: Studied) -> None:
    """Print each measure with its interval, and below the table what the intervals are of."""
    show_line(described(studied))
    out_console.print()
    show_table(_table(studied))
    out_console.print()
    for line in _notes(studied):
        out_console.print(line, markup=False)
    out_console.print()
    folder = studied.folder
    show_places({
        "table": folder / "policies.csv", "each seed": folder / "scores.csv", "figure": folder / "policies.png",
        "episodes": folder / "trials.parquet",
    })  # fmt: skip


def described(studied: Studied) -> str:
    """Return what the numbers are of, in a line: env and its options, training seeds, steps, episodes, libraries."""
    study, libraries = studied.study, ", ".join(f"{name} {version}" for name, version in studied.versions.items())
    seeds = f"{study.runs} training seeds ({study.seeds[0]} to {study.seeds[-1]})"
    trained = f"{study.steps():,} steps in {count(study.first.envs, 'env')}"
    judged = f"{count(studied.episodes, 'episode')} each"
    under = f"; trained and judged under {study.under()}" if study.under() else ""
    return f"{studied.env.partition('/')[2]}: {seeds} of {trained}{under}; {judged}; {libraries}"


def _table(studied: Studied) -> Table:
    """Return two lines a behaviour: the values, and below them their intervals."""
    table = Table(box=None, header_style="bold", pad_edge=False)
    table.add_column("behaviour", no_wrap=True)
    measures = list(studied.standings[0].scores)
    for name in measures:
        table.add_column(name, justify="right", no_wrap=True)
    for standing in studied.standings:
        scores = [standing.scores.get(name) for name in measures]
        cells = ["-" if score is None else stacked(written(score.value), score.interval()) for score in scores]
        table.add_row(standing.name, *cells)
    return table


def _notes(studied: Studied) -> list[str]:
    notes = [
        f"{TRAINED}: interquartile mean over training seeds, a seed's score being its mean over the episodes;"
        " 95 % interval by bootstrap over training seeds.",
        "The others: mean over the same episodes, 95 % interval over episodes.",
    ]
    if studied.study.runs < FEW:
        notes.append(f"{count(studied.study.runs, 'training seed')} are few: such intervals are too narrow.")
    return [*notes, *filter(None, [ENVS[studied.env].note.strip()])]
