"""The command ``colias compare``. Heavy imports happen when it runs."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

if TYPE_CHECKING:
    from rich.table import Table

    from experiments.bench.public.comparison import Comparison

LONGEST = 40
"""Characters of a parameter's value in the table; `experiments.compare` has all."""


def register(app: typer.Typer) -> None:
    """Put the command into ``app``."""
    app.command(short_help="Say how two runs differ: parameters, and spikes on equal trials.")(compare)


def compare(
    first: Annotated[Path, typer.Argument(metavar="RUN", help="The folder of a run.")],
    second: Annotated[Path, typer.Argument(metavar="RUN", help="The folder of another.")],
) -> int:
    """Say how two runs differ: in their parameters, and in what models answered on equal trials.

    Equal trials have the same seed and the same condition: runs of one experiment and one seed under other settings
    have them all. Their spikes are compared pair by pair, per condition. Models are paired by label.
    The trials of an imported log have no seeds: those of equal conditions are compared as independent samples.
    """
    from experiments.bench.engine.terminal import error_console, out_console, show_line, show_table
    from experiments.bench.public.comparison import compare as compared

    comparison = compared(first, second)
    lines = {"first": comparison.first, "second": comparison.second, "other code": comparison.code}
    for name, value in lines.items():
        if str(value):
            show_line(f"{name:<12}{value}", 12)
    if comparison.parameters.height:
        show_table(_parameters(comparison))
    else:
        out_console.print("\nno parameter differs")
    if comparison.note:
        error_console.print(comparison.note, soft_wrap=True, markup=False)
    else:
        show_table(_results(comparison))
    return 0


def _parameters(comparison: Comparison) -> Table:
    from rich.table import Table

    table = Table(title="\nparameters", title_justify="left", box=None, header_style="bold", pad_edge=False)
    for name in ("parameter", "first", "second"):
        table.add_column(name)
    for row in comparison.parameters.to_dicts():
        values = ("-" if row[name] is None else row[name] for name in ("first", "second"))
        table.add_row(row["parameter"], *(v if len(v) <= LONGEST else f"{v[: LONGEST - 3]}..." for v in values))
    return table


def _results(comparison: Comparison) -> Table:
    from rich.table import Table

    from experiments.bench.stats.tests import LEVEL, least_of_pairs

    rows = comparison.results.to_dicts()
    tests = "; ".join(sorted({row["test"] for row in rows}))
    paired = all(row["test"].startswith("Wilcoxon") for row in rows)
    which = "equal trials" if paired else "independent trials of equal conditions"
    title = f"\nspikes a trial on {which}, first less second ({tests}; p after Holm)"
    table = Table(title=title, title_justify="left", box=None, header_style="bold", pad_edge=False)
    conditions = comparison.results.columns[: comparison.results.columns.index("model")]
    names = [name for name in conditions if len({row[name] for row in rows}) > 1] or conditions[:1]
    several = len({(row["model"], row["against"]) for row in rows}) > 1 or rows[0]["model"] != rows[0]["against"]
    for name in (
        *names,
        *(["model"] if several else []),
        "n",
        "first",
        "second",
        "difference",
        "rank-biserial" if paired else "delta",
        "p",
    ):
        table.add_column(name, justify="left" if name in ("model", "clip", "motion", "direction") else "right")
    for row in rows:
        model = row["model"] if row["model"] == row["against"] else f"{row['model']} - {row['against']}"
        table.add_row(
            *(_cell(row[name]) for name in names), *([model] if several else []), f"{row['n']}",
            f"{row['mean_first']:.1f}", f"{row['mean_second']:.1f}", f"{row['mean_difference']:+z.1f}",
            f"{row['rank_biserial']:+z.2f}",
            "-" if paired and least_of_pairs(row["n"]) > LEVEL else f"{row['p_holm']:.4f}",
        )  # fmt: skip
    return table


def _cell(value: Any) -> str:
    return "-" if value is None else f"{value:g}" if isinstance(value, float) else str(value)
