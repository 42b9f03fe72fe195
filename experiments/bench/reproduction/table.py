"""What a reproduction shows on the terminal: the claims, one line each."""

from __future__ import annotations

from collections.abc import Sequence

from rich.markup import escape
from rich.table import Table

from experiments.bench.core.terminal import coloured, out_console
from experiments.bench.core.verdict import Verdict


def show_claims(claims: Sequence[Verdict]) -> None:
    """Print the claims tested, each with its seeds and the number that decided; then those that were not tested."""
    table = Table(box=None, header_style="bold", pad_edge=False)
    for name in ("claim", "verdict", "seeds", "the paper says"):
        table.add_column(name, no_wrap=name != "the paper says")
    for claim in claims:
        if claim.experiment:
            unjudged = f" ({claim.seeds_untested} untested)" if claim.seeds_untested else ""
            seeds = "-" if claim.seeds is None else f"{claim.seeds_holding} of {claim.seeds}{unjudged}"
            decided = claim.decided or claim.measured.partition("; measured:")[0]
            said = f"{claim.says}\n[dim]{escape(decided)}[/dim]"
            table.add_row(claim.id, coloured(claim.verdict), seeds, said)
    out_console.print(table)
    others = [claim.id for claim in claims if not claim.experiment]
    if others:
        out_console.print(f"\nnot judged: {', '.join(others)}; the report says what each would take")
