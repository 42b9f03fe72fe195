"""What the study of detectors shows on the terminal: a line for each detector and arena."""

from __future__ import annotations

from rich.table import Table

from experiments.bench.engine.terminal import out_console, show_line, show_table
from experiments.bench.reproduction.detectors.rows import Triple
from experiments.bench.reproduction.detectors.study import Detectors


def show(table: Detectors) -> None:
    """Print in how many replicates so far C21 held, and in how many it would by the rule of spikes in a row."""
    shown = Table(
        box=None, header_style="bold", pad_edge=False, title=f"C21 held in k of {table.replicates} replicates"
    )
    shown.add_column("arena", no_wrap=True)
    shown.add_column("detector")
    for name in ("T", "held", "95 %", "by rule", "spikes at 0, 15, 30"):
        shown.add_column(name, justify="right", no_wrap=name != "by rule")
    for row in table.rows:
        interval = f"{row.low:.0%} to {row.high:.0%}"
        shown.add_row(
            row.arena, row.label, f"{row.threshold:.3g}", str(row.held), interval, str(row.held_by_collision),
            triple(row.spikes, 1),
        )  # fmt: skip
    show_table(shown)
    for edge in table.edges:
        out_console.print(f"moving edge, {edge.arena}: {triple(edge.cells, 0)} cells a trial at 0, 15, 30 degrees")


def show_causes(table: Detectors) -> None:
    """Print why C21 does not hold, one line for each detector and arena."""
    for row in table.rows:
        if row.cause:
            show_line(f"{row.arena}, {row.label}: {row.cause}", 4)


def triple(values: Triple, digits: int) -> str:
    """Return three numbers with as many digits."""
    return ", ".join(f"{value:.{digits}f}" for value in values)
