"""What a reproduction shows on the terminal: the claims, one line each."""

from __future__ import annotations

from collections.abc import Sequence

from rich.table import Table

from experiments.bench.engine.terminal import coloured, out_console, show_table, stacked
from experiments.bench.judging.claims import readings_of_all, used_to_choose
from experiments.bench.judging.overall import totals
from experiments.bench.judging.verdict import Verdict


def show_model_claims(claims: Sequence[Verdict]) -> None:
    """Print the claims of the models' own papers: verdict, replicates, number of clips, and what was measured."""
    table = Table(box=None, header_style="bold", pad_edge=False)
    for name in ("model", "claim", "verdict"):
        table.add_column(name, no_wrap=True)
    table.add_column("clips", justify="right")
    table.add_column("its paper says")
    for claim in claims:
        said = claim.decided or claim.measured
        held = f"; {claim.held}" if claim.experiment and claim.verdict != "untested" else ""
        words = stacked(claim.says, said + held)
        table.add_row(claim.model, claim.id, coloured(claim.verdict), str(claim.n or "-"), words)
    show_table(table)


def show_claims(claims: Sequence[Verdict]) -> None:
    """Print the claims tested, each with its verdict, replicates and the number that decided; then totals."""
    table = Table(box=None, header_style="bold", pad_edge=False)
    table.add_column("claim", no_wrap=True)
    table.add_column("verdict", no_wrap=True)
    table.add_column("all replicates", min_width=24, max_width=24)
    table.add_column("replicate 0", no_wrap=True)
    table.add_column("the paper says")
    common = [reading.name for reading in readings_of_all()]
    for claim in claims:
        if claim.experiment:
            decided = claim.decided or claim.measured.partition("; measured:")[0]
            alone = [reading.name for reading in used_to_choose(claim.id) if not reading.of_all]
            used = f"used to choose: {', '.join(alone)}" if alone else ""
            lines = filter(None, (f"replicate 0: {decided}", claim.rate.partition(";")[0], used))
            said = stacked(claim.says, "\n".join(lines))
            table.add_row(claim.id, coloured(claim.word), claim.held, coloured(claim.verdict), said)
    show_table(table)
    out_console.print(f"\n{'; '.join(totals([(claim.id, claim.word) for claim in claims]))}", markup=False)
    if common:
        out_console.print(f"\nall claims were used to choose: {', '.join(common)}")
    others = [claim.id for claim in claims if not claim.experiment]
    if others:
        out_console.print(f"\nnot judged: {', '.join(others)}; the report says what each would take")
