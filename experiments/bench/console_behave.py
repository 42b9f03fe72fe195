"""Behaviours on the terminal."""

from __future__ import annotations

import shlex
from collections.abc import Sequence

from rich.table import Table

from experiments.bench.behave import Played, Standing
from experiments.bench.behaviour_claims import BehaviourClaim
from experiments.bench.console import count, out_console
from experiments.bench.episode_scores import Score, written

NOTES = {
    "colias_sim/Avoidance-v0": "An episode ends with its first collision. Intervals are those of Poisson rates.",
    "colias_sim/Fixation-v0": "Time on target: the share of frames with the target within 35 degrees of the axis.",
    "colias_sim/Optomotor-v0": "Gain: 0 for a robot that does nothing, 1 for one whose view never turns.",
    "colias_sim/Pursuit-v0": "Time on target: the share of frames with the target within 35 degrees of the axis.",
}


def show(played: Played, recorded: bool) -> None:
    """The table of scores, and where everything is."""
    if played.standings:
        out_console.print(_table(played.standings))
        out_console.print()
        note = NOTES.get(played.standings[0].env, "")
        out_console.print(f"{note} Below each value its 95 % interval over the episodes.".strip(), markup=False)
        out_console.print()
    places = {"table": str(played.folder / "scores.csv"), "episodes": str(played.folder / "trials.parquet")}
    if played.standings:
        places["figure"] = str(played.folder / "figure.png")
    if recorded:
        own = played.standings[0].behaviour if played.standings else "the behaviour"
        places["recordings"] = f"colias view {shlex.quote(str(played.folder))}  (the episodes of {own})"
    for name, place in places.items():
        out_console.print(f"{name:<12}{place}", soft_wrap=True, markup=False)


def show_claims(claims: Sequence[BehaviourClaim]) -> None:
    """Our own claims, a line each."""
    if not claims:
        return
    table = Table(box=None, header_style="bold", pad_edge=False)
    for name in ("claim", "verdict", "we say"):
        table.add_column(name, no_wrap=name != "we say")
    for claim in claims:
        colour = {"holds": "green", "fails": "red", "untested": "yellow"}[claim.verdict]
        decided = f" (decided by: {claim.decided})" if claim.decided else ""
        table.add_row(claim.id, f"[{colour}]{claim.verdict}[/{colour}]", f"{claim.says}: {claim.measured}{decided}")
    out_console.print()
    out_console.print(table)


def _table(standings: list[Standing]) -> Table:
    """Two lines a behaviour: the values, and below them their intervals."""
    short = standings[0].env.partition("/")[2]
    title = f"{short}, {count(len(standings[0].rows), 'episode')} each, the same worlds"
    table = Table(title=title, title_justify="left", box=None, header_style="bold", pad_edge=False)
    table.add_column("behaviour", no_wrap=True)
    measures = list(standings[0].scores)
    for name in measures:
        table.add_column(name, justify="right", no_wrap=True)
    for standing in standings:
        table.add_row(standing.behaviour, *(_said(standing.scores.get(name)) for name in measures))
    return table


def _said(score: Score | None) -> str:
    if score is None:
        return "-"
    return f"{written(score.value)}\n[dim]{score.interval()}[/dim]"
