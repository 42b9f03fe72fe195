"""The leaderboard on the terminal."""

from __future__ import annotations

import math
from collections.abc import Sequence

from rich.table import Table
from rich.text import Text

from experiments.bench.engine.terminal import out_console, show_table, stacked
from experiments.bench.leaderboard.kinds import Ranking
from experiments.bench.leaderboard.run import Board
from experiments.bench.stats.scores import Score


def show(board: Board) -> None:
    """Print the tables of each kind, what they mean, and where everything is."""
    for ranking in board.rankings:
        for measures in ranking.kind.tables:
            show_table(_table(ranking, measures))
            out_console.print()
        for note in ranking.kind.notes:
            out_console.print(note, markup=False)
        out_console.print()
    for ranking in board.rankings:
        kind = ranking.kind
        for name, file in {"figure": f"{kind.figure}.png", "table": kind.table}.items():
            out_console.print(f"{kind.name} {name:<8}{board.folder / file}", soft_wrap=True, markup=False)


def _table(ranking: Ranking, measures: Sequence[str]) -> Table:
    """Return two lines a model: the values, and below them their intervals."""
    table = Table(
        title=ranking.kind.name, title_justify="left", box=None, header_style="bold", pad_edge=False,
        collapse_padding=True,
    )  # fmt: skip
    table.add_column("model", no_wrap=True)
    for name in measures:
        heading = ranking.kind.measures[name]
        table.add_column("\n".join(heading.replace(",", "").split()), justify="right", no_wrap=True)
    for standing in ranking.standings:
        table.add_row(standing.name, *(_said(name, standing.scores[name]) for name in measures))
    return table


def _said(measure: str, score: Score | None) -> str | Text:
    if score is None:
        return "-"
    form = ".0f" if measure.startswith("us_") else ".1f" if measure.startswith("alarms_") else ".2f"
    interval = "-" if math.isnan(score.low) else f"{score.low:{form}}-{score.high:{form}}"
    return stacked(f"{score.value:{form}}", interval)
