"""Output of a reproduction on the terminal: the claims, one line each."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from rich.table import Table

from experiments.bench.engine.terminal import coloured, out_console, show_table, stacked
from experiments.bench.reproduction.replicates import rate
from experiments.bench.stats.count import totals
from experiments.bench.stats.verdict import Outcome, Verdict
from experiments.claims.readings import READINGS, used_to_choose


def show_model_claims(claims: Sequence[Verdict]) -> None:
    """Print the claims of the models' own papers: count or word, number of clips, and what was measured."""
    table = Table(box=None, header_style="bold", pad_edge=False)
    for name in ("model", "claim", "held"):
        table.add_column(name, no_wrap=True)
    table.add_column("clips", justify="right")
    table.add_column("its paper says")
    for claim in claims:
        outcome, count = claim.outcome, claim.count
        words = stacked(claim.says, "; ".join([outcome.decided or outcome.measured, count.sentence()]))
        table.add_row(claim.model, claim.id, coloured(count), str(outcome.n or "-"), words)
    show_table(table)


def show_claims(claims: Sequence[Verdict], pooled: Mapping[str, Outcome], name: str = "replicate") -> None:
    """Print the claims judged, each with its word, its count and the number that decided; then totals.

    Parameters
    ----------
    claims
        The paper's.
    pooled
        Claim about the robot -> what it comes to on the trials of all replicates together.
    name
        What a replicate with the robot is called.
    """
    table = Table(box=None, header_style="bold", pad_edge=False)
    table.add_column("claim", no_wrap=True)
    table.add_column("word", no_wrap=True)
    table.add_column("all replicates", min_width=24, max_width=24)
    table.add_column("the paper says")
    common = [reading.name for reading in READINGS if reading.of_all]
    for claim in claims:
        if claim.experiment:
            alone = [reading.name for reading in used_to_choose(claim.id) if not reading.of_all]
            lines = (
                f"replicate 0, {claim.outcome.verdict}: {claim.outcome.deciding}",
                f"on equal terms: {claim.equal.sentence(name)}" if claim.equal else "",
                rate(claim.id, pooled[claim.id]) if claim.id in pooled else "",
                f"used to choose: {', '.join(alone)}" if alone else "",
            )
            words = stacked(claim.says, "\n".join(filter(None, lines)))
            word = coloured(claim.count) if claim.count.kind != "counted" else "-"
            table.add_row(claim.id, word, claim.count.sentence(name), words)
    show_table(table)
    out_console.print(f"\n{'; '.join(totals([(claim.id, claim.count) for claim in claims]))}", markup=False)
    if common:
        out_console.print(f"\nall claims were used to choose: {', '.join(common)}")
    others = [claim.id for claim in claims if not claim.experiment]
    if others:
        out_console.print(f"\nnothing here judges {', '.join(others)}; the report says what each would take")
