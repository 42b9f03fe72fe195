"""What the comparison of formats shows on the terminal: a line for each claim, then the errors."""

from __future__ import annotations

from rich.table import Table

from experiments.bench.engine.terminal import out_console, show_line, show_table
from experiments.bench.judging.count import LEAST_JUDGED
from experiments.bench.reproduction.onboard.formats import CLAIMS
from experiments.bench.reproduction.onboard.rows import Onboard


def show(table: Onboard) -> None:
    """Print in how many replicates so far each claim held in each format, and each format's error."""
    shown = Table(box=None, header_style="bold", pad_edge=False, title=f"held in k of {table.replicates} replicates")
    shown.add_column("claim", no_wrap=True)
    for each in table.formats:
        shown.add_column(each.label, justify="right")
    for claim in CLAIMS:
        cells = []
        for each in table.formats:
            row = table.row(claim, each.label)
            changed = f" (-{row.lost} +{row.gained})" if row.lost or row.gained else ""
            cells.append(f"{row.held}{'v' if row.vacuous else ''}{changed}")
        shown.add_row(claim, *cells)
    show_table(shown)
    for error in table.errors:
        said = (
            f"{error.label}: error of HS: median {error.median:.1e}, 99 % {error.most:.1e}, worst {error.worst:.1e} "
            f"over {error.frames} frames; of {error.spikes} spikes {error.lost} lost, {error.gained} gained"
        )
        show_line(said, 4)
    out_console.print(survival(table))


def survival(table: Onboard) -> str:
    """Return which claims that hold do not survive in the best format; below 20 replicates there is no word."""
    if table.replicates < LEAST_JUDGED:
        return f"which claims survive takes {LEAST_JUDGED} replicates"
    broken = table.broken()
    return (
        f"do not survive in {table.formats[1].label}: {', '.join(broken)}"
        if broken
        else "every claim that holds survives"
    )
