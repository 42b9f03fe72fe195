"""A sweep on the terminal: mean spikes at every point."""

from __future__ import annotations

from rich.table import Table

from experiments.bench.engine.terminal import show_places, show_table
from experiments.bench.robot.sweep.figure import telling
from experiments.bench.robot.sweep.run import Sweep
from experiments.bench.robot.table import SHORT
from experiments.bench.store.rows import group


def show(sweep: Sweep) -> None:
    """Print the table of means, and where everything is."""
    if sweep.picture is None:
        return
    show_table(_table(sweep))
    show_places({"figure": sweep.picture, "table": sweep.folder / "sweep.csv"})


def _table(sweep: Sweep) -> Table:
    table = Table(title="mean spikes per trial", title_justify="left", box=None, header_style="bold", pad_edge=False)
    keys, varies = telling(sweep.rows, sweep.keys, sweep.varies), sweep.varies
    levels = list(dict.fromkeys(row[varies] for row in sweep.summary))
    for name in (
        *(SHORT.get(key, key) for key in keys),
        *(v if isinstance(v, str) else f"{v:g} {SHORT.get(varies, varies)}" for v in levels),
    ):
        table.add_column(name, justify="right")
    for values, chosen in group(sweep.summary, *keys).items():
        means = {
            level: [r["spikes_mean"] for r in chosen if r[varies] == level and r["spikes_mean"] is not None]
            for level in levels
        }
        said = ("-" if v is None else v if isinstance(v, str) else f"{v:g}" for v in values)
        table.add_row(*said, *(f"{sum(m) / len(m):.1f}" if m else "-" for m in means.values()))
    return table
