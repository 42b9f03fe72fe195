"""Behaviours on the terminal."""

from __future__ import annotations

import shlex
from collections.abc import Sequence

from rich.table import Table

from colias_sim.envs import ENVS
from experiments.bench.closed_loop.run import Played
from experiments.bench.core.scores import Score, written
from experiments.bench.core.terminal import coloured, count, out_console
from experiments.bench.core.verdict import Verdict


def show(played: Played, recorded: bool) -> None:
    """The table of scores, and where everything is."""
    if played.standings:
        out_console.print(_table(played))
        out_console.print()
        note = ENVS[played.env].note
        out_console.print(f"{note} Below each value its 95 % interval over the episodes.".strip(), markup=False)
        out_console.print()
    places = {"table": str(played.folder / "scores.csv"), "episodes": str(played.folder / "trials.parquet")}
    if played.standings:
        places["figure"] = str(played.folder / "figure.png")
    if recorded:
        own = played.standings[0].name if played.standings else "the behaviour"
        places["recordings"] = f"colias view {shlex.quote(str(played.folder))}  (the episodes of {own})"
    for name, place in places.items():
        out_console.print(f"{name:<12}{place}", soft_wrap=True, markup=False)


def show_claims(claims: Sequence[Verdict]) -> None:
    """Our own claims, a line each."""
    if not claims:
        return
    table = Table(box=None, header_style="bold", pad_edge=False)
    for name in ("claim", "verdict", "we say"):
        table.add_column(name, no_wrap=name != "we say")
    for claim in claims:
        decided = f" (decided by: {claim.decided})" if claim.decided else ""
        table.add_row(claim.id, coloured(claim.verdict), f"{claim.says}: {claim.measured}{decided}")
    out_console.print()
    out_console.print(table)


def _table(played: Played) -> Table:
    """Two lines a behaviour: the values, and below them their intervals."""
    standings, short = played.standings, played.env.partition("/")[2]
    title = f"{short}, {count(len(standings[0].rows), 'episode')} each, the same worlds"
    table = Table(title=title, title_justify="left", box=None, header_style="bold", pad_edge=False)
    table.add_column("behaviour", no_wrap=True)
    measures = list(standings[0].scores)
    for name in measures:
        table.add_column(name, justify="right", no_wrap=True)
    for standing in standings:
        table.add_row(standing.name, *(_said(standing.scores.get(name)) for name in measures))
    return table


def _said(score: Score | None) -> str:
    if score is None:
        return "-"
    return f"{written(score.value)}\n[dim]{score.interval()}[/dim]"
