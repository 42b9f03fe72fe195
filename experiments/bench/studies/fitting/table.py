"""Write a fit into its folder, and print it."""

from __future__ import annotations

from pathlib import Path

from rich.table import Table

from experiments.bench.engine.terminal import out_console, show_places, show_table
from experiments.bench.store.files import Files
from experiments.bench.store.kinds import FIT
from experiments.bench.studies.counts import TOGETHER
from experiments.bench.studies.fitting.fitted import Fitted
from experiments.bench.studies.table import cell_text

ANEW = "anew.csv"
SHOWN = 5
"""Settings judged anew that are printed; `ANEW` has all."""


def write(fitted: Fitted, folder: Path) -> None:
    """Write ``fit.csv``, ``anew.csv``, ``fit.json``, ``fit.svg`` and ``fit.png``."""
    from experiments.bench.figures import plotting  # not before: workers do without matplotlib
    from experiments.bench.studies.fitting import figure

    files = Files(folder)
    files.write_rows(FIT.summary, fitted.rows())
    files.write_rows(ANEW, fitted.anew_rows())
    files.write_json("fit.json", fitted.described())
    plotting.save(figure.draw(fitted), folder, "fit")


def show(fitted: Fitted, folder: Path) -> None:
    """Print the answer, the settings judged anew, and where everything is."""
    for line in fitted.sentences():
        out_console.print(line, markup=False, soft_wrap=True)
    claims = (TOGETHER, *fitted.claims) if len(fitted.claims) > 1 else fitted.claims
    replicates = len(fitted.anew[0].least)
    table = Table(box=None, header_style="bold", pad_edge=False, title=f"kept in k of {replicates} replicates anew")
    keys = [part.key for part in fitted.box.ranges]
    for name in ("number", *keys, *claims, "slack in the search", "slack anew"):
        table.add_column(name, justify="right")
    rows = fitted.anew_rows()
    for number in fitted.best[:SHOWN]:
        chosen = [row for row in rows if row["number"] == number]
        kept = [str(row["kept"]) for row in chosen]
        slacks = [cell_text(chosen[0][name]) for name in ("slack in the search", "slack anew")]
        table.add_row(str(number), *(str(chosen[0][key]) for key in keys), *kept, *slacks)
    show_table(table)
    out_console.print()
    places: dict[str, object] = {"figure": folder / "fit.png", "settings": folder / FIT.summary, "anew": folder / ANEW}
    if fitted.failures:
        places["failures"] = folder
    show_places(places)
