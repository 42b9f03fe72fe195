"""Behaviours on the terminal."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from pathlib import Path

from rich.table import Table
from rich.text import Text

from colias_sim.envs import ENVS
from experiments.behaviours import GROUPS, REFERENCE
from experiments.bench.closed_loop.power import MOST_EPISODES, TARGET, check_pilot, episodes_needed, pilot, power
from experiments.bench.closed_loop.run import Played
from experiments.bench.closed_loop.survival import Survival, best_against, published
from experiments.bench.engine.terminal import count, out_console, show_table, stacked
from experiments.bench.stats.scores import Score, written


def show(played: Played, recorded: bool) -> None:
    """Print the table of scores, and where everything is."""
    if played.standings:
        show_table(_table(played))
        out_console.print()
        note = ENVS[played.env].note
        out_console.print(f"{note} Below each value its 95 % interval over the episodes.".strip(), markup=False)
        out_console.print()
    places = {"table": str(played.folder / "scores.csv"), "episodes": str(played.folder / "trials.parquet")}
    if played.standings:
        places["figure"] = str(played.folder / "figure.png")
    if recorded:
        behaviour = played.standings[0].name if played.standings else "the behaviour"
        places["recordings"] = f"colias view {shlex.quote(str(played.folder))}  (the episodes of {behaviour})"
    for name, place in places.items():
        out_console.print(f"{name:<12}{place}", soft_wrap=True, markup=False)


EQUAL = 1.0
"""The ratio of two rates that is to be excluded."""
TRIED_EPISODES = (20, 60, 120, 240)
"""Numbers of episodes whose power is told beside the number that is needed."""


def show_power(played: Played, other: str) -> None:
    """Print how many episodes the comparison of two behaviours' collisions takes, by those played as a pilot.

    Raises `UsageError` where the pilot says nothing: the behaviour ``other`` touched nothing, or played no episode.
    """
    if len(played.standings) < 2:
        return  # its episodes failed, which is told already
    names = [standing.name for standing in played.standings]
    rarer, often = (pilot(standing.rows) for standing in played.standings)
    check_pilot(other, often)
    for name, pilot_run in zip(names, (rarer, often), strict=True):
        line = f"{name}: {pilot_run.collisions} collisions in {pilot_run.metres:.1f} m, {pilot_run.episodes} episodes"
        out_console.print(line, markup=False)
    needed = episodes_needed(rarer, often, EQUAL)
    enough = f"{needed} episodes of each" if needed else f"more than {MOST_EPISODES} episodes of each"
    aim = f"that {names[0]} collides less often a metre than {names[1]}, by a whole 95 % interval"
    out_console.print(f"For a power of {TARGET:.0%} to show {aim}: {enough}.", markup=False)
    chances = ", ".join(f"{power(rarer, often, EQUAL, episodes):.0%} with {episodes}" for episodes in TRIED_EPISODES)
    out_console.print(f"The power is {chances} episodes.", markup=False)


def show_survival(survivals: Sequence[Survival], group: str, path: Path) -> None:
    """Print the survival of a group of behaviours, B2 asked of the best of them, and where the table is."""
    members, (reference, *_) = GROUPS[group], REFERENCE[group]
    table = Table(title="survival", title_justify="left", box=None, header_style="bold", pad_edge=False)
    for name in ("behaviour", "episodes", "without collision", "collisions/m", f"times that of {reference}"):
        table.add_column(name, justify="left" if name == "behaviour" else "right", no_wrap=True)
    for entry in survivals:
        cells = (str(entry.survived.n), str(entry.survived), str(entry.per_metre), str(entry.ratio or "-"))
        table.add_row(entry.name, *cells)
    out_console.print()
    show_table(table)
    line = (
        best_against(survivals, members, reference),
        published(max((entry.survived.n for entry in survivals), default=0)),
    )
    for text in filter(None, line):
        out_console.print(text, markup=False)
    out_console.print(f"{'survival':<12}{path}", soft_wrap=True, markup=False)


def _table(played: Played) -> Table:
    """Return two lines a behaviour: the values, and below them their intervals."""
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


def _said(score: Score | None) -> str | Text:
    if score is None:
        return "-"
    return stacked(written(score.value), score.interval())
