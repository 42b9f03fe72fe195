"""The leaderboard on the terminal."""

from __future__ import annotations

import math

from rich.markup import escape
from rich.table import Table

from experiments.bench.core.scores import Score, Standing
from experiments.bench.core.terminal import out_console
from experiments.bench.leaderboard.run import Board
from experiments.bench.leaderboard.scores import MEASURES, SORTED_BY

NOTES = (
    f"Sorted by {SORTED_BY}.",
    "Below each value its 95 % interval: of shares the exact one (Clopper and Pearson), of AUCs Newcombe's, both as if "
    "trials were independent; of times (medians of rounds) by order statistics.",
    "Direction: the strongest potential of either system has the right system and sign; two alike are no answer, so "
    "a model that saturates in both gets none right. Guessing gets 0.25.",
    "AUC: translation against motion in depth, by the largest |HS| or |VS|, of a looming detector by its potential: "
    "under 0.5 it prefers depth.",
    "False alarms: clips of background alone that made the model spike. A dash: does not apply, or no answer.",
)


def show(board: Board) -> None:
    """The table, what it means, and where everything is."""
    out_console.print(_table(board.standings))
    out_console.print()
    for note in NOTES:
        out_console.print(note, markup=False)
    out_console.print()
    for name, file in {"figure": "figure.png", "table": "leaderboard.csv"}.items():
        out_console.print(f"{name:<12}{board.folder / file}", soft_wrap=True, markup=False)


def _table(standings: list[Standing]) -> Table:
    """Two lines a model: the values, and below them their intervals."""
    table = Table(box=None, header_style="bold", pad_edge=False, collapse_padding=True)
    table.add_column("model", no_wrap=True)
    for heading in MEASURES.values():
        table.add_column("\n".join(heading.replace(",", "").split()), justify="right", no_wrap=True)
    for standing in standings:
        cells = (_said(name, standing.scores[name]) for name in MEASURES)
        table.add_row(escape(standing.name), *cells)
    return table


def _said(measure: str, score: Score | None) -> str:
    if score is None:
        return "-"
    form = ".0f" if measure.startswith("us_") else ".2f"
    interval = "-" if math.isnan(score.low) else f"{score.low:{form}}-{score.high:{form}}"
    return f"{score.value:{form}}\n[dim]{interval}[/dim]"
